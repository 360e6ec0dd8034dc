/* SPDX-License-Identifier: MIT */
#include "common/trace/path.h"

#include "common/trace/bsdf.h"
#include "common/trace/bvh.h"
#include "common/trace/light.h"
#include "common/trace/light8.h"
#include "common/trace/warp.h"

/* The power heuristic with exponent 2 for the technique of density a beside one of density b. As a
 * quotient, so that no square leaves the range of float: a and b may be anything but both 0. */
static float mis_weight(float a, float b)
{
    const float r = b / a;
    return 1 / (1 + r * r);
}

/* Russian roulette: the chance to go on. `share` is the path's throughput, relative to what its
 * first scattering left of it: what all paths of the pixel have lost alike makes none of them less
 * important. (And relative to what refraction alone has put into it, which leaving the glass takes
 * out again.) Nothing happens to a share of a half; from there on survivors all carry a half. A
 * smaller bound spends rays on paths that hardly count, a larger one ends those that reach a lamp
 * through glass. In a furnace of albedo a the chance becomes a per bounce: the variance is finite
 * exactly when the chance exceeds a^2 (the second moment of the series must converge), and a > a^2
 * always. J. Arvo, D. Kirk, "Particle Transport and Image Synthesis", SIGGRAPH 1990. */
static float survival(float share)
{
    const float q = 2 * share;
    return q < 1 ? q : 1;
}

/* What surface.lit is, as far as anybody asks: the tree of lights. up: of the way out, over the
 * geometric surface. */
static float lit_side(const struct stage *s, const struct material *m, float up)
{
    if (!s->light_nodes.count || !bsdf_is_opaque(m))
        return 0;
    return up < 0 ? -1 : 1;
}

static struct path_vertex vertex_make(const struct stage *s, const struct ray *ray,
                                      const struct ray_hit *hit)
{
    const struct surface at = surface_at(s, ray, hit);
    const struct warp_frame frame = warp_frame_make(at.ng);
    struct path_vertex v = {
        .at = at,
        .frame = frame,
        .material = (const struct material *)stage_at(s, s->materials) + at.material,
        .wo = warp_to_local(&frame, -ray->dir),
    };
    v.at.lit = lit_side(s, v.material, -vec3_dot(ray->dir, at.ng));
    return v;
}

/* What a ray that leaves the scene meets. pdf_w: of its direction, by the sampling that made it; 0:
 * nothing else could have made it. */
static rgb beyond(const struct stage *s, vec3 dir, float pdf_w)
{
    rgb light = s->sky;
    for (uint32_t e = s->beyond_begin; e < s->emitters.count; e++) {
        float sampled;
        const rgb found = light_beyond(s, e, dir, &sampled);
        if (!rgb_is_black(found))
            light += found * (pdf_w == 0 ? 1 : mis_weight(pdf_w, sampled));
    }
    return light;
}

/* What the vertex emits to where the ray came from. */
static rgb emission(const struct stage *s, const struct path_vertex *v)
{
    if (v->at.emitter == STAGE_NONE || !(v->wo[2] > 0))
        return (rgb){0, 0, 0, 0};
    return vec3_load(((const struct emitter *)stage_at(s, s->emitters))[v->at.emitter].radiance);
}

static rgb emission_of_lane(const struct stage *s, const struct path8_vertex *v, uint32_t i)
{
    if (!(v->shining >> i & 1))
        return (rgb){0, 0, 0, 0};
    return vec3_load(((const struct emitter *)stage_at(s, s->emitters))[v->emitter[i]].radiance);
}

