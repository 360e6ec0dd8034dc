/* What the scene is like. SPDX-License-Identifier: MIT */
#include "common/trace/bsdf.h"
#include "common/trace/bvh.h"
#include "common/trace/camera.h"
#include "common/trace/light_map.h"
#include "common/trace/study_parts.h"

enum {
    SALT = 3,
    RAYS = 4,       /* from each place, to see whether it is open */
    MOST_SEEN = 64, /* emitters whose solid angle is looked at */
};

/* --- lists --- */

static enum plan_lobe lobe_of(float alpha)
{
    if (alpha < BSDF_LEAST_ALPHA)
        return PLAN_DELTA;
    return alpha < 0.05f ? PLAN_NARROW : alpha < 0.2f ? PLAN_GLOSSY : PLAN_ROUGH;
}

static void count_lobes(const struct material *m, uint32_t lobes[])
{
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
    case MATERIAL_ROUGH_DIFFUSE:
    case MATERIAL_LEAF:
        lobes[PLAN_MATTE]++;
        return;
    case MATERIAL_CLOTH:
        lobes[PLAN_ROUGH]++;
        lobes[PLAN_MATTE]++;
        return;
    case MATERIAL_MIRROR:
    case MATERIAL_PANE:
        lobes[PLAN_DELTA]++;
        return;
    case MATERIAL_DIELECTRIC:
        lobes[bsdf_is_delta(m) ? PLAN_DELTA : lobe_of(m->dielectric.alpha)]++;
        return;
    case MATERIAL_CONDUCTOR:
        lobes[lobe_of(m->conductor.alpha)]++;
        return;
    case MATERIAL_RETROREFLECTOR:
        lobes[lobe_of(m->retro.alpha)]++;
        return;
    case MATERIAL_METAL:
        lobes[bsdf_is_delta(m) ? PLAN_DELTA
                               : lobe_of(m->metal.alpha_x < m->metal.alpha_y ? m->metal.alpha_x
                                                                             : m->metal.alpha_y)]++;
        return;
    case MATERIAL_PLASTIC:
        lobes[PLAN_MATTE]++;
        lobes[lobe_of(m->plastic.alpha)]++;
        return;
    case MATERIAL_PRINCIPLED:
        lobes[PLAN_MATTE]++;
        lobes[lobe_of(m->principled.roughness * m->principled.roughness)]++;
        return;
    case MATERIAL_MIX: /* of materials that are in the list themselves */
    case MATERIAL_MASK:
    case MATERIAL_TWO_SIDED:
        return;
    }
    __builtin_unreachable();
}

static void count_lists(const struct stage *s, struct plan_features *f)
{
    const struct material *materials = stage_at(s, s->materials);
    const struct emitter *emitters = stage_at(s, s->emitters);
    for (uint32_t i = 0; i < s->materials.count; i++)
        count_lobes(&materials[i], f->lobes);
    for (uint32_t i = 0; i < s->emitters.count; i++)
        f->emitters[emitters[i].kind]++;
    f->sky = !rgb_is_black(s->sky);
    f->textures = s->slots.count > 0;
    f->masks = s->masked;
    f->media = s->media != 0;
    f->light_tree = s->light_nodes.count > 0;
    f->detail = s->details.count > 0;
}

/* --- environment maps --- */

/* In a thousand bins of brightness, an eighth of a doubling each, so that no list is sorted. */
enum { BINS = 1024 };

struct bins {
    double angle[BINS], light[BINS];
};

static uint32_t bin_of(double brightness)
{
    const double place = 8 * fmath_log2(brightness) + BINS / 2;
    return place < 0 ? 0 : place < BINS - 1 ? (uint32_t)place : BINS - 1;
}

static double top_share(const struct bins *b, double angle, double light)
{
    double left = angle / 1000, top = 0;
    for (uint32_t i = BINS; i-- > 0 && left > 0;) {
        const double part = b->angle[i] > left ? left / b->angle[i] : 1;
        left -= b->angle[i];
        top += part * b->light[i];
    }
    return light > 0 ? top / light : 0;
}

