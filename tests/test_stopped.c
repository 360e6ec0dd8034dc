/* adaptive.c on rendered scenes: is what has stopped as good as was asked for?
 *
 * Each block that stops, of scenes of many kinds, is held against a reference (bench/against.h).
 * The figure of docs/accuracy.md: at a target of e, in 95 % of them the true relMSE is at most (1.2
 * e)^2. A target that is not met with the samples that there are counts with what
 * has stopped by then.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "bench/against.h"
#include "bench/corpus.h"
#include "common/estimate.h"
#include "common/trace/prep.h"
#include "tests/adapt.h"
#include "tests/stability/wild.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum {
    WIDTH_PX = 48,
    HEIGHT_PX = 36,
    TARGETS = 3,
    QUICK_SPP = 128,
    LONG_SPP = 2048,
    WILD_SPP = 1024,
    WILD_SCENES = 24
};

static const double targets[TARGETS] = {.1, .03, .01};

struct found {
    uint32_t scenes, met, stopped, good, half; /* half: at most (1.2 e)^2 / 2 */
};

static void size(struct scene *s, uint32_t seed)
{
    s->film.width_px = s->film.crop_x_end = WIDTH_PX;
    s->film.height_px = s->film.crop_y_end = HEIGHT_PX;
    s->film.crop_x_begin = s->film.crop_y_begin = 0;
    s->settings.seed = seed;
}

/* NULL: prep has refused it. */
static const struct stage *stage_of(struct scene *s, uint32_t seed, struct arena *arena)
{
    struct arena scratch = {0};
    const struct stage *stage;
    struct err err;
    size(s, seed);
    const bool good = prep_stage(s, NULL, arena, &scratch, &stage, &err);
    arena_release(&scratch);
    return good ? stage : NULL;
}

static void count_blocks(const struct adapt *a, const struct film *reference, double target,
                         struct found *f)
{
    const double least = estimate_least(reference), most = 1.44 * target * target;
    for (size_t i = 0; i < a->adaptive.count; i++) {
        if (a->adaptive.stop[i] == ADAPTIVE_NEVER)
            continue;
        const struct tile_rect block = block_rect_of(a->film.window, i);
        const double error2 = against_error2(&a->film, reference, block, least);
        f->stopped++;
        f->good += error2 <= most;
        f->half += error2 <= most / 2;
    }
}

/* From the largest target on, while they are met: each goes on from the last. The reference has
 * twice the samples that a block may have. */
static void judge(struct scene *s, uint32_t most_spp, struct found found[TARGETS])
{
    struct arena arena = {0};
    const struct stage *stage = stage_of(s, 1, &arena), *other = stage_of(s, 2, &arena);
    const struct tile_rect window = {0, 0, WIDTH_PX, HEIGHT_PX};
    struct adapt a, reference;
    adapt_init(&a, window, 64);
    adapt_init(&reference, window, 64);
    bool met = stage && other;
    if (met)
        adapt_run(&reference, 0, 2 * most_spp, adapt_render, other);
    for (uint32_t i = 0; met && i < TARGETS; i++) {
        met = adapt_run(&a, targets[i], most_spp, adapt_render, stage);
        count_blocks(&a, &reference.film, targets[i], &found[i]);
        found[i].scenes++;
        found[i].met += met;
    }
    adapt_release(&a);
    adapt_release(&reference);
    arena_release(&arena);
}

static void corpus(struct found found[TARGETS])
{
    static const uint32_t quick[] = {3, 16, 18, 27}; /* a room, a soft box, the dark, glass */
    const uint32_t count = stat_is_long() ? corpus_count() : countof(quick);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t scene = stat_is_long() ? i : quick[i];
        struct scenes s;
        if (!corpus_make(scene, &s)) {
            skip("%s: its files are not here", corpus_name(scene));
            continue;
        }
        judge(&s.scene, stat_is_long() ? LONG_SPP : QUICK_SPP, found);
        scenes_release(&s);
    }
}

static void wild(struct found found[TARGETS])
{
    for (uint64_t seed = 1; seed <= WILD_SCENES && stat_is_long(); seed++) {
        struct wild w;
        const char *why;
        if (!wild_make(&w, seed, &why))
            continue;
        judge(&w.scene, WILD_SPP, found);
        wild_release(&w);
    }
}

int main(void)
{
    struct found found[TARGETS] = {0};
    corpus(found);
    wild(found);
    for (uint32_t i = 0; i < TARGETS && found[i].stopped; i++) {
        const struct found *f = &found[i];
        diag("target %.0f %%: %u of %u scenes met it; %u blocks stopped, %.1f %% within twice as "
             "little",
             100 * targets[i], f->met, f->scenes, f->stopped, 100. * f->half / f->stopped);
        ok(f->good >= .95 * f->stopped,
           "of blocks stopped at %.0f %%, %.1f %% of %u are within 1.2 of it", 100 * targets[i],
           100. * f->good / f->stopped, f->stopped);
    }
    return tap_done();
}
