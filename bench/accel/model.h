/* model.h - the two kinds of scene of the comparison, in any size, and the rays through them.
 *
 * MODEL_BALL: a bumpy ball over a ground, both of triangles of the same size: everything evenly
 * spread, the best case of a uniform grid. MODEL_STADIUM: the same ball, a metre wide, on the floor
 * of an empty hall of 100 m, the "teapot in a stadium" (E. Haines): nearly all triangles in a
 * millionth of the space.
 *
 * Rays come in passes that each stand for the whole image, so that any number of them is a fair
 * sample: half from the camera, in small squares of neighbouring pixels as a tile renderer has
 * them; half leaving what those hit, in a cosine-weighted random direction.
 * SPDX-License-Identifier: MIT */
#ifndef BENCH_ACCEL_MODEL_H
#define BENCH_ACCEL_MODEL_H

#include "bench/accel/accel.h"
#include "common/arena.h"

enum model_kind { MODEL_BALL, MODEL_STADIUM };

enum { MODEL_KINDS = MODEL_STADIUM + 1, MODEL_PASS = 1024 /* rays */ };

const char *model_name(enum model_kind);

/* About so many triangles, at least 24. Memory of the arena. */
struct accel_mesh model_make(enum model_kind, uint32_t triangles, struct arena *);

/* passes * MODEL_PASS rays; `ours` holds the model and finds where bounces start. */
struct ray *model_rays(enum model_kind, const struct accel *ours, uint32_t passes, struct arena *);

#endif
