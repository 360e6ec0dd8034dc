/* SPDX-License-Identifier: MIT */
#include "tests/naive_hit.h"

#include <math.h>

#include "common/trace/bvh.h"
#include "common/trace/sphere.h"
#include "common/trace/tri.h"

/* --- the core's own tests, one primitive after the other --- */

static bool hit_one(const struct stage *s, const struct ray *ray, const struct tri_ray *tri,
                    uint32_t prim, struct ray_hit *hit)
{
    const struct stage_prim *p = (const struct stage_prim *)stage_at(s, s->prims) + prim;
    *hit = (struct ray_hit){.prim = prim};
    switch ((enum stage_prim_kind)p->kind) {
    case STAGE_TRIANGLE: {
        const struct stage_triangle *t = (const struct stage_triangle *)stage_at(s, s->triangles);
        return tri_hit(tri, t[p->index].v, ray->t_max, hit) && hit->t < ray->t_max;
    }
    case STAGE_SPHERE:
        hit->t = (float)sphere_t(ray, (const struct stage_sphere *)stage_at(s, s->spheres) + p->index);
        return hit->t > 0 && hit->t < ray->t_max;
    case STAGE_DISC:
        hit->t = (float)sphere_disc_t(ray, (const struct stage_disc *)stage_at(s, s->discs) + p->index);
        return hit->t > 0 && hit->t < ray->t_max;
    }
    __builtin_unreachable();
}

bool naive_hit_closest(const struct stage *s, const struct ray *ray, struct ray_hit *hit)
{
    if (!bvh_hit_possible(ray))
        return false;
    const struct tri_ray tri = tri_ray_make(ray);
    bool any = false;
    for (uint32_t prim = 0; prim < s->prims.count; prim++) {
        struct ray_hit h;
        if (hit_one(s, ray, &tri, prim, &h) && (!any || h.t < hit->t)) {
            *hit = h;
            any = true;
        }
    }
    return any;
}

bool naive_hit_any(const struct stage *s, const struct ray *ray)
{
    struct ray_hit hit;
    return naive_hit_closest(s, ray, &hit);
}

/* --- the textbook's --- */

typedef long double real;

struct found {
    real t;      /* NAN: none */
    real margin; /* how far from the boundary between hit and miss, as part of the primitive's size */
};

static real dot(const real a[3], const real b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const real a[3], const real b[3], real out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static void difference(const float a[3], const float b[3], real out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = (real)a[k] - (real)b[k];
}

static struct found triangle(const real d[3], const float o[3], const float v[3][3])
{
    real e1[3], e2[3], s[3], p[3], q[3];
    difference(v[1], v[0], e1);
    difference(v[2], v[0], e2);
    difference(o, v[0], s);
    cross(d, e2, p);
    cross(s, e1, q);
    const real det = dot(e1, p), size = sqrtl(dot(e1, e1) * dot(p, p));
    const real u = dot(s, p) / det, w = dot(d, q) / det, rest = 1 - u - w;
    const real inside = fminl(fminl(u, w), rest);
    const bool edge_on = fabsl(det) <= 1e-6L * size; /* then u and w mean little */
    return (struct found){inside >= 0 ? dot(e2, q) / det : (real)NAN,
                          edge_on ? 0 : fabsl(inside)};
}

static struct found sphere(const real d[3], const float o[3], const struct stage_sphere *s)
{
    real f[3];
    difference(o, s->center, f);
    const real r = (real)s->radius;
    const real a = dot(d, d), b = dot(f, d), c = dot(f, f) - r * r, disc = b * b - a * c;
    if (!(disc >= 0))
        return (struct found){(real)NAN, -disc / (a * r * r)};
    const real t0 = (-b - sqrtl(disc)) / a, t1 = (-b + sqrtl(disc)) / a;
    return (struct found){t0 > 0 ? t0 : t1, disc / (a * r * r)};
}

static struct found disc(const real d[3], const float o[3], const struct stage_disc *s)
{
    real f[3], n[3], p[3];
    difference(o, s->center, f);
    for (int k = 0; k < 3; k++)
        n[k] = (real)s->normal[k];
    const real t = -dot(f, n) / dot(d, n), r = (real)s->radius;
    for (int k = 0; k < 3; k++)
        p[k] = f[k] + t * d[k];
    const real inside = 1 - dot(p, p) / (r * r);
    return (struct found){inside >= 0 ? t : (real)NAN, fabsl(inside)};
}

static struct found textbook_one(const struct stage *s, const struct ray *ray, uint32_t prim)
{
    const struct stage_prim *p = (const struct stage_prim *)stage_at(s, s->prims) + prim;
    const real d[3] = {(real)ray->dir[0], (real)ray->dir[1], (real)ray->dir[2]};
    float o[3];
    vec3_store(o, ray->origin);
    switch ((enum stage_prim_kind)p->kind) {
    case STAGE_TRIANGLE:
        return triangle(d, o, ((const struct stage_triangle *)stage_at(s, s->triangles))[p->index].v);
    case STAGE_SPHERE:
        return sphere(d, o, (const struct stage_sphere *)stage_at(s, s->spheres) + p->index);
    case STAGE_DISC:
        return disc(d, o, (const struct stage_disc *)stage_at(s, s->discs) + p->index);
    }
    __builtin_unreachable();
}

struct naive_hit naive_hit_textbook(const struct stage *s, const struct ray *ray)
{
    struct naive_hit best = {.t = (double)ray->t_max};
    for (uint32_t prim = 0; prim < s->prims.count; prim++) {
        const struct found f = textbook_one(s, ray, prim);
        best.doubtful |= f.margin < 1e-7L;
        if (!(f.t > 0 && f.t < (real)ray->t_max))
            continue;
        best.doubtful |= fabsl(f.t / (real)ray->t_max - 1) < 1e-6L;
        if ((double)f.t < best.t)
            best = (struct naive_hit){true, (double)f.t, prim, best.doubtful};
    }
    return best;
}
