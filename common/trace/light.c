/* SPDX-License-Identifier: MIT */
#include "common/trace/light.h"

#include "common/trace/fetch.h"
#include "common/trace/glow.h"
#include "common/trace/light_cylinder.h"
#include "common/trace/light_map.h"
#include "common/trace/light_solid.h"
#include "common/trace/light_spot.h"
#include "common/trace/light_sun.h"
#include "common/trace/light_tree.h"
#include "common/trace/warp.h"

/* --- which one --- */

/* What the cumulative table says and not emitter.pick: a table of floats rounds, and the weights
 * must belong to what is really done. An emitter too weak for the table has probability 0 and is
 * left to the BSDF's sampling, whose MIS weight is then 1: nothing is lost. */
static double pick_probability(const struct stage *s, uint32_t emitter)
{
    const float *cdf = stage_at(s, s->pick_cdf);
    return (double)cdf[emitter + 1] - (double)cdf[emitter];
}

/* The emitter from `begin` on whose part of the cumulative table holds u. */
static uint32_t pick_emitter(const struct stage *s, uint32_t begin, double u)
{
    const float *cdf = stage_at(s, s->pick_cdf);
    uint32_t end = (uint32_t)s->emitters.count; /* cdf[begin] <= u < cdf[end] */
    while (end - begin > 1) {
        const uint32_t middle = begin + (end - begin) / 2;
        if ((double)cdf[middle] <= u)
            begin = middle;
        else
            end = middle;
    }
    return begin;
}

static uint32_t rest_of(double rest)
{
    const double bits = rest * 0x1p32;
    return bits < 0x1.fffffffep31 ? (uint32_t)bits : UINT32_MAX;
}

static double unit_of(uint32_t bits)
{
    return (bits + 0.5) * 0x1p-32; /* the middle of what the bits stand for */
}

static struct light_pick pick_by_table(const struct stage *s, uint32_t begin, double u)
{
    const float *cdf = stage_at(s, s->pick_cdf);
    const uint32_t emitter = pick_emitter(s, begin, u);
    const double probability = pick_probability(s, emitter);
    return (struct light_pick){emitter, (float)probability,
                               rest_of((u - (double)cdf[emitter]) / probability)};
}

/* The part of the table that the tree's emitters share. */
static double tree_share(const struct stage *s)
{
    return (double)((const float *)stage_at(s, s->pick_cdf))[s->far_begin];
}

/* Its corners, so that they are there when all walks have ended and it is sampled. Of the many
 * lights of a mesh they are in nobody's cache. */
static void fetch_place(const struct stage *s, uint32_t emitter)
{
    const struct emitter *e = stage_emitter_at(s, emitter);
    if (e->kind != EMITTER_PRIM || e->place.kind != STAGE_TRIANGLE)
        return;
    fetch_lines((const struct stage_block *)stage_at(s, s->blocks) + e->place.index / STAGE_LANES,
                sizeof(struct stage_block));
}

void light_pick(const struct stage *s, const struct surface *const from[], const uint32_t bits[],
                uint32_t count, struct light_pick picks[])
{
    const double share = s->light_nodes.count ? tree_share(s) : 0;
    const struct surface *walker[LIGHT_TREE_WALKS];
    double u[LIGHT_TREE_WALKS];
    uint32_t which[LIGHT_TREE_WALKS], walks = 0;
    for (uint32_t i = 0; i < count; i++) {
        const double x = unit_of(bits[i]);
        if (x < share) {
            walker[walks] = from[i];
            u[walks] = x / share;
            which[walks++] = i;
        } else {
            picks[i] = pick_by_table(s, share > 0 ? s->far_begin : 0, x);
        }
    }
    struct light_tree_pick found[LIGHT_TREE_WALKS];
    if (walks)
        light_tree_pick(s, walker, u, walks, found);
    for (uint32_t i = 0; i < walks; i++) {
        if (found[i].emitter != STAGE_NONE)
            fetch_place(s, found[i].emitter);
        picks[which[i]] = (struct light_pick){
            found[i].emitter, (float)(share * found[i].probability), rest_of(found[i].rest)};
    }
}

/* The probability of an emitter that has a place. */
static float place_probability(const struct stage *s, const struct surface *from, uint32_t emitter)
{
    return (float)(s->light_nodes.count ? tree_share(s) * light_tree_probability(s, from, emitter)
                                        : pick_probability(s, emitter));
}

/* --- triangles near by: uniform by solid angle, a quad's both together --- */

struct near {
    uint32_t begin;    /* emitter */
    float probability; /* of it and, in a quad, the next one */
    double before;     /* the part of it that is before the one that was asked for */
    struct light_solid solid;
};

