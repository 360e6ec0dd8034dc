/* SPDX-License-Identifier: MIT */
#include "common/trace/surface_detail.h"

#include "common/trace/cylinder.h"
#include "common/trace/shading.h"

#define TURN (2 * FMATH_PI)

/* --- sphere, cylinder, disc --- */

struct axes {
    vec3 x, y, z;
};

static struct axes axes_load(const struct stage_detail *d)
{
    return (struct axes){vec3_load(d->axes[0]), vec3_load(d->axes[1]), vec3_load(d->axes[2])};
}

/* Around y; x and z: of the normal. */
static float turn_u(float x, float z)
{
    return 0.5f + fmath_atan2(x, z) * (1 / TURN);
}

static void on_sphere(const struct axes *a, vec3 n, float radius, struct surface_detail *out)
{
    const float x = vec3_dot(n, a->x), y = vec3_dot(n, a->y), z = vec3_dot(n, a->z);
    const float across = __builtin_sqrtf(x * x + z * z);
    out->u = turn_u(x, z);
    out->v = 0.5f + fmath_atan2(y, across) * FMATH_INV_PI;
    if (!(across > 0))
        return;
    out->dp_du = TURN * radius * (z * a->x - x * a->z);
    out->dp_dv = FMATH_PI * radius * (across * a->y - y / across * (x * a->x + z * a->z));
}

static void on_cylinder(const struct axes *a, const struct stage_cylinder *c,
                        const struct surface *at, struct surface_detail *out)
{
    const float x = vec3_dot(at->ng, a->x), z = vec3_dot(at->ng, a->z);
    double up[3], axis[3];
    cylinder_axis(c, axis);
    for (int k = 0; k < 3; k++)
        up[k] = (double)at->p[k] - (double)c->from[k];
    const float v = (float)(sphere_dot(up, axis) / sphere_dot(axis, axis));
    out->u = turn_u(x, z);
    out->v = v < 0 ? 0 : v > 1 ? 1 : v;
    out->dp_du = TURN * c->radius * (z * a->x - x * a->z);
    out->dp_dv = vec3_load(c->axis);
}

static void on_disc(const struct axes *a, const struct stage_disc *d, vec3 p,
                    struct surface_detail *out)
{
    const float side = 2 * d->radius;
    const vec3 off = p - vec3_load(d->center);
    out->u = 0.5f + vec3_dot(off, a->x) / side;
    out->v = 0.5f + vec3_dot(off, a->y) / side;
    out->dp_du = side * a->x;
    out->dp_dv = side * a->y;
}

/* --- triangles --- */

/* A value at each corner, in the order of the triangle's vertices in the world. */
struct three {
    vec3 a, b, c;
};

static vec3 blend(const struct three *t, const struct ray_hit *hit)
{
    return t->a * (1 - hit->u - hit->v) + t->b * hit->u + t->c * hit->v;
}

struct corners {
    uint32_t a, b, c;
    bool back; /* stage.h */
};

static struct corners corners_of(const struct stage *s, const struct stage_detail *d, uint32_t prim)
{
    const struct stage_corners *c =
        (const struct stage_corners *)stage_at(s, s->corners) + d->corners + (prim - d->prim_begin);
    const uint32_t first = c->v[0] & ~STAGE_CORNERS_BACK;
    const bool back = c->v[0] & STAGE_CORNERS_BACK;
    return d->mirrored ? (struct corners){first, c->v[2], c->v[1], back}
                       : (struct corners){first, c->v[1], c->v[2], back};
}

static vec3 uv_of(const struct stage *s, uint32_t at)
{
    const struct stage_uv *uv = (const struct stage_uv *)stage_at(s, s->uvs) + at;
    return vec3_make(uv->uv[0], uv->uv[1], 0);
}

static bool is_finite(vec3 v)
{
    const vec3 zero = v - v;
    return zero[0] + zero[1] + zero[2] == 0;
}

/* p(u, v) is linear: its gradients solve dp = dp_du du + dp_dv dv along two
 * edges. In double: a long thin triangle of uv keeps its area. */
