/* What is saved and what is lost when a piece is left out, as a figure for paper.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>

#include "client/chart.h"
#include "client/chart_axes.h"

enum {
    WIDTH = 960,
    PLOT_LEFT = 74,
    PLOT_TOP = 70,
    PLOT_WIDTH = 560,
    PLOT_HEIGHT = 380,
    NONE_HEIGHT = 34, /* below the axis: what is not told from nothing */
    NAME_STEP = 34,
};

/* Errors are drawn as parts of the value: of a relMSE, the root. */
static double root_of(double square)
{
    return square > 0 ? sqrt(square) : 0;
}

static struct chart_axes axes_of(const struct chart *c)
{
    struct chart_axes a = {
        PLOT_LEFT, PLOT_TOP, PLOT_LEFT + PLOT_WIDTH, PLOT_TOP + PLOT_HEIGHT, -.05, .05, .001,
        .2,        true};
    for (uint32_t i = 0; i < c->piece_count; i++) {
        a.x_least = fmin(a.x_least, c->pieces[i].saved.at - .05);
        a.x_most = fmax(a.x_most, c->pieces[i].saved.at + .05);
        a.y_most = fmax(a.y_most, 1.5 * root_of(c->pieces[i].error.high));
        a.y_most = fmax(a.y_most, 1.5 * fabs(c->pieces[i].energy.at));
    }
    a.x_least = floor(a.x_least * 10) / 10;
    a.x_most = ceil(a.x_most * 10) / 10;
    return a;
}

static void draw_ground(struct buf *b, const struct chart_axes *a)
{
    const double zero = chart_axes_x(a, 0), one = chart_axes_y(a, 0.01);
    const double below = a->bottom + NONE_HEIGHT;
    svg_box(b, zero, one, a->right - zero, below - one, "fill='#e4f3ec'");
    svg_text(b, a->right - 8, one + 14, "end", "fill='#00694c' font-size='11'",
             "leave it out for this scene");
    svg_line(b, zero, a->top, zero, below, "stroke='#444'");
    for (int t = 0; t < CHART_TARGETS; t++)
        if (chart_axes_holds(a, 0, chart_targets[t])) {
            const double y = chart_axes_y(a, chart_targets[t]);
            svg_line(b, a->left, y, a->right, y, "stroke='#666' stroke-dasharray='8 4'");
            svg_text(b, a->right - 6, y - 4, "end", "fill='#555' font-size='11'", "%g %%",
                     100 * chart_targets[t]);
        }
    const double step = a->x_most - a->x_least > 1.2 ? .2 : .1;
    for (int i = (int)ceil(a->x_least / step - 1e-9); i * step <= a->x_most + 1e-9; i++) {
        const double x = chart_axes_x(a, i * step);
        svg_line(b, x, below, x, below + 5, "stroke='#222'");
        svg_text(b, x, below + 20, "middle", "fill='#222'", "%.0f", 100 * step * i);
    }
    svg_box(b, a->left, a->bottom, a->right - a->left, NONE_HEIGHT, "fill='none' stroke='#222'");
    svg_text(b, a->left - 9, a->bottom + 21, "end", "fill='#222' font-size='11'", "none seen");
}

struct seen {             /* of a piece: parts of the value */
    double at, low, high; /* at 0: not told from nothing */
};

static struct seen error_of(const struct chart_piece *p)
{
    return (struct seen){p->error.low > 0 ? root_of(p->error.at) : 0, root_of(p->error.low),
                         root_of(p->error.high)};
}

static struct seen energy_of(const struct chart_piece *p)
{
    const struct curve_value e = p->energy;
    const bool told = e.low > 0 || e.high < 0;
    const double low = fabs(e.low), high = fabs(e.high);
    return (struct seen){told ? fabs(e.at) : 0, told ? fmin(low, high) : 0, fmax(low, high)};
}

/* "+3.1 %", or what it is less than. */
static const char *percent(struct seen s, double sign, char text[32])
{
    if (s.at > 0)
        snprintf(text, 32, "%+.2g %%", copysign(100 * s.at, sign));
    else
        snprintf(text, 32, "< %.2g %%", 100 * s.high);
    return text;
}

static double height_of(const struct chart_axes *a, double value)
{
    return value > a->y_least ? chart_axes_y(a, value) : a->bottom + 0.5 * NONE_HEIGHT;
}

