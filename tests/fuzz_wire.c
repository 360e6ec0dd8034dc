/* Any bytes as a payload: an error or a message within limits, never anything else.
 * SPDX-License-Identifier: MIT */
#include <stdlib.h>

#include "common/wire.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct arena arena = {0};
    struct wire_samples w;
    struct err err;
    if (wire_decode(&w, data, size, &arena, &err) &&
        tile_rect_pixels(w.samples.rect) > TILE_MAX_PX * TILE_MAX_PX)
        abort();
    arena_release(&arena);
    return 0;
}
