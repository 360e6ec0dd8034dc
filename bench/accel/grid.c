/* Uniform grid, walked cell by cell: J. Amanatides, A. Woo, "A Fast Voxel Traversal Algorithm for
 * Ray Tracing", Eurographics 1987. The number of cells: J. Cleary, G. Wyvill, "Analysis of an
 * algorithm for fast ray tracing using uniform space subdivision", The Visual Computer 4, 1988.
 * Without the mailbox of the former: a triangle in several cells is tested again.
 *
 * A triangle is entered in each cell that its box touches, the box being widened by what
 * rounding may do to any ray within ACCEL_REACH (query.h). SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "bench/accel/build.h"
#include "bench/accel/query.h"
#include "common/arena.h"

enum { CELLS_PER_TRIANGLE = 4 };

struct cells { /* half-open */
    int32_t begin[3], end[3];
};

static int32_t clamp(float x, int32_t count)
{
    return x > 0 ? (x < (float)count ? (int32_t)x : count - 1) : 0;
}

static int32_t cell_of(const struct grid *g, int k, float x)
{
    return clamp((x - g->bounds.lo[k]) / g->side[k], g->cells[k]);
}

static size_t index_of(const struct grid *g, const int32_t at[3])
{
    return ((size_t)at[2] * (size_t)g->cells[1] + (size_t)at[1]) * (size_t)g->cells[0] +
           (size_t)at[0];
}

static float margin(const struct accel_box *bounds)
{
    return round_gamma(32) * (1 + ACCEL_REACH) * query_extent(bounds);
}

/* Cells are cubes as far as whole numbers allow; an axis along which the scene is thinner than a
 * cell is left whole and does not count. */
static void choose_cells(struct grid *g)
{
    double length[3];
    bool cut[3] = {true, true, true};
    for (int k = 0; k < 3; k++)
        length[k] = (double)g->bounds.hi[k] - (double)g->bounds.lo[k];
    for (bool again = true; again;) {
        double volume = 1, side;
        int axes = 0;
        for (int k = 0; k < 3; k++)
            if (cut[k]) {
                volume *= length[k];
                axes++;
            }
        side = axes ? pow(volume / (CELLS_PER_TRIANGLE * (double)g->mesh.count), 1.0 / axes) : 0;
        again = false;
        for (int k = 0; k < 3; k++) {
            again |= cut[k] && length[k] < side;
            cut[k] = cut[k] && length[k] >= side;
            g->cells[k] = cut[k] ? (int32_t)(length[k] / side) : 1;
            g->side[k] = (float)(length[k] / g->cells[k]);
        }
    }
}

static struct cells cells_of(const struct grid *g, uint32_t prim, float pad)
{
    const struct accel_box box = build_box(g->mesh.v[prim]);
    struct cells c;
    for (int k = 0; k < 3; k++) {
        c.begin[k] = cell_of(g, k, box.lo[k] - pad);
        c.end[k] = cell_of(g, k, box.hi[k] + pad) + 1;
    }
    return c;
}

/* Counts the triangles of each cell, or puts them where starts says, last to first. */
static void enter(struct grid *g, float pad, bool counting)
{
    for (uint32_t i = g->mesh.count; i-- > 0;) {
        const struct cells c = cells_of(g, i, pad);
        int32_t at[3];
        for (at[2] = c.begin[2]; at[2] < c.end[2]; at[2]++)
            for (at[1] = c.begin[1]; at[1] < c.end[1]; at[1]++)
                for (at[0] = c.begin[0]; at[0] < c.end[0]; at[0]++) {
                    uint32_t *start = &g->starts[index_of(g, at)];
                    if (counting)
                        ++*start;
                    else
                        g->refs[--*start] = i;
                }
    }
}

bool grid_build(struct grid *g, struct accel_mesh mesh, const struct accel_limits *limits,
                struct err *err)
{
    *g = (struct grid){.mesh = mesh, .bounds = build_bounds(mesh)};
    if (!mesh.count)
        return true;
    const float pad = margin(&g->bounds) + FLT_MIN;
    for (int k = 0; k < 3; k++) { /* a flat scene, too, has a thickness then */
        g->bounds.lo[k] -= 2 * pad;
        g->bounds.hi[k] += 2 * pad;
    }
    choose_cells(g);
    const size_t cells = (size_t)g->cells[0] * (size_t)g->cells[1] * (size_t)g->cells[2];
    uint64_t refs = 0;
    for (uint32_t i = 0; i < mesh.count; i++) {
        const struct cells c = cells_of(g, i, pad);
        refs += (uint64_t)(c.end[0] - c.begin[0]) * (uint64_t)(c.end[1] - c.begin[1]) *
                (uint64_t)(c.end[2] - c.begin[2]);
    }
    if (refs > UINT32_MAX)
        return err_set(err, ERR_LIMIT, "more than 2^32 triangles in cells");
    if (!build_within(limits, (cells + 1 + refs) * sizeof(uint32_t), mesh.count, err))
        return false;
    g->starts = arena_malloc(cells + 1, sizeof *g->starts);
    g->refs = arena_malloc(refs, sizeof *g->refs);
    enter(g, pad, true);
    uint32_t sum = 0;
    for (size_t i = 0; i <= cells; i++) /* to each cell's end, which the second round moves down */
        sum = g->starts[i] += sum;
    enter(g, pad, false);
    return true;
}

/* The walk: next[k] is where the ray leaves its cell across axis k. */
struct walk {
    int32_t at[3], step[3];
    float next[3];
};

/* Computed from the cell's number each time, so that errors do not add up along the way. */
static float leaves_at(const struct grid *g, const struct query *q, int32_t at, int k)
{
    const float plane = g->bounds.lo[k] + (float)(at + !q->down[k]) * g->side[k];
    const float t = (plane - q->box.origin[k]) * q->box.inv[k];
    return t == t ? t : __builtin_inff(); /* in the plane and along it: never */
}

static struct walk walk_make(const struct grid *g, const struct query *q, float t)
{
    struct walk w;
    for (int k = 0; k < 3; k++) {
        w.at[k] = cell_of(g, k, q->box.origin[k] + t * q->tri.ray->dir[k]);
        w.step[k] = q->down[k] ? -1 : 1;
        w.next[k] = leaves_at(g, q, w.at[k], k);
    }
    return w;
}

bool grid_hit(const struct grid *g, const struct ray *ray, struct ray_hit *hit)
{
    struct query q;
    float t[2];
    if (!query_make(&q, g->mesh, &g->bounds, ray) || !query_box(&q, g->bounds.lo, g->bounds.hi, t))
        return false;
    struct walk w = walk_make(g, &q, t[0]);
    for (;;) {
        const size_t cell = index_of(g, w.at);
        query_triangles(&q, g->refs + g->starts[cell], g->starts[cell + 1] - g->starts[cell]);
        int k = w.next[0] < w.next[1] ? 0 : 1;
        k = w.next[2] < w.next[k] ? 2 : k;
        if (q.best.t < w.next[k])
            return query_done(&q, hit);
        w.at[k] += w.step[k];
        if (w.at[k] < 0 || w.at[k] >= g->cells[k])
            return query_done(&q, hit);
        w.next[k] = leaves_at(g, &q, w.at[k], k);
    }
}

uint64_t grid_bytes(const struct grid *g)
{
    if (!g->mesh.count)
        return 0;
    const size_t cells = (size_t)g->cells[0] * (size_t)g->cells[1] * (size_t)g->cells[2];
    return (cells + 1 + g->starts[cells]) * sizeof(uint32_t);
}

void grid_release(struct grid *g)
{
    free(g->starts);
    free(g->refs);
}
