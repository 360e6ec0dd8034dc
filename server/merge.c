/* SPDX-License-Identifier: MIT */
#include "server/merge.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

static const uint64_t most_cpu_us = (uint64_t)24 * 3600 * 1000000; /* of one pass; a peer's claim */

const char *merge_result_name(enum merge_result r)
{
    static const char *const names[] = {"merged", "held", "duplicate", "unwanted"};
    return names[r];
}

static bool rect_equal(struct tile_rect a, struct tile_rect b)
{
    return a.x_begin == b.x_begin && a.y_begin == b.y_begin && a.x_end == b.x_end &&
           a.y_end == b.y_end;
}

bool merge_check(const struct job *j, const struct wire_samples *w, struct err *err)
{
    const struct film_samples *s = &w->samples;
    if (w->job != j->row.id || w->frame != 0)
        return err_set(err, ERR_PROTOCOL, "payload of job %016llx, frame %u: expected %016llx, 0",
                       (unsigned long long)w->job, w->frame, (unsigned long long)j->row.id);
    if (w->tile >= j->tile_count)
        return err_set(err, ERR_PROTOCOL, "payload tile %u: expected below %u", w->tile,
                       j->tile_count);
    const struct tile_rect rect = tile_rect_of(&j->grid, w->tile);
    if (!rect_equal(rect, s->rect))
        return err_set(err, ERR_PROTOCOL,
                       "payload rectangle [%u, %u, %u, %u]: tile %u is [%u, %u, %u, %u]",
                       s->rect.x_begin, s->rect.y_begin, s->rect.x_end, s->rect.y_end, w->tile,
                       rect.x_begin, rect.y_begin, rect.x_end, rect.y_end);
    if (!s->blocks)
        return err_set(err, ERR_PROTOCOL, "payload without blocks: expected version %d",
                       WIRE_VERSION);
    if (s->partial)
        return err_set(err, ERR_PROTOCOL, "payload of %zu blocks of tile %u: expected all %zu",
                       block_set_count(&s->active), w->tile, block_count(rect));
    if (s->layers != j->row.layers)
        return err_set(err, ERR_PROTOCOL, "payload layers 0x%x: expected 0x%x", s->layers,
                       j->row.layers);
    if (w->pass >= tile_pass_count(SCENE_MAX_SPP))
        return err_set(err, ERR_PROTOCOL, "payload pass %u: expected below %u", w->pass,
                       tile_pass_count(SCENE_MAX_SPP));
    const bool inside = w->pass < job_passes(j);
    const struct tile_pass want = tile_pass_of(w->pass, inside ? j->row.target.spp : SCENE_MAX_SPP);
    if (inside && s->pass.s_begin == want.s_begin && s->pass.s_end == want.s_end)
        return true;
    if (j->row.settled && s->pass.s_begin == want.s_begin)
        return err_set(err, ERR_CONFLICT, "the job stops at %u samples per pixel",
                       j->row.target.spp);
    return err_set(err, ERR_PROTOCOL, "payload pass %u with samples [%u, %u): expected [%u, %u)",
                   w->pass, s->pass.s_begin, s->pass.s_end, want.s_begin, want.s_end);
}

static bool may_merge(const struct job *j, uint32_t pass)
{
    return j->row.target.error <= 0 || pass <= j->rounds_judged;
}

static void count_round(struct job *j, uint32_t merged)
{
    j->tiles_ahead += merged == j->rounds_done + 1;
    if (j->tiles_ahead < j->tile_count)
        return;
    j->row.spp_done = tile_pass_of(j->rounds_done, j->row.target.spp).s_end;
    j->rounds_done++;
    j->tiles_ahead = 0;
    for (uint32_t t = 0; t < j->tile_count; t++)
        j->tiles_ahead += j->tiles[t].merged > j->rounds_done;
}