static void look_at_map(const struct stage *s, const struct stage_map *m, struct plan_features *f)
{
    const struct stage_map_row *rows =
        (const struct stage_map_row *)stage_at(s, s->map_rows) + m->row_begin;
    const struct stage_map_pixel *pixel =
        (const struct stage_map_pixel *)stage_at(s, s->map_pixels) + m->pixel_begin;
    struct bins bins = {{0}, {0}};
    double angle = 0, light = 0, peak = 0;
    for (uint32_t y = 0; y < m->height; y++)
        for (uint32_t x = 0; x < m->width; x++, pixel++) {
            const double l = (double)rgb_luminance(vec3_load(pixel->rgb));
            const double part = (double)rows[y].solid_angle;
            const uint32_t bin = l >= 0x1p-126 ? bin_of(l) : 0;
            angle += part;
            light += part * l;
            peak = peak < l ? l : peak;
            bins.angle[bin] += part;
            bins.light[bin] += part * l;
        }
    const double relative = light > 0 ? peak * angle / light : 0;
    const double top = top_share(&bins, angle, light);
    f->map_peak = f->map_peak < relative ? relative : f->map_peak;
    f->map_top = f->map_top < top ? top : f->map_top;
}

/* --- solid angles --- */

/* A. van Oosterom, J. Strackee, "The Solid Angle of a Plane Triangle", IEEE Trans. Biomed. Eng.
 * 30(2), 1983. */
static float of_triangle(const struct stage_triangle *t, vec3 p)
{
    vec3 v[3];
    for (int i = 0; i < 3; i++) {
        v[i] = vec3_load(t->v[i]) - p;
        const float length = vec3_length(v[i]);
        if (!(length > 0))
            return 0;
        v[i] /= length;
    }
    const float volume = vec3_dot(v[0], vec3_cross(v[1], v[2]));
    const float rest = 1 + vec3_dot(v[0], v[1]) + vec3_dot(v[1], v[2]) + vec3_dot(v[2], v[0]);
    const float half =
        fmath_atan2(volume, rest); /* of the front, which is counter-clockwise: < 0 */
    return half < 0 ? -2 * half : 0;
}

/* Its disc or side as a disc of the same area that stands where its middle is. */
static float of_flat(vec3 middle, vec3 normal, float area, vec3 p)
{
    const vec3 d = middle - p;
    const float dd = vec3_dot(d, d), pi = 2 * FMATH_HALF_PI;
    if (!(dd > 0))
        return 0;
    const float cosine = -vec3_dot(d, normal) / __builtin_sqrtf(dd);
    return cosine > 0 ? 2 * pi * (1 - 1 / __builtin_sqrtf(1 + cosine * area / (pi * dd))) : 0;
}

static float of_sphere(const struct stage_sphere *sphere, vec3 p)
{
    const vec3 d = vec3_load(sphere->center) - p;
    const float ss = sphere->radius * sphere->radius / vec3_dot(d, d);
    return ss < 1 ? 4 * FMATH_HALF_PI * (ss / (1 + __builtin_sqrtf(1 - ss))) : 0;
}

static float of_emitter(const struct stage *s, const struct emitter *e, vec3 p)
{
    if (e->kind == EMITTER_SUN)
        return 4 * FMATH_HALF_PI * e->cap;
    if (e->kind != EMITTER_PRIM)
        return 0;
    switch ((enum stage_kind)e->place.kind) {
    case STAGE_TRIANGLE: {
        const struct stage_triangle t = stage_triangle_at(s, e->place.index, STAGE_NONE);
        return of_triangle(&t, p);
    }
    case STAGE_SPHERE:
        return of_sphere((const struct stage_sphere *)stage_at(s, s->spheres) + e->place.index, p);
    case STAGE_DISC: {
        const struct stage_disc *d =
            (const struct stage_disc *)stage_at(s, s->discs) + e->place.index;
        return of_flat(vec3_load(d->center), vec3_load(d->normal), e->area, p);
    }
    case STAGE_CYLINDER: {
        const struct stage_cylinder *c =
            (const struct stage_cylinder *)stage_at(s, s->cylinders) + e->place.index;
        const vec3 middle = vec3_load(c->from) + 0.5f * vec3_load(c->axis);
        return of_flat(middle, vec3_unit(p - middle),
                       2 * c->radius * vec3_length(vec3_load(c->axis)), p);
    }
    }
    __builtin_unreachable();
}

