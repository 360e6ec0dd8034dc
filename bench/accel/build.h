/* build.h - what the structures share in being built: boxes, arrays that grow, limits.
 * SPDX-License-Identifier: MIT */
#ifndef BENCH_ACCEL_BUILD_H
#define BENCH_ACCEL_BUILD_H

#include "bench/accel/accel.h"

struct accel_box build_empty(void); /* what every box covers */
void build_cover(struct accel_box *, const struct accel_box *by);
struct accel_box build_box(const float v[3][3]);
struct accel_box build_bounds(struct accel_mesh); /* all 0 without triangles */
float build_half_area(const struct accel_box *);  /* 0 of an empty box */

void build_push(struct accel_list *, uint32_t);

/* An array with room for `count` elements: the old one, or a larger one with its elements. */
void *build_grow(void *old, size_t *room, size_t count, size_t size);

/* False, with the reason, when so many bytes or the time are beyond the limits. */
bool build_within(const struct accel_limits *, uint64_t bytes, struct err *) MUST_CHECK;

#endif
