/* BSP tree: H. Fuchs, Z. Kedem, B. Naylor, "On Visible Surface Generation by A Priori Tree
 * Structures", SIGGRAPH 1980. Planes come from the triangles ("autopartition"): a triangle's own,
 * and the three through its edges at right angles to it, without which a convex surface could not
 * be cut at all (T. Ize, I. Wald, S. Parker, "Ray Tracing with the BSP Tree", RT 2008). The best of
 * a few random ones is taken. A triangle across the plane goes whole to both sides.
 *
 * Which plane is good would depend on the surfaces of the two cells; these are polyhedra of many
 * sides, so a cell's share of the triangles stands for its share of the surface.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "bench/accel/build.h"
#include "bench/accel/query.h"
#include "tests/dice.h"

enum {
    LEAF_MAX = 6,
    MAX_DEPTH = 64,
    CANDIDATES = 32, /* planes looked at for a node */
    SAMPLE = 64,     /* triangles by which they are judged */
};

#define INNER    UINT32_MAX /* in place of a leaf's count */
#define WORTH_IT 0.9        /* the cost of not cutting is 1 */

struct builder {
    struct bsp *tree;
    const struct accel_limits *limits;
    struct accel_list waiting; /* triangles of the nodes from the root to the one at hand */
    struct dice dice;
    double touching; /* vertices so near are in the plane: normals are rounded to float */
};

struct part { /* what becomes of a node: its triangles are waiting[begin, end) */
    size_t begin, end;
    uint32_t node, depth;
};

struct plane {
    float normal[3], offset;
};

