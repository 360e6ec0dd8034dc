/* wire.h - tile samples <-> bytes. The format is specified in docs/wire.md.
 *
 * Decoding trusts nothing: the result is either complete, finite and within limits,
 * or ERR_PROTOCOL with the field that was wrong. Whether it is what was asked for is
 * the caller's question (merge.c compares it with the lease's record).
 * Pure functions, any thread.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_WIRE_H
#define COMMON_WIRE_H

#include "common/buf.h"
#include "common/err.h"
#include "common/film.h"

enum {
    /* Written. Read are the older ones, too: 3 always of all blocks, 2 without evidence of them, 1
     * without layers */
    WIRE_VERSION = 4,
    WIRE_HEADER_BYTES = 32,
    WIRE_BODY_FIXED_BYTES = 124, /* of versions 3 and 4 */
    WIRE_BLOCK_BYTES = 5 * 8 + BLOCK_TOP * 4,
    WIRE_MAX_BYTES = WIRE_HEADER_BYTES + WIRE_BODY_FIXED_BYTES + BLOCK_SET_MAX / 8 +
                     FILM_MAX_KEYS * 12 +
                     TILE_MAX_PX * TILE_MAX_PX * (FILM_CHANNELS + LAYERS_MAX_CHANNELS) * 4 +
                     TILE_MAX_PX * TILE_MAX_PX / (BLOCK_PX * BLOCK_PX) * WIRE_BLOCK_BYTES,
};

struct wire_samples {
    uint64_t job;
    uint32_t frame, tile, pass;
    uint64_t cpu_us;
    struct film_samples samples;
};

void wire_encode(const struct wire_samples *, struct buf *out); /* appends */

/* samples.sums is memory of the arena. */
bool wire_decode(struct wire_samples *, const void *data, size_t bytes, struct arena *,
                 struct err *) MUST_CHECK;

#endif
