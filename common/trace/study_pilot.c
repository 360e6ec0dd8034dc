/* Pilots: what methods make of the same few pixels. And the outlook: more of the one that was
 * chosen, to say what its work will be. SPDX-License-Identifier: MIT */
#include "common/trace/fmath.h"
#include "common/trace/study_shot.h"
#include "common/trace/work.h"

enum {
    FIRST_BLOCKS = 8, /* of an outlook */
    WIDE_BLOCKS = 64,
    DEEP_SPP = 64,
    DEEPEST_SPP = 256, /* where there are STUDY_BLOCKS already */
};

/* What a stage costs to be another method's: a copy. */
static const struct stage *stage_of(struct study *t, enum plan_candidate_kind k,
                                    struct arena *arena)
{
    if (k == PLAN_PATH_MIS)
        return t->stage;
    if (!t->copy)
        t->copy = study_stage(t->stage, arena);
    study_set_method(t->copy, t->stage, plan_method_of(t->plan, k));
    return t->copy;
}

static void count_work(struct study *t, const struct study_shot *shot)
{
    t->plan->studied += (double)work_units(shot->stage, &shot->work);
}

static bool pilot(struct study *t, enum plan_candidate_kind k, const struct study_shot *usual,
                  struct arena *arena)
{
    struct plan_candidate *c = &t->plan->candidates[k];
    struct study_shot shot;
    study_shot_init(&shot, stage_of(t, k, arena), usual->blocks, arena);
    if (!study_shot_go(&shot, t, usual->blocks, usual->spp))
        return false;
    c->pilot = study_shot_sum(&shot, usual);
    c->tried = true;
    count_work(t, &shot);
    return true;
}

bool study_pilots(struct study *t, struct arena *arena)
{
    struct plan *plan = t->plan;
    struct study_shot usual;
    plan_consider(plan, t->stage->bytes <= STUDY_MOST_BYTES);
    if (plan->pilot_pixels == 0)
        return true;
    const uint32_t blocks = plan->pilot_pixels / (STUDY_BLOCK * STUDY_BLOCK);
    study_shot_init(&usual, t->stage, blocks, arena);
    if (!study_shot_go(&usual, t, blocks, STUDY_FIRST_SPP))
        return false;
    study_shot_scale(&usual);
    plan->candidates[PLAN_PATH_MIS].pilot = study_shot_sum(&usual, &usual);
    plan->candidates[PLAN_PATH_MIS].tried = true;
    count_work(t, &usual);
    for (int k = 0; k < PLAN_PATH_MIS; k++)
        if (plan_wants(plan, (enum plan_candidate_kind)k) &&
            !pilot(t, (enum plan_candidate_kind)k, &usual, arena))
            return false;
    return true;
}

/* --- the outlook --- */

/* Samples of a pixel to the target, by the outlook. A document without an error says it itself. */
static double spp_to_target(const struct plan *plan)
{
    const struct plan_pilot *p = &plan->outlook;
    const double square = p->variance / p->spp / (plan->error * plan->error); /* too large by */
    if (!plan->is_asked)
        return plan->spp;
    if (!(square > 0))
        return FILM_REPLICATES;
    const double doublings = fmath_log2(square) / -p->slope;
    const double n = p->spp * fmath_exp2(doublings < 40 ? doublings > -40 ? doublings : -40 : 40);
    return n < FILM_REPLICATES ? FILM_REPLICATES : n < plan->spp ? n : plan->spp;
}

/* Whether the job, by what is known of it, lets the outlook take so many samples. */
static bool may_take(const struct plan *plan, double samples)
{
    return samples <= PLAN_OUTLOOK_SHARE * spp_to_target(plan) * (double)plan->pixels;
}

/* What would tell more, if the job is large enough for it: first wide, since noise may be in a few
 * pixels, then deep, since it may be in a few samples, then wider again. False: nothing. */
static bool widen_or_deepen(const struct plan *plan, const struct study_shot *shot,
                            uint32_t *blocks, uint32_t *spp)
{
    *blocks = shot->blocks;
    *spp = shot->spp;
    if (shot->blocks >= WIDE_BLOCKS && shot->spp < DEEP_SPP &&
        may_take(plan, (double)shot->count * DEEP_SPP))
        *spp = DEEP_SPP;
    else if (2 * shot->blocks <= STUDY_BLOCKS && may_take(plan, 2.0 * shot->count * shot->spp))
        *blocks = 2 * shot->blocks;
    else if (2 * shot->blocks > STUDY_BLOCKS && shot->spp < DEEPEST_SPP &&
             may_take(plan, 4.0 * shot->count * shot->spp))
        *spp = 4 * shot->spp;
    else
        return false;
    return true;
}

bool study_outlook(struct study *t, struct arena *arena)
{
    struct plan *plan = t->plan;
    struct study_shot shot;
    const double first =
        PLAN_OUTLOOK_SHARE * FILM_REPLICATES * (double)plan->pixels / STUDY_FIRST_SPP;
    uint32_t spp = STUDY_FIRST_SPP;
    uint32_t blocks = first < FIRST_BLOCKS * STUDY_BLOCK * STUDY_BLOCK
                          ? max_u32((uint32_t)first / (STUDY_BLOCK * STUDY_BLOCK), 1)
                          : FIRST_BLOCKS;
    study_shot_init(&shot, stage_of(t, plan->chosen, arena), STUDY_BLOCKS, arena);
    do {
        if (!study_shot_go(&shot, t, blocks, spp))
            return false;
        study_shot_scale(&shot);
        plan->outlook = study_shot_sum(&shot, &shot);
    } while (plan->is_asked && widen_or_deepen(plan, &shot, &blocks, &spp));
    count_work(t, &shot);
    plan_forecast(plan, spp_to_target(plan));
    return true;
}
