/* leaks.h - rays aimed from inside closed meshes at their vertices and edges: how many get out.
 *
 * Two meshes, each at three distances from the origin of coordinates, where floats are coarser: a
 * wavy ball of 1 m with 992 triangles, and the bunny (bench/meshes.h), 15 m tall and its holes
 * closed. Half of the rays go to vertices, half to edges. Starting points are random ones that the
 * surface winds around once. SPDX-License-Identifier: MIT */
#ifndef BENCH_LEAKS_H
#define BENCH_LEAKS_H

#include "bench/race.h"

enum { LEAKS_ROWS = 6 };

struct leaks {
    const char *mesh;
    float offset; /* m along each axis */
    uint64_t rays;
    uint64_t out[RACE_OURS + 1]; /* of RACE_EMBREE, RACE_ROBUST, RACE_OURS; 0 without Embree */
};

/* rays: of each row. False: the bunny's file is bad. */
bool leaks_count(const char *assets, uint64_t rays, struct leaks rows[LEAKS_ROWS],
                 struct err *) MUST_CHECK;

#endif
