/* chart_axes.h - the plot area of a chart: values to pixels, ticks, labels.
 * SPDX-License-Identifier: MIT */
#ifndef CLIENT_CHART_AXES_H
#define CLIENT_CHART_AXES_H

#include "client/svg.h"

struct chart_axes {
    double left, top, right, bottom; /* of the plot, in pixels */
    double x_least, x_most, y_least, y_most;
    bool linear_x; /* else logarithmic; y always is */
};

double chart_axes_x(const struct chart_axes *, double value);
double chart_axes_y(const struct chart_axes *, double value);
bool chart_axes_holds(const struct chart_axes *, double x, double y);

/* Decades, faint lines and labels "10^n" at the left; and below, if x is logarithmic. */
void chart_axes_grid(struct buf *, const struct chart_axes *);
/* Only inside the plot, until chart_axes_unclip. */
void chart_axes_clip(struct buf *, const struct chart_axes *);
void chart_axes_unclip(struct buf *);
void chart_axes_frame(struct buf *, const struct chart_axes *);

struct chart_axes_name { /* of something in the plot, to be written at its right */
    uint32_t of;
    double x, from; /* where it is */
    double y;       /* where its name goes: at first the same height */
};

/* Sorted by height, `step` apart, none below `bottom`. */
void chart_axes_spread(struct chart_axes_name names[], uint32_t n, double step, double bottom);

/* "2.3e9" and the like, short. */
const char *chart_axes_number(double value, char text[32]);

/* As much of a title as fits on a line: whole letters of UTF-8. */
const char *chart_axes_title(const char *title, char text[128]);

#endif
