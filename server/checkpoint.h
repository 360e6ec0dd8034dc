/* checkpoint.h - a film on disk: what a crash cannot take back (STATE/jobs/ID/film).
 *
 * One file with everything that belongs together: the sums, which passes they are made of, and
 * the counters that went with them, closed by a SHA-256. It is written whole and renamed, so there
 * is always either the old film or the new one. All integers little-endian:
 *
 *     "SMLTFILM" | u32 version | u32 tile_count | u64 job | u64 generation
 *     u32 x_begin y_begin x_end y_end tile_px key_count
 *     u64 samples passes_done cpu_us invalid_count elapsed_ms | key_count x (u32 x y sample)
 *     u64 camera_rays bounce_rays shadow_rays plain_vertices other_vertices units
 *     u32 degenerate nonfinite
 *     u32 merged[tile_count] | f64 sum[] | f32 replicate[] | u32 spp[] | u32 layers, f64 layer[]
 *     blocks: (f64 sum square clamped cut, u64 met, f32 top[16])[] | f32 variance[][4]
 *     64 hex digits of SHA-256
 *
 * That is version 3. Films of older versions have no blocks: they are refused, and their jobs begin
 * anew. Any one thread. Errors: ERR_NOT_FOUND; ERR_INPUT: not a whole film of this job; ERR_IO.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_CHECKPOINT_H
#define SERVER_CHECKPOINT_H

#include "server/store.h"

struct checkpoint {
    struct store_job row; /* identity and counters */
    struct film film;
    uint32_t *merged; /* [tile_count], heap */
    uint32_t tile_count;
    uint64_t generation;
};

bool checkpoint_write(struct checkpoint *, const char *path, struct err *) MUST_CHECK;

/* row and tile_count say what is expected; fills film, merged, generation, and the row's counters.
 * False: nothing to release. */
bool checkpoint_read(struct checkpoint *, const char *path, struct err *) MUST_CHECK;
void checkpoint_release(struct checkpoint *);

#endif