/* The vertex of a lane, alone. */
static struct path_vertex vertex_of_lane(const struct stage *s, const struct path8_vertex *v,
                                         uint32_t i)
{
    const vec3 ng = vec8_lane(&v->at.ng, i), wo = vec8_lane(&v->wo, i);
    const struct material *m = (const struct material *)stage_at(s, s->materials) + v->material[i];
    const struct surface at = {.p = vec8_lane(&v->at.p, i),
                               .p_error = vec8_lane(&v->at.p_error, i),
                               .ng = ng,
                               .prim = v->at.prim[i],
                               .material = v->material[i],
                               .emitter = v->emitter[i],
                               .lit = lit_side(s, m, wo[2])};
    return (struct path_vertex){.at = at, .frame = warp_frame_make(ng), .material = m, .wo = wo};
}

void path_begin(const struct stage *s, uint32_t which, const struct ray rays[],
                struct path_starts *starts)
{
    struct ray_hit hits[PATH_WAVE];
    const uint32_t found = bvh_hit_closest_8(s, which, rays, hits);
    starts->met = found;
    starts->ends = s->settings.max_bounces == 0 ? which : which & ~found;
    starts->plain = path8_arrive(s, found, rays, hits, &starts->lanes);
    for (; which; which &= which - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(which);
        if (!(found >> i & 1)) {
            starts->light[i] = beyond(s, rays[i].dir, 0);
            continue;
        }
        if (starts->plain >> i & 1) {
            starts->light[i] = emission_of_lane(s, &starts->lanes, i);
            continue;
        }
        starts->vertices[i] = vertex_make(s, &rays[i], &hits[i]);
        starts->light[i] = emission(s, &starts->vertices[i]);
    }
}

struct path_vertex path_first(const struct stage *s, const struct path_starts *starts, uint32_t i)
{
    return starts->plain >> i & 1 ? vertex_of_lane(s, &starts->lanes, i) : starts->vertices[i];
}

/* --- paths in step --- */

struct path {
    rgb light; /* found so far */
    rgb throughput;
    float scale; /* what roulette divides out of throughput; from the first scattering on */
    float pdf_w; /* of the last direction; 0: a delta lobe's, which next-event estimation cannot
                  * make */
    struct path_vertex vertex;
};

/* By path: bit i and number i are path i's. */
struct wave {
    const struct stage *stage;
    struct rng8 rng;
    uint32_t bounce, roulette_begin;
    uint32_t going; /* paths that have a vertex to go on from */
    uint32_t plain; /* where a path is: in lanes, or by itself */
    struct path8 lanes;
    struct path paths[PATH_WAVE];

    /* A bounce's random numbers: made for all at once, which costs less than for two of them alone.
     */
    struct sobol8_bits lamp;
    struct sobol8_square direction;
    f32x8 lobe, roulette;

    struct ray rays[PATH_WAVE];

    uint32_t lit; /* light arrives if nothing is in its way */
    struct ray shadows[PATH_WAVE];
    rgb light[PATH_WAVE];
};

/* Light that may reach the vertex from one chosen emitter and goes on to wo, MIS-weighted. pick:
 * the choice; NULL: it is still to be made. */
static void light_directly(struct wave *w, uint32_t path, const struct light_pick *pick)
{
    const struct stage *s = w->stage;
    const struct path *p = &w->paths[path];
    const struct path_vertex *v = &p->vertex;
    const struct material *m = v->material;
    if (s->emitters.count == 0 || bsdf_is_delta(m))
        return;
    const struct sobol_bits place = {w->lamp.u[path], w->lamp.v[path]};
    struct light_sample light;
    if (!(pick ? light_sample_picked(s, &v->at, *pick, place.v, &light)
               : light_sample(s, &v->at, place, &light)))
        return;
    const vec3 wi = warp_to_local(&v->frame, light.wi);
    rgb f = bsdf_eval(m, v->wo, wi);
    if (rgb_is_black(f))
        return;
    f *= light.value;
    if (light.pdf_w != 0)
        f *= mis_weight(light.pdf_w, bsdf_pdf_w(m, v->wo, wi));
    w->lit |= 1u << path;
    w->shadows[path] = light.shadow;
    w->light[path] = p->throughput * f;
}

