/* SPDX-License-Identifier: MIT */
#include "common/trace/render.h"

#include <assert.h>
#include <string.h>

#include "common/trace/camera.h"
#include "common/trace/filter.h"
#include "common/trace/layer.h"
#include "common/trace/probe.h"
#include "common/trace/sampler.h"
#include "common/trace/wave.h"
#include "common/trace/work.h"

/* A sample above this is taken for an error. SCENE_MAX_SPP = 2^24 samples below it, weighed by 16/9
 * at most, add up to less than 2^127, so that no sum leaves the range of float. */
#define RENDER_MAX_RADIANCE 0x1p+102f

_Static_assert((int)FILM_REPLICATES == (int)WAVE_LANES, "an octet's rays go together");

/* A pixel's eight samples that differ in their replicate only: what they have in common is done
 * once, and their rays in the lanes of vectors. */
struct octet {
    const struct stage *stage;
    uint32_t x_px, y_px;
    struct rng_pixel rng;
    struct camera_rays rays;
    f32x8 weight;              /* of the elder's samples, if the filter is signed */
    uint32_t elder;            /* whose rays they are; UINT32_MAX: nobody's */
    bool younger;              /* they are the elder's to count */
    uint32_t begun;            /* bit i: starts[i] is the elder's, too */
    struct wave_starts starts; /* for two siblings each */
};

static void octet_init(struct octet *o, const struct stage *s, uint32_t x_px, uint32_t y_px)
{
    o->stage = s;
    o->x_px = x_px;
    o->y_px = y_px;
    o->weight = f32x8_splat(1);
    o->elder = UINT32_MAX;
    rng_pixel_init(&o->rng, s->settings.seed, x_px, y_px);
}

/* Through the lens, if there is one. Apart, so that the pinhole's way stays short. */
__attribute__((noinline)) static void octet_aim(struct octet *o, f32x8 x, f32x8 y)
{
    struct sobol8_square lens = {{0}, {0}};
    if (o->stage->camera.kind == CAMERA_THIN_LENS)
        lens = sampler_elders(&o->stage->settings, &o->rng, RNG_LENS);
    camera_rays_through(&o->stage->camera, x, y, &lens, &o->rays);
}

/* Samples [8 index, 8 index + 8). */
static void octet_go(struct octet *o, uint32_t index)
{
    const struct stage *s = o->stage;
    rng_pixel_go(&o->rng, index);
    o->younger = index % 2 != 0;
    if (o->elder == index / 2)
        return;
    o->elder = index / 2;
    o->begun = 0;
    const struct sobol8_square q = sampler_filter(&s->settings, &o->rng);
    const f32x8 dx = filter_offset(s, q.u), dy = filter_offset(s, q.v);
    const f32x8 x = (float)o->x_px + 0.5f + dx, y = (float)o->y_px + 0.5f + dy;
    if (filter_is_signed(s))
        o->weight = filter_weight(s, dx, dy);
    if (s->camera.kind == CAMERA_PERSPECTIVE)
        camera_rays(&s->camera, x, y, &o->rays);
    else
        octet_aim(o, x, y);
}

/* The camera rays of the replicates whose bit is set in `which`. */
static void octet_begin(struct octet *o, uint32_t which)
{
    struct ray rays[FILM_REPLICATES];
    if (!(which & ~o->begun))
        return;
    for (uint32_t i = 0; i < FILM_REPLICATES; i++)
        rays[i] = camera_rays_at(&o->stage->camera, &o->rays, i);
    wave_begin(o->stage, which, rays, o->rng.replicate, &o->starts);
    o->begun = which;
}

/* Its paths into the wave, numbered from `number` on by replicate. */
static void octet_put(struct octet *o, uint32_t which, struct wave *w, uint32_t number)
{
    octet_begin(o, which);
    if (!o->younger)
        film_work_add(&w->work, &o->starts.work);
    wave_put(w, which, &o->starts, o->rng.replicate, number);
}

