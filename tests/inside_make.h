/* inside_make.h - the table of common/trace/inside.h, made anew by quadrature.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_INSIDE_MAKE_H
#define TESTS_INSIDE_MAKE_H

#include "common/trace/inside.h"

/* The factors for light along a cosine, from below glass: what one facet lets through, by cells,
 * and what facets mirror of it. points: of the quadrature, squared. */
void inside_make_parts(double cos, double ior, double alpha, int points,
                       double parts[INSIDE_PARTS]);

void inside_make_row(int ior, int width, int height, uint16_t row[INSIDE_PARTS]);
void inside_make_mean(const struct inside_table *, int ior, int width, float mean[INSIDE_PARTS]);
void inside_make_several(int ior, int width, float several[INSIDE_CELLS]);

#endif