/* The next ray; false: there is none. */
static bool scatter(struct wave *w, uint32_t path)
{
    struct path *p = &w->paths[path];
    const struct path_vertex *v = &p->vertex;
    const struct square direction = {w->direction.u[path], w->direction.v[path]};
    struct bsdf_sample next;
    if (!bsdf_sample(v->material, v->wo, w->lobe[path], direction, &next))
        return false;
    p->throughput *= next.weight;
    if (rgb_is_black(p->throughput))
        return false;
    p->scale = w->bounce == 0 ? rgb_max(p->throughput) : p->scale * next.scale;
    p->pdf_w = next.pdf_w;
    const vec3 dir = warp_to_world(&v->frame, next.wi);
    if (!(vec3_dot(dir, v->at.ng) * next.wi[2] > 0)) /* rounding put it on the wrong side */
        return false;
    if (w->bounce >= w->roulette_begin) { /* a channel weaker than the strongest only gains */
        const float q = survival(rgb_max(p->throughput) / p->scale);
        if (q < 1) {
            if (w->roulette[path] >= q)
                return false;
            p->throughput /= q;
        }
    }
    w->rays[path] = surface_leave(&v->at, dir);
    return true;
}

/* What the vertex emits, found by the BSDF's sampling from there; a delta lobe's by nothing else.
 */
static void find_emission(const struct stage *s, struct path *p, const struct surface *from)
{
    const rgb found = emission(s, &p->vertex);
    if (rgb_is_black(found))
        return;
    const float weight =
        p->pdf_w == 0 ? 1 : mis_weight(p->pdf_w, light_pdf_w(s, from, &p->vertex.at));
    p->light += p->throughput * found * weight;
}

static void arrive(struct wave *w, uint32_t path, const struct ray_hit *hit)
{
    struct path *p = &w->paths[path];
    const struct surface from = p->vertex.at;
    p->vertex = vertex_make(w->stage, &w->rays[path], hit);
    find_emission(w->stage, p, &from);
}

static void draw(struct wave *w)
{
    bool lobes = false;
    for (uint32_t others = w->going & ~w->plain; others; others &= others - 1)
        lobes = lobes || bsdf_has_lobes(w->paths[__builtin_ctz(others)].vertex.material);
    w->direction = rng8_pair(&w->rng, rng_dimension(w->bounce, RNG_BSDF_DIRECTION));
    if (w->stage->emitters.count > 0)
        w->lamp = rng8_pair_bits(&w->rng, rng_dimension(w->bounce, RNG_LIGHT));
    if (lobes)
        w->lobe = rng8_single(&w->rng, rng_dimension(w->bounce, RNG_BSDF_LOBE));
    if (w->bounce >= w->roulette_begin)
        w->roulette = rng8_single(&w->rng, rng_dimension(w->bounce, RNG_ROULETTE));
}

/* --- paths in lanes --- */

static struct path path_of_lane(const struct stage *s, const struct path8 *lanes, uint32_t i)
{
    return (struct path){.light = vec8_lane(&lanes->light, i),
                         .throughput = vec8_lane(&lanes->throughput, i),
                         .scale = lanes->scale[i],
                         .pdf_w = lanes->pdf_w[i],
                         .vertex = vertex_of_lane(s, &lanes->vertex, i)};
}

/* From the lanes to itself, and the reverse, with the vertex that it has come from. */
static void leave_lanes(struct wave *w, uint32_t i)
{
    w->paths[i] = path_of_lane(w->stage, &w->lanes, i);
    w->plain &= ~(1u << i);
}

static void enter_lanes(struct wave *w, uint32_t i)
{
    const struct path *p = &w->paths[i];
    vec8_set_lane(&w->lanes.light, i, p->light);
    vec8_set_lane(&w->lanes.throughput, i, p->throughput);
    w->lanes.scale[i] = p->scale;
    w->lanes.pdf_w[i] = p->pdf_w;
    vec8_set_lane(&w->lanes.vertex.at.p, i, p->vertex.at.p);
    if (w->stage->light_nodes.count) { /* what of the vertex the tree looks at */
        vec8_set_lane(&w->lanes.vertex.at.ng, i, p->vertex.at.ng);
        vec8_set_lane(&w->lanes.vertex.wo, i, p->vertex.wo);
        w->lanes.vertex.material[i] = p->vertex.at.material;
    }
    w->plain |= 1u << i;
}

