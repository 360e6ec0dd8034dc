/* swarm.h - many lights round a patch: how well they are chosen, computed and not sampled.
 *
 * A white patch at the origin faces up, and points of light lie on the unit sphere round it, evenly
 * at random, their intensities log-uniform from 1 to 10^4. Occluded: the patch stands at the bottom
 * of a black tube, and sees a tenth of them.
 *
 * With f what light i sends and p the probability of choosing it, one sample f / p has the mean
 * sum f and the second moment sum f^2 / p: all in double, over every light.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_SWARM_H
#define TESTS_SWARM_H

#include "common/trace/surface.h"
#include "tests/scenes.h"

struct swarm {
    struct scenes s;
    const struct stage *stage;
    uint32_t count;
};

void swarm_init(struct swarm *, uint32_t count, bool occluded, uint64_t seed);
void swarm_release(struct swarm *);

/* A point of the patch, lit from the front alone. */
struct surface swarm_point(const struct swarm *, vec3 p);

struct swarm_law {
    double irradiance; /* sum of f */
    double mass;       /* sum of p */
    uint32_t missed;   /* lights that are seen, and never chosen */
    /* Of one sample, the variance over the square of the mean: as chosen by the stage; by power;
     * all alike */
    double ours, power, uniform;
};

struct swarm_law swarm_law(const struct swarm *, const struct surface *);

#endif
