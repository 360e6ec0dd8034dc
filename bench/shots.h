/* shots.h - the rays that kernels are raced with, the same plain bytes for each.
 *
 * A kernel is given an array of shots and fills an array of hits; whatever it wants a ray to look
 * like, it makes inside its time, as it would in a renderer.
 * SPDX-License-Identifier: MIT */
#ifndef BENCH_SHOTS_H
#define BENCH_SHOTS_H

#include "common/trace/stage.h"

struct shot {
    float origin[3], t_min; /* t_min is always 0: origins are already off the surface */
    float dir[3], t_max;
};

struct shot_hit {
    float t;
    float u, v;
    uint32_t
        prim; /* as the kernel numbers them; SHOTS_MISS: none. Any-hit: 0 or SHOTS_MISS, no t */
};

#define SHOTS_MISS UINT32_MAX

enum shots_kind { SHOTS_PRIMARY, SHOTS_BOUNCE, SHOTS_SHADOW, SHOTS_KINDS };

struct shots {
    const struct shot *list;
    size_t count;
    enum shots_kind kind; /* SHADOW asks for any hit, PRIMARY is coherent */
};

const char *shots_name(enum shots_kind);

/* [begin, end) of them, end cut off at their number. */
struct shots shots_slice(const struct shots *, size_t begin, size_t end);

/* Fills sets[kind] for each kind with memory of the arena.
 *   PRIMARY  through the centre of every pixel of the stage's film, row by row
 *   BOUNCE   `count`, from the primary rays' hits in pixel order, cosine-distributed to the side
 * they came from SHADOW   as many, from the same to random points of the parallelogram lamp
 * (corner, a, b), those below the surface's horizon left out; they end just before it Fewer when
 * almost nothing is seen or lit. */
void shots_make(const struct stage *, const vec3 lamp[3], size_t count, struct arena *,
                struct shots sets[SHOTS_KINDS]);

#endif
