/* Hits are the same bits whatever finds them and whoever compiled it: the eight-wide tree and the
 * plain one; closest and any; and against tests/golden/hits.txt, which is the same file for all
 * compilers and levels of optimisation. SPDX-License-Identifier: MIT */
#include "common/trace/bvh.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/meshes.h"
#include "common/hash.h"
#include "common/trace/bvh_turns.h"
#include "tests/catalog.h"
#include "tests/crowd.h"
#include "tests/oracle_bvh.h"
#include "tests/soup.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

#define GOLDEN "tests/golden/hits.txt"

static vec3 point_between(struct dice *d, const float bounds[2][3], float more)
{
    vec3 p = {0};
    for (int k = 0; k < 3; k++) {
        const float width = bounds[1][k] - bounds[0][k];
        p[k] = bounds[0][k] - more * width + (1 + 2 * more) * width * dice_float(d);
    }
    return p;
}

/* A third each: anywhere, at a triangle's inside, at a vertex or along an axis. One in eight ends.
 */
static struct stage_triangle any_triangle(struct dice *d, const struct stage *s)
{
    const struct stage_block *blocks = stage_at(s, s->blocks);
    return stage_block_lane(&blocks[dice_bits(d) % (uint32_t)s->blocks.count], 0);
}

static struct ray random_ray(struct dice *d, const struct stage *s, struct stage_triangle t)
{
    const vec3 origin = point_between(d, s->bounds, dice_bits(d) & 1 ? 1 : 0);
    const uint32_t kind = dice_bits(d) % 6;
    const float u = kind > 3 ? 1 : dice_float(d), v = kind > 3 ? 0 : dice_float(d) * (1 - u);
    vec3 dir = point_between(d, s->bounds, 1) - origin;
    if (kind > 1)
        dir = vec3_load(t.v[0]) * (1 - u - v) + vec3_load(t.v[1]) * u + vec3_load(t.v[2]) * v -
              origin;
    if (kind == 5)
        dir[dice_bits(d) % 3] = 0;
    return (struct ray){origin, dir, dice_bits(d) % 8 ? INFINITY : (float)dice_range(d, 0, 2), 0,
                        0};
}

struct tally {
    uint32_t rays, hits, wrong, wrong_any, wrong_batch;
};

/* A ray asked once more, when it says that it starts or ends on what it has hit: for a triangle, it
 * must find the next one. */
static void told(const struct oracle *o, const struct stage *s, struct ray ray, uint32_t prim,
                 struct tally *n)
{
    struct ray_hit wide = {0}, plain = {0};
    if (prim & 1)
        ray.from = prim + 1;
    else
        ray.to = prim + 1;
    const bool hit = bvh_hit_closest(s, &ray, &wide);
    n->wrong += hit != oracle_closest(o, &ray, &plain) || memcmp(&wide, &plain, sizeof wide) != 0;
    n->wrong_any += bvh_hit_any(s, &ray) != hit;
}

static bool same_hit(bool hit, const struct ray_hit *a, bool other_hit, const struct ray_hit *b)
{
    return hit == other_hit && (!hit || !memcmp(a, b, sizeof *a));
}

/* Up to eight like the first one, the others less and less: a fan, some of which are no rays, or
 * go elsewhere. */
