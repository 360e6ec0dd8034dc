/* albedo.h - how much of the light GGX facets reflect that reflect everything, once; and a lobe for
 * the rest.
 *
 * E(w) is the share of light from w that a facet sends away from the surface, tabled by quadrature
 * (tests/tool_albedo.c). Light that meets a second facet is not in it: 1 - E(w), up to two thirds
 * of the light at alpha 1, is missing from bsdf_conductor.h. C. Kulla, A. Conty, "Revisiting
 * Physically Based Shading at Imageworks", SIGGRAPH 2017 course, puts it back as a lobe of its own,
 *
 *     (1 - E(o)) (1 - E(i)) / (pi (1 - E)),    E = the mean of E(w), weighted by the cosine,
 *
 * which is reciprocal and reflects exactly 1 - E(o). With two widths E depends on four numbers; the
 * paper is about one.
 *
 * What is stored is never less than E, or the lobe would make light: by 0.0005 on the whole with
 * one width, 0.0085 with two. So at least 98 % leaves a white surface, and at most 100.1 %.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_ALBEDO_H
#define COMMON_TRACE_ALBEDO_H

#include "common/trace/facet.h"

/* 1 - E(w): w.z >= 0. */
float albedo_missing(vec3 w, struct facet);

/* Its mean over the hemisphere, weighted by the cosine; above 0. */
float albedo_missing_mean(struct facet);

#endif