static void merge_one(struct job *j, uint32_t tile, const struct film_samples *s, uint64_t cpu_us,
                      int64_t now_ms)
{
    struct job_tile *t = &j->tiles[tile];
    const uint64_t samples =
        (uint64_t)tile_rect_pixels(s->rect) * (s->pass.s_end - s->pass.s_begin);
    film_merge(&j->film, s);
    job_trouble_forget(j, tile, t->merged);
    t->slots[t->merged % JOB_LOOKAHEAD] = (struct job_slot){.state = SLOT_READY};
    t->merged++;
    count_round(j, t->merged);
    rate_add(&j->rate, (double)samples, now_ms);
    j->row.samples += samples;
    j->row.passes_done++;
    j->row.cpu_us += cpu_us < most_cpu_us ? cpu_us : most_cpu_us;
    j->row.invalid_count = j->film.invalid_count;
    j->row.key_count = j->film.key_count;
    memcpy(j->row.keys, j->film.keys, sizeof j->row.keys);
    job_touch(j);
}

static size_t held_bytes(const struct film_samples *s)
{
    return block_count(s->rect) * sizeof *s->blocks +
           tile_rect_pixels(s->rect) * (FILM_CHANNELS + layers_channels(s->layers)) * sizeof(float);
}

/* What was waiting for this tile's next pass. */
static void merge_waiting(struct job *j, uint32_t tile, int64_t now_ms)
{
    struct job_tile *t = &j->tiles[tile];
    for (;;) {
        struct job_slot *s = &t->slots[t->merged % JOB_LOOKAHEAD];
        if (s->state != SLOT_HELD || !may_merge(j, t->merged))
            return;
        struct job_held *h = s->held;
        j->held_bytes -= held_bytes(&h->samples);
        merge_one(j, tile, &h->samples, h->cpu_us, now_ms);
        free(h);
    }
}

static void hold(struct job *j, const struct wire_samples *w)
{
    const struct film_samples *s = &w->samples;
    const size_t blocks = block_count(s->rect), pixels = tile_rect_pixels(s->rect);
    const size_t image = pixels * FILM_CHANNELS, layers = pixels * layers_channels(s->layers);
    struct job_held *h = arena_malloc(1, sizeof *h + held_bytes(s));
    float *const sums = (float *)(h->blocks + blocks);
    h->cpu_us = w->cpu_us;
    h->samples = *s;
    h->samples.blocks = h->blocks;
    h->samples.sums = sums;
    h->samples.layer_sums = layers ? sums + image : NULL;
    memcpy(h->blocks, s->blocks, blocks * sizeof *s->blocks);
    memcpy(sums, s->sums, image * sizeof *sums);
    if (layers)
        memcpy(sums + image, s->layer_sums, layers * sizeof *sums);
    *job_slot(j, w->tile, w->pass) = (struct job_slot){.state = SLOT_HELD, .held = h};
    j->held_bytes += held_bytes(s);
}

enum merge_result merge_deliver(struct job *j, const struct wire_samples *w, int64_t now_ms)
{
    struct job_tile *t = &j->tiles[w->tile];
    if (w->pass < t->merged) {
        j->row.duplicates++;
        return MERGE_DUPLICATE;
    }
    const bool undecided =
        j->row.target.seconds > 0 && !j->row.settled && w->pass >= j->rounds_decided;
    if (!job_in_window(j, w->tile, w->pass) || undecided)
        return MERGE_UNWANTED;
    struct job_slot *s = job_slot(j, w->tile, w->pass);
    if (s->state == SLOT_HELD) {
        j->row.duplicates++;
        return MERGE_DUPLICATE;
    }
    if (w->pass > t->merged || !may_merge(j, w->pass)) {
        hold(j, w);
        job_touch(j);
        return MERGE_HELD;
    }
    merge_one(j, w->tile, &w->samples, w->cpu_us, now_ms);
    merge_waiting(j, w->tile, now_ms);
    return MERGE_MERGED;
}

bool merge_is_complete(const struct job *j)
{
    return j->open && j->rounds_done >= job_passes(j);
}

bool merge_wants_judge(const struct job *j)
{
    return j->open && j->row.target.error > 0 && j->rounds_done > j->rounds_judged;
}

void merge_next_round(struct job *j, int64_t now_ms)
{
    assert(merge_wants_judge(j));
    j->rounds_judged = j->rounds_done;
    for (uint32_t t = 0; t < j->tile_count; t++)
        merge_waiting(j, t, now_ms);
}
