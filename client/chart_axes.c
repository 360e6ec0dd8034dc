/* SPDX-License-Identifier: MIT */
#include "client/chart_axes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double part_log(double value, double least, double most)
{
    return log(value / least) / log(most / least);
}

double chart_axes_x(const struct chart_axes *a, double value)
{
    const double part = a->linear_x ? (value - a->x_least) / (a->x_most - a->x_least)
                                    : part_log(value, a->x_least, a->x_most);
    return a->left + part * (a->right - a->left);
}

double chart_axes_y(const struct chart_axes *a, double value)
{
    return a->bottom - part_log(value, a->y_least, a->y_most) * (a->bottom - a->top);
}

bool chart_axes_holds(const struct chart_axes *a, double x, double y)
{
    return x >= a->x_least && x <= a->x_most && y >= a->y_least && y <= a->y_most;
}

#define FAINT "stroke='#e9e9e9'"
#define TICK  "stroke='#222'"

/* Of one axis: 1, 2, 5 of each decade where there are few decades. */
static void ticks(struct buf *b, const struct chart_axes *a, bool is_x)
{
    const double least = is_x ? a->x_least : a->y_least, most = is_x ? a->x_most : a->y_most;
    const bool few = log10(most / least) < 2.5;
    for (int decade = (int)floor(log10(least)); decade <= (int)ceil(log10(most)); decade++)
        for (int m = 1; m < 10; m++) {
            const double value = m * pow(10, decade);
            if (value < least * (1 - 1e-9) || value > most * (1 + 1e-9))
                continue;
            const bool labelled = m == 1 || (few && (m == 2 || m == 5));
            const double at = is_x ? chart_axes_x(a, value) : chart_axes_y(a, value);
            const double length = labelled ? 6 : 3;
            if (labelled && is_x)
                svg_line(b, at, a->top, at, a->bottom, FAINT);
            else if (labelled)
                svg_line(b, a->left, at, a->right, at, FAINT);
            if (is_x)
                svg_line(b, at, a->bottom, at, a->bottom + length, TICK);
            else
                svg_line(b, a->left - length, at, a->left, at, TICK);
            if (!labelled)
                continue;
            const double x = is_x ? at : a->left - 9, y = is_x ? a->bottom + 20 : at + 4;
            if (m == 1)
                svg_text(b, x, y, is_x ? "middle" : "end", "fill='#222'", "10^%d", decade);
            else
                svg_text(b, x, y, is_x ? "middle" : "end", "fill='#222' font-size='10'", "%d·10^%d",
                         m, decade);
        }
}

void chart_axes_grid(struct buf *b, const struct chart_axes *a)
{
    if (!a->linear_x)
        ticks(b, a, true);
    ticks(b, a, false);
}

void chart_axes_clip(struct buf *b, const struct chart_axes *a)
{
    buf_text(b, "<clipPath id='plot'>");
    svg_box(b, a->left, a->top, a->right - a->left, a->bottom - a->top, "");
    buf_text(b, "</clipPath>\n<g clip-path='url(#plot)'>\n");
}

void chart_axes_unclip(struct buf *b)
{
    buf_text(b, "</g>\n");
}

void chart_axes_frame(struct buf *b, const struct chart_axes *a)
{
    svg_box(b, a->left, a->top, a->right - a->left, a->bottom - a->top,
            "fill='none' stroke='#222'");
}

static int by_height(const void *a, const void *b)
{
    const struct chart_axes_name *x = a, *y = b;
    return (x->y > y->y) - (x->y < y->y);
}

void chart_axes_spread(struct chart_axes_name names[], uint32_t n, double step, double bottom)
{
    qsort(names, n, sizeof *names, by_height);
    for (uint32_t i = 1; i < n; i++)
        names[i].y = fmax(names[i].y, names[i - 1].y + step);
    for (uint32_t i = n; i-- > 0; bottom = names[i].y - step)
        names[i].y = fmin(names[i].y, bottom);
}

const char *chart_axes_number(double value, char text[32])
{
    if (isnan(value))
        snprintf(text, 32, "–");
    else if (fabs(value) >= 1e4 || (value != 0 && fabs(value) < 1e-2))
        snprintf(text, 32, "%.2e", value);
    else
        snprintf(text, 32, "%.3g", value);
    /* "1.20e+07" -> "1.20e7" */
    char *e = strchr(text, 'e');
    if (e) {
        int exponent;
        if (sscanf(e + 1, "%d", &exponent) == 1)
            snprintf(e + 1, 8, "%d", exponent);
    }
    return text;
}

const char *chart_axes_title(const char *title, char text[128])
{
    enum { MOST = 78 };
    size_t n = strlen(title);
    if (n > MOST)
        for (n = MOST; n > 0 && ((unsigned char)title[n] & 0xc0) == 0x80;)
            n--;
    snprintf(text, 128, "%.*s%s", (int)n, title, title[n] ? "..." : "");
    return text;
}
