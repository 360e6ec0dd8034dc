/* Pilots: what methods make of the same few pixels. And the outlook: more of the one that was
 * chosen, to say what its work will be. SPDX-License-Identifier: MIT */
#include "common/trace/fmath.h"
#include "common/trace/study_shot.h"

enum {
    LEAST_BLOCKS = 8,  /* of an outlook */
    DEEP_BLOCKS = 192, /* to be STUDY_DEEPEST; or fewer, if these say enough: */
    FEW_BLOCKS = 48,
    ROUNDS = 3,
};

#define LN_2    0.69314718055994531
#define AT_BEST 0.15 /* relative error of a forecast, whatever the spread */
#define EVEN    0.1  /* spread of a shot whose blocks are much the same */
#define STEEP   1.05 /* times a slope: so that no job is thought too large */

/* Times the square of the spread, doublings of the noise. Where few blocks have most of it some
 * that have more were not met, more often than not. */
#define UNSEEN      3.0
#define MOST_UNSEEN 1.0

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

static bool pilot(struct study *t, enum plan_candidate_kind k, uint32_t blocks, struct arena *arena)
{
    struct plan_candidate *c = &t->plan->candidates[k];
    struct study_shot *shot = &t->shots[k];
    study_shot_init(shot, stage_of(t, k, arena), arena);
    if (!study_shot_go(shot, t, blocks, STUDY_PILOT))
        return false;
    if (k == PLAN_PATH_MIS)
        study_shot_scale(shot);
    c->pilot = study_shot_sum(shot, &t->shots[PLAN_PATH_MIS]);
    c->tried = true;
    t->plan->studied += (double)shot->samples.work.units;
    return true;
}

bool study_pilots(struct study *t, struct arena *arena)
{
    struct plan *plan = t->plan;
    plan_consider(plan, t->stage->bytes <= STUDY_MOST_BYTES);
    const uint32_t blocks = plan->pilot_pixels / STUDY_BLOCK_PIXELS;
    t->shots = arena_new(arena, struct study_shot, PLAN_REAL);
    for (int k = PLAN_REAL; k-- > 0;) /* the usual method first: others are relative to it */
        if (plan_wants(plan, (enum plan_candidate_kind)k) &&
            !pilot(t, (enum plan_candidate_kind)k, blocks, arena))
            return false;
    return true;
}

/* --- the outlook --- */

static double unseen_of(const struct plan_pilot *p) /* doublings */
{
    const double unseen = UNSEEN * p->spread * p->spread;
    return unseen < MOST_UNSEEN ? unseen : MOST_UNSEEN;
}

/* Samples of a pixel to the target, by the outlook, if the noise is more by so many doublings and
 * its slope so many times as steep. A document without an error says it itself. */
static double spp_to_target(const struct plan *plan, double more, double steep)
{
    const struct plan_pilot *p = &plan->outlook;
    const double square =
        p->variance / p->spp / (plan->error * plan->error) * fmath_exp2(more); /* too large by */
    if (!plan->is_asked)
        return plan->spp;
    if (!(square > 0))
        return FILM_REPLICATES;
    const double doublings = fmath_log2(square) / -(steep * p->slope);
    const double n = p->spp * fmath_exp2(doublings < 40 ? doublings > -40 ? doublings : -40 : 40);
    return n < FILM_REPLICATES ? FILM_REPLICATES : n < plan->spp ? n : plan->spp;
}

/* By which the forecast may be off: two standard errors. */
static double factor_of(const struct plan_pilot *p)
{
    const double error2 = p->spread * p->spread + AT_BEST * AT_BEST;
    return fmath_exp2(2 * __builtin_sqrt(error2) / LN_2);
}

struct outlook {
    struct study *study;
    struct study_shot *shot;
    double had; /* units of work that the shot has taken as a pilot */
    double may; /* that it may take on its own, by what is known of the job */
};

static double spent(const struct outlook *o)
{
    return (double)o->shot->samples.work.units - o->had;
}

