/* coat_make.h - the table of common/trace/coat_table.h, made anew by quadrature.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_COAT_MAKE_H
#define TESTS_COAT_MAKE_H

#include "common/trace/coat_table.h"

/* Single entries. */
uint16_t coat_make_ratio(int ior, int width, int slope);
/* Of what stands in the table's `ratio`. */
float coat_make_mean(const struct coat_table *, int ior, int width);

/* What GGX facets reflect once of light from the cosine. */
double coat_make_albedo(double cos, double alpha, double ior);

#endif
