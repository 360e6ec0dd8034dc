/* The BVH against brute force with the same primitive tests (equal bits) and against the textbook.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/trace/bvh.h"
#include "tests/jumble.h"
#include "tests/naive_hit.h"
#include "tests/tap.h"

struct tally {
    int rays, hits;
    int closest, any;       /* disagree with brute force */
    int textbook, doubtful; /* disagree with the textbook; left out of that */
};

static bool same_hit(struct ray_hit a, struct ray_hit b)
{
    return memcmp(&a.t, &b.t, sizeof a.t) == 0 && a.prim == b.prim && a.u == b.u && a.v == b.v;
}

static void compare(const struct stage *s, const struct ray *ray, struct tally *n)
{
    struct ray_hit got, want;
    const bool hit = bvh_hit_closest(s, ray, &got), expected = naive_hit_closest(s, ray, &want);
    n->rays++;
    n->hits += hit;
    n->closest += hit != expected || (hit && !same_hit(got, want));
    n->any += bvh_hit_any(s, ray) != expected;
}

static void compare_textbook(const struct stage *s, const struct ray *ray, struct tally *n)
{
    struct ray_hit got;
    const struct naive_hit want = naive_hit_textbook(s, ray);
    if (want.doubtful) {
        n->doubtful++;
        return;
    }
    const bool hit = bvh_hit_closest(s, ray, &got);
    n->textbook += hit != want.hit || (hit && fabs((double)got.t / want.t - 1) > 1e-5);
}

static void report(const struct tally *n, const char *what)
{
    ok(n->closest == 0 && n->any == 0 && n->hits > 0,
       "%s: closest and any hit are brute force's, bit for bit (%d rays, %d hits, %d + %d differ)",
       what, n->rays, n->hits, n->closest, n->any);
}

static void fill(struct jumble *j, struct dice *d, uint32_t triangles, uint32_t others, double size)
{
    const vec3 zero = {0};
    for (uint32_t i = 0; i < triangles; i++) {
        const vec3 at = jumble_point(d, zero, 1);
        jumble_triangle(j, jumble_point(d, at, size), jumble_point(d, at, size),
                        jumble_point(d, at, size));
    }
    for (uint32_t i = 0; i < others; i++) {
        const float radius = (float)dice_range(d, 0.1 * size, size);
        if (dice_bits(d) & 1)
            jumble_sphere(j, jumble_point(d, zero, 1), radius);
        else
            jumble_disc(j, jumble_point(d, zero, 1), jumble_direction(d), radius);
    }
}

/* Anywhere, along an axis with either zero, aimed at a vertex, and of any length. */
static struct ray random_ray(const struct jumble *j, struct dice *d)
{
    const vec3 zero = {0};
    struct ray r = {jumble_point(d, zero, 2), jumble_direction(d), INFINITY};
    const uint32_t vertices = j->scene.meshes[0].vertex_count, kind = dice_bits(d) % 8;
    if (kind < 2) {
        const int axis = (int)(dice_bits(d) % 3);
        for (int k = 0; k < 3; k++)
            if (k != axis)
                r.dir[k] = dice_bits(d) & 1 ? 0.0f : -0.0f;
    } else if (kind < 4 && vertices) {
        const vec3 v = vec3_load(j->vertices + 3 * (size_t)(dice_bits(d) % vertices));
        r.dir = v - r.origin;
        if (kind == 3 && dice_bits(d) & 1) /* in a plane of many boxes */
            r.origin[dice_bits(d) % 3] = v[0];
    } else if (kind == 4) {
        r.t_max = (float)dice_range(d, 0, 2);
    }
    return r;
}

static void random_mixes(void)
{
    struct dice d = dice_make(1);
    struct tally n = {0};
    static const uint32_t counts[][2] = {{1, 0}, {0, 1},  {2, 0},   {3, 3},     {10, 0},
                                         {0, 9}, {20, 7}, {90, 30}, {400, 100}, {1500, 50}};
    for (size_t i = 0; i < countof(counts); i++)
        for (int size = 0; size < 3; size++) {
            struct jumble j;
            jumble_init(&j, counts[i][0], counts[i][1]);
            fill(&j, &d, counts[i][0], counts[i][1], 0.03 * pow(5, size));
            const struct stage *s = jumble_stage(&j);
            for (int k = 0; k < 1500; k++) {
                const struct ray r = random_ray(&j, &d);
                compare(s, &r, &n);
                if (k % 5 == 0)
                    compare_textbook(s, &r, &n);
            }
            jumble_release(&j);
        }
    report(&n, "random mixes");
    ok(n.textbook == 0 && n.doubtful < n.rays / 20,
       "random mixes: the textbook in long double agrees to 1e-5 (%d differ, %d too close to call)",
       n.textbook, n.doubtful);
}

/* Flat faces on shared coordinates: boxes without thickness, rays in their planes and edges. */
static void integer_grid(void)
{
    enum { N = 6 };
    struct jumble j;
    struct dice d = dice_make(2);
    struct tally n = {0};
    jumble_init(&j, 3 * 2 * N * N * (N + 1), 0);
    for (int axis = 0; axis < 3; axis++)
        for (int at = 0; at <= N; at++)
            for (int i = 0; i < N * N; i++) {
                vec3 p[4];
                for (int c = 0; c < 4; c++) {
                    p[c][axis] = (float)at;
                    p[c][(axis + 1) % 3] = (float)(i % N + (c == 1 || c == 2));
                    p[c][(axis + 2) % 3] = (float)(i / N + (c >= 2));
                }
                jumble_triangle(&j, p[0], p[1], p[2]);
                jumble_triangle(&j, p[0], p[2], p[3]);
            }
    const struct stage *s = jumble_stage(&j);
    for (int i = 0; i < 20000; i++) {
        struct ray r = {{0}, {0}, INFINITY};
        for (int k = 0; k < 3; k++) {
            r.origin[k] = (float)(dice_bits(&d) % (4 * N)) * 0.5f - N / 2;
            r.dir[k] = (float)(dice_bits(&d) % 5) - 2;
        }
        compare(s, &r, &n);
    }
    report(&n, "integer grid");
    jumble_release(&j);
}

