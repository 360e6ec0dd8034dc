/* SPDX-License-Identifier: MIT */
#include "tests/local.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/trace/prep.h"
#include "common/trace/render.h"

static void give_up(const char *path, const struct scene_errors *errors)
{
    for (size_t i = 0; i < errors->count; i++)
        fprintf(stderr, "%s: %s: %s\n", path, errors->list[i].where, errors->list[i].what);
    exit(3);
}

void local_open(struct local *l, const char *path)
{
    *l = (struct local){0};
    struct scene_errors errors = {0};
    uint32_t unread = 0;
    if (!scene_disk_open(&l->disk, path, &l->arena, &errors) ||
        !scene_disk_load(&l->disk, &l->arena, &unread, &errors))
        give_up(path, &errors);
    struct arena scratch = {0};
    struct err err;
    if (!prep_stage(&l->disk.scene, NULL, &l->arena, &scratch, &l->stage, &err)) {
        fprintf(stderr, "%s: %s\n", path, err.text);
        exit(3);
    }
    arena_release(&scratch);
}

void local_release(struct local *l)
{
    arena_release(&l->arena);
}

struct share {
    const struct stage *stage;
    const struct tile_grid *grid;
    struct film *film; /* under the mutex */
    uint32_t spp;
    atomic_uint next; /* tile */
    pthread_mutex_t merge;
};

/* One tile: its passes in order. Merging is a thousandth of the work. */
static void render_tile_passes(struct share *s, uint32_t tile, struct arena *arena)
{
    for (uint32_t p = 0; p < tile_pass_count(s->spp); p++) {
        arena_reset(arena);
        struct film_samples samples =
            film_samples_make(tile_rect_of(s->grid, tile), tile_pass_of(p, s->spp), arena);
        film_samples_add_layers(&samples, s->film->layers, arena);
        render_tile(s->stage, &samples);
        pthread_mutex_lock(&s->merge);
        film_merge(s->film, &samples);
        pthread_mutex_unlock(&s->merge);
    }
}

static void *run(void *arg)
{
    struct share *s = arg;
    struct arena arena = {0};
    for (;;) {
        const uint32_t tile = atomic_fetch_add(&s->next, 1);
        if (tile >= tile_count(s->grid))
            break;
        render_tile_passes(s, tile, &arena);
    }
    arena_release(&arena);
    return NULL;
}

void local_render(const struct local *l, uint32_t tile_px, uint32_t threads, struct film *film)
{
    enum { MOST = 64 };
    const struct scene_film *f = &l->disk.scene.film;
    const struct tile_grid grid = tile_grid_make(
        (struct tile_rect){f->crop_x_begin, f->crop_y_begin, f->crop_x_end, f->crop_y_end}, tile_px);
    film_init(film, grid.window);
    film_add_layers(film, f->layers);
    struct share s = {.stage = l->stage,
                      .grid = &grid,
                      .film = film,
                      .spp = l->disk.scene.settings.target.spp};
    pthread_mutex_init(&s.merge, NULL);
    pthread_t thread[MOST];
    const uint32_t count = min_u32(max_u32(threads, 1), MOST);
    for (uint32_t i = 1; i < count; i++)
        if (pthread_create(&thread[i], NULL, run, &s) != 0)
            abort();
    run(&s);
    for (uint32_t i = 1; i < count; i++)
        pthread_join(thread[i], NULL);
    pthread_mutex_destroy(&s.merge);
}
