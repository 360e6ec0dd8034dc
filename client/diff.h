/* diff.h - how far one image is from another.
 *
 * With x the image, y the reference and e = 0.01 mean(y), over pixels and channels R, G, B:
 *
 *     relMSE = mean of (x - y)^2 / (y^2 + e^2)
 *
 * the same form as the error a job reports (estimate.h, whose root this is compared with).
 * relMSE-99.9 leaves out the 0.1 % of pixels that differ most. Sums run in pixel order in double.
 * SPDX-License-Identifier: MIT */
#ifndef CLIENT_DIFF_H
#define CLIENT_DIFF_H

#include "common/err.h"
#include "common/image.h"

struct diff {
    bool identical; /* every channel, by name, type and bits, and both windows */
    double relmse, relmse_999;
    double largest;      /* absolute difference of one channel of one pixel... */
    uint32_t x_px, y_px; /* ...here in the frame; 0, 0 when there is none */
    char channel;        /* 'R', 'G' or 'B' */
    double x_value, y_value;
};

/* Fails with ERR_INPUT when the sizes differ, R, G or B is missing, or a pixel of them is not
 * finite. */
bool diff_images(const struct image *x, const struct image *y, struct arena *scratch, struct diff *,
                 struct err *) MUST_CHECK;

#endif
