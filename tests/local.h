/* local.h - a scene rendered in this process, without a farm: the reference that every farm is held
 * against, through the same core and the same order of sums.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_LOCAL_H
#define TESTS_LOCAL_H

#include "common/film.h"
#include "common/scene_disk.h"
#include "common/trace/stage.h"

struct local {
    struct arena arena; /* of everything below */
    struct scene_disk disk;
    const struct stage *stage;
};

/* Opens, checks and prepares; says what is wrong on stderr and exits when it cannot. */
void local_open(struct local *, const char *path);
void local_release(struct local *);

/* All passes up to the document's spp, tiles shared out among threads. Releases nothing. */
void local_render(const struct local *, uint32_t tile_px, uint32_t threads, struct film *);

#endif
