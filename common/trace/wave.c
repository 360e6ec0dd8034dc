/* SPDX-License-Identifier: MIT */
#include "common/trace/wave.h"

#include <string.h>

#include "common/trace/bsdf.h"
#include "common/trace/bvh.h"
#include "common/trace/light8.h"
#include "common/trace/wave_pick.h"
#include "common/trace/path_mask.h"

static inline uint32_t lowest(uint32_t lanes)
{
    return (uint32_t)__builtin_ctz(lanes);
}

/* --- one lane --- */

static struct path_vertex vertex_of_lane(const struct stage *s, const struct path8_vertex *v,
                                         uint32_t i)
{
    struct path_vertex out; /* its point stays unset: plain vertices have no textures */
    out.at = path8_surface(s, v, i);
    out.frame = warp_frame_make(out.at.ng);
    out.material = path8_material(s, v, i);
    out.wo = vec8_lane(&v->wo, i);
    out.raised.is = false;
    return out;
}

/* Out of the lanes, but for all of the vertex that arriving at the next one does not ask for; and
 * into them, but for the vertex, which is left behind. */
static void leave_lanes(struct wave *w, uint32_t i)
{
    struct path *p = &w->paths[i];
    p->light = vec8_lane(&w->lanes.light, i);
    p->throughput = vec8_lane(&w->lanes.throughput, i);
    p->scale = w->lanes.scale[i];
    p->pdf_w = w->lanes.pdf_w[i];
    p->vertex.at = path8_surface(w->stage, w->lanes.vertex, i);
    w->plain &= ~(1u << i);
}

static void enter_lanes(struct wave *w, uint32_t i)
{
    const struct path *p = &w->paths[i];
    vec8_set_lane(&w->lanes.light, i, p->light);
    vec8_set_lane(&w->lanes.throughput, i, p->throughput);
    w->lanes.scale[i] = p->scale;
    w->lanes.pdf_w[i] = p->pdf_w;
    w->plain |= 1u << i;
}

static rgb light_of(const struct wave *w, uint32_t i)
{
    return w->plain >> i & 1 ? vec8_lane(&w->lanes.light, i) : w->paths[i].light;
}

/* --- the first vertices --- */

/* Past masks: siblings share the ray, so they share its numbers. */
static uint32_t begin_behind(const struct stage *s, uint32_t found, struct path_mask_rays r)
{
    struct rng elders[WAVE_LANES];
    for (uint32_t left = found; left; left &= left - 1)
        elders[lowest(left)] = rng_elder(&r.rngs[lowest(left)]);
    r.rngs = elders;
    return path_mask_pass(s, found, &r);
}

void wave_begin(const struct stage *s, uint32_t which, const struct ray rays[],
                const struct rng rngs[], struct wave_starts *starts)
{
    const struct ray *asked = rays;
    struct film_work *work = &starts->work;
    struct ray passed[WAVE_LANES];
    struct ray_hit hits[WAVE_LANES];
    uint32_t found = bvh_hit_closest_8(s, which, rays, hits);
    *work = (struct film_work){.camera_rays = (uint64_t)__builtin_popcount(which)};
    if (s->masked && found) {
        memcpy(passed, rays, (32 - (size_t)__builtin_clz(which)) * sizeof *rays);
        found = begin_behind(s, found, (struct path_mask_rays){rngs, {0}, passed, hits, work});
        rays = passed;
    }
    starts->met = found;
    starts->ends = s->settings.max_bounces == 0 ? which : which & ~found;
    starts->plain = s->media ? 0 : path8_arrive(s, found, rays, hits, &starts->lanes);
    for (uint32_t left = s->pyramids.count ? found : 0; left; left &= left - 1)
        starts->cones[lowest(left)] =
            cone_along((struct cone){s->cone_width, s->cone_spread}, hits[lowest(left)].t);
    for (uint32_t left = which; left; left &= left - 1) {
        const uint32_t i = lowest(left), bit = 1u << i;
        if (s->media) {
            starts->origins[i] = asked[i].origin;
            starts->rays[i] = rays[i];
            starts->hits[i] = hits[i];
        }
        starts->light[i] = found & bit ? rgb_gray(0) : path_beyond(s, rays[i].dir, 0);
        if (starts->plain & starts->lanes.shining & bit) {
            starts->light[i] = path_radiance(s, starts->lanes.emitter[i]);
        } else if (found & ~starts->plain & bit) {
            starts->vertices[i] =
                path_vertex_make(s, &rays[i], &hits[i], starts->cones[i].width, work);
            starts->light[i] = path_emission(s, &starts->vertices[i]);
        }
    }
}

