/* A shared mesh against its copies: the same hits, the same picture. SPDX-License-Identifier: MIT
 */
#include "common/trace/bvh.h"
#include "common/trace/bvh_cost.h"

#include <math.h>
#include <string.h>

#include "tests/crowd.h"
#include "tests/soup.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

struct pair { /* of the same scene */
    struct scenes scenes[2];
    const struct stage *shared, *copies;
};

static void pair_make(struct pair *p, struct crowd crowd, uint32_t side_px)
{
    const struct stage *stages[2];
    for (int i = 0; i < 2; i++) {
        struct scenes *s = &p->scenes[i];
        scenes_init(s, side_px, side_px);
        scenes_look(s, vec3_make(0, 4, 20), vec3_make(0, -1, 0), 1);
        scenes_sky(s, rgb_gray(0.5f));
        const uint32_t m = scenes_diffuse(s, rgb_gray(0.5f));
        crowd_add_others(s, m, crowd.seed);
        crowd.copies = i;
        crowd_add(s, m, &crowd);
        stages[i] = scenes_stage(s);
    }
    p->shared = stages[0];
    p->copies = stages[1];
}

static void pair_release(struct pair *p)
{
    for (int i = 0; i < 2; i++)
        scenes_release(&p->scenes[i]);
}

/* At a point of a triangle, or at its outline, from near it or from anywhere; one in eight goes
 * just anywhere, one in eight ends on the way. */
static struct ray random_ray(struct dice *d, const struct stage *copies, double reach)
{
    const struct stage_block *blocks = stage_at(copies, copies->blocks);
    uint32_t i;
    do
        i = dice_bits(d) % (uint32_t)(STAGE_LANES * copies->blocks.count);
    while (blocks[i / STAGE_LANES].prim[i % STAGE_LANES] == STAGE_NONE);
    const struct stage_triangle t = stage_triangle_at(copies, i, STAGE_NONE);
    const uint32_t at = dice_bits(d) % 4; /* inside, on an edge, a vertex */
    const float u = at == 2 ? 1 : dice_float(d);
    const float v = at == 1 ? 1 - u : at >= 2 ? 0 : dice_float(d) * (1 - u);
    const vec3 target =
        vec3_load(t.v[0]) * (1 - u - v) + vec3_load(t.v[1]) * u + vec3_load(t.v[2]) * v;
    const bool close = dice_bits(d) & 1;
    const vec3 origin = close ? target + soup_point(d, 3) : soup_point(d, reach);
    const bool astray = dice_bits(d) % 8 == 0;
    const bool ends = dice_bits(d) % 8 == 0;
    return (struct ray){origin, astray ? soup_direction(d) : target - origin,
                        ends ? (float)dice_range(d, 0, 2) : INFINITY, 0, 0};
}

/* Two triangles are as near as each other: their t, relative, rounded and moved. */
#define NEIGHBOURS 1e-5

struct tally {
    uint32_t rays, hits, instanced; /* hits on an instance */
    uint32_t wrong, moved; /* moved: the same triangle at another t; or, once in 1e7, where two
                            * meet, the other one */
    uint32_t wrong_any;
    double farthest; /* of those moved, relative */
};

