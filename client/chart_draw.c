/* Error against work, as a figure for paper (docs/charts.md says how to read it).
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "client/chart.h"
#include "client/chart_axes.h"

enum {
    WIDTH = 940,
    PLOT_LEFT = 74,
    PLOT_TOP = 96,
    PLOT_WIDTH = 560,
    PLOT_HEIGHT = 440,
    ROW = 19,
    NAME_STEP = 17,
};

static const char *const dashes[] = {"", "", "", "7 3", "2.5 2.5", "", ""};

/* Lines are told apart by colour, marker and dash. */
static enum svg_marker marker_of(const struct chart_line *line, uint32_t i)
{
    return line->missing ? SVG_TRIANGLE : (enum svg_marker)(SVG_CIRCLE + i);
}

/* --- range --- */

static void widen(double *least, double *most, double value)
{
    if (value > 0 && isfinite(value)) {
        *least = fmin(*least, value);
        *most = fmax(*most, value);
    }
}

static struct chart_axes axes_of(const struct chart *c)
{
    struct chart_axes a = {
        PLOT_LEFT, PLOT_TOP, PLOT_LEFT + PLOT_WIDTH, PLOT_TOP + PLOT_HEIGHT, INFINITY, 0, INFINITY,
        0,         false};
    for (uint32_t i = 0; i < c->line_count; i++)
        for (uint32_t p = 0; p < c->point_count; p++) {
            widen(&a.x_least, &a.x_most, c->lines[i].curve.work[p]);
            widen(&a.y_least, &a.y_most, c->lines[i].points[p].error.at);
            widen(&a.y_least, &a.y_most, c->lines[i].points[p].trimmed);
        }
    widen(&a.y_least, &a.y_most, c->reference.noise);
    a.x_least /= 1.25;
    a.x_most *= 1.25;
    a.y_least /= 2;
    a.y_most *= 2;
    return a;
}

/* --- behind the lines --- */

static void draw_diagonals(struct buf *b, const struct chart_axes *a)
{
    for (int k = -40; k < 60; k++) { /* work x error = 10^k */
        const double product = pow(10, k);
        const double xy[4] = {chart_axes_x(a, a->x_least), chart_axes_y(a, product / a->x_least),
                              chart_axes_x(a, a->x_most), chart_axes_y(a, product / a->x_most)};
        if (product < a->x_least * a->y_least || product > a->x_most * a->y_most)
            continue;
        svg_polyline(b, xy, 2, "fill='none' stroke='#d4d4d4' stroke-dasharray='1 3'");
    }
}

static void draw_floor(struct buf *b, const struct chart *c, const struct chart_axes *a)
{
    if (!(c->reference.noise > 0))
        return;
    const double y = chart_axes_y(a, c->reference.noise);
    svg_box(b, a->left, y, a->right - a->left, a->bottom - y, "fill='#dcdcdc'");
    svg_text(b, a->left + 6, y + 13, "start", "fill='#555' font-size='11'",
             "the reference's own noise");
}

static void draw_targets(struct buf *b, const struct chart_axes *a)
{
    for (int t = 0; t < CHART_TARGETS; t++) {
        const double error = chart_targets[t] * chart_targets[t];
        if (!chart_axes_holds(a, a->x_least, error))
            continue;
        const double y = chart_axes_y(a, error);
        svg_line(b, a->left, y, a->right, y,
                 "stroke='#666' stroke-width='1' stroke-dasharray='8 4'");
    }
}

struct spot {
    double work, error;
};

static int by_work(const void *a, const void *b)
{
    const struct spot *x = a, *y = b;
    return x->work != y->work ? (x->work > y->work) - (x->work < y->work)
                              : (x->error > y->error) - (x->error < y->error);
}

