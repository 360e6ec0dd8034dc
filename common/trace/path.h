/* path.h - the path integrator: light along a ray, by following it through the scene.
 *
 * J. Kajiya, "The Rendering Equation", SIGGRAPH 1986, with next-event estimation and multiple
 * importance sampling (E. Veach, L. Guibas, "Optimally Combining Sampling Techniques for Monte
 * Carlo Rendering", SIGGRAPH 1995, power heuristic).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PATH_H
#define COMMON_TRACE_PATH_H

#include "common/trace/ray.h"
#include "common/trace/rng.h"
#include "common/trace/stage.h"

/* Roulette starts after this many bounces: before, paths are few, and most light is theirs. */
enum { PATH_ROULETTE_BEGIN = 3 };

/* One unbiased estimate of the radiance that arrives along the ray (of unit direction), cut at
 * settings.max_bounces scattering events. roulette_begin: the first bounce after which a path may
 * be ended by chance; UINT32_MAX for never. */
rgb path_radiance(const struct stage *, struct ray, const struct rng *, uint32_t roulette_begin);

#endif
