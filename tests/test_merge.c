/* merge.c: exactly once, in order, whatever the order of arrival.
 * SPDX-License-Identifier: MIT */
#include "server/merge.h"

#include <stdlib.h>
#include <string.h>

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
    for (int i = 0; i < 100000 && !merge_is_complete(j); i++) {
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
        case MERGE_MERGED:
        case MERGE_HELD:
            twice -= known; /* never */
            break;
        }
    }
    ok(merge_is_complete(j) && film_equal(&j->film, &want->film),
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
    w.samples.partial = true;
    refuse(j, w, ERR_PROTOCOL, "not all of the tile");
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

static void reopened(void)
{
    struct job *want = in_order(), *j = fake_job_open(WIDTH, HEIGHT, to_128);
    for (uint32_t t = 0; t < 5; t++)
        for (uint32_t p = 0; p < 1 + t % 3; p++)
            give(j, t, p);
    uint32_t merged[9];
    for (uint32_t t = 0; t < j->tile_count; t++)
        merged[t] = j->tiles[t].merged;
    struct film film = j->film;
    j->film = (struct film){0};
    job_close(j);
    job_open(j, &film, merged);
    ok(give(j, 1, 1) == MERGE_DUPLICATE, "after reopening, what was merged still is");
    for (uint32_t p = 0; p < job_passes(j); p++)
        for (uint32_t t = 0; t < j->tile_count; t++)
            give(j, t, p);
    ok(film_equal(&j->film, &want->film), "and the film ends the same");
    job_free(j);
    job_free(want);
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
    return tap_done();
}
