/* SPDX-License-Identifier: MIT */
#include "tests/naive_path.h"

#include <complex.h>
#include <math.h>

#include "common/trace/bvh.h"
#include "common/trace/medium.h"
#include "common/trace/surface.h"

static const double pi = 3.14159265358979323846;
static const double least_alpha = 0x1p-10; /* docs/scene.md; of glass, alpha (ior - 1) */

struct dir {
    double x, y, z; /* local: z along the side of the surface that wo is on */
};

static double dot(struct dir a, struct dir b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static struct dir reflect(struct dir w, struct dir m)
{
    const double d = 2 * dot(w, m);
    return (struct dir){d * m.x - w.x, d * m.y - w.y, d * m.z - w.z};
}

/* Reflectances for both polarisations by Fresnel's equations with a complex index. */
static double fresnel(double cos, double complex n)
{
    const double complex t = csqrt(n * n - (1 - cos * cos)); /* n cos_t */
    const double complex s = (cos - t) / (cos + t), p = (n * n * cos - t) / (n * n * cos + t);
    return 0.5 * (creal(s * conj(s)) + creal(p * conj(p)));
}

static struct dir diffuse(struct dice *dice)
{
    const double r = sqrt(dice_unit(dice)), phi = 2 * pi * dice_unit(dice);
    return (struct dir){r * cos(phi), r * sin(phi), sqrt(1 - r * r)};
}

/* Refraction, or reflection by chance; *scale takes the change of radiance. */
static struct dir dielectric(double eta, struct dir wo, struct dice *dice, double *scale)
{
    if (eta == 1)
        return (struct dir){-wo.x, -wo.y, -wo.z};
    const double sine = sqrt(wo.x * wo.x + wo.y * wo.y) / eta;
    if (sine >= 1 || dice_unit(dice) < fresnel(wo.z, eta))
        return (struct dir){-wo.x, -wo.y, wo.z};
    *scale = 1 / (eta * eta);
    return (struct dir){-wo.x / eta, -wo.y / eta, -sqrt(1 - sine * sine)};
}

/* Smith's Lambda for GGX. */
static double lambda(struct dir w, double alpha)
{
    const double t = alpha * alpha * (w.x * w.x + w.y * w.y) / (w.z * w.z);
    return (sqrt(1 + t) - 1) / 2;
}

/* Facets by D(m) m.z (Walter et al. 2007, eq. 35), visible or not. */
static struct dir facet(double alpha, struct dice *dice)
{
    const double u = dice_unit(dice), phi = 2 * pi * dice_unit(dice);
    const double c = 1 / sqrt(1 + alpha * alpha * u / (1 - u)), s = sqrt(1 - c * c);
    return (struct dir){s * cos(phi), s * sin(phi), c};
}

/* Weights by eq. 41, with the masking of bsdf_glass.h. */
static bool rough_dielectric(const struct material *m, double eta, struct dir wo, struct dice *dice,
                             struct dir *wi, double *weight)
{
    const double alpha = (double)m->dielectric.alpha;
    const struct dir h = facet(alpha, dice);
    const double oh = dot(wo, h), tt = 1 - (1 - oh * oh) / (eta * eta);
    if (oh <= 0)
        return false;
    *weight = oh / (wo.z * h.z);
    if (tt <= 0 || dice_unit(dice) < fresnel(oh, eta)) {
        *wi = reflect(wo, h);
        *weight /= 1 + lambda(wo, alpha) + lambda(*wi, alpha);
        return wi->z > 0;
    }
    const double along = oh / eta - sqrt(tt); /* eq. 40 */
    *wi =
        (struct dir){along * h.x - wo.x / eta, along * h.y - wo.y / eta, along * h.z - wo.z / eta};
    *weight /= (1 + lambda(wo, alpha)) * (1 + lambda(*wi, alpha)) * eta * eta;
    return wi->z < 0;
}

/* Either side by half, whatever they return. */
static void leaf(const struct material *m, struct dice *dice, struct dir *wi, double weight[3])
{
    const bool back = dice_unit(dice) < .5;
    *wi = diffuse(dice);
    if (!back)
        wi->z = -wi->z;
    for (int k = 0; k < 3; k++)
        weight[k] = 2 * (double)(back ? m->leaf.reflectance : m->leaf.transmittance)[k];
}

/* A slab of glass, its two faces one after the other, until the light is out. */
static struct dir pane(double ior, struct dir wo, struct dice *dice)
{
    const double r = fresnel(wo.z, ior);
    bool down = true; /* through the glass */
    if (dice_unit(dice) < r)
        return (struct dir){-wo.x, -wo.y, wo.z};
    while (dice_unit(dice) < r)
        down = !down;
    return (struct dir){-wo.x, -wo.y, down ? -wo.z : wo.z};
}

static bool either_dielectric(const struct material *m, bool front, struct dir wo,
                              struct dice *dice, struct dir *wi, double weight[3])
{
    const double ior = (double)m->dielectric.ior, eta = front ? ior : 1 / ior;
    const double alpha = (double)m->dielectric.alpha, bends = ior > 1 ? ior - 1 : 1 / ior - 1;
    double scale = 1;
    bool goes_on = true;
    if (alpha >= least_alpha && alpha * bends >= least_alpha)
        goes_on = rough_dielectric(m, eta, wo, dice, wi, &scale);
    else
        *wi = dielectric(eta, wo, dice, &scale);
    weight[0] = weight[1] = weight[2] = scale;
    return goes_on;
}

/* Reflects by Fresnel's equations, masked by what o and i see at once. */
static bool conductor(const struct material *m, struct dir wo, struct dice *dice, struct dir *wi,
                      double weight[3])
{
    const double alpha = (double)m->conductor.alpha;
    const struct dir h = facet(alpha, dice);
    const double oh = dot(wo, h);
    *wi = reflect(wo, h);
    if (oh <= 0 || wi->z <= 0)
        return false;
    const double g = 1 / (1 + lambda(wo, alpha) + lambda(*wi, alpha));
    for (int k = 0; k < 3; k++) {
        const double complex i = (double complex)I * (double)m->conductor.k[k];
        const double complex n = (double)m->conductor.eta[k] + i;
        weight[k] = fresnel(oh, n) * g * oh / (wo.z * h.z);
    }
    return true;
}

static bool scatter(const struct material *m, bool front, struct dir wo, struct dice *dice,
                    struct dir *wi, double weight[3])
{
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
        *wi = diffuse(dice);
        for (int k = 0; k < 3; k++)
            weight[k] = (double)m->diffuse.albedo[k];
        return true;
    case MATERIAL_MIRROR:
        *wi = (struct dir){-wo.x, -wo.y, wo.z};
        for (int k = 0; k < 3; k++)
            weight[k] = (double)m->mirror.reflectance[k];
        return true;
    case MATERIAL_DIELECTRIC:
        return either_dielectric(m, front, wo, dice, wi, weight);
    case MATERIAL_CONDUCTOR:
        return conductor(m, wo, dice, wi, weight);
    case MATERIAL_LEAF:
        leaf(m, dice, wi, weight);
        return true;
    case MATERIAL_PANE:
        *wi = pane((double)m->pane.ior, wo, dice);
        for (int k = 0; k < 3; k++)
            weight[k] = 1;
        return true;
    case MATERIAL_MIX:
    case MATERIAL_MASK:
    case MATERIAL_TWO_SIDED: /* looked through before */
    case MATERIAL_METAL:
    case MATERIAL_ROUGH_DIFFUSE:
    case MATERIAL_RETROREFLECTOR:
    case MATERIAL_PLASTIC:
    case MATERIAL_PRINCIPLED:
    case MATERIAL_CLOTH:
        break; /* scenes with them are beyond it */
    }
    __builtin_unreachable();
}

