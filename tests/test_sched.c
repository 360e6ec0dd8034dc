/* sched.c: who gets what when; rate.c: how fast it goes.
 * SPDX-License-Identifier: MIT */
#include "server/sched.h"

#include "server/merge.h"
#include "server/round.h"
#include "tests/fake_job.h"
#include "tests/tap.h"

static const struct scene_target to_64 = {.spp = 64};

/* Leases the next pass; false: nothing. */
static bool take(struct sched *s, uint32_t worker, int64_t now_ms, struct sched_pick *p)
{
    if (sched_next(s, worker, now_ms, p) != SCHED_PASS)
        return false;
    sched_grant(p->job, p->tile, p->pass, 1);
    return true;
}

static void deliver(struct sched_pick p, float noise, int64_t now_ms)
{
    struct arena arena = {0};
    const struct wire_samples w = fake_job_payload(p.job, p.tile, p.pass, noise, &arena);
    p.job->lease_count--;
    merge_deliver(p.job, &w, now_ms);
    arena_release(&arena);
}

static struct sched with(struct job *j)
{
    struct sched s = {.held_limit_bytes = 1 << 30};
    sched_add(&s, j);
    return s;
}

static void breadth_first(void)
{
    struct job *j = fake_job_open(16, 16, to_64); /* 4 tiles, 4 passes */
    struct sched s = with(j);
    struct sched_pick p;
    bool in_order = true;
    for (uint32_t i = 0; i < 16; i++)
        in_order &= take(&s, 1, 0, &p) && p.tile == i % 4 && p.pass == i / 4;
    ok(in_order, "pass p of all tiles comes before pass p + 1");
    ok(!take(&s, 1, 0, &p), "what is leased is not leased again");
    job_slot_ready(j, 2, 1);
    ok(take(&s, 1, 0, &p) && p.tile == 2 && p.pass == 1, "what comes back is the next");
    sched_release(&s);
    job_free(j);
}

static void lookahead(void)
{
    struct job *j = fake_job_open(16, 8, (struct scene_target){.spp = 4096}); /* 2 tiles */
    struct sched s = with(j);
    struct sched_pick p, first = {0};
    uint32_t n = 0;
    for (; take(&s, 1, 0, &p); n++)
        if (!n)
            first = p;
    ok(n == 2 * JOB_LOOKAHEAD, "at most %d rounds are out at once", JOB_LOOKAHEAD);
    deliver((struct sched_pick){j, 1, 0}, 0, 1);
    ok(!take(&s, 1, 1, &p), "one tile ahead opens no round");
    deliver(first, 0, 2);
    ok(take(&s, 1, 2, &p) && p.pass == JOB_LOOKAHEAD, "a complete round opens the next one");
    s.held_limit_bytes = 1;
    deliver((struct sched_pick){j, 0, 3}, 0, 3);
    deliver((struct sched_pick){j, 1, 1}, 0, 3);
    job_slot_ready(j, 0, 1);
    job_slot_ready(j, 0, 4);
    ok(take(&s, 1, 3, &p) && p.pass == 1 && !take(&s, 1, 3, &p),
       "with much held, only what is next is leased");
    sched_release(&s);
    job_free(j);
}

static void priorities(void)
{
    struct job *old = fake_job_open(8, 8, to_64), *young = fake_job_open(8, 8, to_64),
               *high = fake_job_open(8, 8, to_64);
    struct sched s = with(young);
    struct sched_pick p;
    high->row.priority = 5;
    sched_add(&s, high);
    sched_add(&s, old);
    ok(sched_next(&s, 1, 0, &p) == SCHED_PASS && p.job == high, "the highest priority first");
    job_pause(high, 0);
    ok(sched_next(&s, 1, 0, &p) == SCHED_PASS && p.job == old,
       "a paused job gives nothing; then age");
    young->row.priority = 1;
    sched_reorder(&s, young);
    ok(sched_next(&s, 1, 0, &p) == SCHED_PASS && p.job == young, "a new priority counts at once");
    sched_remove(&s, young);
    ok(sched_next(&s, 1, 0, &p) == SCHED_PASS && p.job == old, "a removed job gives nothing");
    job_resume(high, 0);
    ok(high->row.state == JOB_QUEUED, "a job resumed before its first lease is queued");
    job_close(old);
    sched_remove(&s, high);
    ok(sched_next(&s, 1, 0, &p) == SCHED_OPEN && p.job == old, "a closed job asks for its film");
    old->starved = true;
    ok(sched_next(&s, 1, 0, &p) == SCHED_NOTHING, "without memory it waits");
    sched_release(&s);
    job_free(old);
    job_free(young);
    job_free(high);
}