/* Of the largest shape: a quad's triangles count together. */
static double largest(const struct stage *s, vec3 p)
{
    const struct emitter *emitters = stage_at(s, s->emitters);
    double most = 0, shape = 0;
    uint32_t last = STAGE_NONE;
    for (uint32_t i = 0; i < s->emitters.count && i < MOST_SEEN; i++) {
        const bool is_prim = emitters[i].kind == EMITTER_PRIM;
        const uint32_t of = is_prim ? stage_shape_of(s, emitters[i].prim) : STAGE_NONE;
        shape = of != STAGE_NONE && of == last ? shape : 0;
        shape += (double)of_emitter(s, &emitters[i], p);
        last = of;
        most = most < shape ? shape : most;
    }
    return most;
}

/* --- rays --- */

struct tally {
    uint32_t rays, hits, open, open_of, behind, behind_of;
    double albedo, solid_angle;
};

static void look_around(struct study *t, struct study_path *p, struct study_place at,
                        struct tally *sum)
{
    const struct path_vertex *v = &p->path.vertex;
    for (uint32_t i = 0; i < RAYS; i++) {
        const struct rng rng = study_rng(t->stage, at, i, SALT);
        vec3 dir = warp_cosine(rng_pair(&rng, rng_dimension(1, RNG_BSDF_DIRECTION)));
        dir[2] = v->wo[2] < 0 ? -dir[2] : dir[2];
        const struct ray ray = surface_leave(&v->at, warp_to_world(&v->frame, dir));
        struct ray_hit hit;
        t->work.bounce_rays++;
        sum->open += !bvh_hit_closest(t->stage, &ray, &hit);
        sum->open_of++;
    }
}

/* Whether something smooth stands first on the way to a light. */
static void look_at_light(struct study *t, struct study_path *p, struct tally *sum)
{
    const struct stage *s = t->stage;
    const struct sobol_bits bits = rng_pair_bits(&p->rng, rng_dimension(0, RNG_LIGHT));
    struct light_sample light;
    struct ray_hit hit;
    if (s->emitters.count == 0 || !light_sample(s, &p->path.vertex.at, bits, &light))
        return;
    sum->behind_of++;
    t->work.bounce_rays++;
    if (!bvh_hit_closest(s, &light.shadow, &hit))
        return;
    const struct surface at = surface_at(s, &light.shadow, &hit);
    const struct material *m = (const struct material *)stage_at(s, s->materials) + at.material;
    const bool is_one = m->kind < MATERIAL_MIX || m->kind > MATERIAL_TWO_SIDED;
    sum->behind += is_one && bsdf_is_delta(m);
}

static void look_from(struct study *t, struct study_place at, struct tally *sum)
{
    const struct stage *s = t->stage;
    const struct rng rng = study_rng(s, at, 0, SALT);
    struct study_path p;
    struct ray ray;
    study_path_init(&p, s, rng, &t->work);
    ray = camera_ray(&s->camera, (float)at.x_px + 0.5f, (float)at.y_px + 0.5f);
    sum->rays++;
    if (!study_path_go(&p, ray, true))
        return;
    sum->hits++;
    const double seen = largest(s, p.path.vertex.at.p);
    sum->solid_angle = sum->solid_angle < seen ? seen : sum->solid_angle;
    look_around(t, &p, at, sum);
    study_path_material(&p);
    look_at_light(t, &p, sum);
    if (study_path_scatter(&p, false, false, &ray)) /* but for what refraction does to radiance */
        sum->albedo += (double)(rgb_luminance(p.path.throughput) / p.path.scale);
}

bool study_features(struct study *t)
{
    const struct stage *s = t->stage;
    struct plan_features *f = &t->plan->features;
    struct tally sum = {0};
    count_lists(s, f);
    const struct stage_map *maps = stage_at(s, s->maps);
    for (uint32_t i = 0; i < s->maps.count; i++)
        look_at_map(s, &maps[i], f);
    const uint32_t places = plan_places(t->plan);
    for (uint32_t i = 0; i < places; i++) {
        if (study_is_halted(t))
            return false;
        look_from(t, study_place(s, i, SALT), &sum);
    }
    const double hits = sum.hits ? sum.hits : 1;
    f->hit = sum.rays ? (double)sum.hits / sum.rays : 0;
    f->solid_angle = sum.solid_angle;
    f->open = sum.open_of ? (double)sum.open / sum.open_of : 0;
    f->albedo = sum.albedo / hits;
    f->behind = sum.behind_of ? (double)sum.behind / sum.behind_of : 0;
    return true;
}
