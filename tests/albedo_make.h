/* albedo_make.h - the table of common/trace/albedo_table.h, made anew by quadrature.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_ALBEDO_MAKE_H
#define TESTS_ALBEDO_MAKE_H

#include "common/trace/albedo_table.h"

/* Single entries of `one` and `two`. */
uint16_t albedo_make_one(uint32_t index);
uint16_t albedo_make_two(uint32_t index);

/* Means of what stands in the table's `one` and `two`. */
float albedo_make_mean_one(const struct albedo_table *, uint32_t index);
float albedo_make_mean_two(const struct albedo_table *, uint32_t index);

#endif
