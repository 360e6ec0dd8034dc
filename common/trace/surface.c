/* SPDX-License-Identifier: MIT */
#include "common/trace/surface.h"

#include "common/trace/cylinder.h"
#include "common/trace/simd.h"

static struct surface make(struct stage_id id, vec3 p, vec3 p_error, vec3 ng)
{
    return (struct surface){p, p_error, ng, id.prim, STAGE_NONE, STAGE_NONE, 0};
}

struct corners { /* of a triangle, in the world */
    vec3 a, b, c;
};

static vec3 corner(const struct stage_block *block, int i, uint32_t lane)
{
    return vec3_make(block->v[i][0][lane], block->v[i][1][lane], block->v[i][2][lane]);
}

/* As stage_triangle_at, into registers. */
static struct corners corners_at(const struct stage *s, struct stage_id id)
{
    const struct stage_block *block =
        (const struct stage_block *)stage_at(s, s->blocks) + id.place.index / STAGE_LANES;
    const uint32_t lane = id.place.index % STAGE_LANES;
    const struct corners t = {corner(block, 0, lane), corner(block, 1, lane),
                              corner(block, 2, lane)};
    if (id.instance == STAGE_NONE)
        return t;
    const struct stage_instance *of = stage_instance_at(s, id.instance);
    const struct corners world = {xform_point(&of->to_world, t.a), xform_point(&of->to_world, t.b),
                                  xform_point(&of->to_world, t.c)};
    return of->mirrored ? (struct corners){world.a, world.c, world.b} : world;
}

/* In double: differences of floats and their products are exact there, so slivers keep a normal. */
static vec3 triangle_normal(const struct corners *t)
{
    const f64x4 a = f64x4_of(t->a);
    const f64x4 n = f64x4_cross(f64x4_of(t->b) - a, f64x4_of(t->c) - a);
    const f64x4 nn = n * n;
    return f64x4_round(n / __builtin_sqrt(nn[0] + nn[1] + nn[2]));
}

static inline struct surface on_triangle(const struct stage *s, struct stage_id id, float u,
                                         float v)
{
    const struct corners t = corners_at(s, id);
    const vec3 a = t.a * (1 - u - v), b = t.b * u, c = t.c * v;
    /* PBRT 4, section 6.8.5: seven roundings at most on the way from vertices to sum. */
    const vec3 error = round_gamma(7) * (vec3_abs(a) + vec3_abs(b) + vec3_abs(c));
    return make(id, a + b + c, error, triangle_normal(&t));
}

/* Sums and differences of floats, in double. */
static double height(vec3 top, vec3 from, vec3 to)
{
    const f64x4 a = f64x4_of(from), way = f64x4_of(to) - a, up = f64x4_of(top) - a;
    const f64x4 n = f64x4_cross(way, up), nn = n * n, ww = way * way;
    return __builtin_sqrt((nn[0] + nn[1] + nn[2]) / (ww[0] + ww[1] + ww[2]));
}

/* The least weight of a corner, so that the point is as far from the opposite edge as it may be off
 * its place; of a sliver, a quarter. */
static double least_weight(double error, double height)
{
    return error < .25 * height ? error / height : .25;
}

/* A hit that is all but on an edge. Rounded, its point may lie in the plane of the triangle behind
 * that edge, or beyond it, and the ray that starts there would not meet that triangle: it would
 * leave a closed body. The point is moved into its own triangle, by no more than its error. */
static struct surface off_edges(const struct stage *s, struct stage_id id, float u, float v)
{
    const struct surface at = on_triangle(s, id, u, v);
    const struct corners t = corners_at(s, id);
    const float error = rgb_max(at.p_error);
    const double least[3] = {least_weight((double)error, height(t.a, t.b, t.c)),
                             least_weight((double)error, height(t.b, t.c, t.a)),
                             least_weight((double)error, height(t.c, t.a, t.b))};
    double weight[3] = {(double)(1 - u - v), (double)u, (double)v}, sum = 0;
    bool moves = false;
    for (int k = 0; k < 3; k++) {
        moves = moves || weight[k] < least[k];
        weight[k] = weight[k] < least[k] ? least[k] : weight[k];
        sum += weight[k];
    }
    return moves ? on_triangle(s, id, (float)(weight[1] / sum), (float)(weight[2] / sum)) : at;
}

struct surface surface_on_triangle(const struct stage *s, struct stage_id id, float u, float v)
{
    return on_triangle(s, id, u, v);
}

/* Centre and radius are exact by definition; the sum in double is rounded once to float. The second
 * term covers a direction that is unit only up to float rounding. */
struct surface surface_on_sphere(const struct stage *s, struct stage_id id, vec3 outward_unit)
{
    const struct stage_sphere *sphere =
        (const struct stage_sphere *)stage_at(s, s->spheres) + id.place.index;
    double n[3], length = 0;
    for (int k = 0; k < 3; k++) {
        n[k] = (double)outward_unit[k];
        length += n[k] * n[k];
    }
    length = __builtin_sqrt(length);
    vec3 p = {0}, ng = {0};
    for (int k = 0; k < 3; k++) {
        p[k] = (float)((double)sphere->center[k] + (double)sphere->radius * (n[k] / length));
        ng[k] = (float)(n[k] / length);
    }
    return make(id, p, round_gamma(2) * vec3_abs(p), ng);
}

