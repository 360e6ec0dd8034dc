/* tool_local SCENE.json OUT.exr [--threads N] [--tile N] [--spp N]
 *
 * Renders in this process: the core, the film and the coordinator's EXR writer without processes, wire or
 * HTTP between them. What a farm renders must have the same pixels (P1), and what it costs more than
 * this is the farm's overhead.
 *
 * Threads take tiles from a counter and render all passes of one in order; tiles share no pixel of
 * the film, so nothing else is locked.
 * SPDX-License-Identifier: MIT */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>

#include "common/clock.h"
#include "common/estimate.h"
#include "common/flags.h"
#include "common/scene_disk.h"
#include "common/trace/prep.h"
#include "common/trace/render.h"
#include "server/image.h"

enum { MAX_THREADS = 64 };

struct work {
    const struct stage *stage;
    struct tile_grid grid;
    uint32_t spp;
    struct film *film;
    pthread_mutex_t merge; /* film_merge also keeps the keys of invalid samples */
    atomic_uint next;
    atomic_int_fast64_t cpu_us;
};

static void render_one(struct work *w, uint32_t tile, struct arena *scratch)
{
    for (uint32_t p = 0; p < tile_pass_count(w->spp); p++) {
        struct film_samples samples = film_samples_make(tile_rect_of(&w->grid, tile),
                                                        tile_pass_of(p, w->spp), scratch);
        render_tile(w->stage, &samples);
        pthread_mutex_lock(&w->merge);
        film_merge(w->film, &samples);
        pthread_mutex_unlock(&w->merge);
        arena_reset(scratch);
    }
}

static void *run(void *user)
{
    struct work *w = user;
    struct arena scratch = {0};
    const int64_t begin_us = clock_thread_cpu_us();
    for (uint32_t t; (t = atomic_fetch_add(&w->next, 1)) < tile_count(&w->grid);)
        render_one(w, t, &scratch);
    atomic_fetch_add(&w->cpu_us, clock_thread_cpu_us() - begin_us);
    arena_release(&scratch);
    return NULL;
}

static void render_all(struct work *w, uint32_t threads)
{
    pthread_t handles[MAX_THREADS];
    uint32_t started = 0;
    while (started < threads && !pthread_create(&handles[started], NULL, run, w))
        started++;
    if (!started)
        run(w);
    for (uint32_t i = 0; i < started; i++)
        pthread_join(handles[i], NULL);
}

static bool write_image(const struct work *w, const char *path, struct arena *arena, struct err *err)
{
    const struct scene_film *f = &w->stage->film;
    const struct image image = image_from_film(w->film, f->width_px, f->height_px, arena);
    char hex[HASH_HEX], target[32];
    image_digest(&image, hex);
    snprintf(target, sizeof target, "{\"spp\": %u}", w->spp);
    const struct image_facts facts = {
        .job = "",
        .document = "",
        .target = target,
        .digest = hex,
        .error = (float)estimate_error(w->film),
        .cpu_seconds = (float)atomic_load(&w->cpu_us) * 1e-6f,
        .spp = w->spp,
    };
    return image_write_exr(&image, &facts, IMAGE_ZIP, path, err);
}

static int render(const char *scene_file, const char *output, uint32_t threads, uint32_t tile_px,
                  uint32_t spp)
{
    struct arena arena = {0}, scratch = {0};
    struct scene_disk disk;
    struct scene_errors errors;
    struct err err = {0};
    uint32_t unread;
    if (!scene_disk_open(&disk, scene_file, &arena, &errors) ||
        !scene_disk_load(&disk, &arena, &unread, &errors)) {
        fprintf(stderr, "%s: %s: %s\n", scene_file, errors.list[0].where, errors.list[0].what);
        return 3;
    }
    struct work w = {.spp = spp ? spp : disk.scene.settings.target.spp};
    bool good = !unread || err_set(&err, ERR_INPUT, "%u meshes have no file", unread);
    good = good && prep_stage(&disk.scene, &arena, &scratch, &w.stage, &err);
    arena_release(&scratch);
    if (good) {
        const struct scene_film *f = &w.stage->film;
        const struct tile_rect window = {f->crop_x_begin, f->crop_y_begin, f->crop_x_end, f->crop_y_end};
        struct film film;
        film_init(&film, window);
        w.film = &film;
        w.grid = tile_grid_make(window, tile_px);
        pthread_mutex_init(&w.merge, NULL);
        render_all(&w, threads);
        good = write_image(&w, output, &arena, &err);
        film_release(&film);
    }
    arena_release(&arena);
    if (!good)
        fprintf(stderr, "tool_local: %s\n", err.text);
    return good ? 0 : 1;
}

int main(int argc, char **argv)
{
    uint32_t threads = 1, tile_px = TILE_DEFAULT_PX, spp = 0;
    const struct flags_entry flags[] = {
        {.name = "threads", .kind = FLAGS_COUNT, .value = &threads, .least = 1, .most = MAX_THREADS},
        {.name = "tile", .kind = FLAGS_COUNT, .value = &tile_px, .least = TILE_MIN_PX, .most = TILE_MAX_PX},
        {.name = "spp", .kind = FLAGS_COUNT, .value = &spp, .least = 1, .most = SCENE_MAX_SPP},
    };
    const char *files[2];
    size_t count;
    struct err err;
    if (!flags_parse(flags, countof(flags), argc - 1, argv + 1, files, 2, &count, &err) || count != 2) {
        fprintf(stderr, "usage: tool_local SCENE.json OUT.exr [--threads N] [--tile N] [--spp N]\n");
        return 2;
    }
    return render(files[0], files[1], threads, tile_px, spp);
}
