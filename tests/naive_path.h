/* naive_path.h - the oracle: a path tracer without any trick.
 *
 * Every direction is sampled from the material alone; light counts where a path happens to meet it.
 * No next-event estimation, no MIS, no roulette, independent random numbers, textbook formulas
 * in double. Integrator and max_bounces are obeyed (Whitted's mirrors and glass are
 * those that are smooth). It shares with the core only the stage, the intersections and surface
 * points. Point and distant lights are never met: scenes with them are beyond it, and so are
 * textures, vertex normals and all materials but diffuse ones, mirrors, glass, metal of one width,
 * leaves and panes. Of these there may be mixes, masks and two-sided ones, and bodies of glass may
 * absorb and overlap.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_NAIVE_PATH_H
#define TESTS_NAIVE_PATH_H

#include "common/trace/ray.h"
#include "common/trace/stage.h"
#include "tests/dice.h"
#include "tests/stat/stat.h"

/* Adds one estimate of the radiance along the ray to sum. */
void naive_path_radiance(const struct stage *, struct ray, struct dice *, double sum[3]);

/* Adds one sample of a pixel, box filter only. */
void naive_path_sample(const struct stage *, uint32_t x_px, uint32_t y_px, struct dice *,
                       double sum[3]);

/* Mean of the green channel over so many samples, dealt to the pixels of a frame of 8 x 8. */
struct stat_mean naive_path_mean(const struct stage *, uint32_t samples, uint64_t seed);

#endif
