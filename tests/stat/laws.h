/* laws.h - every law of scattering, for a material from 20 directions.
 *
 * Samples follow the pdf, masses add up to 1, weights are eval / pdf, no light is made, and it goes
 * back the way it came (scatter.h); results are reported by tap.h. The quick tier takes 3 of the 20
 * directions for each material, others for each.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_STAT_LAWS_H
#define TESTS_STAT_LAWS_H

#include "common/scene.h"

enum { LAWS_VIEWS = 20 };

struct laws_view {
    double cos, phi;
};

/* From straight above, from below, along the seam of phi, at 89.9 degrees on both sides. */
extern const struct laws_view laws_views[LAWS_VIEWS];

vec3 laws_direction(const struct laws_view *);

/* Of a program: how many materials share its level of 0.01; what has two sides counts twice. */
void laws_begin(uint32_t materials);

void laws_obeyed(const struct material *, const char *name);

/* With other than 3 directions in the quick tier: for what takes long. */
void laws_obeyed_from(const struct material *, const char *name, uint32_t quick_views);

#endif
