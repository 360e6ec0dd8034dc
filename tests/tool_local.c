/* tool_local SCENE OUT.exr [--threads N] [--tile N]: renders to the document's spp, or in one
 * thread to its error, in this one process and prints the image's digest. What farms are compared
 * with, and the baseline of bench/. SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/image.h"
#include "server/image.h"
#include "tests/adapt.h"
#include "tests/local.h"

static uint32_t number_after(int argc, char **argv, const char *flag, uint32_t otherwise)
{
    for (int i = 3; i + 1 < argc; i++)
        if (!strcmp(argv[i], flag))
            return (uint32_t)strtoul(argv[i + 1], NULL, 10);
    return otherwise;
}

/* Without layers. */
static void render_to_error(const struct local *l, uint32_t tile_px, struct film *film)
{
    const struct scene_film *f = &l->disk.scene.film;
    const struct scene_target *target = &l->disk.scene.settings.target;
    struct adapt a;
    adapt_init(&a,
               (struct tile_rect){f->crop_x_begin, f->crop_y_begin, f->crop_x_end, f->crop_y_end},
               tile_px);
    adapt_run(&a, target->error, target->spp, adapt_render, l->stage);
    *film = a.film;
    a.film = (struct film){0};
    adapt_release(&a);
}

int main(int argc, char **argv)
{
    if (argc < 3) {
        fprintf(stderr, "usage: tool_local SCENE OUT.exr [--threads N] [--tile N]\n");
        return 2;
    }
    struct local l;
    local_open(&l, argv[1]);
    struct film film;
    const uint32_t tile_px = number_after(argc, argv, "--tile", TILE_DEFAULT_PX);
    if (l.disk.scene.settings.target.error > 0)
        render_to_error(&l, tile_px, &film);
    else
        local_render(&l, tile_px, number_after(argc, argv, "--threads", 1), &film);
    const struct scene_film *f = &l.disk.scene.film;
    const struct image image = image_from_film(&film, f->width_px, f->height_px, &l.arena);
    char digest[HASH_HEX];
    image_digest(&image, digest);
    const struct image_facts facts = {.job = "local",
                                      .document = "",
                                      .target = "{}",
                                      .report = "{}",
                                      .digest = digest,
                                      .spp = l.disk.scene.settings.target.spp};
    struct err err;
    const bool ok = image_write_exr(&image, &facts, IMAGE_ZIP, argv[2], &err);
    printf("%s\n", ok ? digest : err.text);
    film_release(&film);
    local_release(&l);
    return ok ? 0 : 1;
}
