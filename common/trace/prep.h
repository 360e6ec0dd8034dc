/* prep.h - scene -> stage: transforms baked, triangles sorted out, emitters listed, BVH built.
 *
 * Deterministic: the same scene gives the same bytes. Degenerate and non-finite triangles
 * are dropped and counted. Meshes must be loaded (mesh_read). Fails with ERR_LIMIT
 * only (more than 2^30 primitives); the scene has been checked before.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PREP_H
#define COMMON_TRACE_PREP_H

#include "common/trace/stage.h"

/* The block is memory of `arena`, 64-aligned; `scratch` holds what is needed on the way only. */
bool prep_stage(const struct scene *, struct arena *arena, struct arena *scratch,
                const struct stage **stage, struct err *) MUST_CHECK;

#endif
