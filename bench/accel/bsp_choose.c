/* SPDX-License-Identifier: MIT */
#include "bench/accel/bsp_choose.h"

#include <math.h>
#include <stdlib.h>

#include "bench/accel/build.h"
#include "bench/accel/query.h"
#include "tests/soup.h"

enum {
    LEAF_MAX = 6,
    MANY = 32,       /* triangles: halved where no plane pays */
    CANDIDATES = 32, /* planes looked at for a cell */
    SAMPLE = 64,     /* triangles by which they are judged */
    LINES_PER_TRIANGLE = 16,
    LINES_MAX = 1 << 16,
    LINES_SAMPLE = 128, /* by which planes are judged: about so many */
    LINES_ENOUGH = 8,   /* with fewer, the share of triangles stands for the share of lines */
};

#define STEP_COST 0.3 /* in units of a triangle test */
#define WORTH_IT  0.9 /* of the cost of not cutting */

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* The triangle's plane (edge 3), or the one across it through an edge. False when there is none. */
static bool plane_of(const float v[3][3], uint32_t edge, struct bsp_plane *plane)
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

static double height(const struct bsp_plane *plane, const float p[3])
{
    double h = -(double)plane->offset;
    for (int k = 0; k < 3; k++)
        h += (double)plane->normal[k] * (double)p[k];
    return h;
}

struct bsp_sides bsp_sides_of(const struct bsp_chooser *c, uint32_t prim,
                              const struct bsp_plane *plane)
{
    const float(*v)[3] = c->mesh.v[prim];
    const double h[3] = {height(plane, v[0]), height(plane, v[1]), height(plane, v[2])};
    const double t = c->touching;
    const bool before = h[0] > t || h[1] > t || h[2] > t;
    return (struct bsp_sides){h[0] < -t || h[1] < -t || h[2] < -t || !before, before};
}

static void add_line(struct bsp_chooser *c, struct bsp_line line)
{
    c->lines = build_grow(c->lines, &c->line_room, c->line_count + 1, sizeof *c->lines);
    c->lines[c->line_count++] = line;
}

/* From triangles, as bounced rays come, both ways to the bounds. */
static void add_lines(struct bsp_chooser *c, const struct bsp *t)
{
    const uint64_t count = (uint64_t)t->mesh.count * LINES_PER_TRIANGLE;
    for (uint64_t i = 0; i < (count < LINES_MAX ? count : LINES_MAX); i++) {
        const uint32_t prim = dice_bits(&c->dice) % t->mesh.count;
        struct ray ray = {vec3_load(t->mesh.v[prim][0]), soup_direction(&c->dice), INFINITY, 0, 0};
        struct bsp_line line;
        for (int way = 0; way < 2; way++, ray.dir = -ray.dir) {
            struct query q;
            float in[2] = {0, 0};
            if (query_make(&q, t->mesh, &t->bounds, &ray))
                query_box(&q, t->bounds.lo, t->bounds.hi, in);
            vec3_store(line.end[way], ray.origin + ray.dir * in[1]);
        }
        add_line(c, line);
    }
}

void bsp_chooser_init(struct bsp_chooser *c, const struct bsp *t)
{
    *c = (struct bsp_chooser){.mesh = t->mesh, .dice = dice_make(1)};
    c->touching = (double)(round_gamma(8) * query_extent(&t->bounds));
    add_lines(c, t);
}

void bsp_chooser_release(struct bsp_chooser *c)
{
    free(c->lines);
}

void bsp_cut_lines(struct bsp_chooser *c, const struct bsp_cell *cell,
                   const struct bsp_plane *plane, bool before)
{
    for (size_t i = cell->lines_begin; i < cell->lines_end; i++) {
        struct bsp_line line = c->lines[i];
        const double h[2] = {height(plane, line.end[0]), height(plane, line.end[1])};
        const bool in[2] = {(h[0] > 0) == before, (h[1] > 0) == before};
        if (!in[0] && !in[1])
            continue;
        for (int k = 0; k < 3 && in[0] != in[1]; k++) {
            const double from = (double)line.end[0][k], to = (double)line.end[1][k];
            line.end[in[0]][k] = (float)(from + (to - from) * (h[0] / (h[0] - h[1])));
        }
        add_line(c, line);
    }
}

static uint32_t any_of(struct bsp_chooser *c, const struct bsp_cell *cell)
{
    return cell->prims[dice_bits(&c->dice) % cell->count];
}

struct cost { /* of the cell when it is cut, in parts of what it is when not */
    double by_lines, by_count;
};

static struct cost judge(const struct bsp_chooser *c, const struct bsp_cell *cell,
                         const uint32_t *sample, uint32_t samples, const struct bsp_plane *plane)
{
    const size_t step = (cell->lines_end - cell->lines_begin) / LINES_SAMPLE + 1;
    double behind = 0, before = 0, lines = 0, lines_behind = 0, lines_before = 0;
    for (uint32_t i = 0; i < samples; i++) {
        const struct bsp_sides s = bsp_sides_of(c, sample[i], plane);
        behind += s.behind;
        before += s.before;
    }
    for (size_t i = cell->lines_begin; i < cell->lines_end; i += step, lines++) {
        const struct bsp_line *l = &c->lines[i];
        const double from = height(plane, l->end[0]), to = height(plane, l->end[1]);
        lines_behind += from <= 0 || to <= 0;
        lines_before += from > 0 || to > 0;
    }
    struct cost cost = {.by_count = (behind * behind + before * before) / samples / samples};
    cost.by_lines = lines < LINES_ENOUGH
                        ? cost.by_count
                        : (behind * lines_behind + before * lines_before) / samples / lines;
    cost.by_lines += STEP_COST / (double)cell->count;
    return cost;
}

bool bsp_choose(struct bsp_chooser *c, const struct bsp_cell *cell, struct bsp_plane *chosen)
{
    uint32_t sample[SAMPLE];
    const uint32_t samples = (uint32_t)min_size(cell->count, SAMPLE);
    struct cost least = {WORTH_IT, WORTH_IT};
    struct bsp_plane halving = {{0}, 0};
    if (cell->count <= LEAF_MAX)
        return false;
    for (uint32_t i = 0; i < samples; i++)
        sample[i] = cell->count <= SAMPLE ? cell->prims[i] : any_of(c, cell);
    for (uint32_t i = 0; i < CANDIDATES; i++) {
        struct bsp_plane plane;
        if (!plane_of(c->mesh.v[any_of(c, cell)], i % 4, &plane))
            continue;
        const struct cost cost = judge(c, cell, sample, samples, &plane);
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
    return cell->count > MANY && least.by_count < WORTH_IT;
}