/* Any two directions across z make a frame: materials have no tangent. */
static void tangents(vec3 z, vec3 *x, vec3 *y)
{
    const vec3 off = fabsf(z[0]) < 0.5f ? vec3_make(1, 0, 0) : vec3_make(0, 1, 0);
    *x = vec3_unit(vec3_cross(off, z));
    *y = vec3_cross(z, *x);
}

static void add(double sum[3], const double throughput[3], vec3 radiance)
{
    for (int k = 0; k < 3; k++)
        sum[k] += throughput[k] * (double)radiance[k];
}

static vec3 of_map(const struct stage *s, const struct emitter *e, vec3 dir)
{
    const struct stage_map *map = (const struct stage_map *)stage_at(s, s->maps) + e->index;
    const struct stage_map_pixel *pixels =
        (const struct stage_map_pixel *)stage_at(s, s->map_pixels) + map->pixel_begin;
    double d[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            d[i] += (double)map->to_local[i][k] * (double)dir[k];
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    const uint32_t row = (uint32_t)(acos(d[1] / length) / pi * map->height);
    const uint32_t column = (uint32_t)((0.5 + atan2(d[0], -d[2]) / (2 * pi)) * map->width);
    const uint32_t x = column < map->width ? column : map->width - 1;
    const uint32_t y = row < map->height ? row : map->height - 1;
    return vec3_load(pixels[(size_t)y * map->width + x].rgb) * vec3_load(e->radiance);
}

static bool in_sun(const struct emitter *sun, vec3 dir)
{
    double dot = 0, length = 0;
    for (int k = 0; k < 3; k++) {
        dot -= (double)dir[k] * (double)sun->at[k];
        length += (double)dir[k] * (double)dir[k];
    }
    return 1 - dot / sqrt(length) <= (double)sun->cap;
}

/* --- what there is at a hit --- */

/* Which material of those that it is made of; NULL: nothing, the ray goes straight on. */
static const struct material *material_of(const struct stage *s, uint32_t i, bool front,
                                          struct dice *dice)
{
    const struct material *m = (const struct material *)stage_at(s, s->materials) + i;
    switch ((int)m->kind) {
    case MATERIAL_MASK:
        if (dice_unit(dice) >= (double)m->mask.opacity)
            return NULL;
        return material_of(s, m->mask.of, front, dice);
    case MATERIAL_MIX: {
        const bool second = dice_unit(dice) < (double)m->mix.amount;
        return material_of(s, second ? m->mix.second : m->mix.first, front, dice);
    }
    case MATERIAL_TWO_SIDED:
        return material_of(s, front ? m->two_sided.front : m->two_sided.back, front, dice);
    default:
        return m;
    }
}

/* The bodies that the ray is in, in the order in which it has entered them (medium.h). */
struct bodies {
    uint32_t count;
    const struct material *list[32];
};

static const struct material *filling(const struct bodies *b)
{
    const struct material *best = NULL;
    for (uint32_t i = 0; i < b->count; i++)
        if (!best || b->list[i]->inside.priority >= best->inside.priority)
            best = b->list[i];
    return best;
}

static struct bodies without(const struct bodies *b, const struct material *m)
{
    struct bodies rest = {0};
    uint32_t at = b->count;
    for (uint32_t i = 0; i < b->count; i++)
        at = b->list[i] == m ? i : at;
    for (uint32_t i = 0; i < b->count; i++)
        if (i != at)
            rest.list[rest.count++] = b->list[i];
    return rest;
}

static struct bodies with(const struct bodies *b, const struct material *m)
{
    struct bodies all = *b;
    if (all.count < countof(all.list))
        all.list[all.count++] = m;
    return all;
}

static double ior_in(const struct bodies *b)
{
    const struct material *m = filling(b);
    return m ? (double)m->dielectric.ior : 1;
}

/* A surface of a body: *seen is the interface as the viewer's side has it. False: it is not there,
 * and the ray is on its other side. */
static bool interface(const struct stage *s, struct bodies *here, const struct material *m,
                      bool *front, struct material *seen)
{
    const struct bodies beyond = *front ? with(here, m) : without(here, m);
    *seen = *m;
    if (!(s->media & MEDIUM_ORDERED))
        return true;
    const struct bodies *inside = *front ? &beyond : here;
    if (filling(inside) != m) {
        *here = beyond;
        return false;
    }
    const double ratio = ior_in(&beyond) / ior_in(here);
    seen->dielectric.ior = (float)(*front ? ratio : 1 / ratio);
    return true;
}

static void absorb(const struct bodies *b, double distance, double throughput[3])
{
    const struct material *m = filling(b);
    for (int k = 0; m && k < 3; k++)
        if (m->inside.absorption[k] > 0)
            throughput[k] *= exp(-(double)m->inside.absorption[k] * distance);
}

/* Whitted's paths go on from these. */
static bool is_smooth(const struct material *m)
{
    return m->kind == MATERIAL_MIRROR ||
           (m->kind == MATERIAL_DIELECTRIC && m->dielectric.alpha == 0);
}

static void leave(const struct stage *s, const double throughput[3], vec3 dir, bool sky,
                  double sum[3])
{
    const struct emitter *emitters = stage_at(s, s->emitters);
    if (sky)
        add(sum, throughput, s->sky);
    for (uint32_t e = s->beyond_begin; e < s->emitters.count; e++)
        if (emitters[e].kind == EMITTER_MAP)
            add(sum, throughput, of_map(s, &emitters[e], dir));
        else if (in_sun(&emitters[e], dir))
            add(sum, throughput, vec3_load(emitters[e].radiance));
}

struct walk {
    const struct stage *stage;
    struct dice *dice;
    struct ray ray;
    struct bodies bodies;
    double throughput[3], *sum;
    struct surface at;
    bool front;
    const struct material *material;
    struct material seen;
};

/* To the next surface that is there; false: it has left the scene. */
static bool arrive(struct walk *w, bool sky)
{
    const struct emitter *emitters = stage_at(w->stage, w->stage->emitters);
    for (;;) {
        struct ray_hit hit;
        const bool met = bvh_hit_closest(w->stage, &w->ray, &hit);
        absorb(&w->bodies, met ? (double)hit.t : (double)INFINITY, w->throughput);
        if (!met) {
            leave(w->stage, w->throughput, w->ray.dir, sky, w->sum);
            return false;
        }
        w->at = surface_at(w->stage, &w->ray, &hit);
        w->front = vec3_dot(w->ray.dir, w->at.ng) < 0;
        w->material = material_of(w->stage, w->at.material, w->front, w->dice);
        if (w->material && w->front && w->at.emitter != STAGE_NONE)
            add(w->sum, w->throughput, vec3_load(emitters[w->at.emitter].radiance));
        const bool body =
            w->material ==
                (const struct material *)stage_at(w->stage, w->stage->materials) + w->at.material &&
            w->material->kind == MATERIAL_DIELECTRIC;
        const struct material *m = w->material;
        if (body)
            w->material = &w->seen;
        if (m && (!body || interface(w->stage, &w->bodies, m, &w->front, &w->seen)))
            return true;
        w->ray = surface_leave(&w->at, w->ray.dir);
    }
}

/* By the body of the surface that it has passed. */
static void cross(struct walk *w, const struct dir *wi)
{
    const struct material *m =
        (const struct material *)stage_at(w->stage, w->stage->materials) + w->at.material;
    if (wi->z < 0 && m->kind == MATERIAL_DIELECTRIC)
        w->bodies = w->front ? with(&w->bodies, m) : without(&w->bodies, m);
}

static struct bodies around(const struct stage *s)
{
    struct bodies b = {0};
    for (uint32_t i = 0; s->media && i < s->around.count; i++)
        b = with(&b, (const struct material *)stage_at(s, s->materials) + s->around.material[i]);
    return b;
}

void naive_path_radiance(const struct stage *s, struct ray ray, struct dice *dice, double sum[3])
{
    struct walk w = {.stage = s,
                     .dice = dice,
                     .ray = ray,
                     .bodies = around(s),
                     .throughput = {1, 1, 1},
                     .sum = sum};
    bool lights_alone = false; /* behind the last surface of a path of Whitted's */
    for (uint32_t bounce = 0;; bounce++) {
        if (!arrive(&w, !lights_alone) || bounce == s->settings.max_bounces || lights_alone)
            return;
        lights_alone = s->settings.integrator == INTEGRATOR_WHITTED && !is_smooth(w.material);
        const vec3 z = w.front ? w.at.ng : -w.at.ng;
        vec3 x, y;
        tangents(z, &x, &y);
        const struct dir wo = {(double)-vec3_dot(w.ray.dir, x), (double)-vec3_dot(w.ray.dir, y),
                               (double)-vec3_dot(w.ray.dir, z)};
        struct dir wi;
        double weight[3], left = 0;
        if (!scatter(w.material, w.front, wo, dice, &wi, weight))
            return;
        for (int k = 0; k < 3; k++)
            left += w.throughput[k] *= weight[k];
        if (left == 0)
            return;
        cross(&w, &wi);
        w.ray =
            surface_leave(&w.at, vec3_unit(x * (float)wi.x + y * (float)wi.y + z * (float)wi.z));
    }
}

void naive_path_sample(const struct stage *s, uint32_t x_px, uint32_t y_px, struct dice *dice,
                       double sum[3])
{
    const struct stage_camera *c = &s->camera;
    const float x = (float)(x_px + dice_unit(dice)), y = (float)(y_px + dice_unit(dice));
    const vec3 dir = vec3_load(c->corner) + x * vec3_load(c->dx) + y * vec3_load(c->dy);
    const struct ray ray = {vec3_load(c->origin), vec3_unit(dir), INFINITY, 0, 0};
    naive_path_radiance(s, ray, dice, sum);
}

struct stat_mean naive_path_mean(const struct stage *s, uint32_t samples, uint64_t seed)
{
    struct dice dice = dice_make(seed);
    struct stat_mean mean = {0};
    for (uint32_t i = 0; i < samples; i++) {
        double sum[3] = {0};
        naive_path_sample(s, i % 8, i / 8 % 8, &dice, sum);
        stat_add(&mean, sum[1]);
    }
    return mean;
}
