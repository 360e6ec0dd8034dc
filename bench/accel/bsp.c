/* BSP tree: H. Fuchs, Z. Kedem, B. Naylor, "On Visible Surface Generation by A Priori Tree
 * Structures", SIGGRAPH 1980. Planes come from the triangles ("autopartition"): a triangle's own,
 * and the three through its edges at right angles to it, without which a convex surface could not
 * be cut at all (T. Ize, I. Wald, S. Parker, "Ray Tracing with the BSP Tree", RT 2008). The best of
 * a few random ones is taken. A triangle across the plane goes whole to both sides.
 *
 * Which plane is good depends on how many rays meet either side. The cells are polyhedra of many
 * sides, whose surface is laborious; so sample lines are cut up along with the scene and counted
 * (J. Bittner, V. Havran, "RDH: Ray Distribution Heuristics for Construction of Spatial Data
 * Structures", SCCG 2009). Where no plane pays by itself, one that halves many triangles does later
 * on. SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "bench/accel/build.h"
#include "bench/accel/query.h"
#include "tests/soup.h"

enum {
    LEAF_MAX = 6,
    MANY = 32, /* triangles: halved where no plane pays */
    MAX_DEPTH = 64,
    CANDIDATES = 32, /* planes looked at for a node */
    SAMPLE = 64,     /* triangles by which they are judged */
    LINES_PER_TRIANGLE = 16,
    LINES_MAX = 1 << 16,
    LINES_SAMPLE = 128, /* by which planes are judged: about so many */
    LINES_ENOUGH = 8,   /* with fewer, the share of triangles stands for the share of lines */
};

#define INNER     UINT32_MAX /* in place of a leaf's count */
#define STEP_COST 0.3        /* in units of a triangle test */
#define WORTH_IT  0.9        /* of the cost of not cutting */

struct plane {
    float normal[3], offset;
};

struct line { /* what is of it in a cell */
    float end[2][3];
};

struct builder {
    struct bsp *tree;
    const struct accel_limits *limits;
    struct accel_list waiting; /* triangles of the nodes from the root to the one at hand */
    struct line *lines;        /* of the same nodes */
    size_t line_count, line_room;
    struct dice dice;
    double touching; /* vertices so near are in the plane: normals are rounded to float */
};

struct part { /* what becomes of a node: its triangles are waiting[begin, end) */
    size_t begin, end, lines_begin, lines_end;
    uint32_t node, depth;
};

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* The triangle's plane (edge 3), or the one across it through an edge. False without a direction.
 */
static bool plane_of(const float v[3][3], uint32_t edge, struct plane *plane)
{
    double a[3], b[3], along[3], normal[3], *n = normal, offset = 0;
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
    if (!(length > 0 && length < HUGE_VAL))
        return false;
    for (int k = 0; k < 3; k++) {
        plane->normal[k] = (float)(n[k] / length);
        offset += n[k] / length * (double)from[k];
    }
    plane->offset = (float)offset;
    return true;
}

static double height(const struct plane *plane, const float p[3])
{
    double h = -(double)plane->offset;
    for (int k = 0; k < 3; k++)
        h += (double)plane->normal[k] * (double)p[k];
    return h;
}

struct sides { /* what only touches the plane is behind */
    bool behind, before;
};

static struct sides sides_of(const struct builder *b, uint32_t prim, const struct plane *plane)
{
    const float(*v)[3] = b->tree->mesh.v[prim];
    const double h[3] = {height(plane, v[0]), height(plane, v[1]), height(plane, v[2])};
    const double t = b->touching;
    const bool before = h[0] > t || h[1] > t || h[2] > t;
    return (struct sides){h[0] < -t || h[1] < -t || h[2] < -t || !before, before};
}

/* --- lines --- */

static void add_line(struct builder *b, struct line line)
{
    b->lines = build_grow(b->lines, &b->line_room, b->line_count + 1, sizeof *b->lines);
    b->lines[b->line_count++] = line;
}

