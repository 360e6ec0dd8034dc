/* SPDX-License-Identifier: MIT */
#include "common/trace/bvh.h"

#include <float.h>

#include "common/trace/box.h"
#include "common/trace/cylinder.h"
#include "common/trace/sphere.h"
#include "common/trace/tri.h"

struct query {
    const struct bvh_node *nodes;
    const uint32_t *leaf_prims;
    const struct stage_prim *prims;
    const struct stage_triangle *triangles;
    const struct stage_sphere *spheres;
    const struct stage_disc *discs;
    const struct stage_cylinder *cylinders;
    struct box_ray box;
    struct tri_ray tri;
    const struct ray *ray;
    float t_max; /* the ray's, finite */
};

static bool is_finite(vec3 v)
{
    const vec3 zero = v - v; /* NaN for an infinity, too */
    return zero[0] == 0 && zero[1] == 0 && zero[2] == 0;
}

/* False when nothing can be hit: no tree, or a ray that is no ray. */
static bool query_make(const struct stage *s, const struct ray *ray, struct query *q)
{
    if (!s->nodes.count || !is_finite(ray->origin) || !is_finite(ray->dir) || !(ray->t_max > 0) ||
        rgb_is_black(ray->dir))
        return false;
    *q = (struct query){
        .nodes = stage_at(s, s->nodes),
        .leaf_prims = stage_at(s, s->leaf_prims),
        .prims = stage_at(s, s->prims),
        .triangles = stage_at(s, s->triangles),
        .spheres = stage_at(s, s->spheres),
        .discs = stage_at(s, s->discs),
        .cylinders = stage_at(s, s->cylinders),
        .box = box_ray_make(ray),
        .tri = tri_ray_make(ray),
        .ray = ray,
        .t_max = ray->t_max < FLT_MAX ? ray->t_max : FLT_MAX,
    };
    return true;
}

/* The nearer one, among equals the one with the smaller number. */
static void keep_nearer(struct ray_hit *best, struct ray_hit found)
{
    if (found.t < best->t || (found.t == best->t && found.prim < best->prim))
        *best = found;
}

/* The smallest box of a primitive: inside the box of its leaf and so of every node above. */
static struct bvh_box bounds_of(const struct query *q, enum stage_prim_kind kind, uint32_t index)
{
    struct bvh_box box;
    switch (kind) {
    case STAGE_TRIANGLE:
        tri_bounds(q->triangles[index].v, box.lo, box.hi);
        return box;
    case STAGE_SPHERE:
        sphere_bounds(q->spheres[index].center, q->spheres[index].radius, box.lo, box.hi);
        return box;
    case STAGE_DISC:
        sphere_bounds(q->discs[index].center, q->discs[index].radius, box.lo, box.hi);
        return box;
    case STAGE_CYLINDER:
        cylinder_bounds(&q->cylinders[index], box.lo, box.hi);
        return box;
    }
    __builtin_unreachable();
}

/* A hit lies between where the ray enters the primitive's own box and where it leaves. Rounding
 * could place it before, and then a tree that skips boxes behind the best hit would find one or
 * the other of two near hits as its shape has it; a grazing ray's, far beside the primitive. tri is
 * q->tri, with a t_max of its own. */
static inline bool prim_hit(const struct query *q, struct tri_ray *tri, enum stage_prim_kind kind,
                            uint32_t prim, float t_max, struct ray_hit *hit)
{
    const uint32_t index = q->prims[prim].index;
    *hit = (struct ray_hit){0, prim, 0, 0};
    bool found = false;
    switch (kind) {
    case STAGE_TRIANGLE: {
        struct tri_found f;
        tri->t_max = t_max;
        found = tri_hit(tri, q->triangles[index].v, &f);
        if (found)
            *hit = (struct ray_hit){f.t, prim, f.u, f.v};
        break;
    }
    case STAGE_SPHERE:
        found = sphere_hit(q->ray, &q->spheres[index], t_max, &hit->t);
        break;
    case STAGE_DISC:
        found = sphere_disc_hit(q->ray, &q->discs[index], t_max, &hit->t);
        break;
    case STAGE_CYLINDER:
        found = cylinder_hit(q->ray, &q->cylinders[index], t_max, &hit->t);
        break;
    }
    if (!found)
        return false;
    const struct bvh_box box = bounds_of(q, kind, index);
    float t[2];
    if (!box_hit(&q->box, box.lo, box.hi, t_max, t))
        return false;
    hit->t = hit->t < t[0] ? t[0] : hit->t > t[1] ? t[1] : hit->t;
    return true;
}