static void failures(void)
{
    struct job *j = fake_job_open(8, 8, (struct scene_target){.spp = 8}); /* one pass */
    struct sched s = with(j);
    struct sched_pick p;
    ok(take(&s, 7, 0, &p), "one pass is there");
    ok(job_pass_failed(j, 0, 0, 7, "disk full", 0), "one failure is not the end");
    ok(!take(&s, 7, 10, &p), "who has failed a pass does not get it again at once");
    ok(take(&s, 8, 10, &p), "another worker does");
    ok(job_pass_failed(j, 0, 0, 8, "disk full", 10), "nor two");
    ok(take(&s, 7, 10 + JOB_SHUN_MS, &p), "after a while anyone may try");
    ok(job_pass_failed(j, 0, 0, 8, "disk full", 10), "the same worker counts once");
    ok(take(&s, 9, 20, &p) && !job_pass_failed(j, 0, 0, 9, "disk full", 20),
       "the third worker ends it");
    ok(j->row.failure.has_pass && j->row.failure.tile == 0 && j->row.failure.pass == 0 &&
           j->row.failure.reason[0],
       "with its place and reason: %s", j->row.failure.reason);
    sched_release(&s);
    job_free(j);
}

static void one_worker_fails(void)
{
    struct job *j = fake_job_open(8, 8, (struct scene_target){.spp = 8});
    struct sched s = with(j);
    struct sched_pick p;
    int n = 0;
    int64_t now = 0;
    for (bool go = true; go && n < 100; n++, now += JOB_SHUN_MS)
        go = take(&s, 1, now, &p) && job_pass_failed(j, 0, 0, 1, "no", now);
    ok(n == JOB_MAX_FAILURES, "a lone worker is not asked for ever: %d times", n);
    sched_release(&s);
    job_free(j);
}

static void expiries(void)
{
    struct job *j = fake_job_open(8, 8, (struct scene_target){.spp = 8});
    struct sched s = with(j);
    struct sched_pick p;
    int n = 0;
    for (bool go = true; go && n < 100; n++)
        go = take(&s, 1, 0, &p) && job_pass_expired(j, 0, 0);
    ok(n == JOB_MAX_EXPIRIES && j->row.failure.has_pass, "a pass that lapses %d times ends its job",
       n);
    ok(j->row.expired == (uint64_t)n, "expiries are counted");
    sched_release(&s);
    job_free(j);
}

static void plans(void)
{
    struct job *j = fake_job_open(8, 8, (struct scene_target){.spp = 8});
    j->row.method = STORE_METHOD_OPEN;
    struct sched s = with(j);
    struct sched_pick p;
    ok(sched_next(&s, 7, 0, &p) == SCHED_PLAN && p.job == j,
       "a job without a plan wants one first");
    job_plan_granted(j, 1);
    ok(sched_next(&s, 8, 0, &p) == SCHED_NOTHING && j->lease_count == 1,
       "once, and nothing beside it");
    j->lease_count--; /* as server_lease_end does */
    ok(job_plan_failed(j, 7, "no room", 0), "one failure is not the end");
    ok(sched_next(&s, 7, 10, &p) == SCHED_NOTHING, "who has failed does not get it again at once");
    ok(sched_next(&s, 8, 10, &p) == SCHED_PLAN, "another worker does");
    ok(sched_next(&s, 7, JOB_SHUN_MS, &p) == SCHED_PLAN, "after a while anyone may try");
    int n = 0;
    for (bool go = true; go && n < 100; n++) {
        job_plan_granted(j, 2);
        j->lease_count--;
        go = job_plan_expired(j);
    }
    ok(n == JOB_MAX_EXPIRIES && !j->row.failure.has_pass && j->row.failure.reason[0],
       "a plan that lapses %d times ends its job: %s", n, j->row.failure.reason);
    job_plan_made(j, PLAN_PATH_BSDF);
    ok(take(&s, 7, 0, &p) && p.tile == 0 && p.pass == 0, "with a plan there are passes");
    sched_release(&s);
    job_free(j);
}