static double draw_seen(struct buf *b, const struct chart_axes *a, double x, struct seen s,
                        uint32_t color, bool energy)
{
    const double y = height_of(a, s.at);
    char style[128];
    snprintf(style, sizeof style, "stroke='%s' stroke-width='1.2'%s", svg_color(color),
             s.at > 0 ? "" : " stroke-opacity='.5' stroke-dasharray='1.5 2.5'");
    svg_line(b, x, height_of(a, s.low), x, height_of(a, s.high), style);
    svg_mark(b, energy ? SVG_DIAMOND : SVG_CIRCLE, x, y, color, energy ? SVG_HOLLOW : SVG_FULL);
    return y;
}

/* --- names --- */

static void draw_names(struct buf *b, const struct chart *c, const struct chart_axes *a,
                       struct chart_axes_name names[])
{
    chart_axes_spread(names, c->piece_count, NAME_STEP, a->bottom + NONE_HEIGHT - 12);
    for (uint32_t i = 0; i < c->piece_count; i++) {
        const struct chart_piece *p = &c->pieces[names[i].of];
        const double to = a->right + 24, y = names[i].y;
        const double lead[6] = {names[i].x + 7, names[i].from, to - 12, y, to - 5, y};
        char style[96];
        snprintf(style, sizeof style,
                 "fill='none' stroke='%s' stroke-width='.7' stroke-opacity='.7'",
                 svg_color(names[i].of));
        svg_polyline(b, lead, 3, style);
        svg_mark(b, SVG_CIRCLE, to, y, names[i].of, SVG_FULL);
        svg_text(b, to + 10, y + 1, "start", "fill='#222'", "%s", p->name);
        char error[32], energy[32];
        svg_text(b, to + 10, y + 14, "start", "fill='#555' font-size='11'",
                 "saves %.3g %%; error %s, energy %s", 100 * p->saved.at,
                 percent(error_of(p), 1, error), percent(energy_of(p), p->energy.at, energy));
    }
}

static void draw_labels(struct buf *b, const struct chart *c, const struct chart_axes *a)
{
    char title[128];
    svg_text(b, PLOT_LEFT, 24, "start", "font-size='16' font-weight='bold'", "%s",
             chart_axes_title(*c->title ? c->title : "Untitled", title));
    svg_text(
        b, PLOT_LEFT, 43, "start", "fill='#444'",
        "What each piece costs and buys: left out in turn at %u spp, %u runs of %u x %u pixels; "
        "with all pieces the error is %.2f %%",
        c->piece_spp, c->options.runs, c->width_px, c->height_px, 100 * sqrt(c->piece_error));
    svg_text(b, 0.5 * (a->left + a->right), a->bottom + NONE_HEIGHT + 40, "middle", "fill='#222'",
             "work saved by leaving it out, %%");
    buf_text(b, "<g transform='translate(20 %.1f) rotate(-90)'>\n", 0.5 * (a->top + a->bottom));
    svg_text(b, 0, 0, "middle", "fill='#222'", "error added, in parts of the value");
    buf_text(b, "</g>\n");
    svg_mark(b, SVG_CIRCLE, a->left + 10, a->top - 10, 0, SVG_FULL);
    svg_text(b, a->left + 20, a->top - 6, "start", "fill='#222' font-size='11'",
             "root of the relMSE added, noise and bias");
    svg_mark(b, SVG_DIAMOND, a->left + 260, a->top - 10, 0, SVG_HOLLOW);
    svg_text(b, a->left + 270, a->top - 6, "start", "fill='#222' font-size='11'",
             "energy added or lost. Bars: 95 %%");
}

void chart_draw_price(const struct chart *c, struct buf *svg)
{
    const struct chart_axes a = axes_of(c);
    struct chart_axes_name names[CHART_MOST_PIECES];
    svg_begin(svg, WIDTH, a.bottom + NONE_HEIGHT + 56, c->title);
    draw_ground(svg, &a);
    chart_axes_grid(svg, &a);
    chart_axes_frame(svg, &a);
    for (uint32_t i = 0; i < c->piece_count; i++) {
        const double x = chart_axes_x(&a, c->pieces[i].saved.at);
        draw_seen(svg, &a, x + 4, energy_of(&c->pieces[i]), i, true);
        const double y = draw_seen(svg, &a, x, error_of(&c->pieces[i]), i, false);
        names[i] = (struct chart_axes_name){i, x, y, y};
    }
    draw_names(svg, c, &a, names);
    draw_labels(svg, c, &a);
    svg_end(svg);
}
