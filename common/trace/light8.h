/* light8.h - light_sample in the lanes of vectors, for scenes with few lights, all of them
 * triangles of the pick table: stage.lamps has them by lanes. The same bits.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_LIGHT8_H
#define COMMON_TRACE_LIGHT8_H

#include "common/trace/sobol8.h"
#include "common/trace/surface8.h"

struct light8_sample { /* as struct light_sample */
    struct vec8 wi, value;
    f32x8 pdf_w;
};

/* Whether the scene is such; else lights are sampled lane by lane. */
static inline bool light8_can(const struct stage *s)
{
    return s->lamps.count != 0;
}

/* lanes: of which there is a surface; the others may hold anything. Bit i of them: something may
 * arrive in lane i; only then it holds anything. `shadow` is written as a whole. */
uint32_t light8_sample(const struct stage *, const struct surface8 *from, uint32_t lanes,
                       const struct sobol8_bits *, struct light8_sample *, struct ray shadow[8]);

/* For prep.c: whether these emitters make such a scene; and its table, once the rest of the stage
 * is there. */
bool light8_fit(const struct emitter *, uint64_t count);
void light8_lamps(const struct stage *, struct stage_lamps *);

#endif
