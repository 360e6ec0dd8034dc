/* glass_make.h - the table of common/trace/glass_albedo.h, made anew by quadrature.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_GLASS_MAKE_H
#define TESTS_GLASS_MAKE_H

#include "common/trace/glass_albedo.h"

/* What facets of glass reflect and refract once of light from the cosine, seen where `eta` is far
 * over near: n x n of the visible ones, in double. */
double glass_make_once(double cos, double alpha, double eta, int n);

/* Single entries. */
uint16_t glass_make_missing(bool below, int ior, int width, int height);
/* Of what stands in the table's `missing`. */
float glass_make_mean(const struct glass_albedo_table *, bool below, int ior, int width);

#endif
