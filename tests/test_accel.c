/* Every structure of bench/accel against a loop over all triangles, bit by bit: t, number, weights;
 * and the core's own among them. SPDX-License-Identifier: MIT */
#include "bench/accel/accel.h"

#include <math.h>
#include <string.h>

#include "bench/accel/query.h"
#include "common/clock.h"
#include "tests/soup.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum { TRIANGLES_MAX = 400 };

static const struct accel_limits plenty = {1u << 30, INT64_MAX};

struct soup {
    float v[TRIANGLES_MAX][3][3];
    uint32_t count;
};

struct tally {
    int rays, hits, wrong[ACCEL_KINDS];
};

static struct accel_mesh mesh_of(const struct soup *s)
{
    return (struct accel_mesh){(const float(*)[3][3])s->v, s->count};
}

static bool loop_hit(struct accel_mesh mesh, const struct ray *ray, struct ray_hit *hit)
{
    struct query q;
    const struct accel_box nowhere = {{0}, {0}};
    if (!query_make(&q, mesh, &nowhere, ray))
        return false;
    for (uint32_t i = 0; i < mesh.count; i++)
        query_triangle(&q, i);
    return query_done(&q, hit);
}

/* `size` is of the scene. Rays start anywhere about it, one in four on a vertex; they go anywhere,
 * to a vertex, to a point of an edge or a face, or along an axis; some end early. */
static struct ray any_ray(struct dice *d, const struct soup *s, double size)
{
    vec3 origin = soup_point(d, 1.5 * size), dir = soup_direction(d);
    const uint32_t how = dice_bits(d) % 8, axis = dice_bits(d) % 3;
    const float(*v)[3] = s->v[dice_bits(d) % max_u32(s->count, 1)];
    const float u = dice_float(d), w = dice_float(d) * (1 - u);
    if (s->count && dice_bits(d) % 4 == 0)
        origin = vec3_load(s->v[dice_bits(d) % s->count][dice_bits(d) % 3]);
    if (how < 2)
        dir = vec3_load(v[0]) - origin;
    else if (how < 3)
        dir = vec3_load(v[0]) * u + vec3_load(v[1]) * (1 - u) - origin;
    else if (how < 6)
        dir = vec3_load(v[0]) * (1 - u - w) + vec3_load(v[1]) * u + vec3_load(v[2]) * w - origin;
    else if (how < 7)
        for (uint32_t k = 0; k < 3; k++)
            dir[k] = k == axis ? dir[k] : (dice_bits(d) & 1) ? 0.0f : -0.0f;
    const bool ends = dice_bits(d) % 8 == 0;
    return (struct ray){origin, dir, ends ? (float)dice_range(d, 0, 2) : INFINITY, 0, 0};
}

static bool same(bool a_hit, const struct ray_hit *a, bool b_hit, const struct ray_hit *b)
{
    return a_hit == b_hit && (!a_hit || memcmp(a, b, offsetof(struct ray_hit, place)) == 0);
}

static void try_kind(const struct soup *s, enum accel_kind kind, struct dice d, double size,
                     int rays, struct tally *n)
{
    struct accel a;
    struct err err;
    if (!accel_build(&a, kind, mesh_of(s), &plenty, &err)) {
        n->wrong[kind] += rays;
        diag("%s: %s", accel_name(kind), err.text);
        return;
    }
    for (int i = 0; i < rays; i++) {
        const struct ray ray = any_ray(&d, s, size);
        struct ray_hit found = {0}, truth = {0};
        const bool hit = loop_hit(mesh_of(s), &ray, &truth);
        n->rays++;
        n->hits += hit;
        n->wrong[kind] += !same(accel_hit(&a, &ray, &found), &found, hit, &truth);
    }
    accel_release(&a);
}

static void try_all(const struct soup *s, struct dice *d, double size, bool degenerate,
                    struct tally *n)
{
    for (int kind = degenerate ? ACCEL_OURS + 1 : ACCEL_OURS; kind < ACCEL_KINDS; kind++)
        try_kind(s, (enum accel_kind)kind, *d, size, 2000 / STAT_SLOW, n);
    dice_bits(d);
}

static void judge(const struct tally *n, const char *what)
{
    int wrong = 0;
    for (int kind = 0; kind < ACCEL_KINDS; kind++) {
        wrong += n->wrong[kind];
        if (n->wrong[kind])
            diag("%s: %d wrong", accel_name((enum accel_kind)kind), n->wrong[kind]);
    }
    ok(wrong == 0 && n->hits > n->rays / 20,
       "%s: every structure finds the loop's hit, bit by bit (%d of %d rays hit, %d wrong)", what,
       n->hits, n->rays, wrong);
}

