/* The tree against two loops over all primitives: the core's own test of each (equal to the last
 * bit) and an oracle in double; garbage; what hits depend on. SPDX-License-Identifier: MIT */
#include "common/trace/bvh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/trace/prep.h"
#include "tests/naive_hit.h"
#include "tests/soup.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

struct tally {
    int rays, hits, wrong_bits, wrong_any, doubtful, wrong_oracle;
};

static void try_ray(const struct stage *s, struct ray ray, struct tally *n)
{
    struct ray_hit tree = {0}, loop = {0};
    const bool hit = bvh_hit_closest(s, &ray, &tree), also = soup_closest(s, &ray, &loop);
    n->rays++;
    n->hits += hit;
    n->wrong_bits += hit != also || (hit && memcmp(&tree, &loop, sizeof tree) != 0);
    n->wrong_any += bvh_hit_any(s, &ray) != hit;
    const struct naive_hit oracle = naive_hit_closest(s, &ray);
    n->doubtful += oracle.doubtful;
    if (!oracle.doubtful)
        n->wrong_oracle +=
            hit != oracle.hit ||
            (hit && fabs((double)tree.t - oracle.t) > 1e-5 * oracle.t + 1e-6 * oracle.t_reach);
}

static void judge(const struct tally *n, const char *what)
{
    ok(n->hits > n->rays / 20, "%s: %d of %d rays hit", what, n->hits, n->rays);
    ok(n->wrong_bits == 0, "%s: closest hit is the loop's, bit by bit (%d not)", what,
       n->wrong_bits);
    ok(n->wrong_any == 0, "%s: any hit where there is a closest (%d not)", what, n->wrong_any);
    ok(n->doubtful < n->rays / 10 && n->wrong_oracle == 0,
       "%s: the oracle in double agrees within 1e-5 t + 1e-6 reach (%d not; %d graze)", what,
       n->wrong_oracle, n->doubtful);
}

/* Half of the rays aim at a point of some primitive's bounds; one in eight ends early. */
static struct ray random_ray(struct dice *d, const struct stage *s, double half_side)
{
    const vec3 origin = soup_point(d, half_side);
    vec3 dir = soup_direction(d);
    if (dice_bits(d) & 1 && s->blocks.count) {
        const uint32_t first = STAGE_LANES * (dice_bits(d) % (uint32_t)s->blocks.count);
        const struct stage_triangle t = stage_triangle_at(s, first, STAGE_NONE);
        const float u = dice_float(d), v = dice_float(d) * (1 - u);
        dir = vec3_load(t.v[0]) * (1 - u - v) + vec3_load(t.v[1]) * u + vec3_load(t.v[2]) * v -
              origin;
    }
    const bool ends = dice_bits(d) % 8 == 0;
    return (struct ray){origin, dir, ends ? (float)dice_range(d, 0, 2) : INFINITY, 0, 0};
}

static void fill(struct scenes *s, struct dice *d, double size, int triangles, int others)
{
    const uint32_t m = scenes_diffuse(s, rgb_gray(0.5f));
    float(*v)[3] = soup_vertices(s, (uint32_t)triangles);
    for (int i = 0; i < triangles; i++) {
        const vec3 at = soup_point(d, 1);
        for (int k = 0; k < 3; k++)
            vec3_store(v[3 * i + k], at + soup_point(d, size));
    }
    soup_mesh(s, m, v, (uint32_t)triangles);
    for (int i = 0; i < others; i++) {
        const float radius = (float)(size * dice_unit(d)) + 1e-3f;
        scenes_sphere(s, m, soup_point(d, 1), radius);
        scenes_disc(s, m, soup_point(d, 1), soup_direction(d), radius);
        const vec3 end = soup_point(d, 1);
        scenes_cylinder(s, m, end, end + soup_point(d, size), radius);
        scenes_quad(s, m, soup_point(d, 1), soup_point(d, size), soup_point(d, size));
    }
}

