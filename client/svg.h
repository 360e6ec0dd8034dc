/* svg.h - SVG text, element by element, into a buffer; coordinates are in pixels, y downward.
 *
 * For figures on paper: white ground, one font, the colours of M. Okabe, K. Ito, "Color Universal
 * Design", 2008, each beside a marker of its own, so that nothing is told by colour alone.
 * SPDX-License-Identifier: MIT */
#ifndef CLIENT_SVG_H
#define CLIENT_SVG_H

#include "common/buf.h"

enum svg_marker {
    SVG_CIRCLE,
    SVG_SQUARE,
    SVG_DIAMOND,
    SVG_PENTAGON,
    SVG_HEXAGON,
    SVG_WEDGE,
    SVG_BAR,
    SVG_CAPSULE,
    SVG_TRIANGLE,
    SVG_STAR,
    SVG_CROSS,
};

enum { SVG_COLORS = 8 };

/* "#rrggbb" of style i, the first of them black. */
const char *svg_color(uint32_t i);

void svg_begin(struct buf *, double width, double height, const char *title);
void svg_end(struct buf *);

/* style: attributes, as in "stroke='#000' stroke-dasharray='4 2'". */
void svg_line(struct buf *, double x1, double y1, double x2, double y2, const char *style);
void svg_box(struct buf *, double x, double y, double width, double height, const char *style);
/* Points by turns: x, y, ... */
void svg_polyline(struct buf *, const double xy[], size_t points, const char *style);
void svg_polygon(struct buf *, const double xy[], size_t points, const char *style);

enum svg_fill { SVG_FULL, SVG_HOLLOW, SVG_HATCHED };

void svg_mark(struct buf *, enum svg_marker, double x, double y, uint32_t color, enum svg_fill);

/* anchor: start, middle or end. The text is escaped. "10^7": what follows a ^ up to a blank is
 * raised. */
void svg_text(struct buf *, double x, double y, const char *anchor, const char *style,
              const char *fmt, ...) PRINTF(6, 7);

#endif
