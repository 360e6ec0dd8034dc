/* SPDX-License-Identifier: MIT */
#include "client/plot.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { ROWS = PLOT_LINES - 2 };

struct plot {
    double x0, x1, y0,
        y1; /* logarithms of the first and last column, of the lowest and highest row */
    char cell[ROWS][PLOT_COLUMNS + 1];
};

static void widen(double *lo, double *hi, double v)
{
    *lo = fmin(*lo, log(v));
    *hi = fmax(*hi, log(v));
}

static bool is_point(const struct remote_curve *c, size_t i)
{
    return c->points[i].spp > 0 && c->points[i].error > 0 && isfinite(c->points[i].error);
}

static bool frame(struct plot *p, const struct remote_curve *c)
{
    size_t seen = 0;
    p->x0 = p->y0 = (double)INFINITY;
    p->x1 = p->y1 = -(double)INFINITY;
    for (size_t i = 0; i < c->count; i++)
        if (is_point(c, i)) {
            widen(&p->x0, &p->x1, c->points[i].spp);
            widen(&p->y0, &p->y1, c->points[i].error);
            seen++;
        }
    if (c->target_error > 0)
        widen(&p->y0, &p->y1, c->target_error);
    if (c->forecast_spp > 0)
        widen(&p->x0, &p->x1, c->forecast_spp);
    return seen >= 2 && p->x1 > p->x0 && p->y1 > p->y0;
}

static int column_of(const struct plot *p, double spp)
{
    return (int)lround((log(spp) - p->x0) / (p->x1 - p->x0) * (PLOT_COLUMNS - 1));
}

static int row_of(const struct plot *p, double error)
{
    return (int)lround((p->y1 - log(error)) / (p->y1 - p->y0) * (ROWS - 1));
}

static void fill(struct plot *p, const struct remote_curve *c)
{
    for (int r = 0; r < ROWS; r++) {
        memset(p->cell[r], ' ', PLOT_COLUMNS);
        p->cell[r][PLOT_COLUMNS] = 0;
    }
    if (c->target_error > 0)
        for (int x = 0; x < PLOT_COLUMNS; x += 2)
            p->cell[row_of(p, c->target_error)][x] = '-';
    const struct remote_point last = c->points[c->count - 1];
    const int from = column_of(p, last.spp);
    const int to = c->forecast_spp > last.spp ? column_of(p, c->forecast_spp) : from;
    const int high = row_of(p, last.error), low = row_of(p, fmin(last.error, c->target_error));
    for (int x = from + 1; x <= to; x++)
        p->cell[high + (int)lround((double)(low - high) * (x - from) / (to - from))][x] = '.';
    for (size_t i = 0; i < c->count; i++)
        if (is_point(c, i))
            p->cell[row_of(p, c->points[i].error)][column_of(p, c->points[i].spp)] = '*';
}

/* "12 %", "0.4 %"; of the highest, the middle and the lowest row, and of the target's. */
static void name_row(const struct plot *p, const struct remote_curve *c, int row, char out[12])
{
    const int target = c->target_error > 0 ? row_of(p, c->target_error) : -1;
    *out = 0;
    if (row == target)
        snprintf(out, 12, "%.3g %%", 100 * c->target_error);
    else if (row == 0 || row == ROWS - 1 || (row == ROWS / 2 && target != row))
        snprintf(out, 12, "%.2g %%", 100 * exp(p->y1 - (p->y1 - p->y0) * row / (ROWS - 1)));
}

bool plot_draw(const struct remote_curve *c, char out[PLOT_BYTES])
{
    struct plot p;
    char name[12];
    size_t used = 0;
    *out = 0;
    if (!frame(&p, c) || !is_point(c, c->count - 1))
        return false;
    fill(&p, c);
    for (int r = 0; r < ROWS; r++) {
        name_row(&p, c, r, name);
        used += (size_t)snprintf(out + used, PLOT_BYTES - used, "%8s |%s\n", name, p.cell[r]);
    }
    used += (size_t)snprintf(out + used, PLOT_BYTES - used, "%8s +", "");
    memset(out + used, '-', PLOT_COLUMNS);
    used += PLOT_COLUMNS;
    char least[16], most[16];
    snprintf(least, sizeof least, exp(p.x0) < 1e6 ? "%.0f" : "%.3g", exp(p.x0));
    snprintf(most, sizeof most, exp(p.x1) < 1e6 ? "%.0f" : "%.3g", exp(p.x1));
    snprintf(out + used, PLOT_BYTES - used, "\n%10s%-24s%16s%24s\n", "", least, "samples per pixel",
             most);
    return true;
}
