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

struct accel_box *build_boxes(struct accel_mesh); /* of each triangle; the caller frees them */

void build_push(struct accel_list *, uint32_t);

/* Adds from[begin, end); where in the list they begin. */
uint32_t build_push_all(struct accel_list *, const struct accel_list *from, size_t begin,
                        size_t end);

/* An array with room for `count` elements: the old one, or a larger one with its elements. */
void *build_grow(void *old, size_t *room, size_t count, size_t size);

/* False, with the reason, when so many bytes or the time are beyond the limits. To be asked for
 * each node; the clock, which costs as much as a small node, is looked at for the larger ones. */
bool build_within(const struct accel_limits *, uint64_t bytes, size_t triangles,
                  struct err *) MUST_CHECK;

#endif