static uint32_t add_nodes(struct bsp *t, uint32_t count)
{
    t->nodes = build_grow(t->nodes, &t->node_room, t->node_count + count, sizeof *t->nodes);
    t->node_count += count;
    return (uint32_t)t->node_count - count;
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* The triangle's plane (edge 3), or one across it through an edge. False without a direction. */
static bool plane_of(const float v[3][3], uint32_t edge, struct plane *plane)
{
    double a[3], b[3], along[3], normal[3], *n = normal;
    const float *from = v[edge % 3], *to = v[(edge + 1) % 3];
    for (int k = 0; k < 3; k++) {
        a[k] = (double)v[1][k] - (double)v[0][k];
        b[k] = (double)v[2][k] - (double)v[0][k];
        along[k] = (double)to[k] - (double)from[k];
    }
    cross(a, b, normal);
    if (edge < 3) {
        cross(normal, along, a);
        n = a;
    }
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    double offset = 0;
    if (!(length > 0 && length < HUGE_VAL))
        return false;
    for (int k = 0; k < 3; k++) {
        plane->normal[k] = (float)(n[k] / length);
        offset += n[k] / length * (double)from[k];
    }
    plane->offset = (float)offset;
    return true;
}

struct sides {
    bool behind, before; /* what only touches the plane is behind */
};

static struct sides sides_of(const struct builder *b, uint32_t prim, const struct plane *plane)
{
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (int i = 0; i < 3; i++) {
        const float *v = b->tree->mesh.v[prim][i];
        double d = -(double)plane->offset;
        for (int k = 0; k < 3; k++)
            d += (double)plane->normal[k] * (double)v[k];
        least = d < least ? d : least;
        most = d > most ? d : most;
    }
    const bool before = most > b->touching;
    return (struct sides){least < -b->touching || !before, before};
}

static uint32_t any_of(struct builder *b, const struct part *p)
{
    return b->waiting.at[p->begin + dice_bits(&b->dice) % (p->end - p->begin)];
}

static bool choose(struct builder *b, const struct part *p, struct plane *best)
{
    double least = WORTH_IT;
    uint32_t sample[SAMPLE];
    const size_t count = p->end - p->begin;
    if (count <= LEAF_MAX || p->depth == MAX_DEPTH)
        return false;
    const uint32_t samples = (uint32_t)min_size(count, SAMPLE);
    for (uint32_t i = 0; i < samples; i++)
        sample[i] = count <= SAMPLE ? b->waiting.at[p->begin + i] : any_of(b, p);
    for (uint32_t c = 0; c < CANDIDATES; c++) {
        struct plane plane;
        double behind = 0, before = 0;
        if (!plane_of(b->tree->mesh.v[any_of(b, p)], c % 4, &plane))
            continue;
        for (uint32_t i = 0; i < samples; i++) {
            const struct sides s = sides_of(b, sample[i], &plane);
            behind += s.behind;
            before += s.before;
        }
        const double cost = (behind * behind + before * before) / ((double)samples * samples);
        if (cost < least) {
            least = cost;
            *best = plane;
        }
    }
    return least < WORTH_IT;
}

static void make_leaf(struct builder *b, const struct part *p)
{
    struct bsp_node *node = &b->tree->nodes[p->node];
    node->first = (uint32_t)b->tree->refs.count;
    node->count = (uint32_t)(p->end - p->begin);
    for (size_t i = p->begin; i < p->end; i++)
        build_push(&b->tree->refs, b->waiting.at[i]);
}

static bool build_part(struct builder *b, const struct part *p, struct err *err)
{
    struct plane plane = {{0}, 0};
    if (!build_within(b->limits, bsp_bytes(b->tree) + b->waiting.count * sizeof(uint32_t), err))
        return false;
    if (!choose(b, p, &plane)) {
        make_leaf(b, p);
        return true;
    }
    const uint32_t children = add_nodes(b->tree, 2);
    struct bsp_node *node = &b->tree->nodes[p->node];
    for (int k = 0; k < 3; k++)
        node->normal[k] = plane.normal[k];
    node->offset = plane.offset;
    node->first = children;
    node->count = INNER;
    for (uint32_t before = 0; before < 2; before++) {
        struct part child = {p->end, p->end, children + before, p->depth + 1};
        for (size_t i = p->begin; i < p->end; i++) {
            const struct sides s = sides_of(b, b->waiting.at[i], &plane);
            if (before ? s.before : s.behind)
                build_push(&b->waiting, b->waiting.at[i]);
        }
        child.end = b->waiting.count;
        if (!build_part(b, &child, err))
            return false;
        b->waiting.count = p->end;
    }
    return true;
}

bool bsp_build(struct bsp *t, struct accel_mesh mesh, const struct accel_limits *limits,
               struct err *err)
{
    *t = (struct bsp){.mesh = mesh, .bounds = build_bounds(mesh)};
    struct builder b = {.tree = t, .limits = limits, .dice = dice_make(1)};
    b.touching = (double)(round_gamma(8) * query_extent(&t->bounds));
    for (uint32_t i = 0; i < mesh.count; i++)
        build_push(&b.waiting, i);
    const bool done = build_part(&b, &(struct part){0, mesh.count, add_nodes(t, 1), 0}, err);
    free(b.waiting.at);
    if (!done)
        bsp_release(t);
    return done;
}

/* Where the ray crosses the node's plane, at the earliest and at the latest. A direction in the
 * plane has no sign, so that both are infinite: with the sign of the side the origin is on. The
 * slack is along three axes here, and a triangle may lie `touching` beyond the plane. */
static bool crosses(const struct bsp_node *n, const struct query *q, float *early, float *late)
{
    float height = -n->offset, speed = 0;
    for (int k = 0; k < 3; k++) {
        height += n->normal[k] * q->tri.origin[k];
        speed += n->normal[k] * q->tri.dir[k];
    }
    const bool down = speed < 0;
    const float slack = down ? -3 * q->slack : 3 * q->slack, inv = 1 / (speed == 0 ? 0 : speed);
    *early = (-height - slack) * inv;
    *late = (-height + slack) * inv;
    return down;
}

bool bsp_hit(const struct bsp *t, const struct ray *ray, struct ray_hit *hit)
{
    struct {
        uint32_t node;
        float begin, end;
    } stack[MAX_DEPTH + 1];
    struct query q;
    float in[2];
    if (!query_make(&q, t->mesh, &t->bounds, ray) || !query_box(&q, t->bounds.lo, t->bounds.hi, in))
        return false;
    int depth = 0;
    stack[depth].begin = in[0];
    stack[depth].end = in[1];
    stack[depth++].node = 0;
    while (depth) {
        float begin = stack[--depth].begin, end = stack[depth].end;
        if (begin > q.best.t) /* an equal hit in there may have a smaller number */
            continue;
        const struct bsp_node *node = &t->nodes[stack[depth].node];
        while (node->count == INNER) {
            float early, late;
            const bool down = crosses(node, &q, &early, &late);
            const uint32_t near = node->first + down, far = node->first + !down;
            const bool enters_near = !(late < begin), enters_far = !(early > end);
            if (enters_near && enters_far) {
                stack[depth].node = far;
                stack[depth].begin = early > begin ? early : begin;
                stack[depth++].end = end;
                end = late < end ? late : end;
            }
            node = &t->nodes[enters_near ? near : far];
        }
        query_triangles(&q, t->refs.at + node->first, node->count);
    }
    return query_done(&q, hit);
}

uint64_t bsp_bytes(const struct bsp *t)
{
    return t->node_count * sizeof *t->nodes + t->refs.count * sizeof *t->refs.at;
}

void bsp_release(struct bsp *t)
{
    free(t->nodes);
    free(t->refs.at);
}
