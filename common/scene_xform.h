/* scene_xform.h - the affine maps of a document, in double until they are complete.
 *
 * Same pixels (P1): sines are our own polynomial on an exactly reduced angle, so a map has the
 * same bits on every machine, and a quarter turn is exact. Pure functions.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_XFORM_H
#define COMMON_SCENE_XFORM_H

#include "common/vec.h"

struct scene_xform { /* as struct xform: p -> m[.][0..2] p + m[.][3] */
    double m[3][4];
};

struct scene_xform scene_xform_identity(void);
struct scene_xform scene_xform_translate(const double offset[3]);
struct scene_xform scene_xform_scale(const double factors[3]);
/* Counter-clockwise seen against the axis, whose length is free but not 0. */
struct scene_xform scene_xform_rotate(const double axis[3], double angle_deg);
/* First `first`, then `then`. */
struct scene_xform scene_xform_join(const struct scene_xform *then,
                                    const struct scene_xform *first);
/* Camera at `from` that sees `to` in the middle and `up` upright. False: from and to coincide, or
 * `up` lies along the view (or is 0). */
bool scene_xform_look_at(struct scene_xform *, const double from[3], const double to[3],
                         const double up[3]) MUST_CHECK;

void scene_xform_point(const struct scene_xform *, const double p[3], double out[3]);
double scene_xform_determinant(const struct scene_xform *); /* of the linear part */
struct xform scene_xform_round(const struct scene_xform *); /* to the core's precision */

double scene_dot(const double a[3], const double b[3]);
void scene_cross(const double a[3], const double b[3], double out[3]);
double scene_length(const double v[3]);

#endif
