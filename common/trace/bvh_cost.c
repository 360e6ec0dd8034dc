/* SPDX-License-Identifier: MIT */
#include "common/trace/bvh_cost.h"

#include "common/trace/bvh.h"

/* Half the surface; the planes are a little apart from where the box ends (box8.h), which does not
 * matter here. */
static double half_area(const double size[3])
{
    return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
}

static double child_area(const struct bvh_node *n, uint32_t i)
{
    double size[3];
    for (int k = 0; k < 3; k++)
        size[k] = (double)n->plane[2 * k + 1][i] - (double)n->plane[2 * k][i];
    return half_area(size);
}

static double node_area(const struct bvh_node *n)
{
    double size[3];
    for (int k = 0; k < 3; k++) {
        double lo = (double)n->plane[2 * k][0], hi = (double)n->plane[2 * k + 1][0];
        for (uint32_t i = 1; n->used >> i & 1; i++) {
            const double l = (double)n->plane[2 * k][i], h = (double)n->plane[2 * k + 1][i];
            lo = l < lo ? l : lo;
            hi = h > hi ? h : hi;
        }
        size[k] = hi - lo;
    }
    return half_area(size);
}

static const struct bvh_node *node_at(const struct stage *s, uint32_t ref)
{
    return (const struct bvh_node *)stage_at(s, s->nodes) + bvh_ref_index(ref) / BVH_NODE_LINES;
}

/* The areas of all that is visited from here on, this included. Trees are at most BVH_MAX_DEPTH
 * deep.
 */
static double visits(const struct stage *s, uint32_t ref, double area)
{
    if (bvh_ref_kind(ref) == BVH_INSTANCE) {
        const struct stage_tree *trees = stage_at(s, s->trees);
        return area * (1 + trees[stage_instance_at(s, bvh_ref_index(ref))->tree].cost);
    }
    if (bvh_ref_kind(ref) != BVH_NODE)
        return area;
    const struct bvh_node *n = node_at(s, ref);
    double sum = area;
    for (uint32_t i = 0; n->used >> i & 1; i++)
        sum += visits(s, n->child[i], child_area(n, i));
    return sum;
}

/* What has no extent is visited whole. */
double bvh_cost(const struct stage *s, uint32_t tree)
{
    const uint32_t root = ((const struct stage_tree *)stage_at(s, s->trees))[tree].root;
    if (bvh_ref_kind(root) != BVH_NODE)
        return visits(s, root, 1);
    const double area = node_area(node_at(s, root));
    return area > 0 ? visits(s, root, area) / area : 1;
}