/* A sample on its own, in lane 0. */
struct lone {
    struct octet octet;
    struct wave wave;
    rgb radiance[FILM_REPLICATES];
};

/* Its path may scatter so often. */
static rgb go_alone(struct lone *l, const struct stage *s, struct film_key key,
                    uint32_t max_bounces)
{
    const uint32_t replicate = key.sample % FILM_REPLICATES, which = 1u << replicate;
    wave_init(&l->wave, s, PATH_ROULETTE_BEGIN, NULL, l->radiance);
    l->wave.max_bounces = max_bounces;
    octet_init(&l->octet, s, key.x_px, key.y_px);
    octet_go(&l->octet, key.sample / FILM_REPLICATES);
    octet_begin(&l->octet, which);
    l->octet.starts.ends = max_bounces > 0 ? which & ~l->octet.starts.met : which;
    octet_put(&l->octet, which, &l->wave, 0);
    wave_finish(&l->wave);
    return l->radiance[replicate];
}

static rgb sample_alone(const struct stage *s, struct film_key key, uint32_t max_bounces)
{
    struct lone l;
    return go_alone(&l, s, key, max_bounces);
}

rgb render_sample(const struct stage *s, uint32_t x_px, uint32_t y_px, uint32_t sample)
{
    return sample_alone(s, (struct film_key){x_px, y_px, sample}, s->settings.max_bounces);
}

void render_follow(const struct stage *s, struct film_key key, uint32_t bounces,
                   struct render_place *out)
{
    const uint32_t most = s->settings.max_bounces;
    struct lone l;
    out->light = go_alone(&l, s, key, min_u32(bounces, most));
    out->traced = l.wave.work.bounce_rays;
    out->throughput = rgb_gray(1);
    struct surface at = {.material = STAGE_NONE, .emitter = STAGE_NONE};
    const uint32_t replicate = key.sample % FILM_REPLICATES;
    if (bounces > most) {
        out->material = STAGE_NONE;
        return;
    }
    if (bounces == 0 && !s->media && l.octet.starts.met >> replicate & 1) {
        at = wave_first(s, &l.octet.starts, replicate).at;
    } else if (bounces > 0 ? l.wave.cut & 1 : l.octet.starts.met >> replicate & 1) {
        const bool plain = l.wave.plain & 1;
        at = plain ? path8_surface(s, l.wave.lanes.vertex, 0) : l.wave.paths[0].vertex.at;
        out->throughput =
            plain ? vec8_lane(&l.wave.lanes.throughput, 0) : l.wave.paths[0].throughput;
    }
    out->material = at.material;
    out->p = at.p;
    out->ng = at.ng;
    out->shines = at.emitter != STAGE_NONE;
}

/* False for a NaN. */
static bool is_valid(rgb c)
{
    const rgb least = rgb_gray(0), most = rgb_gray(RENDER_MAX_RADIANCE);
    return (i32x4_mask((c >= least) & (c <= most)) & 7) == 7;
}

/* One pixel's pass. */
struct pixel {
    f64x4 sums[FILM_REPLICATES];
    double layers[LAYERS_MAX_CHANNELS];
};

/* A row of pixels. Its octets go through the wave in order, many together, so that its lanes are
 * all but always taken; then what they have found is added up in the same order. (Layers ask for
 * each octet alone: they want its starts as well.) */
enum { ROW_OCTETS = 32 };

struct row {
    struct film_samples *out;
    float *sums, *layers; /* the row's; layers: if there are any */
    uint32_t channels;    /* of layers */
    struct block *blocks; /* the row's */
    struct pixel pixel;
    struct octet octet;
    struct wave wave;
    struct wave_terms terms;
    uint32_t count; /* octets under way */
    struct octet_samples {
        f32x8 weight; /* by replicate, if the filter is signed */
        uint32_t x_px, s_begin, s_end;
    } octets[ROW_OCTETS];
    rgb radiance[ROW_OCTETS * FILM_REPLICATES];
};