static void batch(const struct stage *s, struct dice *d, struct ray first, struct tally *n)
{
    struct ray rays[8] = {first};
    struct ray_hit hits[8], hit;
    const uint32_t count = 1 + dice_bits(d) % 8;
    const float spread = 1 / (float)(1u << dice_bits(d) % 20);
    const float size = vec3_length(first.dir);
    for (uint32_t i = 1; i < count; i++) {
        rays[i] = first;
        for (int k = 0; k < 3; k++) {
            rays[i].dir[k] += spread * size * (float)dice_range(d, -1, 1);
            rays[i].origin[k] += spread * (float)dice_range(d, -0.1, 0.1);
        }
        if (dice_bits(d) % 64 == 0)
            rays[i].dir[dice_bits(d) % 3] = dice_bits(d) & 1 ? NAN : 0;
        if (dice_bits(d) % 64 == 0)
            rays[i] = (struct ray){first.origin, -first.dir, dice_bits(d) & 1 ? 0 : 1, 0, 0};
    }
    const uint32_t which = (1u << count) - 1;
    const uint32_t closest = bvh_hit_closest_8(s, which, rays, hits);
    const uint32_t any = bvh_hit_any_8(s, which, rays);
    for (uint32_t i = 0; i < count; i++) {
        memset(&hit, 0, sizeof hit);
        n->wrong_batch +=
            !same_hit(bvh_hit_closest(s, &rays[i], &hit), &hit, closest >> i & 1, &hits[i]) ||
            bvh_hit_any(s, &rays[i]) != (any >> i & 1);
    }
}

static void compare(const struct stage *s, uint64_t seed, uint32_t rays, struct tally *n)
{
    struct oracle o;
    struct dice d = dice_make(seed);
    oracle_make(&o, s);
    for (uint32_t i = 0; i < rays; i++) {
        const struct ray ray = random_ray(&d, s, any_triangle(&d, s));
        struct ray_hit wide = {0}, plain = {0};
        const bool hit = bvh_hit_closest(s, &ray, &wide);
        n->rays++;
        n->hits += hit;
        n->wrong +=
            hit != oracle_closest(&o, &ray, &plain) || memcmp(&wide, &plain, sizeof wide) != 0;
        n->wrong_any += bvh_hit_any(s, &ray) != hit || oracle_any(&o, &ray) != hit;
        batch(s, &d, ray, n);
        if (hit)
            told(&o, s, ray, wide.prim, n);
    }
    oracle_release(&o);
}

static void judge(const struct tally *n, const char *what)
{
    ok(n->hits > n->rays / 4 && n->wrong == 0,
       "%s: %u of %u rays hit, as the plain tree has it, bit by bit (%u not)", what, n->hits,
       n->rays, n->wrong);
    ok(n->wrong_any == 0, "%s: any hit where there is a closest (%u not)", what, n->wrong_any);
    ok(n->wrong_batch == 0, "%s: a ray among eight hits what it hits alone (%u not)", what,
       n->wrong_batch);
}

static void test_meshes(void)
{
    for (enum meshes_kind kind = 0; kind < MESHES_KINDS; kind++) {
        struct meshes m;
        struct err err;
        struct tally n = {0};
        const uint32_t triangles = stat_is_long() ? 200000 : 20000;
        if (!meshes_init(&m, kind, triangles, "../shared/assets", &err)) {
            ok(false, "%s", err.text);
            continue;
        }
        compare(scenes_stage(&m.scenes), 1 + (uint64_t)kind, stat_tries(30000, 1500000), &n);
        judge(&n, m.what);
        meshes_release(&m);
    }
}

/* Spheres, discs and cylinders among meshes of all sizes, 1 km apart or in each other. */
static void test_crowd(void)
{
    struct scenes s;
    struct tally n = {0};
    scenes_init(&s, 1, 1);
    const uint32_t m = scenes_diffuse(&s, rgb_gray(0.5f));
    crowd_add_others(&s, m, 5);
    crowd_add(&s, m, &(struct crowd){.seed = 5, .uses = 40, .rings = 16, .reach = 1000});
    compare(scenes_stage(&s), 9, stat_tries(30000, 1500000), &n);
    judge(&n, "a crowd of shapes");
    scenes_release(&s);
}

/* So many triangles that rays of a batch which go different ways walk in turn. */
static void test_large(void)
{
    struct scenes s;
    struct tally n = {0};
    scenes_init(&s, 1, 1);
    const uint32_t m = scenes_diffuse(&s, rgb_gray(0.5f));
    scenes_ball(&s, m, vec3_make(0, 0, 0), 3, 220, .3f, false);
    crowd_add_others(&s, m, 6);
    const struct stage *stage = scenes_stage(&s);
    ok(bvh_turns_pay(stage, 3) && !bvh_turns_pay(stage, 4), "%u triangles: rays walk in turn",
       stage->prim_count);
    compare(stage, 10, stat_tries(20000, 1500000), &n);
    judge(&n, "a large mesh among shapes");
    scenes_release(&s);
}