struct path_vertex wave_first(const struct stage *s, const struct wave_starts *starts, uint32_t i)
{
    return starts->plain >> i & 1 ? vertex_of_lane(s, &starts->lanes, i) : starts->vertices[i];
}

/* --- from vertices to rays --- */

/* Whether sampling looks at it somewhere. */
static bool needs_lobe(const struct wave *w)
{
    const struct path8_vertex *v = w->lanes.vertex;
    bool lobes = false;
    for (uint32_t left = w->going & w->plain & ~v->diffuse; left; left &= left - 1)
        lobes = lobes || bsdf_has_lobes(path8_material(w->stage, v, lowest(left)));
    for (uint32_t left = w->going & ~w->plain; left; left &= left - 1)
        lobes = lobes || bsdf_has_lobes(w->paths[lowest(left)].vertex.material);
    return lobes;
}

static void draw(struct wave *w)
{
    w->draw.direction = rng8_pair(&w->rng, rng_dimension(0, RNG_BSDF_DIRECTION));
    if (w->stage->emitters.count > 0)
        w->lamp = rng8_pair_bits(&w->rng, rng_dimension(0, RNG_LIGHT));
    if (needs_lobe(w))
        w->draw.lobe = rng8_single(&w->rng, rng_dimension(0, RNG_BSDF_LOBE));
    w->draw.first = w->bounce == 0;
    w->draw.may_end = w->bounce >= w->roulette_begin;
    if (w->going & i32x8_mask(w->draw.may_end))
        w->draw.roulette = rng8_single(&w->rng, rng_dimension(0, RNG_ROULETTE));
}

/* Light that may reach the vertices. Bit i: light[i], in lanes for those that are there, comes if
 * shadows[i] hits nothing. */
struct direct {
    uint32_t lanes, others;
    struct vec8 of_lanes;
    rgb of_others[WAVE_LANES];
};

static void look_at_lights(struct wave *w, struct direct *d)
{
    const struct stage *s = w->stage;
    struct light_pick picks[WAVE_LANES], *const picked = s->light_nodes.count ? picks : NULL;
    const struct path8_lamps lamps = {w->going & w->plain, &w->lamp, picked};
    d->lanes = d->others = 0;
    if (s->emitters.count == 0)
        return;
    if (picked)
        wave_pick(w, picks);
    if (lamps.lanes)
        d->lanes = path8_light_directly(s, &w->lanes, &lamps, w->shadows, &d->of_lanes);
    for (uint32_t left = w->going & ~w->plain; left; left &= left - 1) {
        const uint32_t i = lowest(left);
        const struct path_lamp lamp = {{w->lamp.u[i], w->lamp.v[i]}, picked ? &picked[i] : NULL};
        if (path_light_directly(s, &w->paths[i], &lamp, &w->shadows[i], &d->of_others[i]))
            d->others |= 1u << i;
    }
}

static void add_to_lanes(struct wave *w, uint32_t lanes, struct vec8 light)
{
    w->lanes.light =
        vec8_choose(i32x8_of_bits(lanes), vec8_add(w->lanes.light, light), w->lanes.light);
}

static void add_to_path(struct wave *w, uint32_t i, rgb light)
{
    if (w->plain >> i & 1)
        vec8_set_lane(&w->lanes.light, i, light_of(w, i) + light);
    else
        w->paths[i].light += light;
}

/* What comes along shadow rays that have met something. */
static void add_through_masks(struct wave *w, const struct direct *d, uint32_t dark)
{
    for (; dark; dark &= dark - 1) {
        const uint32_t i = lowest(dark);
        const rgb all = d->lanes >> i & 1 ? vec8_lane(&d->of_lanes, i) : d->of_others[i];
        add_to_path(w, i, all * path_mask_share(w->stage, w->shadows[i], &w->work));
    }
}