/* probability: of the emitter, whose front `from` sees. */
static struct near near_make(const struct stage *s, const struct surface *from, uint32_t emitter,
                             float probability)
{
    const int32_t partner = stage_emitter_at(s, emitter)->partner;
    struct near n = {.begin = partner < 0 ? emitter - 1 : emitter, .probability = probability};
    if (partner) {
        const float other = place_probability(s, from, emitter + (uint32_t)partner);
        n.before = partner < 0 ? (double)other : 0;
        n.probability += other;
    }
    vec3 corners[4];
    struct stage_triangle t =
        stage_triangle_at(s, stage_emitter_at(s, n.begin)->place.index, STAGE_NONE);
    for (int i = 0; i < 3; i++)
        corners[i] = vec3_load(t.v[i]);
    if (partner)
        t = stage_triangle_at(s, stage_emitter_at(s, n.begin + 1)->place.index, STAGE_NONE);
    corners[3] = vec3_load(t.v[2]);
    n.solid = light_solid_make(corners, partner ? 4 : 3, from->p);
    return n;
}

static float near_pdf_w(const struct near *n)
{
    const double half = n->solid.half[0] + n->solid.half[1];
    return half > 0 ? n->probability / (float)(2 * half) : 0;
}

static bool is_near(const struct emitter *e, vec3 ng, vec3 p)
{
    return light_solid_is_near(vec3_load(e->at), e->near_dd, ng, p);
}

/* --- triangles and discs: uniform by area --- */

/* pdf_a turned into pdf_w: seen from d away, area shrinks by cos / d^2. 0 from behind. */
static float area_pdf_w(vec3 d, vec3 ng, float area)
{
    const float dd = vec3_dot(d, d);
    const float cos = -vec3_dot(d, ng) / __builtin_sqrtf(dd);
    return cos > 0 ? dd / (cos * area) : 0;
}

static struct surface point_on_disc(const struct stage *s, struct stage_id id, struct square q)
{
    const struct stage_disc *disc =
        (const struct stage_disc *)stage_at(s, s->discs) + id.place.index;
    const struct warp_frame f = warp_frame_make(vec3_load(disc->normal));
    const vec3 p = warp_to_world(&f, warp_disc(q)) * disc->radius;
    return surface_on_disc(s, id, vec3_load(disc->center) + p);
}

/* --- cylinders: nearly uniform in the solid angle they fill --- */

static const struct stage_cylinder *cylinder_at(const struct stage *s, uint32_t index)
{
    return (const struct stage_cylinder *)stage_at(s, s->cylinders) + index;
}

static float cylinder_pdf_w(const struct light_cylinder *view, vec3 d, vec3 ng)
{
    return area_pdf_w(d, ng, light_cylinder_area(view, d, ng));
}

/* --- spheres: uniform in the cone they fill --- */

static const struct stage_sphere *sphere_at(const struct stage *s, uint32_t index)
{
    return (const struct stage_sphere *)stage_at(s, s->spheres) + index;
}

/* 1 - cos of the cone's half angle; its sine is radius / distance. 0 from inside, where the
 * sphere does not shine. Written without the difference, which has no digits for a far sphere. */
static float sphere_cap(const struct stage_sphere *sphere, vec3 to_center)
{
    const float ss = sphere->radius * sphere->radius / vec3_dot(to_center, to_center);
    return ss < 1 ? ss / (1 + __builtin_sqrtf(1 - ss)) : 0;
}

static float sphere_pdf_w(const struct stage_sphere *sphere, vec3 to_center)
{
    const float cap = sphere_cap(sphere, to_center);
    return cap > 0 ? warp_cap_pdf_w(cap) : 0;
}

/* Where a direction of the cone, theta off its axis, first meets the sphere: at the angle alpha
 * from the axis as seen from the centre. With rho = sin(theta) / sin(theta_max) and a distance of
 * 1 / sin(theta_max) radii:
 *
 *     sin alpha = rho (cos theta - sin theta_max sqrt(1 - rho^2))
 *     cos alpha = rho^2 sin theta_max + cos theta sqrt(1 - rho^2) */
static struct surface point_on_sphere(const struct stage *s, struct stage_id id,
                                      const struct stage_sphere *sphere, vec3 to_center,
                                      struct square q)
{
    const float distance = vec3_length(to_center);
    const struct warp_frame f = warp_frame_make(to_center / distance);
    const float sine_max = sphere->radius / distance;
    const float cap = sphere_cap(sphere, to_center);
    const float m = cap * q.u;                  /* 1 - cos theta */
    const float rr = q.u * (2 - m) / (2 - cap); /* rho^2 = m (2 - m) / (cap (2 - cap)) */
    const float root = __builtin_sqrtf(rr < 1 ? 1 - rr : 0);
    const float sine = __builtin_sqrtf(rr) * ((1 - m) - sine_max * root);
    const float cosine = rr * sine_max + (1 - m) * root;
    float a, b;
    fmath_sincos_turns(q.v, &a, &b);
    return surface_on_sphere(s, id, warp_to_world(&f, vec3_make(sine * b, sine * a, -cosine)));
}