static void differentiate(const struct stage_triangle *t, const struct three *uv,
                          struct surface_detail *out)
{
    const double du1 = (double)uv->b[0] - (double)uv->a[0],
                 dv1 = (double)uv->b[1] - (double)uv->a[1];
    const double du2 = (double)uv->c[0] - (double)uv->a[0],
                 dv2 = (double)uv->c[1] - (double)uv->a[1];
    const double det = du1 * dv2 - dv1 * du2;
    vec3 dp_du = {0}, dp_dv = {0};
    for (int k = 0; k < 3; k++) {
        const double e1 = (double)t->v[1][k] - (double)t->v[0][k];
        const double e2 = (double)t->v[2][k] - (double)t->v[0][k];
        dp_du[k] = (float)((dv2 * e1 - dv1 * e2) / det);
        dp_dv[k] = (float)((du1 * e2 - du2 * e1) / det);
    }
    const bool some = vec3_dot(vec3_abs(dp_du), vec3_make(1, 1, 1)) > 0 &&
                      vec3_dot(vec3_abs(dp_dv), vec3_make(1, 1, 1)) > 0;
    if (!is_finite(dp_du) || !is_finite(dp_dv) || !some) /* det 0, or next to it */
        return;
    out->dp_du = dp_du;
    out->dp_dv = dp_dv;
}

static vec3 normal_of(const struct stage *s, uint32_t at)
{
    return vec3_load(((const struct stage_normal *)stage_at(s, s->normals))[at].n);
}

static vec3 to_world(const struct stage_detail *d, vec3 n)
{
    return vec3_make(vec3_dot(vec3_load(d->axes[0]), n), vec3_dot(vec3_load(d->axes[1]), n),
                     vec3_dot(vec3_load(d->axes[2]), n));
}

/* Where a corner has no normal, or they cancel, the triangle's. On the
 * triangle's front, which its corners' order says: normals that as a whole
 * point the other way are turned; one that goes below the surface is raised
 * just above it. */
static vec3 shading_normal(const struct stage *s, const struct stage_detail *d,
                           const struct corners *c, const struct ray_hit *hit, vec3 ng)
{
    const struct three n = {normal_of(s, d->normals + c->a), normal_of(s, d->normals + c->b),
                            normal_of(s, d->normals + c->c)};
    if (!(vec3_dot(n.a, n.a) > 0 && vec3_dot(n.b, n.b) > 0 && vec3_dot(n.c, n.c) > 0))
        return ng;
    vec3 ns = to_world(d, blend(&n, hit));
    const float length = vec3_length(ns);
    if (!(length > 0))
        return ng;
    return shading_rise(ns / (c->back ? -length : length), ng);
}

/* What a corner's tangent plane adds, by its weight; n: of any length, on the wanted side. */
static vec3 raise_by(vec3 p, const float corner[3], vec3 n, float weight)
{
    const float nn = vec3_dot(n, n), below = vec3_dot(p - vec3_load(corner), n);
    return below < 0 ? -weight * below / nn * n : vec3_make(0, 0, 0);
}

static float edge_of_triangle(const struct stage *s, const struct ray_hit *hit)
{
    const struct stage_triangle t = stage_triangle_at(s, hit->place.index, hit->instance);
    const vec3 a = vec3_load(t.v[0]), ab = vec3_load(t.v[1]) - a, ac = vec3_load(t.v[2]) - a;
    const float w = 1 - hit->u - hit->v, uv = hit->u < hit->v ? hit->u : hit->v;
    const float longest =
        rgb_max(vec3_make(vec3_dot(ab, ab), vec3_dot(ac, ac), vec3_dot(ac - ab, ac - ab)));
    return (w < uv ? w : uv) * vec3_length(vec3_cross(ab, ac)) / __builtin_sqrtf(longest);
}

float surface_detail_edge(const struct stage *s, const struct ray_hit *hit,
                          const struct surface *at)
{
    const uint32_t index = hit->place.index;
    switch ((enum stage_kind)hit->place.kind) {
    case STAGE_TRIANGLE:
        return edge_of_triangle(s, hit);
    case STAGE_SPHERE:
        break;
    case STAGE_DISC: {
        const struct stage_disc *d = (const struct stage_disc *)stage_at(s, s->discs) + index;
        return d->radius - vec3_length(at->p - vec3_load(d->center));
    }
    case STAGE_CYLINDER: {
        const struct stage_cylinder *c =
            (const struct stage_cylinder *)stage_at(s, s->cylinders) + index;
        const vec3 axis = vec3_load(c->axis);
        const float length = vec3_length(axis);
        const float along = vec3_dot(at->p - vec3_load(c->from), axis) / length;
        return along < length - along ? along : length - along;
    }
    }
    return __builtin_inff();
}