static void pixel_begin(struct row *r)
{
    memset(r->pixel.sums, 0, sizeof r->pixel.sums);
    memset(r->pixel.layers, 0, r->channels * sizeof r->pixel.layers[0]);
}

static void pixel_end(struct row *r, uint32_t x_px)
{
    const size_t at = x_px - r->out->rect.x_begin;
    float *sums = r->sums + at * FILM_CHANNELS;
    for (int i = 0; i < FILM_REPLICATES; i++)
        vec3_store(sums + 3 * i, f64x4_round(r->pixel.sums[i]));
    for (uint32_t i = 0; i < r->channels; i++)
        r->layers[at * r->channels + i] = (float)r->pixel.layers[i];
}

static struct block *block_at(const struct row *r, uint32_t x_px)
{
    return &r->blocks[(x_px - r->out->rect.x_begin) / BLOCK_PX];
}

/* The filter's sign and gain, and the clamp, on what sample i of the eight has brought, which was
 * judged before. */
static void weigh(float weight, struct wave_terms *terms, uint32_t i, rgb *radiance)
{
    *radiance *= weight;
    for (uint32_t k = 0; k < terms->count; k++)
        terms->light[k][i] *= weight;
}

/* What goes beyond settings.clamp is taken away, and counted; returns what is left of 1. */
static float clamp_share(const struct stage *s, float x, rgb radiance, float weight,
                         struct block *b)
{
    const float limit = s->settings.clamp, most = rgb_max(radiance);
    if (!(most > limit))
        return 1;
    const float share = limit / most;
    b->clamped += (double)(x * weight) - (double)(x * share * weight);
    return share;
}

/* Where the filter is signed, or samples are clamped: what the sample weighs, and x after the
 * clamp. */
static void weigh_valid(struct row *r, const struct octet_samples *o, uint32_t i, rgb *radiance,
                        float *x)
{
    const struct stage *s = r->octet.stage;
    float weight = filter_is_signed(s) ? o->weight[i] : 1;
    if (s->settings.clamp > 0) {
        const float share = clamp_share(s, *x, *radiance, weight, block_at(r, o->x_px));
        weight *= share;
        *x *= share;
    }
    weigh(weight, &r->terms, i, radiance);
}

/* rgb_luminance of eight. */
static f32x8 luminance8(const rgb radiance[])
{
    f32x8 c[3];
    f32x8_columns(radiance, c);
    return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
}

static void add_octet(struct row *r, const struct octet_samples *o, rgb radiance[])
{
    const struct stage *s = r->octet.stage;
    struct pixel *to = &r->pixel;
    struct block *block = block_at(r, o->x_px);
    const uint32_t layers = r->out->layers;
    const bool weighed = filter_is_signed(s) || s->settings.clamp > 0;
    const f32x8 luminance = luminance8(radiance);
    if (o->s_begin == r->out->pass.s_begin)
        pixel_begin(r);
    for (uint32_t sample = o->s_begin; sample < o->s_end; sample++) {
        const uint32_t i = sample % FILM_REPLICATES;
        float x = luminance[i];
        if (layers)
            layer_surface(s, layers, &r->octet.starts, &r->octet.rng.replicate[i], sample,
                          to->layers);
        if (!is_valid(radiance[i])) {
            film_samples_note_invalid(r->out, (struct film_key){o->x_px, r->octet.y_px, sample});
            continue;
        }
        if (weighed)
            weigh_valid(r, o, i, &radiance[i], &x);
        block_add(block, x);
        to->sums[i] += f64x4_of(radiance[i]);
        if (r->terms.count)
            layer_bounces(layers, &r->terms, i, radiance[i], to->layers);
    }
    if (o->s_end == r->out->pass.s_end)
        pixel_end(r, o->x_px);
}