/* --- the choice --- */

/* At a point that shines, chosen with the density pdf_w. */
static bool look_at(const struct surface *from, const struct surface *on, float pdf_w, rgb radiance,
                    struct light_sample *out)
{
    const vec3 d = on->p - from->p;
    if (!(pdf_w > 0 && vec3_dot(d, d) > 0)) /* at contact it may be the very place */
        return false;
    out->pdf_w = pdf_w;
    out->value = radiance / pdf_w;
    out->wi = vec3_unit(d);
    out->shadow = surface_to_surface(from, on);
    return true;
}

/* b: of a triangle, the weights of its corners 1 and 2. */
static rgb radiance_on(const struct stage *s, const struct emitter *e, const struct surface *on,
                       struct square b)
{
    if (e->texture == STAGE_NONE)
        return vec3_load(e->radiance);
    const struct ray_hit hit = {
        .prim = e->prim, .place = e->place, .instance = STAGE_NONE, .u = b.u, .v = b.v};
    return glow_on(s, e, &hit, on);
}

static bool sample_near(const struct stage *s, const struct surface *from, const struct emitter *e,
                        float pick, struct square q, struct light_sample *out)
{
    const struct near n = near_make(s, from, (uint32_t)(e - stage_emitter_at(s, 0)), pick);
    const float pdf_w = near_pdf_w(&n);
    if (!(pdf_w > 0))
        return false;
    const double u = (n.before + (double)q.u * (double)pick) / (double)n.probability;
    const struct light_solid_place place = light_solid_sample(&n.solid, u, (double)q.v);
    const struct emitter *of = stage_emitter_at(s, n.begin + place.triangle);
    const struct stage_id id = {of->prim, of->place, STAGE_NONE};
    const struct surface on = surface_on_triangle(s, id, place.b.u, place.b.v);
    return look_at(from, &on, pdf_w, radiance_on(s, of, &on, place.b), out);
}

/* No flat or round primitive sees its own front, so `from` never chooses its own. */
static bool sample_primitive(const struct stage *s, const struct surface *from,
                             const struct emitter *e, float pick, struct square q,
                             struct light_sample *out)
{
    if (e->prim == from->prim)
        return false;
    const struct stage_id id = {e->prim, e->place, STAGE_NONE};
    struct surface on;
    struct square b = {0, 0};
    float pdf_w = 0;
    switch ((enum stage_kind)id.place.kind) {
    case STAGE_TRIANGLE:
        b = warp_triangle(q);
        on = surface_on_triangle(s, id, b.u, b.v);
        if (is_near(e, on.ng, from->p))
            return sample_near(s, from, e, pick, q, out);
        pdf_w = area_pdf_w(on.p - from->p, on.ng, e->area);
        break;
    case STAGE_DISC:
        on = point_on_disc(s, id, q);
        pdf_w = area_pdf_w(on.p - from->p, on.ng, e->area);
        break;
    case STAGE_CYLINDER: {
        const struct light_cylinder view =
            light_cylinder_make(cylinder_at(s, id.place.index), from->p);
        if (!(view.sine > 0))
            return false;
        on = surface_on_cylinder(s, id, light_cylinder_along(&view, q.u),
                                 light_cylinder_outward(&view, q.v));
        pdf_w = cylinder_pdf_w(&view, on.p - from->p, on.ng);
        break;
    }
    case STAGE_SPHERE: {
        const struct stage_sphere *sphere = sphere_at(s, id.place.index);
        const vec3 to_center = vec3_load(sphere->center) - from->p;
        pdf_w = sphere_pdf_w(sphere, to_center);
        if (pdf_w > 0)
            on = point_on_sphere(s, id, sphere, to_center, q);
        break;
    }
    }
    return look_at(from, &on, pick * pdf_w, radiance_on(s, e, &on, b), out);
}

static bool sample_point(const struct stage *s, const struct surface *from, const struct emitter *e,
                         float pick, struct light_sample *out)
{
    const vec3 d = vec3_load(e->at) - from->p;
    const float dd = vec3_dot(d, d);
    if (!(dd > 0))
        return false;
    out->wi = vec3_unit(d);
    out->value = vec3_load(e->radiance) / (dd * pick);
    if (e->kind == EMITTER_SPOT) {
        const struct stage_spot *spot = (const struct stage_spot *)stage_at(s, s->spots) + e->index;
        const float part = light_spot_falloff(spot, -out->wi);
        if (!(part > 0))
            return false;
        out->value *= part;
    }
    out->pdf_w = 0;
    out->shadow = surface_to_point(from, vec3_load(e->at));
    return true;
}