static void error_rounds(void)
{
    struct job *j = fake_job_open(16, 8, (struct scene_target){.spp = 4096, .error = .01});
    struct sched s = with(j);
    struct sched_pick p;
    uint32_t n = 0, last = 0;
    for (; take(&s, 1, 0, &p); n++)
        last = p.pass;
    ok(n == 4 && last == 1, "an error target: one round and a guess at the next");
    deliver((struct sched_pick){j, 0, 0}, 1, 1);
    deliver((struct sched_pick){j, 1, 0}, 1, 1);
    ok(round_wants_judge(j), "a complete round is to be judged");
    deliver((struct sched_pick){j, 0, 1}, 1, 1);
    ok(j->film.spp[0] == 8, "nothing of the next one is merged before");
    merge_next_round(j, 2);
    ok(j->film.spp[0] == 16 && j->film.spp[8] == 8, "then what was held is");
    sched_release(&s);
    job_free(j);
}

/* Delivers everything until the job has nothing to lease; each pass takes `pass_ms`. */
static enum sched_result run(struct sched *s, struct job *j, int64_t *now, int64_t pass_ms)
{
    struct sched_pick p;
    for (;;) {
        const enum sched_result r = sched_next(s, 1, *now, &p);
        if (r != SCHED_PASS)
            return r;
        sched_grant(j, p.tile, p.pass, 1);
        if (j->row.state == JOB_QUEUED)
            job_start(j, *now, 1);
        *now += pass_ms *
                (tile_pass_of(p.pass, j->row.target.spp).s_end -
                 tile_pass_of(p.pass, j->row.target.spp).s_begin) /
                8;
        deliver(p, 1, *now);
    }
}

static void seconds(void)
{
    struct job *j = fake_job_open(16, 8, (struct scene_target){.spp = 1 << 20, .seconds = 10});
    struct sched s = with(j);
    int64_t now = 1000;
    const enum sched_result r = run(&s, j, &now, 50); /* 2 tiles x 8 spp: 100 ms; 10 s: 800 spp */
    ok(r == SCHED_SETTLE && j->row.settled,
       "a seconds target settles before the round that would not fit");
    ok(j->row.target.spp > 600 && j->row.target.spp <= 800 && j->row.target.spp % 8 == 0,
       "on what the rate allows, a multiple of 8: %u", j->row.target.spp);
    ok(run(&s, j, &now, 50) == SCHED_NOTHING && round_is_last(j), "then it runs to that count");
    ok(now - 1000 <= 10000 && now - 1000 > 8000, "in the time it was given: %lld ms",
       (long long)(now - 1000));
    sched_release(&s);
    job_free(j);
}

/* With an error target, too: what has stopped takes no time. */
static void seconds_and_error(void)
{
    struct job *j =
        fake_job_open(32, 16, (struct scene_target){.spp = 4096, .error = .00075, .seconds = 10});
    struct sched s = with(j);
    struct sched_pick p;
    struct arena arena = {0};
    int64_t now = 1000;
    uint64_t samples = 0;
    enum sched_result r = SCHED_NOTHING;
    while (r != SCHED_SETTLE && now < 20000) {
        while ((r = sched_next(&s, 1, now, &p)) == SCHED_PASS) {
            const struct block_set blocks = round_blocks(j, p.tile, p.pass);
            const struct tile_pass range = tile_pass_of(p.pass, j->row.target.spp);
            sched_grant(j, p.tile, p.pass, 1);
            if (j->row.state == JOB_QUEUED)
                job_start(j, now, 1);
            now += range.s_end - range.s_begin; /* a tile is one block: 64 samples per ms */
            samples += (range.s_end - range.s_begin) *
                       (uint64_t)block_set_pixels(&blocks, tile_rect_of(&j->grid, p.tile));
            deliver(p, 1, now);
        }
        if (!round_wants_judge(j))
            break;
        if (adaptive_judges(round_spp(j))) {
            const struct adaptive_look look =
                adaptive_look(&j->film, round_spp(j), &j->adaptive, &arena);
            adaptive_add(&j->adaptive, &look);
        }
        merge_next_round(j, now);
    }
    ok(r == SCHED_SETTLE && adaptive_stopped(&j->adaptive, j->row.spp_done) > .4,
       "error and seconds: it settles when half has stopped, on %u", j->row.target.spp);
    ok(j->row.target.spp * (int64_t)j->pixels > 64 * 10000 && samples <= 64 * 10000,
       "on more than all pixels could have had in that time");
    arena_release(&arena);
    sched_release(&s);
    job_free(j);
}

