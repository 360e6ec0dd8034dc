/* sheen_make.h - the table of common/trace/sheen.h, made anew by quadrature.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_SHEEN_MAKE_H
#define TESTS_SHEEN_MAKE_H

#include "common/trace/sheen.h"

double sheen_make_albedo(double roughness, double cos);

/* Single entries; the mean of what stands in the table's `albedo`. */
float sheen_make_entry(int width, int cosine);
float sheen_make_mean(const struct sheen_table *, int width);

#endif
