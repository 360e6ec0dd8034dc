/* plot.h - the curve of a job in characters: error against samples per pixel, both logarithmic.
 *
 *      50 % |*
 *           |  *
 *           |     * *
 *       5 % |         *
 *           |           * .
 *       1 % |- - - - - - - - . - -
 *           +-----------------------
 *            8                 4.1 k  samples per pixel
 *
 * `*` was measured, `.` is expected, `-` is the target. Pure; ASCII alone, so that it works on
 * every terminal. SPDX-License-Identifier: MIT */
#ifndef CLIENT_PLOT_H
#define CLIENT_PLOT_H

#include "client/remote.h"

enum { PLOT_LINES = 12, PLOT_COLUMNS = 64, PLOT_BYTES = PLOT_LINES * (PLOT_COLUMNS + 24) };

/* PLOT_LINES lines, each ended by a newline. False, and out is "": there are less than two points
 * to see. */
bool plot_draw(const struct remote_curve *, char out[PLOT_BYTES]);

#endif