bool surface_detail_raise(const struct stage *s, const struct stage_detail *d,
                          const struct ray_hit *hit, const struct surface *at, float side,
                          vec3 *raised)
{
    const struct corners c = corners_of(s, d, hit->prim);
    const struct stage_triangle t = stage_triangle_at(s, hit->place.index, hit->instance);
    const float sign = (side < 0) == c.back ? 1 : -1;
    const vec3 a = sign * to_world(d, normal_of(s, d->normals + c.a));
    const vec3 b = sign * to_world(d, normal_of(s, d->normals + c.b));
    const vec3 g = sign * to_world(d, normal_of(s, d->normals + c.c));
    const vec3 way = raise_by(at->p, t.v[0], a, 1 - hit->u - hit->v) +
                     raise_by(at->p, t.v[1], b, hit->u) + raise_by(at->p, t.v[2], g, hit->v);
    const vec3 up = side < 0 ? -at->ng : at->ng;
    const float error = vec3_dot(vec3_abs(up), at->p_error);
    *raised = at->p + way;
    /* Next to an edge nobody knows on which side of the next triangle the point is. */
    return vec3_dot(way, up) > 4 * error &&
           edge_of_triangle(s, hit) > 8 * error; /* not for a NaN */
}

static void on_triangle(const struct stage *s, const struct stage_detail *d,
                        const struct ray_hit *hit, struct surface_detail *out)
{
    if (d->corners == STAGE_NONE)
        return;
    const struct corners c = corners_of(s, d, hit->prim);
    if (d->uvs != STAGE_NONE) {
        const struct three uv = {uv_of(s, d->uvs + c.a), uv_of(s, d->uvs + c.b),
                                 uv_of(s, d->uvs + c.c)};
        const struct stage_triangle t = stage_triangle_at(s, hit->place.index, hit->instance);
        const vec3 at = blend(&uv, hit);
        out->u = at[0];
        out->v = at[1];
        differentiate(&t, &uv, out);
    }
    if (d->normals != STAGE_NONE)
        out->ns = shading_normal(s, d, &c, hit, out->ns);
    if (d->colors != STAGE_NONE) {
        const struct stage_color *of =
            (const struct stage_color *)stage_at(s, s->colors) + d->colors;
        const struct three of_corner = {vec3_load(of[c.a].rgb), vec3_load(of[c.b].rgb),
                                        vec3_load(of[c.c].rgb)};
        out->color = blend(&of_corner, hit);
    }
}

/* --- all of them --- */

struct surface_detail surface_detail_at(const struct stage *s, const struct stage_detail *d,
                                        const struct ray_hit *hit, const struct surface *at)
{
    struct surface_detail out = {.ns = at->ng, .color = {1, 1, 1, 0}};
    const struct axes axes = axes_load(d);
    const uint32_t index = hit->place.index;
    switch ((enum stage_kind)hit->place.kind) {
    case STAGE_TRIANGLE:
        on_triangle(s, d, hit, &out);
        return out;
    case STAGE_SPHERE: {
        const struct stage_sphere *spheres = stage_at(s, s->spheres);
        on_sphere(&axes, at->ng, spheres[index].radius, &out);
        return out;
    }
    case STAGE_DISC: {
        const struct stage_disc *discs = stage_at(s, s->discs);
        on_disc(&axes, &discs[index], at->p, &out);
        return out;
    }
    case STAGE_CYLINDER: {
        const struct stage_cylinder *cylinders = stage_at(s, s->cylinders);
        on_cylinder(&axes, &cylinders[index], at, &out);
        return out;
    }
    }
    __builtin_unreachable();
}

/* Scaled by its greatest component before it is squared. Nearer to ns than a
 * thousandth of a radian, rounding alone would choose the direction; above
 * that, taking away twice what lies along ns leaves nothing of it. */
struct warp_frame surface_detail_frame(vec3 ns, vec3 dp_du)
{
    const vec3 size = vec3_abs(dp_du);
    const float greatest = rgb_max(size);
    const vec3 t = dp_du / greatest;
    const vec3 across = t - vec3_dot(t, ns) * ns;
    const float aa = vec3_dot(across, across);
    if (!(greatest > 0) || !(aa > 1e-6f * vec3_dot(t, t))) /* or a NaN */
        return warp_frame_make(ns);
    const vec3 once = across / __builtin_sqrtf(aa), x = vec3_unit(once - vec3_dot(once, ns) * ns);
    return (struct warp_frame){x, vec3_cross(ns, x), ns};
}