/* What no other point is better than in both. */
static void draw_frontier(struct buf *b, const struct chart *c, const struct chart_axes *a)
{
    struct spot spots[CHART_MOST_LINES * CURVE_MOST_POINTS];
    double xy[2 * CHART_MOST_LINES * CURVE_MOST_POINTS], least = (double)INFINITY;
    uint32_t count = 0, kept = 0;
    for (uint32_t i = 0; i < c->line_count; i++)
        for (uint32_t p = 0; p < c->point_count; p++)
            if (c->lines[i].points[p].error.at > 0)
                spots[count++] =
                    (struct spot){c->lines[i].curve.work[p], c->lines[i].points[p].error.at};
    qsort(spots, count, sizeof *spots, by_work);
    for (uint32_t i = 0; i < count; i++) {
        if (spots[i].error >= least)
            continue;
        least = spots[i].error;
        xy[2 * kept] = chart_axes_x(a, spots[i].work);
        xy[2 * kept++ + 1] = chart_axes_y(a, spots[i].error);
    }
    svg_polyline(b, xy, kept,
                 "fill='none' stroke='#f0e442' stroke-width='9' stroke-opacity='.75' "
                 "stroke-linejoin='round' stroke-linecap='round'");
}

/* --- lines --- */

static void draw_band(struct buf *b, const struct chart_line *line, uint32_t i,
                      const struct chart_axes *a)
{
    double xy[4 * CURVE_MOST_POINTS];
    uint32_t n = 0;
    char style[96];
    while (n < line->curve.points && line->points[n].error.low > 0)
        n++;
    for (uint32_t p = 0; p < n; p++) {
        xy[2 * p] = xy[2 * (2 * n - 1 - p)] = chart_axes_x(a, line->curve.work[p]);
        xy[2 * p + 1] = chart_axes_y(a, line->points[p].error.high);
        xy[2 * (2 * n - 1 - p) + 1] = chart_axes_y(a, line->points[p].error.low);
    }
    snprintf(style, sizeof style, "fill='%s' fill-opacity='.2'", svg_color(i));
    if (n > 1)
        svg_polygon(b, xy, 2 * n, style);
}

static void draw_line(struct buf *b, const struct chart_line *line, uint32_t i,
                      const struct chart_axes *a, bool trimmed)
{
    double xy[2 * CURVE_MOST_POINTS];
    uint32_t n = 0;
    char style[128];
    for (uint32_t p = 0; p < line->curve.points; p++) {
        const double error = trimmed ? line->points[p].trimmed : line->points[p].error.at;
        if (!(error > 0))
            break;
        xy[2 * n] = chart_axes_x(a, line->curve.work[p]);
        xy[2 * n++ + 1] = chart_axes_y(a, error);
    }
    snprintf(style, sizeof style, "fill='none' stroke='%s' stroke-width='%s' stroke-dasharray='%s'",
             svg_color(i), trimmed ? "1" : "1.8", trimmed ? "1 2.5" : dashes[i]);
    if (n > 1)
        svg_polyline(b, xy, n, style);
}

static enum svg_fill fill_of(const struct chart_line *line, const struct chart_point *p)
{
    if (p->tail || p->untrusted > 0.05)
        return SVG_HATCHED;
    return p->near_floor || line->missing ? SVG_HOLLOW : SVG_FULL;
}

static void draw_points(struct buf *b, const struct chart_line *line, uint32_t i,
                        const struct chart_axes *a)
{
    for (uint32_t p = 0; p < line->curve.points; p++)
        if (line->points[p].error.at > 0)
            svg_mark(b, marker_of(line, i), chart_axes_x(a, line->curve.work[p]),
                     chart_axes_y(a, line->points[p].error.at), i, fill_of(line, &line->points[p]));
}

static void draw_best(struct buf *b, const struct chart *c, const struct chart_axes *a)
{
    if (c->best < 0)
        return;
    const double target = chart_targets[c->best_target];
    const double x = chart_axes_x(a, c->lines[c->best].work_to[c->best_target].at);
    const double y = chart_axes_y(a, target * target);
    svg_line(b, x - 7, y - 7, x + 7, y + 7, "stroke='#c00000' stroke-width='3'");
    svg_line(b, x - 7, y + 7, x + 7, y - 7, "stroke='#c00000' stroke-width='3'");
}

