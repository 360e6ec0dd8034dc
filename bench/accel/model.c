/* SPDX-License-Identifier: MIT */
#include "bench/accel/model.h"

#include <assert.h>
#include <math.h>

#include "common/trace/surface.h"
#include "common/trace/warp.h"
#include "tests/dice.h"

enum {
    SQUARE = 4,    /* pixels on a side of what is traced together */
    FRAME = 512,   /* pixels on a side of the image */
    HALL_CUTS = 2, /* a wall of the hall is so many squares wide */
};

static const float hall_m[3] = {100, 40, 100};

const char *model_name(enum model_kind kind)
{
    static const char *const names[] = {"ball", "stadium"};
    _Static_assert(countof(names) == MODEL_KINDS, "a name for each kind");
    return names[kind];
}

/* --- triangles --- */

struct filler {
    float (*v)[3][3];
    uint32_t count;
};

static struct filler filler_make(size_t triangles, struct arena *arena)
{
    return (struct filler){arena_alloc(arena, triangles, sizeof(float[3][3]), alignof(float)), 0};
}

static void add(struct filler *f, vec3 a, vec3 b, vec3 c)
{
    vec3_store(f->v[f->count][0], a);
    vec3_store(f->v[f->count][1], b);
    vec3_store(f->v[f->count][2], c);
    f->count++;
}

/* 2 n^2 triangles. */
static void add_square(struct filler *f, vec3 corner, vec3 x, vec3 y, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = 0; j < n; j++) {
            const float at[4] = {(float)i / (float)n, (float)(i + 1) / (float)n,
                                 (float)j / (float)n, (float)(j + 1) / (float)n};
            const vec3 a = corner + x * at[0], b = corner + x * at[1];
            add(f, a + y * at[2], b + y * at[2], b + y * at[3]);
            add(f, a + y * at[2], b + y * at[3], a + y * at[3]);
        }
}

/* A unit direction, moved out and in by waves. */
static vec3 bumpy(vec3 d)
{
    const vec3 u = vec3_unit(d);
    return u * (1 + 0.06f * sinf(9 * u[0]) * sinf(9 * u[1]) * sinf(9 * u[2]));
}

/* The octahedron, each face cut into n^2, blown up to a ball: 8 n^2 triangles. */
static void add_ball(struct filler *f, vec3 center, float radius, uint32_t n)
{
    for (uint32_t face = 0; face < 8; face++) {
        const vec3 x = vec3_make(face & 1 ? -1 : 1, 0, 0), y = vec3_make(0, face & 2 ? -1 : 1, 0);
        const vec3 z = vec3_make(0, 0, face & 4 ? -1 : 1);
        for (uint32_t i = 0; i < n; i++)
            for (uint32_t j = 0; i + j < n; j++) {
                vec3 p[2][2];
                for (uint32_t k = 0; k < 4; k++) {
                    const float a = (float)(i + (k & 1)), b = (float)(j + (k >> 1));
                    p[k & 1][k >> 1] =
                        center + bumpy(x * a + y * b + z * ((float)n - a - b)) * radius;
                }
                add(f, p[0][0], p[1][0], p[0][1]);
                if (i + j + 1 < n)
                    add(f, p[1][0], p[1][1], p[0][1]);
            }
    }
}

static void add_hall(struct filler *f)
{
    for (int k = 0; k < 3; k++)
        for (int side = 0; side < 2; side++) {
            vec3 corner = vec3_make(-hall_m[0] / 2, 0, -hall_m[2] / 2), x = {0}, y = {0};
            corner[k] += side ? hall_m[k] : 0;
            x[(k + 1) % 3] = hall_m[(k + 1) % 3];
            y[(k + 2) % 3] = hall_m[(k + 2) % 3];
            add_square(f, corner, x, y, HALL_CUTS);
        }
}

static uint32_t root(uint32_t squares, uint32_t least)
{
    return max_u32((uint32_t)lround(sqrt(squares)), least);
}

