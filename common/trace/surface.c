/* Points are computed in double and rounded once to float, so the bound on a point's error is half an
 * ulp and what double leaves over. SPDX-License-Identifier: MIT */
#include "common/trace/surface.h"

#include "common/trace/round.h"
#include "common/trace/sphere.h"

static const struct stage_prim *prim_at(const struct stage *s, uint32_t prim)
{
    return (const struct stage_prim *)stage_at(s, s->prims) + prim;
}

static const struct stage_sphere *sphere_at(const struct stage *s, uint32_t index)
{
    return (const struct stage_sphere *)stage_at(s, s->spheres) + index;
}

static const struct stage_disc *disc_at(const struct stage *s, uint32_t index)
{
    return (const struct stage_disc *)stage_at(s, s->discs) + index;
}

static vec3 rounded(const double v[3])
{
    return vec3_make((float)v[0], (float)v[1], (float)v[2]);
}

static vec3 unit(const double v[3])
{
    const double length = __builtin_sqrt(sphere_dot(v, v));
    const double u[3] = {v[0] / length, v[1] / length, v[2] / length};
    return rounded(u);
}

/* `exact` is right up to 2^-48 of `terms`, the greatest magnitude that went into it. */
static struct surface make(const struct stage *s, uint32_t prim, const double exact[3],
                           const double terms[3], vec3 ng)
{
    const struct stage_prim *is = prim_at(s, prim);
    vec3 p = rounded(exact), error;
    for (int k = 0; k < 3; k++)
        error[k] = ROUND_UNIT * __builtin_fabsf(p[k]) + 0x1p-48f * (float)terms[k] + 0x1p-149f;
    return (struct surface){p, error, ng, prim, is->material, is->emitter};
}

/* Differences of floats and their products are nearly exact in double: slivers keep a normal. */
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
    return unit(n);
}

/* u and v need not be exact: every weighted mean lies in the triangle's plane, and weights that sum to
 * more than 1 by rounding are brought back, so it lies in the triangle. */
struct surface surface_on_triangle(const struct stage *s, uint32_t prim, float u, float v)
{
    const struct stage_triangle *t =
        (const struct stage_triangle *)stage_at(s, s->triangles) + prim_at(s, prim)->index;
    double w[3] = {1 - (double)u - (double)v, (double)u, (double)v};
    if (w[0] < 0) {
        const double sum = w[1] + w[2];
        w[0] = 0;
        w[1] /= sum;
        w[2] /= sum;
    }
    double p[3] = {0}, terms[3] = {0};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            const double term = w[i] * (double)t->v[i][k];
            p[k] += term;
            terms[k] += __builtin_fabs(term);
        }
    return make(s, prim, p, terms, triangle_normal(t->v));
}

/* The point of the sphere in the direction n, of any length, from its centre. */
static struct surface on_sphere(const struct stage *s, uint32_t prim, const double n[3])
{
    const struct stage_sphere *sphere = sphere_at(s, prim_at(s, prim)->index);
    const double radius = (double)sphere->radius, length = __builtin_sqrt(sphere_dot(n, n));
    double p[3], terms[3];
    for (int k = 0; k < 3; k++) {
        const double c = (double)sphere->center[k];
        p[k] = c + radius * (n[k] / length);
        terms[k] = __builtin_fabs(c) + radius;
    }
    return make(s, prim, p, terms, unit(n));
}

struct surface surface_on_sphere(const struct stage *s, uint32_t prim, vec3 outward_unit)
{
    const double n[3] = {(double)outward_unit[0], (double)outward_unit[1],
                         (double)outward_unit[2]};
    return on_sphere(s, prim, n);
}

/* The point of the disc's plane nearest to centre + from. */
static struct surface on_disc(const struct stage *s, uint32_t prim, const double from[3])
{
    const struct stage_disc *disc = disc_at(s, prim_at(s, prim)->index);
    const double n[3] = {(double)disc->normal[0], (double)disc->normal[1], (double)disc->normal[2]};
    const double off = sphere_dot(from, n) / sphere_dot(n, n);
    double p[3], terms[3];
    for (int k = 0; k < 3; k++) {
        const double c = (double)disc->center[k];
        p[k] = c + (from[k] - off * n[k]);
        terms[k] = __builtin_fabs(c) + (double)disc->radius;
    }
    return make(s, prim, p, terms, vec3_load(disc->normal));
}

struct surface surface_on_disc(const struct stage *s, uint32_t prim, vec3 p)
{
    const struct stage_disc *disc = disc_at(s, prim_at(s, prim)->index);
    double from[3];
    for (int k = 0; k < 3; k++)
        from[k] = (double)p[k] - (double)disc->center[k];
    return on_disc(s, prim, from);
}

/* Where the ray is at t, seen from the centre. */
static void reached(const struct ray *ray, double t, const float center[3], double from[3])
{
    double d[3];
    sphere_relative(ray, center, from, d);
    for (int k = 0; k < 3; k++)
        from[k] += t * d[k];
}

/* Sphere and disc compute t again: hit->t is rounded to float, and for a ray from afar that is more
 * than the radius. */
struct surface surface_at(const struct stage *s, const struct ray *ray, const struct ray_hit *hit)
{
    const struct stage_prim *prim = prim_at(s, hit->prim);
    double from[3];
    switch ((enum stage_prim_kind)prim->kind) {
    case STAGE_TRIANGLE:
        return surface_on_triangle(s, hit->prim, hit->u, hit->v);
    case STAGE_SPHERE: {
        const struct stage_sphere *sphere = sphere_at(s, prim->index);
        reached(ray, sphere_t(ray, sphere), sphere->center, from);
        return on_sphere(s, hit->prim, from);
    }
    case STAGE_DISC: {
        const struct stage_disc *disc = disc_at(s, prim->index);
        reached(ray, sphere_disc_t(ray, disc), disc->center, from);
        return on_disc(s, hit->prim, from);
    }
    }
    __builtin_unreachable();
}

/* s.p moved along ng, to the side of dir, until the box of its error is left behind, and rounded
 * outwards (PBRT 4, section 6.8.6). gamma(8) covers the rounding of ng and of this sum. */
static vec3 outside(const struct surface *s, vec3 p_error, vec3 dir)
{
    float distance = 0;
    for (int k = 0; k < 3; k++)
        distance += __builtin_fabsf(s->ng[k]) * p_error[k];
    distance *= 1 + round_gamma(8);
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

/* The direction is rounded, so at t = 1 the segment is up to 2^-24 |d| per axis beside its end; that is
 * added to the error which the end keeps clear of. t of the target itself is then at least
 * 1 - 2^-46 before it is rounded to float: 1, and no hit. */
struct ray surface_to_surface(const struct surface *from, const struct surface *to)
{
    const vec3 way = to->p - from->p;
    const vec3 origin = outside(from, from->p_error, way);
    vec3 error = to->p_error;
    const vec3 both = from->p_error + to->p_error;
    const float moved = 2 * (both[0] + both[1] + both[2]); /* at most, by leaving both surfaces */
    for (int k = 0; k < 3; k++)
        error[k] += round_gamma(2) * (__builtin_fabsf(way[k]) + moved);
    const vec3 target = outside(to, error, -way);
    return (struct ray){origin, target - origin, 1};
}

struct ray surface_to_point(const struct surface *from, vec3 to)
{
    const vec3 origin = outside(from, from->p_error, to - from->p);
    return (struct ray){origin, to - origin, 1};
}
