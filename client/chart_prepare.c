/* What all of a chart's parts begin with: the frame made small, a method's stage, runs of it.
 * SPDX-License-Identifier: MIT */
#include "client/chart.h"
#include "common/trace/prep.h"

/* A crop keeps its place. */
struct scene chart_shrunk(const struct scene *scene, uint32_t size_px)
{
    struct scene small = *scene;
    struct scene_film *f = &small.film;
    const uint32_t side = max_u32(f->width_px, f->height_px);
    if (side <= size_px)
        return small;
    const double scale = (double)size_px / side;
    f->width_px = max_u32(1, (uint32_t)(f->width_px * scale + .5));
    f->height_px = max_u32(1, (uint32_t)(f->height_px * scale + .5));
    f->crop_x_begin = min_u32((uint32_t)(f->crop_x_begin * scale), f->width_px - 1);
    f->crop_y_begin = min_u32((uint32_t)(f->crop_y_begin * scale), f->height_px - 1);
    f->crop_x_end = max_u32(f->crop_x_begin + 1, (uint32_t)(f->crop_x_end * scale + .5));
    f->crop_y_end = max_u32(f->crop_y_begin + 1, (uint32_t)(f->crop_y_end * scale + .5));
    return small;
}

bool chart_prepare(const struct scene *scene, const struct chart_method *m,
                   const struct stage **stage, struct arena *arena, struct err *err)
{
    struct scene s = *scene;
    struct arena scratch = {0};
    s.settings.integrator = m->integrator;
    s.settings.strategy = m->strategy;
    s.settings.sampler = m->sampler;
    s.film.layers = 0;
    const bool good = prep_stage(&s, NULL, arena, &scratch, stage, err);
    arena_release(&scratch);
    return good;
}

struct chart_run *chart_make_runs(const struct stage *stage, uint32_t spp, uint32_t n,
                                  uint64_t seed, uint32_t of, struct arena *arena)
{
    struct chart_run *runs = arena_new(arena, struct chart_run, n);
    for (uint32_t i = 0; i < n; i++)
        runs[i] = (struct chart_run){
            .stage = stage,
            .seed = chart_runs_seed(seed, of, i),
            .spp = spp,
            .image = arena_new(arena, double, 3 * chart_runs_pixels(stage)),
        };
    return runs;
}
