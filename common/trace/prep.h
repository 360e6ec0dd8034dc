/* prep.h - scene -> stage: transforms baked, triangles sorted out, emitters listed, BVH built.
 *
 * Deterministic: the same scene gives the same bytes, whatever the crew. Degenerate and non-finite
 * triangles are dropped and counted. Meshes and images must be loaded (mesh_read, image_asset_read).
 * Fails with ERR_LIMIT only (2^32 primitives, 2^27 triangles to be stored, 16 GB of hierarchy or of
 * textures); the scene has been checked before.
 *
 * A mesh is stored once, and its shapes become instances, when it has several that are no
 * lights and their copies would be 2^20 triangles or more.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_PREP_H
#define COMMON_TRACE_PREP_H

#include "common/trace/crew.h"
#include "common/trace/stage.h"

/* crew: threads to help, or NULL. The block is memory of `arena`, 64-aligned; `scratch` holds what
 * is needed on the way only. */
bool prep_stage(const struct scene *, const struct crew *crew, struct arena *arena,
                struct arena *scratch, const struct stage **stage, struct err *) MUST_CHECK;

#endif