bool bvh_hit_prim(const struct stage *s, uint32_t prim, const struct ray *ray, struct ray_hit *hit)
{
    struct query q;
    if (!query_make(s, ray, &q))
        return false;
    struct tri_ray tri = q.tri;
    return prim_hit(&q, &tri, (enum stage_prim_kind)q.prims[prim].kind, prim, q.t_max, hit) &&
           hit->t < q.t_max;
}

static void leaf_closest(const struct query *q, struct tri_ray *tri, const struct bvh_node *leaf,
                         struct ray_hit *best)
{
    const uint32_t *prims = q->leaf_prims + leaf->first;
    const enum stage_prim_kind kind = (enum stage_prim_kind)leaf->kind;
    const uint32_t count = leaf->count;
    for (uint32_t i = 0; i < count; i++) {
        struct ray_hit found;
        if (prim_hit(q, tri, kind, prims[i], best->t, &found))
            keep_nearer(best, found);
    }
}

bool bvh_hit_closest(const struct stage *s, const struct ray *ray, struct ray_hit *hit)
{
    struct query q;
    if (!query_make(s, ray, &q))
        return false;
    /* An entry is pushed for the farther child of each level at most. */
    struct {
        uint32_t node;
        float t;
    } stack[BVH_MAX_DEPTH];
    int depth = 0;
    struct tri_ray tri = q.tri;
    struct ray_hit best = {q.t_max, STAGE_NONE, 0, 0};
    float t[2], t1[2];
    if (!box_hit(&q.box, q.nodes[0].lo, q.nodes[0].hi, best.t, t))
        return false;
    uint32_t at = 0;
    for (;;) {
        const struct bvh_node *node = &q.nodes[at];
        if (node->count) {
            leaf_closest(&q, &tri, node, &best);
        } else {
            const struct bvh_node *child = &q.nodes[node->first];
            const bool hit0 = box_hit(&q.box, child[0].lo, child[0].hi, best.t, t);
            const bool hit1 = box_hit(&q.box, child[1].lo, child[1].hi, best.t, t1);
            const uint32_t near = node->first + (hit1 && (!hit0 || t1[0] < t[0]));
            if (hit0 && hit1) {
                stack[depth].node = 2 * node->first + 1 - near;
                stack[depth++].t = t[0] < t1[0] ? t1[0] : t[0];
            }
            if (hit0 || hit1) {
                at = near;
                continue;
            }
        }
        /* Boxes as near as the best hit are still opened: an equal hit may have a smaller number. */
        do {
            if (!depth) {
                *hit = best;
                return best.prim != STAGE_NONE && best.t < q.t_max;
            }
            depth--;
        } while (!(stack[depth].t <= best.t));
        at = stack[depth].node;
    }
}

static bool leaf_any(const struct query *q, struct tri_ray *tri, const struct bvh_node *leaf)
{
    const uint32_t *prims = q->leaf_prims + leaf->first;
    const enum stage_prim_kind kind = (enum stage_prim_kind)leaf->kind;
    const uint32_t count = leaf->count;
    const float t_max = q->t_max;
    for (uint32_t i = 0; i < count; i++) {
        struct ray_hit found;
        if (prim_hit(q, tri, kind, prims[i], t_max, &found) && found.t < t_max)
            return true;
    }
    return false;
}

bool bvh_hit_any(const struct stage *s, const struct ray *ray)
{
    struct query q;
    if (!query_make(s, ray, &q))
        return false;
    uint32_t stack[BVH_MAX_DEPTH + 1];
    int depth = 0;
    struct tri_ray tri = q.tri;
    stack[depth++] = 0;
    while (depth) {
        const struct bvh_node *node = &q.nodes[stack[--depth]];
        float t[2];
        if (!box_hit(&q.box, node->lo, node->hi, q.t_max, t))
            continue;
        if (!node->count) {
            stack[depth++] = node->first + 1;
            stack[depth++] = node->first;
        } else if (leaf_any(&q, &tri, node)) {
            return true;
        }
    }
    return false;
}