static void fill_random(struct soup *s, struct dice *d, uint32_t count, double spread, double size)
{
    s->count = count;
    for (uint32_t i = 0; i < count; i++) {
        const vec3 at = soup_point(d, spread);
        for (int k = 0; k < 3; k++)
            vec3_store(s->v[i][k], at + soup_point(d, size));
    }
}

static void test_random(void)
{
    static const double sizes[] = {0.01, 0.1, 1};
    struct tally n = {0};
    for (uint64_t seed = 0; seed < 12; seed++) {
        struct dice d = dice_make(seed);
        struct soup s;
        fill_random(&s, &d, 200, 1, sizes[seed % 3]);
        try_all(&s, &d, 1, false, &n);
    }
    judge(&n, "random triangles");
}

static void test_few(void)
{
    struct tally n = {.hits = 1000};
    for (uint32_t count = 0; count < 12; count++) {
        struct dice d = dice_make(50 + count);
        struct soup s;
        fill_random(&s, &d, count, 0.5, 0.5);
        try_all(&s, &d, 1, false, &n);
    }
    judge(&n, "0 to 11 triangles");
}

/* Halves of unit squares on whole coordinates: equal distances, shared edges, boxes without
 * thickness, cells whose borders are the triangles'. */
static void fill_lattice(struct soup *s, struct dice *d, uint32_t count, uint32_t axes)
{
    s->count = count;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t axis = dice_bits(d) % axes;
        float corner[3];
        for (int k = 0; k < 3; k++)
            corner[k] = axes == 1 && k == 0 ? 0 : (float)((int)(dice_bits(d) % 8) - 4) / 4;
        for (uint32_t j = 0; j < 3; j++) {
            memcpy(s->v[i][j], corner, sizeof corner);
            if (j > 0)
                s->v[i][j][(axis + j) % 3] += 0.25f;
        }
    }
}

static void test_lattice(void)
{
    struct tally n = {0}, flat = {0};
    for (uint64_t seed = 0; seed < 8; seed++) {
        struct dice d = dice_make(100 + seed);
        struct soup s;
        fill_lattice(&s, &d, TRIANGLES_MAX, 3);
        try_all(&s, &d, 1, false, &n);
        fill_lattice(&s, &d, TRIANGLES_MAX, 1);
        try_all(&s, &d, 1, false, &flat);
    }
    judge(&n, "a lattice");
    judge(&flat, "all in one plane");
}

/* A closed surface, to whose edges and vertices rays are aimed, far from the origin and not. */
static void test_surface(void)
{
    static const float offsets[] = {0, 1000};
    for (size_t o = 0; o < countof(offsets); o++) {
        struct tally n = {0};
        for (uint64_t seed = 0; seed < 4; seed++) {
            struct scenes ball;
            struct dice d = dice_make(200 + seed);
            struct soup s = {.count = 0};
            scenes_init(&ball, 1, 1);
            scenes_ball(&ball, 0, vec3_make(offsets[o], 0, 0), 1, 10, 0.2f, false);
            const struct mesh *m = &ball.scene.meshes[0];
            for (uint32_t i = 0; i < m->triangle_count && s.count < TRIANGLES_MAX; i++) {
                for (uint32_t k = 0; k < 3; k++)
                    memcpy(s.v[s.count][k], m->vertices + 3 * (size_t)m->indices[3 * i + k],
                           sizeof s.v[0][0]);
                s.count += memcmp(s.v[s.count][0], s.v[s.count][1], sizeof s.v[0][0]) != 0 &&
                           memcmp(s.v[s.count][1], s.v[s.count][2], sizeof s.v[0][0]) != 0 &&
                           memcmp(s.v[s.count][2], s.v[s.count][0], sizeof s.v[0][0]) != 0;
            }
            try_all(&s, &d, 1 + (double)offsets[o], false, &n);
            scenes_release(&ball);
        }
        judge(&n, offsets[o] > 0 ? "a closed surface, a thousand away" : "a closed surface");
    }
}

