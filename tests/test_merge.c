/* merge.c: exactly once, in order, whatever the order of arrival.
 * SPDX-License-Identifier: MIT */
#include "server/merge.h"

#include <stdlib.h>
#include <string.h>

#include "server/round.h"
#include "server/sched.h"
#include "tests/fake_job.h"
#include "tests/tap.h"

enum { WIDTH = 24, HEIGHT = 20 }; /* 9 tiles, some of them cut */

static const struct scene_target to_128 = {.spp = 128}; /* 5 passes */

static enum merge_result give(struct job *j, uint32_t tile, uint32_t pass)
{
    struct arena arena = {0};
    const struct wire_samples w = fake_job_payload(j, tile, pass, .7f, &arena);
    struct err err;
    const bool fine = merge_check(j, &w, &err);
    const enum merge_result r = merge_deliver(j, &w, 0);
    arena_release(&arena);
    return fine ? r : MERGE_UNWANTED;
}

static bool film_equal(const struct film *a, const struct film *b)
{
    const size_t pixels = tile_rect_pixels(a->window);
    return !memcmp(a->sum, b->sum, pixels * 3 * sizeof *a->sum) &&
           !memcmp(a->replicate, b->replicate, pixels * FILM_CHANNELS * sizeof *a->replicate) &&
           !memcmp(a->spp, b->spp, pixels * sizeof *a->spp);
}

static struct job *in_order(void)
{
    struct job *j = fake_job_open(WIDTH, HEIGHT, to_128);
    for (uint32_t p = 0; p < job_passes(j); p++)
        for (uint32_t t = 0; t < j->tile_count; t++)
            give(j, t, p);
    return j;
}

/* Each delivery is of a random tile and a random pass of its window, again and again. */
static void any_order(const struct job *want, unsigned seed)
{
    struct job *j = fake_job_open(WIDTH, HEIGHT, to_128);
    srand(seed);
    uint64_t twice = 0, unwanted = 0;
    for (int i = 0; i < 100000 && !round_is_last(j); i++) {
        const uint32_t tile = (uint32_t)rand() % j->tile_count;
        const uint32_t pass = (uint32_t)rand() % job_passes(j);
        const bool known =
            pass < j->tiles[tile].merged ||
            (job_in_window(j, tile, pass) && job_slot(j, tile, pass)->state == SLOT_HELD);
        switch (give(j, tile, pass)) {
        case MERGE_DUPLICATE:
            twice += known;
            break;
        case MERGE_UNWANTED:
            unwanted++;
            break;
        case MERGE_STALE:
            twice++; /* never */
            break;
        case MERGE_MERGED:
        case MERGE_HELD:
            twice -= known; /* never */
            break;
        }
    }
    ok(round_is_last(j) && film_equal(&j->film, &want->film),
       "seed %u: the same film to the last bit in any order", seed);
    ok(j->row.duplicates == twice && twice > 0, "%llu duplicates change nothing",
       (unsigned long long)twice);
    ok(j->row.samples == want->row.samples && j->row.passes_done == want->row.passes_done &&
           j->row.cpu_us == want->row.cpu_us && j->row.spp_done == 128,
       "the counters count each pass once");
    ok(j->held_bytes == 0, "nothing is held at the end");
    job_free(j);
}

static void results(void)
{
    struct job *j = fake_job_open(WIDTH, HEIGHT, to_128);
    ok(give(j, 0, 1) == MERGE_HELD, "an early pass is held");
    ok(give(j, 0, 1) == MERGE_DUPLICATE, "and known when it comes again");
    ok(give(j, 0, 4) == MERGE_UNWANTED, "one beyond the window is not kept");
    ok(give(j, 0, 0) == MERGE_MERGED && j->tiles[0].merged == 2, "its turn brings both in");
    ok(give(j, 0, 0) == MERGE_DUPLICATE, "a merged pass is a duplicate");
    ok(j->row.spp_done == 0 && j->rounds_done == 0, "the job has what every pixel has");
    for (uint32_t t = 1; t < j->tile_count; t++)
        give(j, t, 0);
    ok(j->row.spp_done == 8 && j->rounds_done == 1, "a round is complete with its last tile");
    job_free(j);
}