static void add_direct(struct wave *w, const struct direct *d)
{
    const uint32_t seen = ~bvh_hit_any_8(w->stage, d->lanes | d->others, w->shadows);
    if (d->lanes & seen)
        add_to_lanes(w, d->lanes & seen, d->of_lanes);
    for (uint32_t left = d->others & seen; left; left &= left - 1) {
        const uint32_t i = lowest(left);
        add_to_path(w, i, d->of_others[i]);
    }
    if (w->stage->masked)
        add_through_masks(w, d, (d->lanes | d->others) & ~seen);
}

/* Bit i: path i goes on along rays[i]. */
static uint32_t scatter(struct wave *w)
{
    uint32_t next = w->going & w->plain;
    if (next)
        next = path8_scatter(w->stage, &w->lanes, next, &w->draw, w->rays);
    for (uint32_t left = w->going & ~w->plain; left; left &= left - 1) {
        const uint32_t i = lowest(left);
        const struct path_draw one = {
            .direction = {w->draw.direction.u[i], w->draw.direction.v[i]},
            .lobe = w->draw.lobe[i],
            .roulette = w->draw.roulette[i],
            .first = w->draw.first[i] != 0,
            .may_end = w->draw.may_end[i] != 0,
        };
        next |= (uint32_t)path_scatter(w->stage, &w->paths[i], &one, &w->rays[i]) << i;
    }
    return next;
}

/* --- from rays to vertices --- */

/* The sky and what stands in it, where a path ends. */
static void leave_scene(struct wave *w, uint32_t which)
{
    const struct stage *s = w->stage;
    if (s->beyond_begin == s->emitters.count && which & w->plain) { /* the same for all of them */
        const struct vec8 sky = {f32x8_splat(s->sky[0]), f32x8_splat(s->sky[1]),
                                 f32x8_splat(s->sky[2])};
        add_to_lanes(w, which & w->plain, vec8_mul(w->lanes.throughput, sky));
        which &= ~w->plain;
    }
    for (; which; which &= which - 1) {
        const uint32_t i = lowest(which);
        const bool lane = w->plain >> i & 1;
        const float pdf_w = lane ? w->lanes.pdf_w[i] : w->paths[i].pdf_w;
        const rgb share = lane ? vec8_lane(&w->lanes.throughput, i) : w->paths[i].throughput;
        add_to_path(w, i, share * path_beyond(s, w->rays[i].dir, pdf_w));
    }
}

/* A vertex in lanes that emits. lane: the path has come from there, too. */
static void find_emission(struct wave *w, const struct path8_vertex *at, uint32_t i, bool lane)
{
    const struct stage *s = w->stage;
    const struct surface from = lane ? path8_surface(s, w->lanes.vertex, i) : w->paths[i].vertex.at;
    const struct surface on = path8_surface(s, at, i);
    const rgb found = vec8_lane(&w->lanes.throughput, i) * path_radiance(s, on.emitter);
    add_to_path(w, i, found * path_emission_weight(s, &from, &on, w->lanes.pdf_w[i]));
}

/* Of paths that have a vertex to go on from, those that may. */
static uint32_t not_cut(struct wave *w, uint32_t found)
{
    const uint32_t left = found & i32x8_mask(w->bounce + 1 < w->max_bounces);
    w->cut |= found & ~left;
    return left;
}

/* There no vertex is plain. */
static void arrive_in_media(struct wave *w, uint32_t which, uint32_t found,
                            const struct ray_hit hits[])
{
    w->going = 0;
    for (; which; which &= which - 1) {
        const uint32_t i = lowest(which);
        const struct path_media_way way = {&w->rays[i], found >> i & 1 ? &hits[i] : NULL,
                                           w->cones[i].width, &w->rngs[i], w->bounce[i] + 1};
        w->going |= (uint32_t)path_media_arrive(w->stage, &w->paths[i], &way) << i;
    }
    w->going = not_cut(w, w->going);
}

