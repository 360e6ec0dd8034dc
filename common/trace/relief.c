/* SPDX-License-Identifier: MIT */
#include "common/trace/relief.h"

#include "common/trace/shading.h"

/* n over its length, or `other` where it has none or is no vector. */
static vec3 unit_or(vec3 n, vec3 other)
{
    const float length = vec3_length(n);
    return length > 0 && length < __builtin_inff() ? n / length : other;
}

/* A texture that is laid on backwards is seen backwards: its own u and v are meant. Turned away
 * from the surface it says nothing. */
static vec3 mapped(const struct stage *s, const struct material_relief *r,
                   const struct texture_point *at, const struct surface_detail *d, vec3 ns)
{
    const struct stage_texture *t =
        (const struct stage_texture *)stage_at(s, s->textures) + r->normal_map;
    const rgb value = texture_at(s, r->normal_map, at).color;
    const struct warp_frame frame = surface_detail_frame(ns, d->dp_du);
    const bool turned = vec3_dot(vec3_cross(d->dp_du, d->dp_dv), ns) < 0;
    const float x = r->strength * (2 * value[0] - 1), y = r->strength * (2 * value[1] - 1);
    const float z = 2 * value[2] - 1;
    const vec3 along = (t->uv_scale[0] < 0 ? -x : x) * frame.x;
    const vec3 up = (turned == (t->uv_scale[1] < 0) ? y : -y) * frame.y;
    return unit_or(along + up + (z > 0 ? z : 0) * ns, ns);
}

/* M. Mikkelsen, "Bump Mapping Unparametrized Surfaces on the GPU", 2010, with the surface's own
 * derivatives for those of the screen: the surface p + h n has the normal
 * n |D| - sign D (h_u (p_v x n) + h_v (n x p_u)), D = p_u (p_v x n), when the curvature of p is
 * passed over. */
static vec3 bumped(const struct stage *s, const struct material_relief *r,
                   const struct texture_point *at, const struct surface_detail *d, vec3 ns)
{
    const struct texture_slope h = texture_slope(s, r->bump, at, r->channel);
    const vec3 r1 = vec3_cross(d->dp_dv, ns), r2 = vec3_cross(ns, d->dp_du);
    const float det = vec3_dot(d->dp_du, r1);
    const vec3 grad = r->height * (h.du * r1 + h.dv * r2);
    return unit_or(det < 0 ? -det * ns + grad : det * ns - grad, ns);
}

vec3 relief_normal(const struct stage *s, const struct material *m, const struct texture_point *at,
                   const struct surface_detail *d, vec3 ng)
{
    const struct material_relief *r =
        (const struct material_relief *)stage_at(s, s->reliefs) + (m->relief - 1);
    vec3 ns = d->ns;
    if (!(vec3_dot(vec3_abs(d->dp_du), vec3_make(1, 1, 1)) > 0))
        return ns;
    if (r->normal_map != SCENE_NO_TEXTURE)
        ns = mapped(s, r, at, d, ns);
    if (r->bump != SCENE_NO_TEXTURE)
        ns = bumped(s, r, at, d, ns);
    return shading_rise(ns, ng);
}