/* Follows one of the octet's samples beyond the cut, if it is its block's turn. */
__attribute__((noinline)) static void probe_octet(struct row *r, const struct octet_samples *o,
                                                  const rgb radiance[])
{
    const struct stage *s = r->octet.stage;
    const struct tile_rect rect = r->out->rect;
    const uint32_t y = r->octet.y_px, first = o->s_begin - o->s_begin % FILM_REPLICATES;
    const struct probe p = probe_choose(s, o->x_px - (o->x_px - rect.x_begin) % BLOCK_PX,
                                        y - (y - rect.y_begin) % BLOCK_PX, first / FILM_REPLICATES);
    const struct film_key key = {p.x_px, p.y_px, first + p.replicate};
    if (key.x_px != o->x_px || key.y_px != y || key.sample < o->s_begin || key.sample >= o->s_end)
        return;
    const rgb all = sample_alone(s, key, s->settings.max_bounces + PROBE_BOUNCES);
    if (!is_valid(all) || !is_valid(radiance[p.replicate]))
        return;
    const float weight = filter_is_signed(s) ? o->weight[p.replicate] : 1;
    const float x = rgb_luminance(all - radiance[p.replicate]) * weight;
    block_at(r, o->x_px)->cut += (double)x * BLOCK_PROBE_RATE;
}

static void row_flush(struct row *r)
{
    wave_finish(&r->wave);
    const bool cut = r->wave.cut || r->octet.stage->settings.max_bounces == 0;
    for (uint32_t i = 0; cut && i < r->count; i++)
        probe_octet(r, &r->octets[i], r->radiance + i * FILM_REPLICATES);
    r->wave.cut = 0;
    for (uint32_t i = 0; i < r->count; i++)
        add_octet(r, &r->octets[i], r->radiance + i * FILM_REPLICATES);
    r->count = 0;
}

static void row_pixel(struct row *r, uint32_t x_px)
{
    const struct tile_pass pass = r->out->pass;
    octet_init(&r->octet, r->octet.stage, x_px, r->octet.y_px);
    for (uint32_t i = pass.s_begin, end; i < pass.s_end; i = end) {
        const uint32_t first = i - i % FILM_REPLICATES;
        end = min_u32(first + FILM_REPLICATES, pass.s_end);
        const uint32_t which = (1u << (end - first)) - (1u << (i - first));
        octet_go(&r->octet, first / FILM_REPLICATES);
        octet_put(&r->octet, which, &r->wave, r->count * FILM_REPLICATES);
        block_at(r, x_px)->met += (uint64_t)__builtin_popcount(which & r->octet.starts.met);
        r->octets[r->count++] = (struct octet_samples){r->octet.weight, x_px, i, end};
        if (r->count == ROW_OCTETS || r->out->layers)
            row_flush(r);
    }
}

void render_row(const struct stage *s, struct film_samples *out, uint32_t y_px)
{
    const struct tile_rect rect = out->rect;
    assert(y_px >= rect.y_begin && y_px < rect.y_end);
    const size_t before = (size_t)(y_px - rect.y_begin) * (rect.x_end - rect.x_begin);
    struct row r;
    r.out = out;
    r.channels = layers_channels(out->layers);
    r.sums = out->sums + before * FILM_CHANNELS;
    r.layers = r.channels ? out->layer_sums + before * r.channels : NULL;
    r.blocks = out->blocks + (y_px - rect.y_begin) / BLOCK_PX * block_columns(rect);
    r.terms.count = layers_bounces(out->layers);
    r.count = 0;
    r.octet.stage = s;
    r.octet.y_px = y_px;
    wave_init(&r.wave, s, PATH_ROULETTE_BEGIN, r.terms.count ? &r.terms : NULL, r.radiance);
    for (uint32_t x = rect.x_begin, end; film_samples_run(out, y_px, &x, &end);)
        for (; x < end; x++)
            row_pixel(&r, x);
    row_flush(&r);
    r.wave.work.units = work_units(s, &r.wave.work);
    film_work_add(&out->work, &r.wave.work);
    out->dropped = (struct film_dropped){s->dropped_degenerate, s->dropped_nonfinite};
}

void render_tile(const struct stage *s, struct film_samples *out)
{
    for (uint32_t y = out->rect.y_begin; y < out->rect.y_end; y++)
        render_row(s, out, y);
}