static void add_light(struct wave *w, uint32_t lanes, struct vec8 light)
{
    w->lanes.light =
        vec8_choose(i32x8_of_bits(lanes), vec8_add(w->lanes.light, light), w->lanes.light);
}

/* As find_emission, for a path whose next vertex is a lane of `at`. */
static void find_emission_of_lane(struct wave *w, uint32_t i, const struct path8_vertex *at)
{
    struct path p = path_of_lane(w->stage, &w->lanes, i);
    const struct surface from = p.vertex.at;
    p.vertex = vertex_of_lane(w->stage, at, i);
    find_emission(w->stage, &p, &from);
    vec8_set_lane(&w->lanes.light, i, p.light);
}

/* --- all paths --- */

/* Of many lights: the choices first, for all paths side by side. */
static void light_by_tree(struct wave *w)
{
    const struct surface *from[PATH_WAVE];
    uint32_t path_of[PATH_WAVE], bits[PATH_WAVE], count = 0;
    struct light_pick picks[PATH_WAVE];
    for (uint32_t lanes = w->going & w->plain; lanes; lanes &= lanes - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(lanes);
        w->paths[i] = path_of_lane(w->stage, &w->lanes, i);
    }
    for (uint32_t paths = w->going; paths; paths &= paths - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(paths);
        if (bsdf_is_delta(w->paths[i].vertex.material))
            continue;
        from[count] = &w->paths[i].vertex.at;
        bits[count] = w->lamp.u[i];
        path_of[count++] = i;
    }
    light_pick(w->stage, from, bits, count, picks);
    for (uint32_t k = 0; k < count; k++)
        light_directly(w, path_of[k], &picks[k]);
}

/* Bit i: path i goes on along rays[i]. */
static uint32_t wave_scatter(struct wave *w)
{
    const struct stage *s = w->stage;
    const uint32_t plain = w->going & w->plain;
    const struct path8_draw draw = {
        w->direction, w->bounce >= w->roulette_begin ? &w->roulette : NULL, w->bounce == 0};
    struct vec8 light;
    uint32_t next = 0, lit = 0;
    w->lit = 0;
    const bool many = s->light_nodes.count > 0;
    if (many)
        light_by_tree(w);
    else if (plain && light8_can(s))
        lit = plain & path8_light_directly(s, &w->lanes, &w->lamp, w->shadows, &light);
    else if (s->emitters.count > 0)
        for (uint32_t lanes = plain; lanes; lanes &= lanes - 1) {
            const uint32_t i = (uint32_t)__builtin_ctz(lanes);
            w->paths[i] = path_of_lane(w->stage, &w->lanes, i);
            light_directly(w, i, NULL);
        }
    if (plain)
        next = plain & path8_scatter(&w->lanes, &draw, w->rays);
    for (uint32_t others = w->going & ~plain; others; others &= others - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(others);
        if (!many)
            light_directly(w, i, NULL);
        next |= (uint32_t)scatter(w, i) << i;
    }
    const uint32_t seen = ~bvh_hit_any_8(s, lit | w->lit, w->shadows);
    if (lit & seen)
        add_light(w, lit & seen, light);
    for (uint32_t others = w->lit & seen; others; others &= others - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(others);
        if (plain >> i & 1)
            vec8_set_lane(&w->lanes.light, i, vec8_lane(&w->lanes.light, i) + w->light[i]);
        else
            w->paths[i].light += w->light[i];
    }
    return next;
}

