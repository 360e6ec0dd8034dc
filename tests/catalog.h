/* catalog.h - all primitives of a stage, in no particular order.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_CATALOG_H
#define TESTS_CATALOG_H

#include "common/trace/stage.h"

/* for (uint64_t at = 0; catalog_next(stage, &at, &id);) */
bool catalog_next(const struct stage *, uint64_t *at, struct stage_id *id);

/* One of them by its number, which must be below prim_count; by a search. */
struct stage_id catalog_id(const struct stage *, uint32_t prim);
struct stage_triangle catalog_triangle(const struct stage *, uint32_t prim); /* in the world */

#endif