static void test_mixes(void)
{
    static const double sizes[] = {0.01, 0.1, 1};
    struct tally n = {0};
    for (uint64_t seed = 0; seed < 12; seed++) {
        struct dice d = dice_make(seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        fill(&s, &d, sizes[seed % 3], 100, 20);
        const struct stage *stage = scenes_stage(&s);
        for (uint32_t i = 0; i < stat_tries(10000, 85000); i++)
            try_ray(stage, random_ray(&d, stage, 1.5), &n);
        scenes_release(&s);
    }
    judge(&n, "random mixes");
}

/* Everything in few planes, on few coordinates: equal distances, shared edges, flat boxes. */
static void test_grid(void)
{
    struct tally n = {0};
    for (uint64_t seed = 0; seed < 12; seed++) {
        struct dice d = dice_make(100 + seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        const uint32_t m = scenes_diffuse(&s, rgb_gray(0.5f));
        for (int i = 0; i < 60; i++) {
            vec3 corner = {0}, side[2] = {{0}, {0}};
            for (int k = 0; k < 3; k++)
                corner[k] = (float)(int)dice_range(&d, -3, 3) / 3;
            const uint32_t axis = dice_bits(&d) % 3;
            for (uint32_t k = 0; k < 2; k++)
                side[k][(axis + 1 + k) % 3] = (float)(1 + dice_bits(&d) % 2) / 3;
            scenes_quad(&s, m, corner, side[0], side[1]);
        }
        const struct stage *stage = scenes_stage(&s);
        for (uint32_t i = 0; i < stat_tries(10000, 85000); i++)
            try_ray(stage, random_ray(&d, stage, 1.5), &n);
        scenes_release(&s);
    }
    judge(&n, "quads on a grid");
}

static const struct stage *stage_of(struct scenes *s, float (*v)[3], uint32_t triangles)
{
    soup_mesh(s, scenes_diffuse(s, rgb_gray(0.5f)), v, triangles);
    return scenes_stage(s);
}

static void test_coincident(void)
{
    enum { COPIES = 100000 };
    struct scenes s;
    scenes_init(&s, 1, 1);
    const float corner[3][3] = {{-1, -1, 0.1f}, {1, -1, 0.2f}, {0, 1, 0.3f}};
    float(*v)[3] = soup_vertices(&s, COPIES);
    for (uint32_t i = 0; i < 3 * COPIES; i++)
        memcpy(v[i], corner[i % 3], sizeof v[i]);
    const struct stage *stage = stage_of(&s, v, COPIES);
    struct dice d = dice_make(1);
    int wrong = 0;
    for (int i = 0; i < 20; i++) {
        const vec3 origin = soup_point(&d, 0.3) + vec3_make(0, 0, 2);
        const struct ray ray = {origin, vec3_make(0, -0.1f, 0) - origin, INFINITY, 0, 0};
        struct ray_hit hit;
        wrong += !bvh_hit_closest(stage, &ray, &hit) || hit.prim != 0 || !bvh_hit_any(stage, &ray);
    }
    ok(wrong == 0, "F-14: of 1e5 coincident triangles the first is hit");
    ok(stage->bvh_depth <= 32, "1e5 coincident triangles make a tree of depth %u",
       stage->bvh_depth);
    scenes_release(&s);
}

/* The later shape lies on the earlier one; neither order of traversal is favoured by the seeds. */
static void test_ties(void)
{
    int wrong = 0, hits = 0;
    for (uint64_t seed = 0; seed < 50; seed++) {
        struct dice d = dice_make(seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        const uint32_t m = scenes_diffuse(&s, rgb_gray(0.5f));
        const vec3 at = soup_point(&d, 1), a = soup_point(&d, 1), b = soup_point(&d, 1);
        const int copies = 2 + (int)(dice_bits(&d) % 20);
        for (int i = 0; i < copies; i++)
            scenes_quad(&s, m, at, a, b);
        const struct stage *stage = scenes_stage(&s);
        for (int i = 0; i < 200; i++) {
            const vec3 target = at + a * dice_float(&d) + b * dice_float(&d);
            const vec3 origin = soup_point(&d, 3);
            const struct ray ray = {origin, target - origin, INFINITY, 0, 0};
            struct ray_hit hit;
            const bool found = bvh_hit_closest(stage, &ray, &hit);
            hits += found;
            wrong += found && hit.prim > 1;
        }
        scenes_release(&s);
    }
    ok(hits > 9000 && wrong == 0, "F-14: coplanar duplicates: the smaller number is hit (%d of %d not)",
       wrong, hits);
}

static float garbage_number(struct dice *d)
{
    static const float odd[] = {0,     -0.0f,  1,        -1,        1e-38f, 1e-45f,
                                3e38f, -3e38f, INFINITY, -INFINITY, NAN,    1e10f};
    const uint32_t i = dice_bits(d) % (8 * countof(odd));
    return i < countof(odd) ? odd[i] : (float)dice_range(d, -1, 1);
}

static struct ray garbage_ray(struct dice *d)
{
    struct ray ray = {soup_point(d, 2), soup_direction(d), INFINITY, 0, 0};
    const uint32_t k = dice_bits(d) % 12;
    if (k < 3)
        ray.origin[k] = garbage_number(d);
    else if (k < 6)
        ray.dir[k - 3] = garbage_number(d);
    else if (k == 6)
        ray.t_max = garbage_number(d);
    return ray;
}

/* Vertices near each other or not, repeated, collinear, without bounds or no numbers at all. */
static void garbage_triangle(struct dice *d, float (*v)[3], uint32_t i)
{
    for (uint32_t k = 0; k < 3; k++)
        for (int j = 0; j < 3; j++)
            v[3 * i + k][j] = (float)dice_range(d, -1, 1);
    switch (dice_bits(d) % 8) {
    case 0:
        memcpy(v[3 * i + 1], v[3 * i], sizeof v[0]);
        break;
    case 1:
        for (int j = 0; j < 3; j++)
            v[3 * i + 2][j] = 2 * v[3 * i + 1][j] - v[3 * i][j];
        break;
    case 2:
        v[3 * i + dice_bits(d) % 3][dice_bits(d) % 3] = garbage_number(d);
        break;
    case 3:
        if (i)
            memcpy(v[3 * i], v[3 * (dice_bits(d) % i)], 3 * sizeof v[0]);
        break;
    }
}

static void test_garbage(void)
{
    const uint64_t seeds = stat_is_long() ? 1000 : 300;
    int wrong = 0, hits = 0;
    uint32_t depth = 0;
    for (uint64_t seed = 0; seed < seeds; seed++) {
        struct dice d = dice_make(1000 + seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        const uint32_t count = seed < 6 ? (uint32_t)seed : 1 + dice_bits(&d) % 64;
        float(*v)[3] = soup_vertices(&s, count);
        for (uint32_t i = 0; i < count; i++)
            garbage_triangle(&d, v, i);
        const struct stage *stage = stage_of(&s, v, count);
        depth = max_u32(depth, stage->bvh_depth);
        for (int i = 0; i < 200; i++) {
            const struct ray ray = garbage_ray(&d);
            struct ray_hit tree = {0}, loop = {0};
            const bool hit = bvh_hit_closest(stage, &ray, &tree);
            hits += hit;
            wrong += hit != soup_closest(stage, &ray, &loop) ||
                     (hit && memcmp(&tree, &loop, sizeof tree) != 0) ||
                     hit != bvh_hit_any(stage, &ray) ||
                     (hit && !(tree.t > 0 && tree.t < ray.t_max));
        }
        scenes_release(&s);
    }
    ok(wrong == 0 && hits > 3000, "F-14: garbage, %d seeds: the tree is the loop (%d of %d hits not)",
       (int)seeds, wrong, hits);
    ok(depth <= BVH_MAX_DEPTH, "garbage: depth %u of at most %d", depth, BVH_MAX_DEPTH);
}

/* Triangles that are no triangles hide none of those among which they are. */
static void test_holes(void)
{
    enum { COUNT = 2000 };
    struct scenes s, clean;
    struct dice d = dice_make(14);
    scenes_init(&s, 1, 1);
    scenes_init(&clean, 1, 1);
    float(*v)[3] = soup_vertices(&s, 2 * COUNT), (*w)[3] = soup_vertices(&clean, COUNT);
    for (uint32_t i = 0; i < COUNT; i++) {
        const vec3 at = soup_point(&d, 1);
        for (uint32_t k = 0; k < 3; k++) {
            vec3_store(w[3 * i + k], at + soup_point(&d, 0.1));
            memcpy(v[6 * i + 3 + k], w[3 * i + k], sizeof v[0]);
            memcpy(v[6 * i + k], w[3 * i + k], sizeof v[0]);
        }
        v[6 * i + dice_bits(&d) % 3][dice_bits(&d) % 3] = i & 1 ? NAN : INFINITY;
    }
    const struct stage *holed = stage_of(&s, v, 2 * COUNT), *whole = stage_of(&clean, w, COUNT);
    int hits = 0, wrong = 0;
    for (int i = 0; i < 20000 / STAT_SLOW; i++) {
        const struct ray ray = random_ray(&d, whole, 1.5);
        struct ray_hit a = {0}, b = {0};
        const bool hit = bvh_hit_closest(whole, &ray, &a);
        wrong += hit != bvh_hit_closest(holed, &ray, &b) || memcmp(&a, &b, sizeof a) != 0;
        hits += hit;
    }
    ok(hits > 1000 / STAT_SLOW && wrong == 0 && holed->dropped_nonfinite == COUNT,
       "F-14: %d triangles with NaN or infinity hide none of %d others (%d of %d hits)", COUNT, COUNT,
       wrong, hits);
    scenes_release(&s);
    scenes_release(&clean);
}

static double build_seconds(uint64_t seed, void (*make)(struct dice *, float (*)[3], uint32_t))
{
    enum { COUNT = 200000 };
    double least = HUGE_VAL;
    for (int run = 0; run < 3; run++) {
        struct scenes s;
        struct dice d = dice_make(seed);
        struct timespec a, b;
        scenes_init(&s, 1, 1);
        float(*v)[3] = soup_vertices(&s, COUNT);
        for (uint32_t i = 0; i < COUNT; i++)
            make(&d, v, i);
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &a);
        stage_of(&s, v, COUNT);
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &b);
        least = fmin(least, (double)(b.tv_sec - a.tv_sec) + 1e-9 * (double)(b.tv_nsec - a.tv_nsec));
        scenes_release(&s);
    }
    return least;
}

static void clean_triangle(struct dice *d, float (*v)[3], uint32_t i)
{
    const vec3 at = soup_point(d, 1);
    for (uint32_t k = 0; k < 3; k++)
        vec3_store(v[3 * i + k], at + soup_point(d, 0.01));
}

static void same_triangle(struct dice *d, float (*v)[3], uint32_t i)
{
    if (i)
        memcpy(v[3 * i], v[0], 3 * sizeof v[0]);
    else
        clean_triangle(d, v, i);
}

/* All but on one line, and from one end of the scene to the other. */
static void sliver(struct dice *d, float (*v)[3], uint32_t i)
{
    const float y = (float)dice_range(d, -1e-6, 1e-6);
    vec3_store(v[3 * i], vec3_make(-1, y, 0));
    vec3_store(v[3 * i + 1], vec3_make(1, y, 0));
    vec3_store(v[3 * i + 2], vec3_make(dice_float(d), y + 1e-7f, 0));
}

static void test_build_time(void)
{
    static const struct {
        const char *name;
        void (*make)(struct dice *, float (*)[3], uint32_t);
    } kinds[] = {{"coincident triangles", same_triangle},
                 {"slivers across each other", sliver},
                 {"garbage", garbage_triangle}};
    const double clean = build_seconds(1, clean_triangle);
    for (size_t i = 0; i < countof(kinds); i++) {
        const double seconds = build_seconds(2, kinds[i].make);
        ok(seconds <= 3 * clean, "F-14: a tree of %s takes at most 3 times as long as others (%.2f)",
           kinds[i].name, seconds / clean);
    }
}

/* Sizes that halve: every split cuts off one triangle, until the builder stops that. */
static void test_depth(void)
{
    enum { COUNT = 200 };
    struct scenes s;
    scenes_init(&s, 1, 1);
    float(*v)[3] = soup_vertices(&s, COUNT);
    float size = 0x1p60f;
    for (uint32_t i = 0; i < COUNT; i++, size /= 2)
        for (uint32_t k = 0; k < 3; k++)
            v[3 * i + k][0] = size * (float)(k + 1), v[3 * i + k][1] = k == 1 ? size : 0;
    const struct stage *stage = stage_of(&s, v, COUNT);
    ok(stage->bvh_depth > 8 && stage->bvh_depth <= BVH_MAX_DEPTH,
       "triangles of halving sizes: depth %u of at most %d", stage->bvh_depth, BVH_MAX_DEPTH);
    scenes_release(&s);
}

/* So many that the builder has parts, and one for the floor and what lies about it. */
static void test_floor(void)
{
    enum { COUNT = 100000 };
    struct scenes s;
    scenes_init(&s, 1, 1);
    struct dice d = dice_make(9);
    float(*v)[3] = soup_vertices(&s, COUNT);
    for (uint32_t i = 0; i < COUNT; i++) {
        const vec3 at = soup_point(&d, 1);
        for (uint32_t k = 0; k < 3; k++)
            vec3_store(v[3 * i + k], at + soup_point(&d, 0.01));
    }
    for (uint32_t i = 0; i < 6;
         i++) /* (-4, -4) to (4, 4), in the middle of the dust's lower side */
        vec3_store(v[i], vec3_make(i % 3 == 1 ? 4 : -4, -1, (i < 3) == (i % 3 == 2) ? 4 : -4));
    const struct stage *stage = stage_of(&s, v, COUNT);
    const struct bvh_node *root = stage_at(stage, stage->nodes);
    const struct stage_block *blocks = stage_at(stage, stage->blocks);
    const uint64_t first = stage->nodes.count * BVH_NODE_LINES;
    bool found = false;
    for (uint32_t k = 0; root->used >> k; k++)
        if (bvh_ref_kind(root->child[k]) == BVH_BLOCK) {
            const uint64_t lines = bvh_ref_index(root->child[k]) - first;
            for (uint32_t i = 0; i < STAGE_LANES; i++)
                found |= blocks[lines / BVH_BLOCK_LINES].prim[i] == 0;
        }
    ok(found, "a floor under dust: a child of the root, not of another node as large");
    scenes_release(&s);
}

static void test_determinism(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    struct dice d = dice_make(7);
    fill(&s, &d, 0.1, 500, 50);
    const struct stage *a = scenes_stage(&s), *b = scenes_stage(&s);
    ok(a != b && a->bytes == b->bytes && memcmp(a, b, a->bytes) == 0,
       "building twice gives the same bytes");
    unsigned char *elsewhere = aligned_alloc(64, (a->bytes + 127) / 64 * 64);
    memcpy(elsewhere, a, a->bytes);
    memset((void *)(uintptr_t)b, 0, sizeof *b);
    const struct stage *moved = (const struct stage *)(const void *)elsewhere;
    int wrong = 0;
    for (int i = 0; i < 2000; i++) {
        const struct ray ray = random_ray(&d, a, 1.5);
        struct ray_hit x = {0}, y = {0};
        wrong += bvh_hit_closest(a, &ray, &x) != bvh_hit_closest(moved, &ray, &y) ||
                 memcmp(&x, &y, sizeof x) != 0;
    }
    ok(wrong == 0, "a copy of the stage elsewhere gives the same hits");
    free(elsewhere);
    scenes_release(&s);
}

int main(void)
{
    test_mixes();
    test_grid();
    test_ties();
    test_coincident();
    test_garbage();
    test_holes();
    test_build_time();
    test_depth();
    test_floor();
    test_determinism();
    return tap_done();
}
