/* checkpoint.h - a film on disk: what a crash cannot take back (STATE/jobs/ID/film).
 *
 * One file with everything that belongs together: the sums, how many samples they are made of, what
 * was written down of rounds (common/adaptive.h), and the counters, closed by a SHA-256. It is
 * written whole and renamed, so there is always either the old film or the new one. All integers
 * little-endian:
 *
 *     "SMLTFILM" | u32 version | u32 tile_count | u64 job | u64 generation
 *     u32 x_begin y_begin x_end y_end tile_px key_count
 *     u64 samples passes_done cpu_us invalid_count elapsed_ms | key_count x (u32 x y sample)
 *     u64 camera_rays bounce_rays shadow_rays plain_vertices other_vertices units
 *     u32 degenerate nonfinite
 *     f64 sum[] | f32 replicate[] | u32 spp[] | u32 layers, f64 layer[]
 *     blocks: (f64 sum square clamped cut, u64 met, f32 top[16])[] | f32 variance[][4]
 *     u32 rounds_judged rounds | f64 least | u32 spp[rounds] | (f32 error2 neff)[rounds][blocks]
 *     64 hex digits of SHA-256
 *
 * That is version 5. Version 4 is the same, of films whose blocks stopped by another rule; version
 * 3 has u32 merged[tile_count] before sum, which follows from spp, and nothing of rounds. Both are
 * read, but not for a job with an error target, which would not be on the way of one that is asked
 * for now. Films of older versions have no blocks. What is refused begins anew. Any one thread.
 * Errors: ERR_NOT_FOUND; ERR_INPUT: not a whole film of this job; ERR_IO.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_CHECKPOINT_H
#define SERVER_CHECKPOINT_H

#include "common/adaptive.h"
#include "server/store.h"

struct checkpoint {
    struct store_job row; /* identity and counters */
    struct film film;
    struct adaptive adaptive; /* what is written down; its target is the caller's */
    uint32_t rounds_judged;
    uint32_t tile_count;
    uint64_t generation;
};

bool checkpoint_write(struct checkpoint *, const char *path, struct err *) MUST_CHECK;

/* row and tile_count say what is expected; fills film, adaptive, rounds_judged, generation, and the
 * row's counters. False: nothing to release. */
bool checkpoint_read(struct checkpoint *, const char *path, struct err *) MUST_CHECK;
void checkpoint_release(struct checkpoint *);

#endif
