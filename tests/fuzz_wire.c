/* Any bytes as a payload: an error, or a message within limits that can be encoded again.
 * SPDX-License-Identifier: MIT */
#include <stdlib.h>

#include "common/wire.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* What was taken can be said again, of the same blocks. */
static void comes_back(const struct wire_samples *w, struct arena *arena)
{
    struct buf b = {0};
    struct wire_samples back;
    struct err err;
    wire_encode(w, &b);
    if (!wire_decode(&back, b.data, b.size, arena, &err) ||
        back.samples.partial != w->samples.partial ||
        !block_set_equal(&back.samples.active, &w->samples.active) ||
        film_samples_pixels(&back.samples) != film_samples_pixels(&w->samples))
        abort();
    buf_release(&b);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct arena arena = {0};
    struct wire_samples w;
    struct err err;
    if (wire_decode(&w, data, size, &arena, &err)) {
        if (tile_rect_pixels(w.samples.rect) > TILE_MAX_PX * TILE_MAX_PX)
            abort();
        if (w.samples.blocks)
            comes_back(&w, &arena);
    }
    arena_release(&arena);
    return 0;
}