static void refuse(struct job *j, struct wire_samples w, enum err_code code, const char *what)
{
    struct err err = {.text = ""};
    ok(!merge_check(j, &w, &err) && err.code == code, "refused: %s: %s", what, err.text);
}

static void contradictions(void)
{
    struct arena arena = {0};
    struct job *j = fake_job_open(WIDTH, HEIGHT, to_128);
    const struct wire_samples good = fake_job_payload(j, 3, 2, 0, &arena);
    struct wire_samples w = good;
    struct err err;
    ok(merge_check(j, &good, &err), "a payload that agrees is taken");
    w.job++;
    refuse(j, w, ERR_PROTOCOL, "another job");
    w = good;
    w.frame = 1;
    refuse(j, w, ERR_PROTOCOL, "another frame");
    w = good;
    w.tile = j->tile_count;
    refuse(j, w, ERR_PROTOCOL, "a tile that does not exist");
    w = good;
    w.tile = UINT32_MAX;
    refuse(j, w, ERR_PROTOCOL, "the last tile there could be");
    w = good;
    w.tile = 4;
    refuse(j, w, ERR_PROTOCOL, "another tile's rectangle");
    w = good;
    w.samples.rect.x_end++;
    refuse(j, w, ERR_PROTOCOL, "a wider rectangle");
    w = good;
    w.pass = 3;
    refuse(j, w, ERR_PROTOCOL, "another pass's samples");
    w = good;
    w.pass = UINT32_MAX;
    refuse(j, w, ERR_PROTOCOL, "a pass beyond all passes");
    w = good;
    w.pass = 5;
    refuse(j, w, ERR_PROTOCOL, "a pass beyond the job's");
    w = good;
    w.samples.pass.s_end--;
    refuse(j, w, ERR_PROTOCOL, "fewer samples");
    w = good;
    w.samples.partial = true; /* of no block at all */
    w.tile = 3;
    w.pass = 0;
    w.samples.pass = (struct tile_pass){0, 8};
    refuse(j, w, ERR_PROTOCOL, "not all that the pass lacks");
    j->row.settled = true;
    j->row.target.spp = 40;
    struct job *whole = fake_job_open(WIDTH, HEIGHT, to_128);
    w = fake_job_payload(whole, 3, 3, 0, &arena);
    job_free(whole);
    w.job = good.job;
    refuse(j, w, ERR_CONFLICT, "a pass leased before the job settled on less");
    job_free(j);
    arena_release(&arena);
}

static void undecided(void)
{
    struct job *j = fake_job_open(WIDTH, HEIGHT, (struct scene_target){.spp = 128, .seconds = 5});
    ok(give(j, 0, 0) == MERGE_MERGED && give(j, 0, 1) == MERGE_UNWANTED,
       "a seconds target takes nothing of a round it has not decided on");
    job_free(j);
}

/* As from a checkpoint. */
static void reopen(struct job *j, uint32_t rounds_judged)
{
    struct film film = j->film;
    struct adaptive records = j->adaptive;
    j->film = (struct film){0};
    j->adaptive = (struct adaptive){0};
    job_close(j);
    job_open(j, &film, &records, rounds_judged);
}

static void reopened(void)
{
    struct job *want = in_order(), *j = fake_job_open(WIDTH, HEIGHT, to_128);
    for (uint32_t t = 0; t < 5; t++)
        for (uint32_t p = 0; p < 1 + t % 3; p++)
            give(j, t, p);
    reopen(j, 0);
    ok(give(j, 1, 1) == MERGE_DUPLICATE, "after reopening, what was merged still is");
    for (uint32_t p = 0; p < job_passes(j); p++)
        for (uint32_t t = 0; t < j->tile_count; t++)
            give(j, t, p);
    ok(film_equal(&j->film, &want->film), "and the film ends the same");
    job_free(j);
    job_free(want);
}

/* ---- jobs with an error target ---- */

enum { BUSY_W = 56, BUSY_H = 44 };