/* From triangles, as bounced rays come, both ways to the bounds. */
static void add_lines(struct builder *b)
{
    const struct bsp *t = b->tree;
    const uint64_t count = (uint64_t)t->mesh.count * LINES_PER_TRIANGLE;
    for (uint64_t i = 0; i < (count < LINES_MAX ? count : LINES_MAX); i++) {
        const uint32_t prim = dice_bits(&b->dice) % t->mesh.count;
        struct ray ray = {vec3_load(t->mesh.v[prim][0]), soup_direction(&b->dice), INFINITY};
        struct line line;
        for (int way = 0; way < 2; way++, ray.dir = -ray.dir) {
            struct query q;
            float in[2] = {0, 0};
            if (query_make(&q, t->mesh, &t->bounds, &ray))
                query_box(&q, t->bounds.lo, t->bounds.hi, in);
            vec3_store(line.end[way], ray.origin + ray.dir * in[1]);
        }
        add_line(b, line);
    }
}

/* Adds what is of the part's lines on one side. */
static void cut_lines(struct builder *b, const struct part *p, const struct plane *plane,
                      bool before)
{
    for (size_t i = p->lines_begin; i < p->lines_end; i++) {
        struct line line = b->lines[i];
        const double h[2] = {height(plane, line.end[0]), height(plane, line.end[1])};
        const bool in[2] = {(h[0] > 0) == before, (h[1] > 0) == before};
        if (!in[0] && !in[1])
            continue;
        for (int k = 0; k < 3 && in[0] != in[1]; k++) {
            const double from = (double)line.end[0][k], to = (double)line.end[1][k];
            line.end[in[0]][k] = (float)(from + (to - from) * (h[0] / (h[0] - h[1])));
        }
        add_line(b, line);
    }
}

/* --- the tree --- */

static uint32_t any_of(struct builder *b, const struct part *p)
{
    return b->waiting.at[p->begin + dice_bits(&b->dice) % (p->end - p->begin)];
}

struct cost { /* of the cell when it is cut, in parts of what it is when not */
    double by_lines, by_count;
};

static struct cost judge(const struct builder *b, const struct part *p, const uint32_t *sample,
                         uint32_t samples, const struct plane *plane)
{
    const size_t step = (p->lines_end - p->lines_begin) / LINES_SAMPLE + 1;
    double behind = 0, before = 0, lines = 0, lines_behind = 0, lines_before = 0;
    for (uint32_t i = 0; i < samples; i++) {
        const struct sides s = sides_of(b, sample[i], plane);
        behind += s.behind;
        before += s.before;
    }
    for (size_t i = p->lines_begin; i < p->lines_end; i += step, lines++) {
        const struct line *l = &b->lines[i];
        const double from = height(plane, l->end[0]), to = height(plane, l->end[1]);
        lines_behind += from <= 0 || to <= 0;
        lines_before += from > 0 || to > 0;
    }
    struct cost cost = {.by_count = (behind * behind + before * before) / samples / samples};
    cost.by_lines = lines < LINES_ENOUGH
                        ? cost.by_count
                        : (behind * lines_behind + before * lines_before) / samples / lines;
    cost.by_lines += STEP_COST / (double)(p->end - p->begin);
    return cost;
}

/* False: no plane is worth it. */
static bool choose(struct builder *b, const struct part *p, struct plane *chosen)
{
    uint32_t sample[SAMPLE];
    const size_t count = p->end - p->begin;
    const uint32_t samples = (uint32_t)min_size(count, SAMPLE);
    struct cost least = {WORTH_IT, count > MANY ? WORTH_IT : 0};
    struct plane halving = {{0}, 0};
    if (count <= LEAF_MAX || p->depth == MAX_DEPTH)
        return false;
    for (uint32_t i = 0; i < samples; i++)
        sample[i] = count <= SAMPLE ? b->waiting.at[p->begin + i] : any_of(b, p);
    for (uint32_t c = 0; c < CANDIDATES; c++) {
        struct plane plane;
        if (!plane_of(b->tree->mesh.v[any_of(b, p)], c % 4, &plane))
            continue;
        const struct cost cost = judge(b, p, sample, samples, &plane);
        if (cost.by_lines < least.by_lines) {
            least.by_lines = cost.by_lines;
            *chosen = plane;
        }
        if (cost.by_count < least.by_count) {
            least.by_count = cost.by_count;
            halving = plane;
        }
    }
    if (least.by_lines < WORTH_IT)
        return true;
    *chosen = halving;
    return count > MANY && least.by_count < WORTH_IT;
}