/* The nearest point of the disc's plane, in double, rounded once to float. */
struct surface surface_on_disc(const struct stage *s, struct stage_id id, vec3 p)
{
    const struct stage_disc *disc =
        (const struct stage_disc *)stage_at(s, s->discs) + id.place.index;
    double off = 0, nn = 0;
    for (int k = 0; k < 3; k++) {
        off += ((double)p[k] - (double)disc->center[k]) * (double)disc->normal[k];
        nn += (double)disc->normal[k] * (double)disc->normal[k];
    }
    for (int k = 0; k < 3; k++)
        p[k] = (float)((double)p[k] - off / nn * (double)disc->normal[k]);
    return make(id, p, round_gamma(2) * vec3_abs(p), vec3_load(disc->normal));
}

static const struct stage_cylinder *cylinder_at(const struct stage *s, uint32_t index)
{
    return (const struct stage_cylinder *)stage_at(s, s->cylinders) + index;
}

/* out: from any point of the axis; what of it lies along the axis is taken away. In double; the sum
 * is rounded once to float, and before that each of its terms by a few parts in 2^53, which shows
 * where they cancel. */
static struct surface on_cylinder(const struct stage *s, struct stage_id id, double along,
                                  const double out[3])
{
    const struct stage_cylinder *c = cylinder_at(s, id.place.index);
    double a[3], n[3];
    cylinder_axis(c, a);
    const double up = sphere_dot(out, a) / sphere_dot(a, a);
    for (int k = 0; k < 3; k++)
        n[k] = out[k] - up * a[k];
    const double length = __builtin_sqrt(sphere_dot(n, n));
    vec3 p = {0}, ng = {0};
    for (int k = 0; k < 3; k++) {
        n[k] /= length;
        p[k] = (float)((double)c->from[k] + along * a[k] + (double)c->radius * n[k]);
        ng[k] = (float)n[k];
    }
    const vec3 terms = vec3_abs(vec3_load(c->from)) + vec3_abs(vec3_load(c->axis)) + c->radius;
    return make(id, p, round_gamma(2) * vec3_abs(p) + 0x1p-49f * terms, ng);
}

struct surface surface_on_cylinder(const struct stage *s, struct stage_id id, float along,
                                   vec3 outward)
{
    const double out[3] = {(double)outward[0], (double)outward[1], (double)outward[2]};
    return on_cylinder(s, id, (double)along, out);
}

/* Met anew in double: far away, the rounding of the hit's t is more than a thin cylinder's radius,
 * and the normal would be that of some other point. The root is the one the hit was rounded from.
 */
static struct surface met_cylinder(const struct stage *s, const struct ray *ray,
                                   const struct ray_hit *hit)
{
    const struct stage_cylinder *c = cylinder_at(s, hit->place.index);
    double f[3], d[3], a[3], t = (double)hit->t;
    cylinder_root(ray, c, &t);
    sphere_relative(ray, c->from, f, d);
    cylinder_axis(c, a);
    for (int k = 0; k < 3; k++)
        f[k] += t * d[k];
    const struct stage_id id = {hit->prim, hit->place, hit->instance};
    return on_cylinder(s, id, sphere_dot(f, a) / sphere_dot(a, a), f);
}

static inline struct surface point_at(const struct stage *s, const struct ray *ray,
                                      const struct ray_hit *hit)
{
    const struct stage_id id = {hit->prim, hit->place, hit->instance};
    const vec3 p = ray->origin + hit->t * ray->dir;
    switch ((enum stage_kind)id.place.kind) {
    case STAGE_TRIANGLE:
        return surface_is_near_edge(hit) ? off_edges(s, id, hit->u, hit->v)
                                         : on_triangle(s, id, hit->u, hit->v);
    case STAGE_SPHERE: {
        const struct stage_sphere *sphere =
            (const struct stage_sphere *)stage_at(s, s->spheres) + id.place.index;
        return surface_on_sphere(s, id, p - vec3_load(sphere->center));
    }
    case STAGE_DISC:
        return surface_on_disc(s, id, p);
    case STAGE_CYLINDER:
        return met_cylinder(s, ray, hit);
    }
    __builtin_unreachable();
}

struct surface surface_point_at(const struct stage *s, const struct ray *ray,
                                const struct ray_hit *hit)
{
    return point_at(s, ray, hit);
}

struct surface surface_at(const struct stage *s, const struct ray *ray, const struct ray_hit *hit)
{
    struct surface at = point_at(s, ray, hit);
    const uint32_t shape = hit->instance == STAGE_NONE ? stage_shape_of(s, hit->prim)
                                                       : stage_instance_at(s, hit->instance)->shape;
    const struct stage_shape *of = (const struct stage_shape *)stage_at(s, s->shapes) + shape;
    at.material = of->material;
    if (of->emitter_begin != STAGE_NONE)
        at.emitter = of->emitter_begin + hit->prim - of->prim_begin;
    return at;
}
