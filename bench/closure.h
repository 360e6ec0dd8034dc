/* closure.h - whether a mesh is closed, and making it so.
 *
 * Closed: for each edge of a triangle from vertex a to b there is one from b to a, counted with
 * multiplicity. Vertices are told apart by their number, not by where they are.
 * SPDX-License-Identifier: MIT */
#ifndef BENCH_CLOSURE_H
#define BENCH_CLOSURE_H

#include "common/scene.h"

struct closure_edge { /* as the triangle that has it runs along it */
    uint32_t from, to;
};

/* The edges without a partner, sorted; memory of the arena. */
size_t closure_open_edges(const struct mesh *, struct arena *, struct closure_edge **open);

/* Joins every open edge to one new vertex, in the middle of them: a cone on each hole. The arrays
 * become new ones of the arena. */
void closure_fill(struct mesh *, struct arena *);

#endif
