/* ours.h - our kernel as the race sees it; the only file of the race that knows our tree's layout.
 * SPDX-License-Identifier: MIT */
#ifndef BENCH_OURS_H
#define BENCH_OURS_H

#include "bench/shots.h"

/* Ray by ray: bvh_hit_closest, bvh_hit_any. hits[i] belongs to shot i. */
void ours_trace(const struct stage *, const struct shots *, struct shot_hit *hits);

/* The same by eights: bvh_hit_closest_8, bvh_hit_any_8. */
void ours_trace_eights(const struct stage *, const struct shots *, struct shot_hit *hits);

/* Builds the stage's tree once more, from its triangles (there must be nothing else in it), and
 * throws it away. Returns the CPU time in us, bounding the triangles included, as it is in
 * Embree's. */
int64_t ours_build(const struct stage *);

struct ours_tree {
    /* (sum over inner nodes of their half area + sum over leaves of half area x blocks) / half area
     * of the root. A block is four triangles or what is left of them: what Embree tests at once.
     * This is the formula of its kernels/bvh/bvh_statistics.cpp: what it prints for its own trees.
     */
    double sah;
    uint64_t inner, leaves; /* nodes */
    uint64_t bytes; /* of nodes and leaves; triangles that leaves only point to are not counted */
};

struct ours_tree ours_tree(const struct stage *);

#endif
