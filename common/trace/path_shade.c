/* SPDX-License-Identifier: MIT */
#include "common/trace/path_shade.h"

#include "common/trace/bsdf.h"
#include "common/trace/bvh.h"
#include "common/trace/relief.h"
#include "common/trace/shading.h"
#include "common/trace/surface_detail.h"

/* A matte surface looks the same from everywhere: it keeps its normal, and the viewer is moved to
 * the normal's side. What reflects has its normal bent to the viewer. */
static void turn_frame(struct path_vertex *v, const struct surface_detail *detail, vec3 wo)
{
    const float side = vec3_dot(wo, v->at.ng) < 0 ? -1 : 1;
    const bool matte = bsdf_is_matte(v->material);
    const vec3 ns =
        matte ? detail->ns : side * shading_bend(side * detail->ns, side * v->at.ng, wo);
    v->frame = v->material->needs & MATERIAL_NEEDS_TANGENT ? surface_detail_frame(ns, detail->dp_du)
                                                           : warp_frame_make(ns);
    v->wo = shading_raise(warp_to_local(&v->frame, wo), side);
}

/* Tilted normals that face each other in a corner send a ray back and forth, ever deeper into it,
 * until the corner is narrower than the error of a point, and the ray starts behind a wall. A
 * bounce leaves its surface at SHADING_LEAST_RISE or more, so that the next wall is no nearer than
 * a fiftieth of the height from which the viewer looks: it is beyond the error if that is 256 times
 * as much. A point may also lie on an edge by chance; then it is looked whether the viewer sees
 * where a ray will start, and that no wall passes there. */
static bool is_caught(const struct stage *s, const struct ray *ray, const struct ray_hit *hit,
                      const struct surface *at, struct film_work *work)
{
    const float height = vec3_dot(ray->origin - at->p, at->ng);
    const float error = vec3_dot(vec3_abs(at->ng), at->p_error);
    if (!(height > 256 * error || height < -256 * error))
        return true;
    if (surface_detail_edge(s, hit, at) > 4 * error)
        return false;
    const vec3 start = surface_outside(at, at->p_error, ray->origin - at->p);
    const struct ray way = {ray->origin, start - ray->origin, 1 + 0x1p-20f, ray->from,
                            at->prim + 1};
    work->shadow_rays++;
    return bvh_hit_any(s, &way);
}

void path_shade(const struct stage *s, const struct ray *ray, const struct ray_hit *hit,
                struct path_vertex *v, struct film_work *work)
{
    const struct stage_detail *d = surface_detail_of(s, hit->prim, hit->instance);
    if (!d || v->wo[2] == 0)
        return;
    const bool smooth = d->normals != STAGE_NONE, relief = v->material->relief;
    if (!smooth && !relief && !(v->material->needs & MATERIAL_NEEDS_TANGENT))
        return;
    struct surface_detail detail = surface_detail_at(s, d, hit, &v->at);
    if (relief)
        detail.ns = relief_normal(s, v->material, &v->point, &detail, v->at.ng);
    if (smooth)
        v->raised.is = surface_detail_raise(s, d, hit, &v->at, v->wo[2], &v->raised.p);
    turn_frame(v, &detail, -ray->dir);
    if ((smooth || relief) && is_caught(s, ray, hit, &v->at, work))
        v->wo[2] = 0; /* the path ends */
}

/* And a little beyond, so that what touches the point counts as being in the way. */
bool path_shade_is_clear(const struct stage *s, const struct path_vertex *v, struct film_work *work)
{
    struct ray way = surface_to_point(&v->at, v->raised.p);
    way.t_max = 1 + 0x1p-10f;
    work->shadow_rays++;
    return !bvh_hit_any(s, &way);
}

struct surface path_shade_raised(const struct path_vertex *v)
{
    struct surface from = v->at;
    from.p = v->raised.p;
    from.p_error = vec3_make(0, 0, 0);
    from.prim = STAGE_NONE;
    from.lit = 0; /* from both sides: that is what it is raised for */
    return from;
}

bool path_shade_move(const struct stage *s, struct path_vertex *v, vec3 dir, vec3 wi,
                     struct film_work *work)
{
    if (!path_shade_is_raised(v, dir, wi) || !path_shade_is_clear(s, v, work))
        return false;
    v->at = path_shade_raised(v);
    return true;
}