static void draw_planned(struct buf *b, const struct chart *c, const struct chart_axes *a)
{
    if (c->planned < 0)
        return;
    const struct chart_line *line = &c->lines[c->planned];
    double work = line->curve.work[c->point_count - 1];
    double error = line->points[c->point_count - 1].error.at;
    if (c->best_target >= 0 && !isnan(line->work_to[c->best_target].at)) {
        work = line->work_to[c->best_target].at;
        error = chart_targets[c->best_target] * chart_targets[c->best_target];
    }
    svg_mark(b, SVG_STAR, chart_axes_x(a, work), chart_axes_y(a, error), (uint32_t)c->planned,
             SVG_HOLLOW);
}

/* --- names at the lines' ends --- */

static void draw_names(struct buf *b, const struct chart *c, const struct chart_axes *a)
{
    struct chart_axes_name names[CHART_MOST_LINES];
    const uint32_t last = c->point_count - 1;
    for (uint32_t i = 0; i < c->line_count; i++) {
        const double error = c->lines[i].points[last].error.at;
        const double y = error > 0 ? chart_axes_y(a, error) : a->bottom;
        names[i] = (struct chart_axes_name){i, chart_axes_x(a, c->lines[i].curve.work[last]), y, y};
    }
    chart_axes_spread(names, c->line_count, NAME_STEP, a->bottom - 4);
    for (uint32_t k = 0; k < c->line_count; k++) {
        const uint32_t i = names[k].of;
        const struct chart_line *line = &c->lines[i];
        const double to = a->right + 62;
        const double lead[6] = {names[k].x + 7, names[k].from, to - 14,
                                names[k].y,     to - 6,        names[k].y};
        char style[96], slope[32] = "";
        snprintf(style, sizeof style,
                 "fill='none' stroke='%s' stroke-width='.7' stroke-opacity='.6'", svg_color(i));
        svg_polyline(b, lead, 3, style);
        svg_mark(b, marker_of(line, i), to, names[k].y, i, line->missing ? SVG_HOLLOW : SVG_FULL);
        if (!isnan(line->slope.at))
            snprintf(slope, sizeof slope, "  %.2f", line->slope.at);
        snprintf(style, sizeof style, "fill='%s' font-weight='%s'", i == 6 ? "#222" : svg_color(i),
                 i == 0 ? "bold" : "normal");
        svg_text(b, to + 10, names[k].y + 4, "start", style, "%s%s", line->method->name, slope);
    }
}

/* --- the other two axes --- */

/* Seconds of one core are so many units; where a round number of them is. */
static void draw_seconds(struct buf *b, const struct chart *c, const struct chart_axes *a)
{
    const double unit = c->unit_ns[1] * 1e-9;
    for (int decade = -9; decade < 9; decade++)
        for (int m = 1; m < 10; m++) {
            const double seconds = m * pow(10, decade), work = seconds / unit;
            if (work < a->x_least || work > a->x_most)
                continue;
            const double x = chart_axes_x(a, work);
            svg_line(b, x, a->top, x, a->top - (m == 1 ? 6 : 3), "stroke='#222'");
            if (m == 1)
                svg_text(b, x, a->top - 10, "middle", "fill='#222'", "%g", seconds);
        }
    svg_text(b, 0.5 * (a->left + a->right), a->top - 27, "middle", "fill='#222'",
             "seconds of one core (%.2f ns a unit; 90 %% of runs %.2f to %.2f)", c->unit_ns[1],
             c->unit_ns[0], c->unit_ns[2]);
}

