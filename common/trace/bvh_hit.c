/* SPDX-License-Identifier: MIT */
#include "common/trace/bvh.h"

#include "common/trace/box.h"
#include "common/trace/sphere.h"
#include "common/trace/tri.h"

struct query {
    const struct bvh_node *nodes;
    const struct stage_triangle *triangles;
    const struct stage_sphere *spheres;
    const struct stage_disc *discs;
    const struct ray *ray;
    struct box_ray box;
    struct tri_ray tri;
};

static bool is_finite(vec3 v)
{
    const vec3 zero = v - v; /* NaN for an infinity, too */
    return zero[0] == 0 && zero[1] == 0 && zero[2] == 0;
}

bool bvh_hit_possible(const struct ray *ray)
{
    bool moves = false;
    for (int k = 0; k < 3; k++)
        moves |= __builtin_fabsf(ray->dir[k]) >= 0x1p-126f;
    return moves && is_finite(ray->origin) && is_finite(ray->dir) && ray->t_max > 0;
}

double bvh_edge(double ax, double ay, double bx, double by)
{
    return tri_edge(ax, ay, bx, by);
}

/* False when nothing can be hit. */
static bool query_make(const struct stage *s, const struct ray *ray, struct query *q)
{
    if (!s->nodes.count || !bvh_hit_possible(ray))
        return false;
    q->nodes = stage_at(s, s->nodes);
    q->triangles = stage_at(s, s->triangles);
    q->spheres = stage_at(s, s->spheres);
    q->discs = stage_at(s, s->discs);
    q->ray = ray;
    q->box = box_ray_make(ray, s->bounds);
    q->tri = tri_ray_make(ray);
    return true;
}

/* The nearer one, among equals the one with the smaller number. */
static void keep_nearer(struct ray_hit *best, const struct ray_hit *found, uint32_t prim)
{
    if (found->t < best->t || (found->t == best->t && prim < best->prim))
        *best = (struct ray_hit){found->t, prim, found->u, found->v};
}

static void leaf_closest(const struct query *q, const struct bvh_node *leaf, struct ray_hit *best)
{
    const uint32_t begin = leaf->first, end = begin + leaf->count;
    struct ray_hit found = {0};
    switch ((enum stage_prim_kind)leaf->kind) {
    case STAGE_TRIANGLE:
        for (uint32_t i = begin; i < end; i++)
            if (tri_hit(&q->tri, q->triangles[i].v, best->t, &found))
                keep_nearer(best, &found, q->triangles[i].prim);
        return;
    case STAGE_SPHERE:
        for (uint32_t i = begin; i < end; i++) {
            found.t = (float)sphere_t(q->ray, &q->spheres[i]);
            if (found.t > 0)
                keep_nearer(best, &found, q->spheres[i].prim);
        }
        return;
    case STAGE_DISC:
        for (uint32_t i = begin; i < end; i++) {
            found.t = (float)sphere_disc_t(q->ray, &q->discs[i]);
            if (found.t > 0)
                keep_nearer(best, &found, q->discs[i].prim);
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
    struct { /* the farther children that wait: at most one per level */
        uint32_t node;
        float t;
    } stack[BVH_MAX_DEPTH];
    uint32_t waiting = 0, at = 0;
    struct ray_hit best = {ray->t_max, 0, 0, 0}; /* prim 0: a hit at t_max itself is not nearer */
    for (;;) {
        const struct bvh_node *node = &q.nodes[at];
        if (node->count) {
            leaf_closest(&q, node, &best);
        } else {
            const struct bvh_node *child = &q.nodes[node->first];
            float t0, t1;
            const bool hit0 = box_hit(&q.box, child[0].plane, best.t, &t0);
            const bool hit1 = box_hit(&q.box, child[1].plane, best.t, &t1);
            const uint32_t second_is_near = hit1 && (!hit0 || t1 < t0);
            at = node->first + second_is_near;
            if (hit0 && hit1) {
                stack[waiting].node = node->first + 1 - second_is_near;
                stack[waiting++].t = second_is_near ? t0 : t1;
            }
            if (hit0 || hit1)
                continue;
        }
        /* Boxes as near as the best hit are still opened: an equal hit may have a smaller number. */
        do {
            if (!waiting) {
                *hit = best;
                return best.t < ray->t_max;
            }
            waiting--;
        } while (stack[waiting].t > best.t);
        at = stack[waiting].node;
    }
}

static bool leaf_any(const struct query *q, const struct bvh_node *leaf)
{
    const uint32_t begin = leaf->first, end = begin + leaf->count;
    const float t_max = q->ray->t_max;
    struct ray_hit found;
    bool hit = false;
    switch ((enum stage_prim_kind)leaf->kind) {
    case STAGE_TRIANGLE:
        for (uint32_t i = begin; i < end && !hit; i++)
            hit = tri_hit(&q->tri, q->triangles[i].v, t_max, &found) && found.t < t_max;
        return hit;
    case STAGE_SPHERE:
        for (uint32_t i = begin; i < end && !hit; i++) {
            const float t = (float)sphere_t(q->ray, &q->spheres[i]);
            hit = t > 0 && t < t_max;
        }
        return hit;
    case STAGE_DISC:
        for (uint32_t i = begin; i < end && !hit; i++) {
            const float t = (float)sphere_disc_t(q->ray, &q->discs[i]);
            hit = t > 0 && t < t_max;
        }
        return hit;
    }
    __builtin_unreachable();
}

bool bvh_hit_any(const struct stage *s, const struct ray *ray)
{
    struct query q;
    if (!query_make(s, ray, &q))
        return false;
    uint32_t stack[BVH_MAX_DEPTH]; /* at most one waits per level */
    uint32_t waiting = 0, at = 0;
    for (;;) {
        const struct bvh_node *node = &q.nodes[at];
        if (node->count) {
            if (leaf_any(&q, node))
                return true;
        } else {
            const struct bvh_node *child = &q.nodes[node->first];
            float t0, t1;
            const bool hit0 = box_hit(&q.box, child[0].plane, ray->t_max, &t0);
            const bool hit1 = box_hit(&q.box, child[1].plane, ray->t_max, &t1);
            const uint32_t second_is_near = hit1 && (!hit0 || t1 < t0);
            at = node->first + second_is_near;
            if (hit0 && hit1)
                stack[waiting++] = node->first + 1 - second_is_near;
            if (hit0 || hit1)
                continue;
        }
        if (!waiting)
            return false;
        at = stack[--waiting];
    }
}