static void ties_go_to_the_smaller_number(void)
{
    enum { COPIES = 100 };
    struct jumble j;
    jumble_init(&j, COPIES, COPIES);
    const vec3 a = {-1, -1, 0, 0}, b = {1, -1, 0, 0}, c = {0, 1, 0, 0}, z = {0, 0, 1, 0}, o = {0};
    for (int i = 0; i < COPIES; i++) {
        jumble_triangle(&j, a, b, c);
        jumble_disc(&j, o, z, 1);
    }
    const struct stage *s = jumble_stage(&j);
    struct dice d = dice_make(3);
    int wrong = 0, hits = 0;
    struct tally n = {0};
    for (int i = 0; i < 1000; i++) {
        const vec3 from = jumble_point(&d, z * 3, 1);
        const struct ray r = {from, jumble_point(&d, o, 0.3) * vec3_make(1, 1, 0) - from, INFINITY};
        struct ray_hit h;
        compare(s, &r, &n);
        if (bvh_hit_closest(s, &r, &h)) {
            hits++;
            wrong += h.prim != 0;
        }
    }
    ok(hits == 1000 && wrong == 0, "of 100 triangles and 100 discs in one place, number 0 is hit");
    report(&n, "coincident triangles and discs");
    jumble_release(&j);
}

static void t_max_is_open(void)
{
    struct jumble j;
    jumble_init(&j, 1, 2);
    const vec3 z = {0, 0, 1, 0};
    jumble_triangle(&j, vec3_make(-1, -1, 0), vec3_make(1, -1, 0), vec3_make(0, 1, 0));
    jumble_sphere(&j, vec3_make(10, 0, -1), 1);
    jumble_disc(&j, vec3_make(20, 0, 0), z, 1);
    const struct stage *s = jumble_stage(&j);
    for (int i = 0; i < 3; i++) {
        struct ray r = {vec3_make(10 * (float)i, 0, 3), -z, 3};
        struct ray_hit h = {.t = -1};
        const bool at = bvh_hit_closest(s, &r, &h) || bvh_hit_any(s, &r);
        r.t_max = nextafterf(3, 4);
        const bool beyond = bvh_hit_any(s, &r) && bvh_hit_closest(s, &r, &h);
        ok(!at && beyond && h.t == 3, "primitive %d at t = 3 is hit when t_max > 3 only", i);
    }
    jumble_release(&j);
}

/* The block means the same at another address. */
static void stage_can_be_moved(void)
{
    struct jumble j;
    struct dice d = dice_make(4);
    jumble_init(&j, 300, 60);
    fill(&j, &d, 300, 60, 0.2);
    const struct stage *s = jumble_stage(&j);
    struct stage *copy = aligned_alloc(64, (s->bytes + 63) / 64 * 64);
    memcpy(copy, s, s->bytes);
    int different = 0, hits = 0;
    for (int i = 0; i < 5000; i++) {
        const struct ray r = random_ray(&j, &d);
        struct ray_hit a = {0}, b = {0};
        const bool hit_a = bvh_hit_closest(s, &r, &a), hit_b = bvh_hit_closest(copy, &r, &b);
        hits += hit_a;
        different += hit_a != hit_b || (hit_a && !same_hit(a, b));
    }
    ok(different == 0 && hits > 100, "a stage copied elsewhere gives the same %d hits", hits);
    free(copy);
    jumble_release(&j);
}

/* F-16 */
static void rays_that_are_none(void)
{
    struct jumble j;
    struct dice d = dice_make(5);
    jumble_init(&j, 300, 60);
    fill(&j, &d, 300, 60, 0.4);
    const struct stage *s = jumble_stage(&j);
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    int hits = 0;
    for (int i = 0; i < 1000; i++)
        for (int where = 0; where < 6; where++)
            for (size_t b = 0; b < countof(bad); b++) {
                struct ray r = random_ray(&j, &d);
                struct ray_hit h;
                if (where < 3)
                    r.origin[where] = bad[b];
                else
                    r.dir[where - 3] = bad[b];
                hits += bvh_hit_closest(s, &r, &h) + bvh_hit_any(s, &r);
            }
    ok(hits == 0, "a ray with a NaN or an infinity hits nothing (%d)", hits);
    static const float lengths[] = {NAN, 0, -0.0f, -1, -INFINITY};
    for (size_t b = 0; b < countof(lengths); b++) {
        const struct ray r = {vec3_make(0, 0, 0), vec3_make(0, 0, 1), lengths[b]};
        struct ray_hit h;
        hits += bvh_hit_closest(s, &r, &h) + bvh_hit_any(s, &r);
    }
    const struct ray still = {vec3_make(0, 0, 0), vec3_make(0, -0.0f, 0), INFINITY};
    struct ray_hit h;
    hits += bvh_hit_closest(s, &still, &h) + bvh_hit_any(s, &still);
    ok(hits == 0, "nor one without length or direction");
    jumble_release(&j);
}

int main(void)
{
    random_mixes();
    integer_grid();
    ties_go_to_the_smaller_number();
    t_max_is_open();
    stage_can_be_moved();
    rays_that_are_none();
    return tap_done();
}