static bool sample_sun(const struct surface *from, const struct emitter *e, float pick,
                       struct square q, struct light_sample *out)
{
    out->wi = light_sun_direction(e, q);
    out->pdf_w = pick * light_sun_pdf_w(e);
    out->value = vec3_load(e->radiance) / out->pdf_w;
    out->shadow = surface_leave(from, out->wi);
    return true;
}

static const struct stage_map *map_of(const struct stage *s, const struct emitter *e)
{
    return (const struct stage_map *)stage_at(s, s->maps) + e->index;
}

static bool sample_map(const struct stage *s, const struct surface *from, const struct emitter *e,
                       float pick, struct sobol_bits q, struct light_sample *out)
{
    const struct light_map_sample found = light_map_sample(s, map_of(s, e), q);
    out->wi = found.dir;
    out->pdf_w = pick * found.pdf_w;
    out->value = vec3_load(e->radiance) * found.pixel / out->pdf_w;
    out->shadow = surface_leave(from, out->wi);
    return out->pdf_w > 0;
}

bool light_sample_picked(const struct stage *s, const struct surface *from, struct light_pick pick,
                         uint32_t v, struct light_sample *out)
{
    if (pick.emitter == STAGE_NONE)
        return false;
    const struct emitter *e = stage_emitter_at(s, pick.emitter);
    const struct square place = {sobol_float(pick.rest), sobol_float(v)};
    const float probability = pick.probability;
    switch (e->kind) {
    case EMITTER_PRIM:
        return sample_primitive(s, from, e, probability, place, out);
    case EMITTER_POINT:
    case EMITTER_SPOT:
        return sample_point(s, from, e, probability, out);
    case EMITTER_SUN:
        return sample_sun(from, e, probability, place, out);
    case EMITTER_MAP:
        return sample_map(s, from, e, probability, (struct sobol_bits){pick.rest, v}, out);
    case EMITTER_DISTANT:
        out->wi = -vec3_load(e->at);
        out->value = vec3_load(e->radiance) / probability;
        out->pdf_w = 0;
        out->shadow = surface_leave(from, out->wi);
        return true;
    }
    __builtin_unreachable();
}

bool light_sample(const struct stage *s, const struct surface *from, struct sobol_bits q,
                  struct light_sample *out)
{
    struct light_pick pick;
    if (s->emitters.count == 0)
        return false;
    if (s->light_nodes.count)
        light_pick(s, &from, &q.u, 1, &pick);
    else
        pick = pick_by_table(s, 0, unit_of(q.u));
    return light_sample_picked(s, from, pick, q.v, out);
}

rgb light_beyond(const struct stage *s, uint32_t emitter, vec3 dir, float *pdf_w)
{
    const struct emitter *e = stage_emitter_at(s, emitter);
    rgb radiance = vec3_load(e->radiance);
    if (e->kind == EMITTER_MAP)
        radiance *= light_map_pixel(s, map_of(s, e), dir, pdf_w);
    else if (light_sun_meets(e, dir))
        *pdf_w = light_sun_pdf_w(e);
    else
        return rgb_gray(0);
    *pdf_w *= (float)pick_probability(s, emitter);
    return radiance;
}

float light_pdf_w(const struct stage *s, const struct surface *from, const struct surface *at)
{
    const struct emitter *e = stage_emitter_at(s, at->emitter);
    const float pick = place_probability(s, from, at->emitter);
    const vec3 p = from->p;
    switch ((enum stage_kind)e->place.kind) {
    case STAGE_TRIANGLE:
        if (is_near(e, at->ng, p)) {
            const struct near n = near_make(s, from, at->emitter, pick);
            return near_pdf_w(&n);
        }
        return pick * area_pdf_w(at->p - p, at->ng, e->area);
    case STAGE_DISC:
        return pick * area_pdf_w(at->p - p, at->ng, e->area);
    case STAGE_CYLINDER: {
        const struct light_cylinder view = light_cylinder_make(cylinder_at(s, e->place.index), p);
        return pick * cylinder_pdf_w(&view, at->p - p, at->ng);
    }
    case STAGE_SPHERE: {
        const struct stage_sphere *sphere = sphere_at(s, e->place.index);
        return pick * sphere_pdf_w(sphere, vec3_load(sphere->center) - p);
    }
    }
    __builtin_unreachable();
}