/* Along the rays, to what they have met. */
static void follow_cones(struct wave *w, uint32_t which, const struct ray_hit hits[])
{
    for (; which; which &= which - 1) {
        const uint32_t i = lowest(which);
        const float pdf_w = w->plain >> i & 1 ? w->lanes.pdf_w[i] : w->paths[i].pdf_w;
        w->cones[i] = cone_along(cone_scatter(w->cones[i], pdf_w), hits[i].t);
    }
}

static void arrive(struct wave *w, uint32_t which)
{
    const struct stage *s = w->stage;
    struct ray_hit hits[WAVE_LANES];
    struct path8_vertex *at = &w->vertices[w->lanes.vertex == w->vertices];
    uint32_t found = bvh_hit_closest_8(s, which, w->rays, hits);
    if (s->masked)
        found = path_mask_pass(
            s, found, &(struct path_mask_rays){w->rngs, w->bounce + 1, w->rays, hits, &w->work});
    if (s->pyramids.count)
        follow_cones(w, found, hits);
    if (s->media) {
        arrive_in_media(w, which, found, hits);
        return;
    }
    leave_scene(w, which & ~found);
    const uint32_t plain = path8_arrive(s, found, w->rays, hits, at);
    for (uint32_t left = found & ~plain; left; left &= left - 1) {
        const uint32_t i = lowest(left);
        const struct path_vertex v =
            path_vertex_make(s, &w->rays[i], &hits[i], w->cones[i].width, &w->work);
        if (w->plain >> i & 1)
            leave_lanes(w, i);
        path_arrive(s, &w->paths[i], &v);
    }
    const uint32_t were_plain = w->plain;
    for (uint32_t left = plain & ~were_plain; left; left &= left - 1)
        enter_lanes(w, lowest(left));
    for (uint32_t left = plain & at->shining; left; left &= left - 1)
        find_emission(w, at, lowest(left), were_plain >> lowest(left) & 1);
    if (plain)
        w->lanes.vertex = at;
    w->going = not_cut(w, found);
}

/* --- the way of a path --- */

/* What has been found up to here; of a path that has ended, for all bounces to come as well. */
static void note_terms(struct wave_terms *terms, uint32_t bounce, bool ended, uint32_t number,
                       rgb light)
{
    const uint32_t end = ended ? terms->count : bounce + 1;
    for (uint32_t k = bounce; k < end && k < terms->count; k++)
        terms->light[k][number] = light;
}

static void step(struct wave *w)
{
    const uint32_t before = w->going;
    struct direct direct;
    if (w->stage->wrapped)
        wave_choose_materials(w);
    if (w->stage->slots.count)
        wave_apply_textures(w);
    if (!wave_has_drawn_otherwise(w))
        draw(w);
    look_at_lights(w, &direct);
    const uint32_t next = wave_kept(w, scatter(w));
    wave_count(w, direct.lanes | direct.others, next);
    add_direct(w, &direct);
    arrive(w, next);
    w->bounce += 1;
    rng8_next_bounce(&w->rng);
    for (uint32_t left = w->terms ? before : 0; left; left &= left - 1) {
        const uint32_t i = lowest(left);
        note_terms(w->terms, w->bounce[i], !(w->going >> i & 1), w->number[i], light_of(w, i));
    }
    for (uint32_t left = before & ~w->going; left; left &= left - 1) {
        const uint32_t i = lowest(left);
        w->radiance[w->number[i]] = light_of(w, i);
    }
}

void wave_init(struct wave *w, const struct stage *s, uint32_t roulette_begin,
               struct wave_terms *terms, rgb radiance[])
{
    w->stage = s;
    w->roulette_begin = roulette_begin;
    w->max_bounces = s->settings.max_bounces;
    w->cut = 0;
    w->terms = terms;
    w->radiance = radiance;
    w->work = (struct film_work){0};
    for (int i = 0; i < WAVE_LANES; i++) {
        w->paths[i].work = &w->work;
        w->paths[i].media = s->media ? &w->media[i] : NULL;
    }
    w->going = w->plain = 0;
    w->lanes.vertex = w->vertices;
    w->draw.lobe = w->draw.roulette = (f32x8){0};
}

