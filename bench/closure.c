/* SPDX-License-Identifier: MIT */
#include "bench/closure.h"

#include <stdlib.h>
#include <string.h>

static uint64_t key(const struct closure_edge *e)
{
    const uint32_t lo = min_u32(e->from, e->to), hi = max_u32(e->from, e->to);
    return (uint64_t)lo << 32 | hi;
}

/* Partners become neighbours. */
static int compare(const void *a, const void *b)
{
    const uint64_t x = key(a), y = key(b);
    return x < y ? -1 : x > y;
}

size_t closure_open_edges(const struct mesh *m, struct arena *arena, struct closure_edge **open)
{
    const size_t count = 3 * (size_t)m->triangle_count;
    struct closure_edge *edges = arena_new(arena, struct closure_edge, count);
    for (size_t i = 0; i < count; i++)
        edges[i] = (struct closure_edge){m->indices[i], m->indices[i % 3 == 2 ? i - 2 : i + 1]};
    qsort(edges, count, sizeof *edges, compare);
    size_t left = 0; /* those kept are moved to the front */
    for (size_t i = 0; i < count;) {
        const struct closure_edge e = edges[i];
        int64_t surplus = 0; /* of e's direction */
        for (; i < count && key(&edges[i]) == key(&e); i++)
            surplus += edges[i].from == e.from ? 1 : -1;
        for (; surplus > 0; surplus--)
            edges[left++] = e;
        for (; surplus < 0; surplus++)
            edges[left++] = (struct closure_edge){e.to, e.from};
    }
    *open = edges;
    return left;
}

void closure_fill(struct mesh *m, struct arena *arena)
{
    struct closure_edge *open;
    const size_t count = closure_open_edges(m, arena, &open);
    if (!count)
        return;
    float *v = arena_new(arena, float, 3 * ((size_t)m->vertex_count + 1));
    uint32_t *t = arena_new(arena, uint32_t, 3 * ((size_t)m->triangle_count + count));
    memcpy(v, m->vertices, 3 * (size_t)m->vertex_count * sizeof *v);
    memcpy(t, m->indices, 3 * (size_t)m->triangle_count * sizeof *t);
    const uint32_t apex = m->vertex_count++;
    for (size_t k = 0; k < 3; k++) {
        double sum = 0;
        for (size_t i = 0; i < count; i++)
            sum += (double)v[3 * (size_t)open[i].from + k];
        v[3 * (size_t)apex + k] = (float)(sum / (double)count);
    }
    for (size_t i = 0; i < count; i++) {
        uint32_t *out = t + 3 * (size_t)m->triangle_count++;
        out[0] = open[i].to;
        out[1] = open[i].from;
        out[2] = apex;
    }
    m->vertices = v;
    m->indices = t;
}
