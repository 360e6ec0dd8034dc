/* furnace.h - what a surface returns in a white furnace, by its own sampling.
 *
 * The mean of weight / scale (bsdf.h), over a lattice of random numbers: 1 for what takes nothing,
 * whatever its parameters, narrow lobes and single directions included.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_FURNACE_H
#define TESTS_FURNACE_H

#include "common/scene.h"
#include "tests/dice.h"

/* Of the first channel. Rough where that is enough to say whether it lies in [.98, 1.001]. */
double furnace_returned(const struct material *, vec3 wo);

struct furnace { /* what was returned at least and at most */
    double least, most;
};

void furnace_add(struct furnace *, double returned);
bool furnace_is_white(const struct furnace *); /* in [.98, 1.001] */

/* In [least, 1], and often one of the two. */
float furnace_parameter(struct dice *, double least);

#endif
