/* crowd.h - one mesh used by many shapes: in every size, squeezed, mirrored, near and far.
 *
 * The same scene can be had with the mesh given once per shape, so that prep.h has nothing to
 * share: what is hit must not depend on that. SPDX-License-Identifier: MIT */
#ifndef TESTS_CROWD_H
#define TESTS_CROWD_H

#include "tests/dice.h"
#include "tests/scenes.h"

struct crowd {
    uint64_t seed;
    uint32_t uses, rings; /* of a ball of 4 rings^2 triangles, 4 rings of them degenerate */
    double reach;         /* the farthest ones are so far away; half are within 10 m */
    bool copies;          /* a mesh for each shape */
};

/* Adds the uses, one of them a lamp (a lamp is never shared), after whatever shapes are there. */
void crowd_add(struct scenes *, uint32_t material, const struct crowd *);

/* A floor, a lamp, spheres, discs and cylinders for them to be among. */
void crowd_add_others(struct scenes *, uint32_t material, uint64_t seed);

#endif