static bool is_same(float a, float b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

static void try_ray(const struct pair *p, const struct ray *ray, struct tally *n)
{
    struct ray_hit a = {0}, b = {0};
    const bool hit = bvh_hit_closest(p->shared, ray, &a),
               also = bvh_hit_closest(p->copies, ray, &b);
    n->rays++;
    n->hits += hit;
    n->instanced += hit && a.instance != STAGE_NONE;
    n->wrong_any += bvh_hit_any(p->shared, ray) != hit || bvh_hit_any(p->copies, ray) != also;
    const bool same = a.prim == b.prim && is_same(a.u, b.u) && is_same(a.v, b.v);
    const double apart = hit && also ? fabs((double)(a.t - b.t) / (double)b.t) : 0;
    if (hit != also || (!same && (a.prim == b.prim || apart > NEIGHBOURS)))
        n->wrong++;
    else if (hit && (!same || !is_same(a.t, b.t))) {
        n->moved++;
        n->farthest = fmax(n->farthest, apart);
    }
}

/* Equal but for this: a hit on an instance lies within its triangle's box in the world and also
 * within the one in object space (bvh_hit.c), and where a ray all but lies in the triangle the
 * second may be the one that says where. */
static void test_hits(const struct pair *p, double reach)
{
    struct dice d = dice_make(2);
    struct tally n = {0};
    const uint32_t rays = stat_tries(400000, 10000000);
    for (uint32_t i = 0; i < rays; i++) {
        const struct ray ray = random_ray(&d, p->copies, reach);
        try_ray(p, &ray, &n);
    }
    ok(n.hits > n.rays / 2 && n.instanced > n.rays / 3, "%u rays: %u hit something, %u an instance",
       n.rays, n.hits, n.instanced);
    ok(n.wrong == 0, "the same triangle, u and v as among copies, bit by bit (%u not)", n.wrong);
    ok(n.moved <= n.rays / 100000, "and the same t (%u not, off by at most %.2g)", n.moved,
       n.farthest);
    ok(n.wrong_any == 0, "any hit where there is a closest (%u not)", n.wrong_any);
}

static void test_picture(const struct pair *p)
{
    const uint32_t spp = STAT_SLOW > 1 ? 1 : 16;
    struct film a, b;
    scenes_render(p->shared, spp, &a);
    scenes_render(p->copies, spp, &b);
    const size_t pixels = tile_rect_pixels(a.window);
    double sum = 0;
    for (size_t i = 0; i < 3 * pixels; i++)
        sum += a.sum[i];
    ok(sum > 0 && memcmp(a.sum, b.sum, 3 * pixels * sizeof *a.sum) == 0 &&
           memcmp(a.replicate, b.replicate, FILM_CHANNELS * pixels * sizeof *a.replicate) == 0,
       "the picture is that of the copies, bit by bit: %zu pixels, %u spp", pixels, spp);
    film_release(&a);
    film_release(&b);
}

static void test_crowd(void)
{
    const struct crowd crowd = {.seed = 1, .uses = 300, .rings = 32, .reach = 1000};
    struct pair p;
    pair_make(&p, crowd, 48);
    ok(p.shared->instances.count == crowd.uses - 1 && p.shared->trees.count == 2 &&
           p.copies->instances.count == 0 && p.shared->prim_count == p.copies->prim_count,
       "%u uses of a mesh are %u instances and a lamp, %.1f MB instead of %.1f", crowd.uses,
       (unsigned)p.shared->instances.count, (double)p.shared->bytes * 1e-6,
       (double)p.copies->bytes * 1e-6);
    const double cost = bvh_cost_of_ray(p.shared), of_copies = bvh_cost_of_ray(p.copies);
    ok(cost > .8 * of_copies && cost < 2 * of_copies, "a ray costs %.1f visits, in copies %.1f", cost,
       of_copies);
    test_hits(&p, crowd.reach);
    test_picture(&p);
    pair_release(&p);
}

/* Few and large, so that going through all primitives for a ray takes no longer than it must. */
static void test_loop(void)
{
    const struct crowd crowd = {.seed = 3, .uses = 5, .rings = 256, .reach = 5};
    struct pair p;
    pair_make(&p, crowd, 1);
    struct dice d = dice_make(4);
    uint32_t wrong = 0, instanced = 0;
    const uint32_t rays = STAT_SLOW > 1 ? 5 : stat_tries(50, 2000);
    for (uint32_t i = 0; i < rays; i++) {
        const struct ray ray = random_ray(&d, p.copies, 20);
        struct ray_hit tree = {0}, loop = {0};
        const bool hit = bvh_hit_closest(p.shared, &ray, &tree);
        wrong +=
            hit != soup_closest(p.shared, &ray, &loop) || memcmp(&tree, &loop, sizeof tree) != 0;
        instanced += hit && tree.instance != STAGE_NONE;
    }
    ok(p.shared->instances.count == 4 && instanced > rays / 8 && wrong == 0,
       "the hit is the loop's over all %u primitives, bit by bit (%u of %u rays not, %u instances "
       "hit)",
       p.shared->prim_count, wrong, rays, instanced);
    pair_release(&p);
}

int main(void)
{
    test_crowd();
    test_loop();
    return tap_done();
}