static struct job *busy(uint32_t tile_px, double error)
{
    const struct scene_target target = {.spp = SCENE_MAX_SPP, .error = error};
    struct store_job row = fake_job_row(BUSY_W, BUSY_H, target);
    row.id = 4711;
    row.tile_px = tile_px;
    return fake_job_of(&row);
}

static enum merge_result give_busy(struct job *j, uint32_t tile, uint32_t pass)
{
    struct arena arena = {0};
    const struct wire_samples w = fake_job_payload(j, tile, pass, 2, &arena);
    struct err err = {.text = ""};
    const bool fine = merge_check(j, &w, &err);
    const enum merge_result r = fine ? merge_deliver(j, &w, 0) : MERGE_UNWANTED;
    if (!fine)
        diag("%s", err.text);
    arena_release(&arena);
    return r;
}

/* As output.c does, by the same functions. True: it is good enough. */
static bool judge(struct job *j)
{
    struct arena arena = {0};
    const uint32_t spp = round_spp(j);
    bool due = false;
    if (adaptive_judges(spp)) {
        const struct adaptive_look look = adaptive_look(&j->film, spp, &j->adaptive, &arena);
        adaptive_add(&j->adaptive, &look);
        due = adaptive_is_due(&j->adaptive, spp);
    }
    if (!due)
        merge_next_round(j, 0);
    arena_release(&arena);
    return due;
}

/* Passes come in any order, early ones too; now and then the job is closed and opened again. */
static void run_busy(struct job *j, unsigned seed)
{
    srand(seed);
    for (bool due = false; !due;) {
        const uint32_t tile = (uint32_t)rand() % j->tile_count;
        const uint32_t pass = j->rounds_done + (uint32_t)rand() % 2;
        if (pass >= j->tiles[tile].merged && round_lacks(j, tile, pass))
            give_busy(j, tile, pass);
        if (round_wants_judge(j))
            due = judge(j);
        if (!due && rand() % 100 == 0)
            reopen(j, j->rounds_judged);
    }
}

static void spp_of(const struct job *j, uint32_t *least, uint32_t *most, uint64_t *sum)
{
    *least = UINT32_MAX;
    *most = 0;
    *sum = 0;
    for (size_t i = 0; i < j->pixels; i++) {
        *least = min_u32(*least, j->film.spp[i]);
        *most = max_u32(*most, j->film.spp[i]);
        *sum += j->film.spp[i];
    }
}

static void blocks_stop(void)
{
    struct job *want = busy(16, .003);
    uint32_t least, most;
    uint64_t sum;
    run_busy(want, 1);
    spp_of(want, &least, &most, &sum);
    ok(least >= 32 && least < most, "an error target: pixels end with %u to %u samples", least,
       most);
    ok(want->row.samples == sum && want->row.spp_done == most, "all of them counted");
    static const uint32_t sides[] = {8, 16, 24, 64};
    for (unsigned i = 0; i < 8; i++) {
        struct job *j = busy(sides[i % 4], .003);
        run_busy(j, 100 + i);
        ok(film_equal(&j->film, &want->film) && j->row.samples == sum,
           "tiles of %u px, order %u: the same film", sides[i % 4], i);
        job_free(j);
    }
    job_free(want);
}

/* Done, and then asked for less error or for more samples. */
static void goes_on(void)
{
    struct job *j = busy(24, .02), *want = busy(16, .001);
    static const double targets[] = {.02, .004, .001};
    uint32_t least, most, first = 0;
    uint64_t sum;
    run_busy(want, 5);
    for (unsigned i = 0; i < countof(targets); i++) {
        j->row.target.error = targets[i];
        reopen(j, j->rounds_judged);
        run_busy(j, 7 + i);
        spp_of(j, &least, &most, &sum);
        first = i == 1 ? least : first;
    }
    ok(first < least && film_equal(&j->film, &want->film),
       "an error of .02, then .004, then .001: the film of .001 at once; what had stopped at %u "
       "goes on",
       first);
    j->row.target = (struct scene_target){.spp = 2 * most};
    reopen(j, j->rounds_judged);
    ok(j->rounds_done == tile_pass_count(least), "samples for all: rounds begin again at %u",
       least);
    struct store_job row = j->row;
    struct job *all = fake_job_of(&row);
    for (uint32_t p = 0; p < job_passes(j); p++)
        for (uint32_t t = 0; t < j->tile_count; t++) {
            if (p >= j->tiles[t].merged)
                give_busy(j, t, p);
            give_busy(all, t, p);
        }
    ok(round_is_last(j) && film_equal(&j->film, &all->film),
       "and it ends as one of so many samples");
    job_free(all);
    job_free(j);
    job_free(want);
}