/* Paths from starts k[i] into the lanes i, which are free. */
static void begin_paths(struct wave *w, uint32_t lanes, const struct wave_starts *starts, u32x8 k)
{
    const i32x8 m = i32x8_of_bits(lanes);
    const f32x8 one = f32x8_splat(1);
    const uint32_t plain = path8_bits_take(m, starts->plain, k);
    w->going |= lanes;
    w->plain = (w->plain & ~lanes) | plain;
    w->bounce = (u32x8)((i32x8)w->bounce & ~m);
    w->lanes.light = vec8_take(m, vec8_gather(starts->light), k, w->lanes.light);
    w->lanes.throughput = vec8_choose(m, (struct vec8){one, one, one}, w->lanes.throughput);
    path8_vertex_take(&w->vertices[w->lanes.vertex != w->vertices], m, &starts->lanes, k);
    for (lanes &= ~plain; lanes; lanes &= lanes - 1) {
        const uint32_t i = lowest(lanes), start = k[i];
        w->paths[i].light = starts->light[start];
        w->paths[i].throughput = rgb_gray(1);
        w->paths[i].vertex = starts->vertices[start];
    }
}

/* In a scene with media the light of the camera ray itself is the path's. False: it ends with it.
 */
static bool begin_in_media(struct wave *w, uint32_t i, const struct wave_starts *starts, uint32_t k,
                           const struct rng *rng)
{
    struct path *p = &w->paths[i];
    p->light = rgb_gray(0);
    p->throughput = rgb_gray(1);
    p->vertex.at.p = starts->origins[k];
    const struct path_media_way way = {&starts->rays[k],
                                       starts->met >> k & 1 ? &starts->hits[k] : NULL,
                                       starts->cones[k].width, rng, 0};
    const bool goes_on = path_media_begin(w->stage, p, &way) && w->max_bounces > 0;
    w->going |= (uint32_t)goes_on << i;
    w->plain &= ~(1u << i);
    if (w->terms)
        note_terms(w->terms, 0, !goes_on, w->number[i], p->light);
    if (!goes_on)
        w->radiance[w->number[i]] = p->light;
    return goes_on;
}

static void put_in_media(struct wave *w, uint32_t which, const struct wave_starts *starts,
                         const struct rng rngs[], uint32_t number)
{
    for (; which; which &= which - 1) {
        const uint32_t k = lowest(which);
        while (w->going == (1u << WAVE_LANES) - 1)
            step(w);
        const uint32_t i = lowest(~w->going);
        w->number[i] = number + k;
        if (!begin_in_media(w, i, starts, k, &rngs[k]))
            continue;
        w->bounce[i] = 0;
        w->cones[i] = starts->cones[k];
        rng8_set_lane(&w->rng, i, &rngs[k]);
        w->rngs[i] = rngs[k];
    }
}

void wave_put(struct wave *w, uint32_t which, const struct wave_starts *starts,
              const struct rng rngs[], uint32_t number)
{
    if (w->stage->media) {
        put_in_media(w, which, starts, rngs, number);
        return;
    }
    for (uint32_t left = w->terms ? which : 0; left; left &= left - 1) {
        const uint32_t i = lowest(left);
        note_terms(w->terms, 0, starts->ends >> i & 1, number + i, starts->light[i]);
    }
    for (uint32_t left = which & starts->ends; left; left &= left - 1)
        w->radiance[number + lowest(left)] = starts->light[lowest(left)];
    which &= ~starts->ends;
    while (which) {
        const uint32_t all = (1u << WAVE_LANES) - 1;
        uint32_t taken = 0;
        u32x8 k = {0};
        while (w->going == all)
            step(w);
        for (uint32_t free = all & ~w->going; free && which; free &= free - 1) {
            const uint32_t i = lowest(free), start = lowest(which);
            which &= which - 1;
            taken |= 1u << i;
            k[i] = start;
            w->number[i] = number + start;
            if (w->stage->pyramids.count)
                w->cones[i] = starts->cones[start];
            rng8_set_lane(&w->rng, i, &rngs[start]);
            if (w->stage->masked)
                w->rngs[i] = rngs[start];
        }
        begin_paths(w, taken, starts, k);
    }
}

void wave_finish(struct wave *w)
{
    while (w->going)
        step(w);
}