/* What it may take goes by the noise that was seen, and later by half of what was not, so that no
 * job is thought too large. What is known since some blocks are deep is not given up for what all
 * say. */
static void look(struct outlook *o)
{
    struct plan *plan = o->study->plan;
    study_shot_scale(o->shot);
    plan->outlook = study_shot_sum(o->shot, o->shot);
    if (!o->shot->is_picked && o->shot->reached >= STUDY_DEEP)
        return;
    const double more = o->shot->is_picked ? 0.5 * unseen_of(&plan->outlook) : 0;
    const double job = spp_to_target(plan, more, STEEP) * plan->outlook.work * (double)plan->pixels;
    const double all = PLAN_SHARE * job - plan->studied, most = PLAN_OUTLOOK_SHARE * job;
    o->may = all < most ? all : most;
}

static uint32_t blocks_for(double units, double each)
{
    const double blocks = each > 0 && units > 0 ? units / each : 0;
    return blocks < STUDY_BLOCKS ? (uint32_t)blocks : STUDY_BLOCKS;
}

/* The first half. No more than twice as wide at once: what is known of the job changes on the way.
 */
static bool widen(struct outlook *o)
{
    struct study_shot *shot = o->shot;
    for (;;) {
        const double pixel = o->study->plan->outlook.work * study_depth_spp[STUDY_FIRST];
        const uint32_t more = blocks_for(0.5 * o->may - spent(o), pixel * shot->block_pixels);
        const uint32_t blocks = min_u32(shot->blocks + min_u32(more, shot->blocks), STUDY_BLOCKS);
        if (blocks == shot->blocks)
            return true;
        if (!study_shot_go(shot, o->study, blocks, STUDY_FIRST))
            return false;
        look(o);
    }
}

static uint32_t deep_blocks(const struct outlook *o, double each, enum study_depth depth)
{
    const double more = study_depth_spp[depth] - study_depth_spp[STUDY_FIRST];
    return blocks_for(o->may - spent(o), each * more);
}

static bool deepen(struct outlook *o)
{
    struct study_shot *shot = o->shot;
    const double each = study_shot_price(shot);
    const uint32_t enough = o->study->plan->outlook.spread < EVEN ? FEW_BLOCKS : DEEP_BLOCKS;
    enum study_depth depth = STUDY_DEEPEST;
    uint32_t blocks = deep_blocks(o, each, depth);
    if (blocks < enough && shot->reached < depth)
        blocks = deep_blocks(o, each, depth = STUDY_DEEP);
    if (blocks < LEAST_BLOCKS)
        return true;
    if (!study_shot_deepen(shot, o->study, blocks, depth))
        return false;
    look(o);
    return true;
}

static bool make_outlook(struct outlook *o)
{
    struct study *t = o->study;
    const double pixels = PLAN_OUTLOOK_SHARE * (double)t->plan->pixels;
    const uint32_t first = blocks_for(pixels, o->shot->block_pixels);
    const uint32_t blocks = max_u32(o->shot->blocks, min_u32(max_u32(first, 1), LEAST_BLOCKS));
    if (!study_shot_go(o->shot, t, blocks, STUDY_FIRST))
        return false;
    look(o);
    for (int round = 0; t->plan->is_asked && round < ROUNDS && o->may > 2 * spent(o); round++)
        if (!widen(o) || !deepen(o))
            return false;
    return true;
}

bool study_outlook(struct study *t, struct arena *arena)
{
    struct plan *plan = t->plan;
    struct study_shot *shot = &t->shots[plan->chosen];
    const struct stage *s = stage_of(t, plan->chosen, arena);
    if (!shot->stage)
        study_shot_init(shot, s, arena);
    struct outlook o = {t, shot, (double)shot->samples.work.units, 0};
    if (!make_outlook(&o))
        return false;
    plan->studied += spent(&o);
    plan_forecast(plan, spp_to_target(plan, unseen_of(&plan->outlook), 1),
                  factor_of(&plan->outlook));
    return true;
}