static void draw_percents(struct buf *b, const struct chart_axes *a)
{
    static const double percents[] = {1000, 300, 100, 30, 10, 3, 1, .3, .1, .03, .01};
    for (size_t i = 0; i < countof(percents); i++) {
        const double error = 1e-4 * percents[i] * percents[i];
        if (error < a->y_least || error > a->y_most)
            continue;
        const double y = chart_axes_y(a, error);
        svg_line(b, a->right, y, a->right + 5, y, "stroke='#222'");
        svg_text(b, a->right + 8, y + 4, "start", "fill='#222' font-size='11'", "%g %%",
                 percents[i]);
    }
}

static void draw_labels(struct buf *b, const struct chart *c, const struct chart_axes *a)
{
    char title[128];
    svg_text(b, PLOT_LEFT, 24, "start", "font-size='16' font-weight='bold'", "%s",
             chart_axes_title(*c->title ? c->title : "Untitled", title));
    svg_text(
        b, PLOT_LEFT, 43, "start", "fill='#444'",
        "%u x %u pixels, %u runs a point, 95 %% bands; %s and %s agree within %g %% (p = %.1g)",
        c->width_px, c->height_px, c->options.runs, c->reference.methods[0]->name,
        c->reference.methods[1]->name, 100 * c->reference.margin, c->reference.p);
    svg_text(b, 0.5 * (a->left + a->right), a->bottom + 40, "middle", "fill='#222'",
             "work of a run, in units: rays and vertices at the scene's prices");
    buf_text(b, "<g transform='translate(20 %.1f) rotate(-90)'>\n", 0.5 * (a->top + a->bottom));
    svg_text(b, 0, 0, "middle", "fill='#222'", "relMSE");
    buf_text(b, "</g>\n");
    svg_text(b, a->right + 8, a->top - 10, "start", "fill='#222' font-size='11'", "RMS error");
    svg_text(b, a->right + 72, a->top - 10, "start", "fill='#222' font-size='11'", "method, slope");
}

/* --- the table --- */

static const char *work_cell(const struct chart_line *line, int target, char text[64])
{
    const double error = chart_targets[target] * chart_targets[target];
    char work[32];
    if (!isnan(line->work_to[target].at))
        snprintf(text, 64, "%s (%.2g s)", chart_axes_number(line->work_to[target].at, work),
                 line->work_to[target].at * line->unit_ns * 1e-9);
    else
        snprintf(text, 64, "%s",
                 line->points[0].error.at <= error ? "less than the first" : "not reached");
    return text;
}

/* The two hardest targets that some line reaches; else the two easiest. */
static int hard_target(const struct chart *c)
{
    return c->best_target > 0 ? c->best_target : 1;
}

static const double columns[] = {74, 226, 310, 426, 542, 702, 838};

static void draw_head(struct buf *b, const struct chart *c, double y)
{
    const int t = hard_target(c);
    const char *const style = "font-weight='bold' font-size='11' fill='#222'";
    svg_text(b, columns[0], y, "start", style, "method");
    svg_text(b, columns[1], y, "start", style, "slope");
    svg_text(b, columns[2], y, "start", style, "work to %g %%", 100 * chart_targets[t - 1]);
    svg_text(b, columns[3], y, "start", style, "work to %g %%", 100 * chart_targets[t]);
    svg_text(b, columns[4], y, "start", style, "efficiency");
    svg_text(b, columns[5], y, "start", style, "bias² (95 %%)");
    svg_text(b, columns[6], y, "start", style, "energy");
    svg_line(b, columns[0] - 16, y + 6, WIDTH - 20, y + 6, "stroke='#222'");
}

