/* cylinder_view.h - what the origin sees of the outside of a cylinder, by quadrature in double: the
 * oracle of light sampling and of the truths with cylinders.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_CYLINDER_VIEW_H
#define TESTS_CYLINDER_VIEW_H

#include "common/vec.h"

struct cylinder_view {
    double solid_angle; /* sr; radiance 1 */
    double irradiance;  /* on a surface with that normal */
};

/* The middle rule on n x n parts of the arc that is seen times the length. */
struct cylinder_view cylinder_view_make(const vec3 ends[2], float radius, vec3 normal, int n);

#endif
