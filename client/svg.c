/* SPDX-License-Identifier: MIT */
#include "client/svg.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

/* Of Okabe and Ito's eight; yellow is too pale on white paper. */
static const char *const colors[SVG_COLORS] = {"#000000", "#0072b2", "#d55e00", "#009e73",
                                               "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f"};

const char *svg_color(uint32_t i)
{
    return colors[i % SVG_COLORS];
}

static void put_escaped(struct buf *b, char c)
{
    if (c == '<')
        buf_text(b, "&lt;");
    else if (c == '&')
        buf_text(b, "&amp;");
    else if (c == '>')
        buf_text(b, "&gt;");
    else if ((unsigned char)c >= ' ')
        buf_append(b, &c, 1);
}

void svg_begin(struct buf *b, double width, double height, const char *title)
{
    buf_text(b,
             "<svg xmlns='http://www.w3.org/2000/svg' width='%.0f' height='%.0f' viewBox='0 0 %.0f "
             "%.0f' font-family='Helvetica, Arial, \"DejaVu Sans\", sans-serif' font-size='12'>\n"
             "<title>",
             width, height, width, height);
    for (const char *c = title; *c; c++)
        put_escaped(b, *c);
    buf_text(b, "</title>\n<defs>\n");
    for (uint32_t i = 0; i < SVG_COLORS; i++)
        buf_text(b,
                 "<pattern id='hatch%u' width='2.6' height='2.6' patternUnits='userSpaceOnUse' "
                 "patternTransform='rotate(45)'><rect width='2.6' height='2.6' fill='#fff'/>"
                 "<rect width='1.2' height='2.6' fill='%s'/></pattern>\n",
                 i, colors[i]);
    buf_text(b, "</defs>\n");
    svg_box(b, 0, 0, width, height, "fill='#fff'");
}

void svg_end(struct buf *b)
{
    buf_text(b, "</svg>\n");
}

void svg_line(struct buf *b, double x1, double y1, double x2, double y2, const char *style)
{
    buf_text(b, "<line x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f' %s/>\n", x1, y1, x2, y2, style);
}

void svg_box(struct buf *b, double x, double y, double width, double height, const char *style)
{
    buf_text(b, "<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' %s/>\n", x, y, width, height,
             style);
}

static void put_points(struct buf *b, const char *element, const double xy[], size_t points,
                       const char *style)
{
    buf_text(b, "<%s points='", element);
    for (size_t i = 0; i < points; i++)
        buf_text(b, "%s%.1f,%.1f", i ? " " : "", xy[2 * i], xy[2 * i + 1]);
    buf_text(b, "' %s/>\n", style);
}

void svg_polyline(struct buf *b, const double xy[], size_t points, const char *style)
{
    put_points(b, "polyline", xy, points, style);
}

void svg_polygon(struct buf *b, const double xy[], size_t points, const char *style)
{
    put_points(b, "polygon", xy, points, style);
}

/* --- markers --- */

struct shape { /* a regular polygon, or with every second corner nearer the middle */
    double corners, radius, turn, inner;
};

static const struct shape shapes[] = {
    [SVG_CIRCLE] = {24, 4, 0, 1},    [SVG_SQUARE] = {4, 5, .125, 1},
    [SVG_DIAMOND] = {4, 5.4, 0, 1},  [SVG_PENTAGON] = {5, 4.8, 0, 1},
    [SVG_HEXAGON] = {6, 4.6, 0, 1},  [SVG_WEDGE] = {3, 5.6, .5, 1},
    [SVG_BAR] = {8, 5.4, 0, .35},    [SVG_CAPSULE] = {12, 5.2, 0, .65},
    [SVG_TRIANGLE] = {3, 5.6, 0, 1}, [SVG_STAR] = {10, 11, 0, .45},
    [SVG_CROSS] = {8, 9, .125, .12},
};

void svg_mark(struct buf *b, enum svg_marker marker, double x, double y, uint32_t color,
              enum svg_fill fill)
{
    double xy[64];
    char style[96];
    const struct shape *s = &shapes[marker];
    for (int i = 0; i < (int)s->corners; i++) {
        const double turn = 6.283185307179586 * (s->turn + i / s->corners);
        const double radius = s->radius * (i % 2 ? s->inner : 1);
        xy[2 * i] = x + radius * sin(turn);
        xy[2 * i + 1] = y - radius * cos(turn);
    }
    const char *ink = svg_color(color);
    if (fill == SVG_HATCHED)
        snprintf(style, sizeof style, "fill='url(#hatch%u)' stroke='%s' stroke-width='1.2'",
                 color % SVG_COLORS, ink);
    else
        snprintf(style, sizeof style, "fill='%s' stroke='%s' stroke-width='1.2'",
                 fill == SVG_FULL ? ink : "#fff", ink);
    svg_polygon(b, xy, (size_t)s->corners, style);
}

/* --- text --- */

void svg_text(struct buf *b, double x, double y, const char *anchor, const char *style,
              const char *fmt, ...)
{
    char text[400];
    va_list args;
    va_start(args, fmt);
    vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    buf_text(b, "<text x='%.1f' y='%.1f' text-anchor='%s' %s>", x, y, anchor, style);
    bool raised = false;
    for (const char *c = text; *c; c++) {
        if (*c == '^' && !raised && c[1]) {
            buf_text(b, "<tspan dy='-4' font-size='75%%'>");
            raised = true;
            continue;
        }
        if (raised && *c == ' ') {
            buf_text(b, "</tspan><tspan dy='4'> ");
            for (c++; *c; c++)
                put_escaped(b, *c);
            raised = true;
            break;
        }
        put_escaped(b, *c);
    }
    buf_text(b, "%s</text>\n", raised ? "</tspan>" : "");
}