/* --- who compiled it --- */

enum { PLAIN_TRIANGLES = 3000 }; /* the first numbers */

/* Neither libm nor a file: soup of exact numbers, and round shapes. */
static const struct stage *plain_scene(struct scenes *s)
{
    struct dice d = dice_make(77);
    scenes_init(s, 1, 1);
    const uint32_t m = scenes_diffuse(s, rgb_gray(0.5f));
    float(*v)[3] = soup_vertices(s, PLAIN_TRIANGLES);
    for (uint32_t i = 0; i < PLAIN_TRIANGLES; i++) {
        const vec3 at = soup_point(&d, 1);
        for (uint32_t k = 0; k < 3; k++)
            vec3_store(v[3 * i + k], at + soup_point(&d, 0.1));
    }
    soup_mesh(s, m, v, PLAIN_TRIANGLES);
    for (int i = 0; i < 40; i++) {
        const float radius = (float)dice_range(&d, 0.02, 0.2);
        scenes_sphere(s, m, soup_point(&d, 1), radius);
        /* One call of the dice each: compilers differ in which argument they make first. */
        const vec3 center = soup_point(&d, 1), normal = soup_point(&d, 1);
        scenes_disc(s, m, center, normal, radius);
        const vec3 from = soup_point(&d, 1);
        scenes_cylinder(s, m, from, from + soup_point(&d, 1), radius);
    }
    return scenes_stage(s);
}

/* As bytes, little end first. */
static void note(unsigned char out[16], const struct ray_hit *hit)
{
    uint32_t words[4] = {0, hit->prim, 0, 0};
    memcpy(&words[0], &hit->t, sizeof hit->t);
    memcpy(&words[2], &hit->u, sizeof hit->u);
    memcpy(&words[3], &hit->v, sizeof hit->v);
    for (int i = 0; i < 16; i++)
        out[i] = (unsigned char)(words[i / 4] >> 8 * (i % 4));
}

static void test_golden(void)
{
    enum { RAYS = 50000 };
    struct scenes s;
    struct dice d = dice_make(78);
    const struct stage *stage = plain_scene(&s);
    unsigned char(*hits)[16] = (unsigned char(*)[16])arena_alloc(&s.arena, RAYS, 16, 1);
    /* By their numbers, so that the rays do not depend on the tree. */
    struct stage_triangle *triangles =
        arena_new(&s.arena, struct stage_triangle, stage->prim_count);
    struct stage_id id;
    for (uint64_t at = 0; catalog_next(stage, &at, &id);)
        if (id.place.kind == STAGE_TRIANGLE)
            triangles[id.prim] = stage_triangle_at(stage, id.place.index, id.instance);
    char found[HASH_HEX], golden[HASH_HEX] = "";
    for (int i = 0; i < RAYS; i++) {
        const struct ray ray = random_ray(&d, stage, triangles[dice_bits(&d) % PLAIN_TRIANGLES]);
        struct ray_hit hit = {0};
        if (bvh_hit_closest(stage, &ray, &hit))
            note(hits[i], &hit);
    }
    hash_hex(hits, RAYS * sizeof *hits, found);
    FILE *file = fopen(GOLDEN, "r");
    const bool read = file && fscanf(file, "%64s", golden) == 1;
    if (file)
        fclose(file);
    if (!ok(read && !strcmp(found, golden), "50000 hits are the bits of " GOLDEN))
        diag("found %s", found);
    scenes_release(&s);
}

int main(void)
{
    test_meshes();
    test_crowd();
    test_large();
    test_golden();
    return tap_done();
}