static void seconds_too_few(void)
{
    struct job *j = fake_job_open(16, 8, (struct scene_target){.spp = 1 << 20, .seconds = .001});
    struct sched s = with(j);
    int64_t now = 1000;
    ok(run(&s, j, &now, 500) == SCHED_SETTLE && j->row.target.spp == 8 && round_is_last(j),
       "the first pass is always done");
    sched_release(&s);
    job_free(j);
}

static void seconds_without_workers(void)
{
    struct job *j = fake_job_open(16, 8, (struct scene_target){.spp = 1 << 20, .seconds = 10});
    struct sched s = with(j);
    struct sched_pick p;
    for (int64_t now = 1000; now < 1002; now++)
        if (take(&s, 1, now, &p)) {
            if (j->row.state == JOB_QUEUED)
                job_start(j, now, 1);
            deliver(p, 1, now);
        }
    ok(!sched_time_is_up(j, 10000) && !j->row.settled, "a job that nobody asks for has its time");
    ok(sched_time_is_up(j, 11001) && j->row.target.spp == 8 && round_is_last(j),
       "when it is over, what is complete is the image");
    ok(!sched_time_is_up(j, 12000), "once");
    sched_release(&s);
    job_free(j);
}

static void seconds_after_restart(void)
{
    struct job *j = fake_job_open(16, 8, (struct scene_target){.spp = 1 << 20, .seconds = 100});
    struct sched s = with(j);
    struct sched_pick p;
    int64_t now = 1000;
    for (int i = 0; i < 3; i++) { /* round 0 and one tile of round 1 */
        if (!take(&s, 1, now, &p))
            break;
        if (j->row.state == JOB_QUEUED)
            job_start(j, now, 1);
        deliver(p, 1, now += 100);
    }
    struct film film = j->film;
    struct adaptive none = j->adaptive;
    j->film = (struct film){0};
    j->adaptive = (struct adaptive){0};
    job_clock(j, now);
    job_close(j);
    j->rate = (struct rate){0};
    job_open(j, &film, &none, 0);
    ok(take(&s, 1, now, &p) && p.tile == 1 && p.pass == 1,
       "a round that has begun is not judged anew");
    ok(!take(&s, 1, now, &p), "the next one waits until it is known how fast we are");
    deliver(p, 1, now += 100);
    ok(take(&s, 1, now, &p) && p.pass == 2, "the mean over the life of the job serves until then");
    sched_release(&s);
    job_free(j);
}

static void rates(void)
{
    struct rate r = {0};
    ok(rate_per_second(&r, 5000) == 0, "a rate is unknown at first");
    rate_add(&r, 1e9, 5000);
    ok(rate_per_second(&r, 5000) == 0, "and after one event, which only starts the clock");
    for (int i = 1; i <= 100; i++)
        rate_add(&r, 100, 5000 + 100 * i);
    near(rate_per_second(&r, 15000), 1000, 30, "ten a second of a hundred each");
    for (int i = 1; i <= 200; i++)
        rate_add(&r, 400, 15000 + 100 * i);
    near(rate_per_second(&r, 35000), 4000, 120, "what was more than ten seconds ago is forgotten");
    near(rate_per_second(&r, 40000), 2000, 300, "it falls when nothing comes");
    ok(rate_per_second(&r, 90000) > 0, "after long silence the mean over all time stands");
}

int main(void)
{
    breadth_first();
    lookahead();
    priorities();
    failures();
    one_worker_fails();
    expiries();
    plans();
    error_rounds();
    seconds();
    seconds_and_error();
    seconds_too_few();
    seconds_without_workers();
    seconds_after_restart();
    rates();
    return tap_done();
}
