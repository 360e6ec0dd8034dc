/* SPDX-License-Identifier: MIT */
#include "common/trace/surface.h"

#include "common/trace/cylinder.h"

static vec3 absolute(vec3 v)
{
    return vec3_make(__builtin_fabsf(v[0]), __builtin_fabsf(v[1]), __builtin_fabsf(v[2]));
}

static struct surface make(const struct stage *s, struct stage_id id, vec3 p, vec3 p_error, vec3 ng)
{
    const uint32_t shape = id.instance == STAGE_NONE ? stage_shape_of(s, id.prim)
                                                     : stage_instance_at(s, id.instance)->shape;
    const struct stage_shape *of = (const struct stage_shape *)stage_at(s, s->shapes) + shape;
    const uint32_t emitter =
        of->emitter_begin == STAGE_NONE ? STAGE_NONE : of->emitter_begin + id.prim - of->prim_begin;
    return (struct surface){p, p_error, ng, id.prim, of->material, emitter};
}

/* In double: differences of floats and their products are exact there, so slivers keep a normal. */
static vec3 triangle_normal(const float v[3][3])
{
    double a[3], b[3], n[3];
    for (int k = 0; k < 3; k++) {
        a[k] = (double)v[1][k] - (double)v[0][k];
        b[k] = (double)v[2][k] - (double)v[0][k];
    }
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        n[k] = a[i] * b[j] - a[j] * b[i];
    }
    const double length = __builtin_sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    return vec3_make((float)(n[0] / length), (float)(n[1] / length), (float)(n[2] / length));
}

struct surface surface_on_triangle(const struct stage *s, struct stage_id id, float u, float v)
{
    const struct stage_triangle t = stage_triangle_at(s, id.place.index, id.instance);
    const vec3 a = vec3_load(t.v[0]) * (1 - u - v);
    const vec3 b = vec3_load(t.v[1]) * u;
    const vec3 c = vec3_load(t.v[2]) * v;
    /* PBRT 4, section 6.8.5: seven roundings at most on the way from vertices to sum. */
    const vec3 error = round_gamma(7) * (absolute(a) + absolute(b) + absolute(c));
    return make(s, id, a + b + c, error, triangle_normal((const float(*)[3])t.v));
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
    return make(s, id, p, round_gamma(2) * absolute(p), ng);
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
    return make(s, id, p, round_gamma(2) * absolute(p), vec3_load(disc->normal));
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
    const vec3 terms = absolute(vec3_load(c->from)) + absolute(vec3_load(c->axis)) + c->radius;
    return make(s, id, p, round_gamma(2) * absolute(p) + 0x1p-49f * terms, ng);
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

struct surface surface_at(const struct stage *s, const struct ray *ray, const struct ray_hit *hit)
{
    const struct stage_id id = {hit->prim, hit->place, hit->instance};
    const vec3 p = ray->origin + hit->t * ray->dir;
    switch ((enum stage_kind)id.place.kind) {
    case STAGE_TRIANGLE:
        return surface_on_triangle(s, id, hit->u, hit->v);
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

/* s.p moved along ng, to the side of dir, until the box of its error is left behind (PBRT 4,
 * section 6.8.6); rounded outwards. */
static vec3 outside(const struct surface *s, vec3 p_error, vec3 dir)
{
    const float distance = vec3_dot(absolute(s->ng), p_error);
    const vec3 offset = s->ng * (vec3_dot(dir, s->ng) < 0 ? -distance : distance);
    vec3 p = s->p + offset;
    for (int k = 0; k < 3; k++)
        p[k] = offset[k] > 0 ? round_up(p[k]) : offset[k] < 0 ? round_down(p[k]) : p[k];
    return p;
}

struct ray surface_leave(const struct surface *s, vec3 dir)
{
    return (struct ray){outside(s, s->p_error, dir), dir, __builtin_inff()};
}

/* A segment's direction is rounded, so that its end lies up to gamma(1) |d| beside the target; t of
 * the target's own surface is rounded to float, and a hit may be moved to where the ray enters the
 * primitive's box, by gamma(3) at most. All are lengths along the segment. */
struct ray surface_to_surface(const struct surface *from, const struct surface *to)
{
    const vec3 way = to->p - from->p;
    const vec3 origin = outside(from, from->p_error, way);
    const float blur = round_gamma(6) * vec3_length(way);
    const vec3 target = outside(to, to->p_error + vec3_make(blur, blur, blur), -way);
    return (struct ray){origin, target - origin, 1};
}

struct ray surface_to_point(const struct surface *from, vec3 to)
{
    const vec3 origin = outside(from, from->p_error, to - from->p);
    return (struct ray){origin, to - origin, 1};
}