/* A tiny dense heap in a large coarse room. */
static void test_stadium(void)
{
    struct tally n = {0};
    for (uint64_t seed = 0; seed < 6; seed++) {
        struct dice d = dice_make(300 + seed);
        struct soup s;
        fill_random(&s, &d, 300, 0.01, 0.001);
        const uint32_t heap = s.count;
        for (; s.count < heap + 12; s.count++)
            for (int k = 0; k < 3; k++)
                vec3_store(s.v[s.count][k], soup_point(&d, 10));
        try_all(&s, &d, 0.02, false, &n);
    }
    judge(&n, "a tiny heap in a large room");
}

/* Points, lines, the same triangle many times, slivers. */
static void test_degenerate(void)
{
    struct tally n = {0};
    for (uint64_t seed = 0; seed < 12; seed++) {
        struct dice d = dice_make(400 + seed);
        struct soup s;
        fill_random(&s, &d, 200, seed % 3 ? 1 : 0, 0.3);
        for (uint32_t i = 1; i < s.count; i++)
            switch (dice_bits(&d) % 6) {
            case 0:
                memcpy(s.v[i][1], s.v[i][0], sizeof s.v[i][0]);
                break;
            case 1:
                memcpy(s.v[i][1], s.v[i][0], sizeof s.v[i][0]);
                memcpy(s.v[i][2], s.v[i][0], sizeof s.v[i][0]);
                break;
            case 2:
                for (int k = 0; k < 3; k++)
                    s.v[i][2][k] = 2 * s.v[i][1][k] - s.v[i][0][k];
                break;
            case 3:
                memcpy(s.v[i], s.v[dice_bits(&d) % i], sizeof s.v[i]);
                break;
            case 4:
                for (int k = 0; k < 3; k++)
                    s.v[i][2][k] = s.v[i][1][k] * (1 + 0x1p-20f);
                break;
            }
        try_all(&s, &d, 1, true, &n);
    }
    judge(&n, "degenerate and coincident triangles");
    memset(&n, 0, sizeof n);
    struct dice d = dice_make(500);
    struct soup s;
    fill_random(&s, &d, 1, 0, 1);
    for (s.count = 1; s.count < TRIANGLES_MAX; s.count++)
        memcpy(s.v[s.count], s.v[0], sizeof s.v[0]);
    try_all(&s, &d, 1, false, &n);
    judge(&n, "400 times the same triangle");
}

static void test_no_ray(void)
{
    struct dice d = dice_make(600);
    struct soup s;
    fill_random(&s, &d, 50, 0.1, 1);
    int wrong = 0;
    for (int kind = 0; kind < ACCEL_KINDS; kind++) {
        struct accel a;
        struct err err;
        struct ray_hit hit;
        if (!accel_build(&a, (enum accel_kind)kind, mesh_of(&s), &plenty, &err)) {
            wrong++;
            continue;
        }
        for (int i = 0; i < 8; i++) {
            struct ray ray = {vec3_make(0, 0, -3), vec3_make(0, 0, 1), INFINITY, 0, 0};
            if (i < 3)
                ray.origin[i] = NAN;
            else if (i < 6)
                ray.dir[i - 3] = i == 4 ? NAN : INFINITY;
            else if (i == 6)
                ray.dir = vec3_make(0, -0.0f, 0);
            else
                ray.t_max = NAN;
            wrong += accel_hit(&a, &ray, &hit);
        }
        accel_release(&a);
    }
    ok(wrong == 0, "rays that are none hit nothing (%d did)", wrong);
}

/* Builders that cannot know their size stop where they are told. */
static void test_limits(void)
{
    static const enum accel_kind kinds[] = {ACCEL_GRID, ACCEL_KDTREE, ACCEL_OCTREE, ACCEL_BSP,
                                            ACCEL_BVH2};
    struct dice d = dice_make(700);
    struct soup s;
    fill_random(&s, &d, TRIANGLES_MAX, 1, 0.1);
    for (size_t i = 0; i < countof(kinds); i++) {
        struct accel a;
        struct err small = {0}, late = {0};
        const struct accel_limits little = {1000, INT64_MAX};
        const struct accel_limits over = {1u << 30, clock_thread_cpu_us() - 1};
        ok(!accel_build(&a, kinds[i], mesh_of(&s), &little, &small) && small.code == ERR_LIMIT &&
               !accel_build(&a, kinds[i], mesh_of(&s), &over, &late) && late.code == ERR_LIMIT,
           "%s gives up: \"%s\", \"%s\"", accel_name(kinds[i]), small.text, late.text);
    }
}

int main(void)
{
    test_random();
    test_few();
    test_lattice();
    test_surface();
    test_stadium();
    test_degenerate();
    test_no_ray();
    test_limits();
    return tap_done();
}
