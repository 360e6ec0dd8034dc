/* SPDX-License-Identifier: MIT */
#include "bench/accel/build.h"

#include "common/arena.h"
#include "common/clock.h"
#include "common/trace/tri.h"

enum { LOOK = 64 /* triangles */ };

struct accel_box build_empty(void)
{
    const float inf = __builtin_inff();
    return (struct accel_box){{inf, inf, inf}, {-inf, -inf, -inf}};
}

void build_cover(struct accel_box *b, const struct accel_box *by)
{
    for (int k = 0; k < 3; k++) {
        b->lo[k] = by->lo[k] < b->lo[k] ? by->lo[k] : b->lo[k];
        b->hi[k] = by->hi[k] > b->hi[k] ? by->hi[k] : b->hi[k];
    }
}

struct accel_box build_box(const float v[3][3])
{
    struct stage_triangle t;
    memcpy(&t, v, sizeof t);
    vec3 lo, hi;
    tri_bounds(&t, &lo, &hi);
    struct accel_box box;
    vec3_store(box.lo, lo);
    vec3_store(box.hi, hi);
    return box;
}

struct accel_box build_bounds(struct accel_mesh mesh)
{
    struct accel_box bounds = build_empty();
    for (uint32_t i = 0; i < mesh.count; i++) {
        const struct accel_box box = build_box(mesh.v[i]);
        build_cover(&bounds, &box);
    }
    return mesh.count ? bounds : (struct accel_box){{0}, {0}};
}

struct accel_box *build_boxes(struct accel_mesh mesh)
{
    struct accel_box *boxes = arena_malloc(mesh.count, sizeof *boxes);
    for (uint32_t i = 0; i < mesh.count; i++)
        boxes[i] = build_box(mesh.v[i]);
    return boxes;
}

float build_half_area(const struct accel_box *b)
{
    const float x = b->hi[0] - b->lo[0], y = b->hi[1] - b->lo[1], z = b->hi[2] - b->lo[2];
    return x < 0 ? 0 : x * y + y * z + z * x;
}

void *build_grow(void *old, size_t *room, size_t count, size_t size)
{
    if (count <= *room)
        return old;
    *room = count < 1024 ? 1024 : count + count / 2;
    return arena_realloc(old, *room, size);
}

void build_push(struct accel_list *list, uint32_t number)
{
    list->at = build_grow(list->at, &list->room, list->count + 1, sizeof *list->at);
    list->at[list->count++] = number;
}

uint32_t build_push_all(struct accel_list *list, const struct accel_list *from, size_t begin,
                        size_t end)
{
    const uint32_t first = (uint32_t)list->count;
    for (size_t i = begin; i < end; i++)
        build_push(list, from->at[i]);
    return first;
}

bool build_within(const struct accel_limits *limits, uint64_t bytes, size_t triangles,
                  struct err *err)
{
    if (bytes > limits->bytes)
        return err_set(err, ERR_LIMIT, "more than %llu MiB",
                       (unsigned long long)(limits->bytes >> 20));
    if (triangles >= LOOK && clock_thread_cpu_us() > limits->until_us)
        return err_set(err, ERR_LIMIT, "out of time");
    return true;
}