/* The sky, and what stands in it. */
static void find_beyond(struct wave *w, uint32_t missed)
{
    const struct stage *s = w->stage;
    uint32_t alone = missed;
    if (s->beyond_begin == s->emitters.count && missed & w->plain) { /* the same for all of them */
        const struct vec8 sky = {f32x8_splat(s->sky[0]), f32x8_splat(s->sky[1]),
                                 f32x8_splat(s->sky[2])};
        add_light(w, missed & w->plain, vec8_mul(w->lanes.throughput, sky));
        alone &= ~w->plain;
    }
    for (; alone; alone &= alone - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(alone);
        if (w->plain >> i & 1)
            leave_lanes(w, i);
        struct path *p = &w->paths[i];
        p->light += p->throughput * beyond(s, w->rays[i].dir, p->pdf_w);
    }
}

/* The next vertices, or the sky, where a path ends. */
static void wave_arrive(struct wave *w, uint32_t next)
{
    const struct stage *s = w->stage;
    struct ray_hit hits[PATH_WAVE];
    struct path8_vertex at;
    const uint32_t found = bvh_hit_closest_8(s, next, w->rays, hits), missed = next & ~found;
    find_beyond(w, missed);
    const uint32_t plain = path8_arrive(s, found, w->rays, hits, &at);
    for (uint32_t others = found & ~plain; others; others &= others - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(others);
        if (w->plain >> i & 1)
            leave_lanes(w, i);
        arrive(w, i, &hits[i]);
    }
    for (uint32_t others = plain & ~w->plain; others; others &= others - 1)
        enter_lanes(w, (uint32_t)__builtin_ctz(others));
    for (uint32_t lanes = plain & at.shining; lanes; lanes &= lanes - 1)
        find_emission_of_lane(w, (uint32_t)__builtin_ctz(lanes), &at);
    if (plain)
        w->lanes.vertex = at;
    w->going = w->bounce + 1 < s->settings.max_bounces ? found : 0;
    w->bounce++;
}

/* Of path i, found up to here. */
static rgb wave_light(const struct wave *w, uint32_t i)
{
    return w->plain >> i & 1 ? vec8_lane(&w->lanes.light, i) : w->paths[i].light;
}

/* The terms from the bounces so far on: those that there are no more bounces for are like the last.
 */
static void note_terms(const struct wave *w, uint32_t which, struct path_terms *terms)
{
    const uint32_t end = w->going ? w->bounce + 1 : terms->count;
    for (uint32_t k = w->bounce; k < end && k < terms->count; k++)
        for (uint32_t i = 0; i < PATH_WAVE; i++)
            if (which >> i & 1)
                terms->light[k][i] = wave_light(w, i);
}

void path_radiance(const struct stage *s, uint32_t which, const struct path_starts *starts,
                   const struct rng rngs[], uint32_t roulette_begin, struct path_terms *terms,
                   rgb radiance[])
{
    struct wave w;
    w.stage = s;
    w.bounce = 0;
    w.roulette_begin = roulette_begin;
    w.going = which & ~starts->ends;
    w.plain = starts->plain;
    w.lobe = (f32x8){0};
    rng8_make(&w.rng, rngs, 32 - (uint32_t)__builtin_clz(which));
    w.lanes.light = vec8_gather(starts->light);
    w.lanes.throughput = (struct vec8){f32x8_splat(1), f32x8_splat(1), f32x8_splat(1)};
    w.lanes.vertex = starts->lanes;
    for (uint32_t others = which & ~w.plain; others; others &= others - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(others);
        w.paths[i].light = starts->light[i];
        w.paths[i].throughput = (rgb){1, 1, 1, 0};
        if (w.going >> i & 1)
            w.paths[i].vertex = starts->vertices[i];
    }
    for (;;) {
        if (terms)
            note_terms(&w, which, terms);
        if (!w.going)
            break;
        draw(&w);
        wave_arrive(&w, wave_scatter(&w));
    }
    for (uint32_t i = 0; i < PATH_WAVE; i++)
        if (which >> i & 1)
            radiance[i] = wave_light(&w, i);
}