/* The ball's bumps do not reach the floor. */
struct accel_mesh model_make(enum model_kind kind, uint32_t triangles, struct arena *arena)
{
    struct filler f = {0};
    uint32_t n, m;
    switch (kind) {
    case MODEL_BALL:
        n = root(triangles / 16, 1);
        m = root(triangles / 4, 1);
        f = filler_make(8 * (size_t)n * n + 2 * (size_t)m * m, arena);
        add_ball(&f, vec3_make(0, 1.1f, 0), 1, n);
        add_square(&f, vec3_make(-2, 0, -2), vec3_make(0, 0, 4), vec3_make(4, 0, 0), m);
        break;
    case MODEL_STADIUM:
        n = root((triangles - min_u32(triangles, 12 * HALL_CUTS * HALL_CUTS)) / 8, 1);
        f = filler_make(8 * (size_t)n * n + 12 * HALL_CUTS * HALL_CUTS, arena);
        add_ball(&f, vec3_make(0, 0.55f, 0), 0.5f, n);
        add_hall(&f);
        break;
    }
    return (struct accel_mesh){(const float(*)[3][3])f.v, f.count};
}

/* --- rays --- */

struct view {
    vec3 from, ahead, right, up;
};

/* The ball takes up about half of the picture. */
static struct view view_of(enum model_kind kind)
{
    const float size = kind == MODEL_BALL ? 1 : 0.5f;
    const vec3 at = vec3_make(0, 1.05f * size, 0), from = vec3_make(1.1f, 2.6f, 2.9f) * size;
    const vec3 ahead = vec3_unit(at - from);
    const vec3 right = vec3_unit(vec3_cross(ahead, vec3_make(0, 1, 0)));
    return (struct view){from, ahead, right * 0.42f, vec3_cross(right, ahead) * 0.42f};
}

static struct ray camera_ray(const struct view *v, uint32_t x, uint32_t y, struct dice *d)
{
    const float a = 2 * ((float)x + dice_float(d)) / FRAME - 1;
    const float b = 2 * ((float)y + dice_float(d)) / FRAME - 1;
    return (struct ray){v->from, v->ahead + v->right * a + v->up * b, INFINITY, 0, 0};
}

static struct ray bounce(const struct surface *s, vec3 seen_from, struct dice *d)
{
    const bool behind = vec3_dot(s->ng, seen_from) < 0;
    const struct warp_frame frame = warp_frame_make(behind ? -s->ng : s->ng);
    const struct square q = {dice_float(d), dice_float(d)};
    return surface_leave(s, warp_to_world(&frame, warp_cosine(q)));
}

struct ray *model_rays(enum model_kind kind, const struct accel *ours, uint32_t passes,
                       struct arena *arena)
{
    const struct view view = view_of(kind);
    const uint32_t squares = passes * (MODEL_PASS / 2 / (SQUARE * SQUARE));
    struct ray *rays = arena_new(arena, struct ray, (size_t)passes * MODEL_PASS), *r = rays;
    struct surface last = {
        0}; /* a camera ray that leaves the scene is followed by one more bounce of it */
    struct dice d = dice_make(1);
    assert(ours->kind == ACCEL_OURS);
    for (uint32_t i = 0; i < squares; i++) {
        const uint32_t x = dice_bits(&d) % (FRAME / SQUARE) * SQUARE;
        const uint32_t y = dice_bits(&d) % (FRAME / SQUARE) * SQUARE;
        for (uint32_t k = 0; k < SQUARE * SQUARE; k++) {
            struct ray_hit hit;
            r[0] = camera_ray(&view, x + k % SQUARE, y + k / SQUARE, &d);
            if (accel_hit(ours, r, &hit))
                last = surface_at(ours->ours.stage, r, &hit);
            r[1] = bounce(&last, view.from - last.p, &d);
            r += 2;
        }
    }
    return rays;
}
