/* embree.h - Intel's Embree 3, the kernel to be measured against; the only file that knows it is
 * embree.c.
 *
 * Where its header is missing the Makefile takes embree_none.c instead: then embree_version is NULL
 * and nothing else may be called.
 *
 * One thread. A scene's meshes and quads become one geometry each, with copies of their arrays. All
 * calls run with denormals flushed to zero, as its manual asks for, and put the caller's mode back.
 * A failure inside Embree ends the program with its message. SPDX-License-Identifier: MIT */
#ifndef BENCH_EMBREE_H
#define BENCH_EMBREE_H

#include "bench/shots.h"

struct embree; /* a scene with its tree */

enum embree_kind {
    EMBREE_DEFAULT,
    EMBREE_ROBUST, /* RTC_SCENE_FLAG_ROBUST: Pluecker's test, boxes with padding */
    EMBREE_KINDS
};

enum embree_call {
    EMBREE_SINGLE,  /* rtcIntersect1, rtcOccluded1 */
    EMBREE_PACKETS, /* rtcIntersect8, rtcOccluded8: eight consecutive rays */
    EMBREE_STREAM,  /* rtcIntersect1M, rtcOccluded1M: 256 at a time */
};

const char *embree_version(void); /* "3.13.5", or NULL */

struct embree *embree_new(const struct scene *, enum embree_kind);
void embree_free(struct embree *);

/* Builds the tree anew from the geometry; before the first ray. Returns the CPU time in us. */
int64_t embree_build(struct embree *);
/* What the last build left allocated: the tree and its blocks of triangles, not the geometry. */
uint64_t embree_bytes(const struct embree *);

/* hits[i] belongs to shot i. prim: the number inside its geometry. */
void embree_trace(const struct embree *, enum embree_call, const struct shots *,
                  struct shot_hit *hits);

/* Surface area cost of the default tree. Its builder prints it (a device with verbose=2), in units
 * that bench/ours.h repeats. NaN when what it prints is not understood. Builds once more. */
double embree_sah(const struct scene *);

#endif