static uint32_t add_nodes(struct bsp *t, uint32_t count)
{
    t->nodes = build_grow(t->nodes, &t->node_room, t->node_count + count, sizeof *t->nodes);
    t->node_count += count;
    return (uint32_t)t->node_count - count;
}

static bool build_part(struct builder *b, const struct part *p, struct err *err)
{
    struct bsp *t = b->tree;
    struct plane plane = {{0}, 0};
    if (!build_within(b->limits, bsp_bytes(t) + b->waiting.count * sizeof(uint32_t),
                      p->end - p->begin, err))
        return false;
    if (!choose(b, p, &plane)) {
        t->nodes[p->node].count = (uint32_t)(p->end - p->begin);
        t->nodes[p->node].first = build_push_all(&t->refs, &b->waiting, p->begin, p->end);
        return true;
    }
    const uint32_t children = add_nodes(t, 2);
    t->nodes[p->node] = (struct bsp_node){
        {plane.normal[0], plane.normal[1], plane.normal[2]}, plane.offset, children, INNER};
    for (uint32_t before = 0; before < 2; before++) {
        struct part child = {p->end, 0, p->lines_end, 0, children + before, p->depth + 1};
        for (size_t i = p->begin; i < p->end; i++) {
            const struct sides s = sides_of(b, b->waiting.at[i], &plane);
            if (before ? s.before : s.behind)
                build_push(&b->waiting, b->waiting.at[i]);
        }
        cut_lines(b, p, &plane, before);
        child.end = b->waiting.count;
        child.lines_end = b->line_count;
        if (!build_part(b, &child, err))
            return false;
        b->waiting.count = p->end;
        b->line_count = p->lines_end;
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
    add_lines(&b);
    const struct part root = {0, mesh.count, 0, b.line_count, add_nodes(t, 1), 0};
    const bool done = build_part(&b, &root, err);
    free(b.waiting.at);
    free(b.lines);
    if (!done)
        bsp_release(t);
    return done;
}

/* Where the ray crosses the node's plane, at the earliest and at the latest; true when it runs
 * down. One in the plane has no sign, so that both are infinite, as the side says that the origin
 * is on. The slack adds up over three axes here, and a triangle may lie `touching` beyond its
 * plane. */
static bool crosses(const struct bsp_node *n, const struct query *q, float *early, float *late)
{
    float h = -n->offset, speed = 0;
    for (int k = 0; k < 3; k++) {
        h += n->normal[k] * q->box.origin[k];
        speed += n->normal[k] * q->tri.dir[k];
    }
    const bool down = speed < 0;
    const float slack = down ? -3 * q->slack : 3 * q->slack, inv = 1 / (speed == 0 ? 0 : speed);
    *early = (-h - slack) * inv;
    *late = (-h + slack) * inv;
    return down;
}

bool bsp_hit(const struct bsp *t, const struct ray *ray, struct ray_hit *hit)
{
    struct query_visit stack[MAX_DEPTH + 1], *top = stack;
    struct query q;
    if (!query_enter(&q, t->mesh, &t->bounds, ray, top++))
        return false;
    while (top > stack) {
        struct query_visit v = *--top;
        if (v.begin > q.best.t) /* an equal hit in there may have a smaller number */
            continue;
        const struct bsp_node *node = &t->nodes[v.node];
        for (; node->count == INNER; node = &t->nodes[v.node]) {
            float early, late;
            const bool down = crosses(node, &q, &early, &late);
            top = query_cut(&v, top, node->first, down, early, late);
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
