/* scene_check.h - what takes more than one value to judge: maps, quads, windows.
 *
 * Ranges of single values stand in the readers, beside their keys. The errors say what was found
 * and what is allowed; the reader adds where. Tolerances are relative and admit documents whose
 * numbers were printed with six digits. Pure functions.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_CHECK_H
#define COMMON_SCENE_CHECK_H

#include "common/scene.h"
#include "common/scene_xform.h"

#define SCENE_MAX_ABS 1e18 /* of coordinates: products of two stay finite in float */
#define SCENE_MIN_LENGTH 1e-18 /* of radii: squares stay normal numbers in float */

/* Finite, coordinates in range, not flattening space. */
bool scene_check_affine(const struct scene_xform *, struct err *) MUST_CHECK;
/* Rotations, translations, one scale for all axes, mirrors. */
bool scene_check_similarity(const struct scene_xform *, const char *what, struct err *) MUST_CHECK;
/* Rotations and translations; the columns are then made exactly orthonormal. */
bool scene_check_rigid(struct scene_xform *, struct err *) MUST_CHECK;
/* The image of a point, of a length (`what`: "a radius") under a similarity, lies in range. */
bool scene_check_world(const struct scene_xform *, const double p[3], struct err *) MUST_CHECK;
bool scene_check_length(const struct scene_xform *, const char *what, double length,
                        struct err *) MUST_CHECK;
bool scene_check_quad(double vertices[4][3], struct err *) MUST_CHECK; /* flat and convex */
bool scene_check_crop(const struct scene_film *, struct err *) MUST_CHECK;
bool scene_check_pixels(const struct scene_film *, struct err *) MUST_CHECK;

#endif
