/* SPDX-License-Identifier: MIT */
#include "common/trace/study.h"

#include <string.h>

#include "common/trace/study_parts.h"
#include "common/trace/work.h"

static uint32_t side(uint32_t begin, uint32_t end)
{
    return end - begin;
}

struct study_place study_place(const struct stage *s, uint32_t i, uint32_t salt)
{
    const struct scene_film *f = &s->film;
    const struct rng rng = {rng_mix(salt), sobol_reverse(i)};
    const struct square q = rng_pair(&rng, 0);
    const uint32_t w = side(f->crop_x_begin, f->crop_x_end);
    const uint32_t h = side(f->crop_y_begin, f->crop_y_end);
    return (struct study_place){f->crop_x_begin + min_u32((uint32_t)(q.u * (float)w), w - 1),
                                f->crop_y_begin + min_u32((uint32_t)(q.v * (float)h), h - 1)};
}

struct rng study_rng(const struct stage *s, struct study_place at, uint32_t sample, uint32_t salt)
{
    return rng_make(rng_mix(s->settings.seed) ^ salt, at.x_px, at.y_px, sample);
}

bool study_is_halted(const struct study *t)
{
    return t->halt && t->halt->is_wanted(t->halt->user);
}

bool study_make(const struct stage *s, const struct study_halt *halt, struct arena *scratch,
                struct plan *plan)
{
    const struct scene_film *f = &s->film;
    const uint64_t pixels =
        (uint64_t)side(f->crop_x_begin, f->crop_x_end) * side(f->crop_y_begin, f->crop_y_end);
    struct study t = {.stage = s, .halt = halt, .plan = plan};
    plan_init(plan, &s->settings, pixels);
    if (!study_features(&t) || !study_eye(&t) || !study_light(&t) || !study_pilots(&t, scratch))
        return false;
    plan->studied += (double)work_units(s, &t.work);
    plan_choose(plan);
    return study_outlook(&t, scratch);
}

/* --- other methods of the same scene --- */

struct stage *study_stage(const struct stage *s, struct arena *arena)
{
    struct stage *copy = arena_alloc(arena, (size_t)s->bytes, 1, STAGE_ALIGN);
    memcpy(copy, s, (size_t)s->bytes);
    return copy;
}

void study_set_method(struct stage *copy, const struct stage *of, struct plan_method m)
{
    struct scene_settings *to = &copy->settings;
    *to = of->settings;
    to->integrator = m.integrator;
    to->strategy = m.strategy;
    to->sampler = m.sampler;
    if (m.integrator == INTEGRATOR_DIRECT)
        to->max_bounces = min_u32(to->max_bounces, 1);
    if (m.integrator == INTEGRATOR_WHITTED)
        to->strategy = STRATEGY_LIGHT;
    copy->lamps = of->lamps; /* as in prep.c */
    if (to->strategy != STRATEGY_MIS)
        copy->lamps.count = 0;
    copy->prices = work_prices(copy);
}
