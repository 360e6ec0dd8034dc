/* SPDX-License-Identifier: MIT */
#include "common/trace/bvh.h"

#include "common/trace/box.h"
#include "common/trace/sphere.h"
#include "common/trace/tri.h"

struct query {
    const struct bvh_node *nodes;
    const uint32_t *leaf_prims;
    const struct stage_prim *prims;
    const struct stage_triangle *triangles;
    const struct stage_sphere *spheres;
    const struct stage_disc *discs;
    struct box_ray box;
    struct tri_ray tri;
    const struct ray *ray;
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
        .box = box_ray_make(ray),
        .tri = tri_ray_make(ray),
        .ray = ray,
    };
    return true;
}

/* The nearer one, among equals the one with the smaller number. */
static void keep_nearer(struct ray_hit *best, struct ray_hit found)
{
    if (found.t < best->t || (found.t == best->t && found.prim < best->prim))
        *best = found;
}

static void leaf_closest(const struct query *q, struct tri_ray *tri, const struct bvh_node *leaf,
                         struct ray_hit *best)
{
    const uint32_t *prims = q->leaf_prims + leaf->first;
    const uint32_t count = leaf->count;
    switch ((enum stage_prim_kind)leaf->kind) {
    case STAGE_TRIANGLE:
        for (uint32_t i = 0; i < count; i++) {
            struct tri_found f;
            tri->t_max = best->t;
            if (tri_hit(tri, q->triangles[q->prims[prims[i]].index].v, &f))
                keep_nearer(best, (struct ray_hit){f.t, prims[i], f.u, f.v});
        }
        return;
    case STAGE_SPHERE:
        for (uint32_t i = 0; i < count; i++) {
            float t;
            if (sphere_hit(q->ray, &q->spheres[q->prims[prims[i]].index], best->t, &t))
                keep_nearer(best, (struct ray_hit){t, prims[i], 0, 0});
        }
        return;
    case STAGE_DISC:
        for (uint32_t i = 0; i < count; i++) {
            float t;
            if (sphere_disc_hit(q->ray, &q->discs[q->prims[prims[i]].index], best->t, &t))
                keep_nearer(best, (struct ray_hit){t, prims[i], 0, 0});
        }
        return;
    }
    __builtin_unreachable();
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
    struct ray_hit best = {ray->t_max, STAGE_NONE, 0, 0};
    float t;
    if (!box_hit(&q.box, q.nodes[0].lo, q.nodes[0].hi, best.t, &t))
        return false;
    uint32_t at = 0;
    for (;;) {
        const struct bvh_node *node = &q.nodes[at];
        if (node->count) {
            leaf_closest(&q, &tri, node, &best);
        } else {
            const struct bvh_node *child = &q.nodes[node->first];
            float t0, t1;
            const bool hit0 = box_hit(&q.box, child[0].lo, child[0].hi, best.t, &t0);
            const bool hit1 = box_hit(&q.box, child[1].lo, child[1].hi, best.t, &t1);
            const uint32_t near = node->first + (hit1 && (!hit0 || t1 < t0));
            if (hit0 && hit1) {
                stack[depth].node = 2 * node->first + 1 - near;
                stack[depth++].t = t0 < t1 ? t1 : t0;
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
                return best.prim != STAGE_NONE && best.t < ray->t_max;
            }
            depth--;
        } while (!(stack[depth].t <= best.t));
        at = stack[depth].node;
    }
}

static bool leaf_any(const struct query *q, const struct bvh_node *leaf)
{
    const uint32_t *prims = q->leaf_prims + leaf->first;
    const uint32_t count = leaf->count;
    const float t_max = q->ray->t_max;
    bool hit = false;
    float t = t_max;
    switch ((enum stage_prim_kind)leaf->kind) {
    case STAGE_TRIANGLE:
        for (uint32_t i = 0; i < count && !hit; i++) {
            struct tri_found f;
            hit = tri_hit(&q->tri, q->triangles[q->prims[prims[i]].index].v, &f) && f.t < t_max;
        }
        return hit;
    case STAGE_SPHERE:
        for (uint32_t i = 0; i < count && !hit; i++)
            hit = sphere_hit(q->ray, &q->spheres[q->prims[prims[i]].index], t_max, &t) && t < t_max;
        return hit;
    case STAGE_DISC:
        for (uint32_t i = 0; i < count && !hit; i++)
            hit = sphere_disc_hit(q->ray, &q->discs[q->prims[prims[i]].index], t_max, &t) &&
                  t < t_max;
        return hit;
    }
    __builtin_unreachable();
}

bool bvh_hit_any(const struct stage *s, const struct ray *ray)
{
    struct query q;
    if (!query_make(s, ray, &q))
        return false;
    uint32_t stack[BVH_MAX_DEPTH + 1];
    int depth = 0;
    stack[depth++] = 0;
    while (depth) {
        const struct bvh_node *node = &q.nodes[stack[--depth]];
        float t;
        if (!box_hit(&q.box, node->lo, node->hi, ray->t_max, &t))
            continue;
        if (!node->count) {
            stack[depth++] = node->first + 1;
            stack[depth++] = node->first;
        } else if (leaf_any(&q, node)) {
            return true;
        }
    }
    return false;
}