/* To the first round after which tile 0 has lost a block, and not the others: *before is what its
 * next pass was of. */
static struct job *until_one_stops(struct block_set *before)
{
    struct job *j = busy(64, .003);
    for (uint32_t pass = 0;; pass++) {
        give_busy(j, 0, pass);
        *before = round_blocks(j, 0, pass + 1);
        if (!round_wants_judge(j) || judge(j))
            return j;
        const struct block_set now = round_blocks(j, 0, pass + 1);
        if (!block_set_equal(&now, before))
            return j;
    }
}

static void what_is_too_much(void)
{
    struct arena arena = {0};
    struct block_set before, now;
    struct err err = {.text = ""};
    struct job *j = until_one_stops(&before);
    const uint32_t pass = j->rounds_done;
    now = round_blocks(j, 0, pass);
    ok(block_set_count(&now) > 0 && block_set_count(&now) < block_set_count(&before),
       "%zu of %zu blocks go on after %u samples", block_set_count(&now), block_set_count(&before),
       j->row.spp_done);
    struct wire_samples w = fake_job_payload(j, 0, pass, 2, &arena);
    ok(w.samples.partial && merge_check(j, &w, &err), "a payload of them is taken %s", err.text);
    struct block_set less = now;
    for (size_t i = 0; block_set_equal(&less, &now); i++)
        less.bits[i / 64] &= ~(UINT64_C(1) << i % 64);
    film_samples_restrict(&w.samples, &less);
    refuse(j, w, ERR_PROTOCOL, "one block less");
    film_samples_restrict(&w.samples, &before);
    const uint64_t samples = j->row.samples;
    ok(merge_check(j, &w, &err) && merge_deliver(j, &w, 0) == MERGE_STALE &&
           j->row.samples == samples && job_slot(j, 0, pass)->state == SLOT_READY,
       "one of those that it was before is stale, and changes nothing");
    film_samples_restrict(&w.samples, &now);
    ok(merge_deliver(j, &w, 0) == MERGE_MERGED, "then the right one is merged");
    j->reached = true;
    ok(give_busy(j, 0, pass + 1) == MERGE_UNWANTED, "nothing is wanted of a job that has enough");
    job_free(j);
    arena_release(&arena);
}

/* What is leased and held ahead of a judgement that takes blocks away. */
static void ahead_of_a_judgement(bool held)
{
    struct block_set before;
    struct job *probe = until_one_stops(&before), *j = busy(64, .003);
    const uint32_t last = probe->rounds_done - 1;
    for (uint32_t pass = 0; pass < last; pass++) {
        give_busy(j, 0, pass);
        judge(j);
    }
    give_busy(j, 0, last);
    if (held)
        ok(give_busy(j, 0, last + 1) == MERGE_HELD && j->held_bytes > 0, "an early pass is held");
    else
        sched_grant(j, 0, last + 1, 99);
    judge(j);
    ok(job_slot(j, 0, last + 1)->state == SLOT_READY && j->held_bytes == 0,
       "what was %s for blocks that have stopped is free again", held ? "held" : "leased");
    give_busy(probe, 0, last + 1);
    ok(give_busy(j, 0, last + 1) == MERGE_MERGED && film_equal(&j->film, &probe->film),
       "and comes without them");
    job_free(probe);
    job_free(j);
}

int main(void)
{
    results();
    struct job *want = in_order();
    for (unsigned seed = 1; seed <= 5; seed++)
        any_order(want, seed);
    job_free(want);
    contradictions();
    undecided();
    reopened();
    blocks_stop();
    goes_on();
    what_is_too_much();
    ahead_of_a_judgement(true);
    ahead_of_a_judgement(false);
    return tap_done();
}