static void draw_row(struct buf *b, const struct chart *c, uint32_t i, double y)
{
    const struct chart_line *line = &c->lines[i];
    const int t = hard_target(c);
    const char *const style = "font-size='11' fill='#222'";
    char text[64], low[32], high[32];
    svg_mark(b, marker_of(line, i), columns[0] - 9, y - 4, i,
             line->missing ? SVG_HOLLOW : SVG_FULL);
    svg_text(b, columns[0], y, "start", style, "%s", line->method->name);
    if (!isnan(line->slope.at))
        svg_text(b, columns[1], y, "start", style, "%.2f ± %.2f", line->slope.at,
                 0.5 * (line->slope.high - line->slope.low));
    svg_text(b, columns[2], y, "start", style, "%s", work_cell(line, t - 1, text));
    svg_text(b, columns[3], y, "start", style, "%s", work_cell(line, t, text));
    if (i == 0)
        svg_text(b, columns[4], y, "start", style, "1");
    else if (!isnan(line->gain.at))
        svg_text(b, columns[4], y, "start", style, "%.2g (%.2g to %.2g)", line->gain.at,
                 line->gain.low, line->gain.high);
    svg_text(b, columns[5], y, "start", style, "%s to %s", chart_axes_number(line->bias2.low, low),
             chart_axes_number(line->bias2.high, high));
    svg_text(b, columns[6], y, "start", line->missing ? "font-size='11' fill='#c00000'" : style,
             "%+.2g ± %.1g %%%s", 100 * line->energy.at,
             50 * (line->energy.high - line->energy.low), line->missing ? " !" : "");
}

static void draw_key(struct buf *b, const struct chart *c, double y)
{
    const char *const lines[] = {
        "Hollow: within three times of the reference's noise. Hatched: one pixel in a thousand has "
        "most "
        "of the error, or blocks have under 32 effective samples.",
        "Open triangle: a class of paths is missing; its energy stands in the last column (!). "
        "Dotted, beside a line: the error without one pixel in a thousand.",
        "Yellow: the frontier, no point is better in both. Diagonals: equal efficiency. "
        "Efficiency: the first method's error at equal work over the method's.",
        c->best < 0      ? "Star: the planner's choice."
        : c->planned < 0 ? "Red cross: least work to the hardest target that is reached."
                         : "Red cross: least work to the hardest target that is reached. Star: the "
                           "planner's choice for it.",
    };
    for (size_t i = 0; i < countof(lines) - (c->best < 0 && c->planned < 0); i++)
        svg_text(b, columns[0] - 16, y + 15 * (double)i, "start", "font-size='11' fill='#444'",
                 "%s", lines[i]);
}

void chart_draw(const struct chart *c, struct buf *svg)
{
    const struct chart_axes a = axes_of(c);
    const double table = a.bottom + 70;
    const double height = table + (c->line_count + 1) * ROW + 78;
    svg_begin(svg, WIDTH, height, c->title);
    chart_axes_grid(svg, &a);
    chart_axes_clip(svg, &a);
    draw_floor(svg, c, &a);
    draw_diagonals(svg, &a);
    draw_targets(svg, &a);
    draw_frontier(svg, c, &a);
    for (uint32_t i = c->line_count; i-- > 0;)
        draw_band(svg, &c->lines[i], i, &a);
    for (uint32_t i = c->line_count; i-- > 0;) {
        draw_line(svg, &c->lines[i], i, &a, true);
        draw_line(svg, &c->lines[i], i, &a, false);
    }
    for (uint32_t i = c->line_count; i-- > 0;)
        draw_points(svg, &c->lines[i], i, &a);
    draw_planned(svg, c, &a);
    draw_best(svg, c, &a);
    chart_axes_unclip(svg);
    chart_axes_frame(svg, &a);
    draw_seconds(svg, c, &a);
    draw_percents(svg, &a);
    draw_labels(svg, c, &a);
    draw_names(svg, c, &a);
    draw_head(svg, c, table);
    for (uint32_t i = 0; i < c->line_count; i++)
        draw_row(svg, c, i, table + (i + 1) * ROW + 3);
    draw_key(svg, c, table + (c->line_count + 1) * ROW + 16);
    svg_end(svg);
}
