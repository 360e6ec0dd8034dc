/* Hits where a careless test has none, and none where it has one: shared edges, rays that are no
 * rays, spheres far away, tangents. SPDX-License-Identifier: MIT */
#include "common/trace/bvh.h"

#include <math.h>
#include <time.h>

#include "bench/closure.h"
#include "bench/meshes.h"
#include "common/trace/surface.h"
#include "tests/aim.h"
#include "tests/catalog.h"
#include "tests/naive_hit.h"
#include "tests/soup.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum { ORIGINS = 32 };

/* Points that a closed surface winds around. */
static void find_inside(const struct stage *s, struct dice *d, vec3 out[ORIGINS])
{
    const vec3 lo = vec3_load(s->bounds[0]), hi = vec3_load(s->bounds[1]);
    for (int n = 0; n < ORIGINS;) {
        for (int k = 0; k < 3; k++)
            out[n][k] = lo[k] + (hi[k] - lo[k]) * dice_float(d);
        n += aim_winding(s, out[n]) > 0.5;
    }
}

static uint32_t count_leaks(const struct stage *s, const vec3 *origins, bool vertex, uint32_t rays)
{
    struct dice d = dice_make(10);
    uint32_t leaks = 0;
    for (uint32_t i = 0; i < rays; i++) {
        const struct ray ray = aim_ray(&d, s, origins[dice_bits(&d) % ORIGINS], vertex);
        struct ray_hit hit;
        leaks += !bvh_hit_closest(s, &ray, &hit) || !bvh_hit_any(s, &ray);
    }
    return leaks;
}

static const float offsets[] = {0, 1e3f, 1e5f};

static void judge_leaks(struct scenes *s, const char *what, float offset)
{
    const struct stage *stage = scenes_stage(s);
    struct dice d = dice_make(11);
    vec3 origins[ORIGINS] = {{0}};
    find_inside(stage, &d, origins);
    const uint32_t rays = stat_tries(100000, 850000); /* 12 times: 1e7 in the long tier */
    const uint32_t a = count_leaks(stage, origins, true, rays);
    const uint32_t b = count_leaks(stage, origins, false, rays);
    ok(a == 0 && b == 0, "F-10: %s at %g: %u rays at vertices leak, %u at edges, of %u each", what,
       (double)offset, a, b, rays);
}

/* F-10 */
static void test_leaks(void)
{
    for (size_t i = 0; i < countof(offsets); i++) {
        const float off = offsets[i], scale = 100; /* the bunny is 15 cm long */
        struct scenes s;
        scenes_init(&s, 1, 1);
        scenes_ball(&s, scenes_diffuse(&s, rgb_gray(0.5f)), vec3_make(off, -off, off), 1, 16, 0.2f,
                    false);
        judge_leaks(&s, "bumpy ball", off);
        scenes_release(&s);

        struct err err;
        const char *what;
        scenes_init(&s, 1, 1);
        struct shape *bunny = meshes_add_bunny(&s, scenes_diffuse(&s, rgb_gray(0.5f)),
                                               "../shared/assets", &what, &err);
        if (ok(bunny != NULL, "%s", bunny ? what : err.text)) {
            closure_fill(&s.scene.meshes[bunny->mesh.mesh], &s.arena);
            bunny->to_world =
                (struct xform){{{scale, 0, 0, off}, {0, scale, 0, -off}, {0, 0, scale, off}}};
            judge_leaks(&s, "that, its holes closed,", off);
        }
        scenes_release(&s);
    }
}

/* A large, closed room, seen from close to its edges: rounding errors are in proportion to the far
 * ends of its walls, distances are small. (Hits nearer than a wall's error do not count, tri.h.) */
static void test_corners(void)
{
    int leaks = 0, rays = 0;
    for (uint64_t seed = 0; seed < 20; seed++) {
        struct dice d = dice_make(seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        const vec3 lo = soup_point(&d, 100) - rgb_gray(200),
                   hi = soup_point(&d, 100) + rgb_gray(200);
        scenes_box(&s, scenes_diffuse(&s, rgb_gray(0.5f)), lo, hi, true);
        const struct stage *stage = scenes_stage(&s);
        for (int i = 0; i < 20000 / STAT_SLOW; i++, rays++) {
            vec3 edge = {0}, origin = {0}; /* a point on an edge; one beside it in the room */
            const uint32_t along = dice_bits(&d) % 3;
            const float aside = (float)pow(10, dice_range(&d, -1, 1));
            for (uint32_t k = 0; k < 3; k++) {
                const bool high = dice_bits(&d) & 1;
                edge[k] = high ? hi[k] : lo[k];
                origin[k] = edge[k] + (high ? -aside : aside) * (0.1f + dice_float(&d));
            }
            edge[along] = lo[along] + (hi[along] - lo[along]) * dice_float(&d);
            origin[along] = edge[along] + aside * (dice_float(&d) - 0.5f);
            origin[along] = origin[along] < lo[along]   ? lo[along]
                            : origin[along] > hi[along] ? hi[along]
                                                        : origin[along];
            const struct ray ray = {origin, edge - origin, INFINITY, 0, 0};
            struct ray_hit hit;
            leaks += !bvh_hit_closest(stage, &ray, &hit);
        }
        scenes_release(&s);
    }
    ok(leaks == 0, "F-10: a room seen from beside its edges: %d of %d rays leak", leaks, rays);
}

/* Distance by which p lies outside the triangle's box, in parts of the largest number about: a
 * coordinate, or the way from the origin to the box's far side. */
static double outside_box(const struct stage_triangle *t, vec3 p, const struct ray *ray)
{
    double outside = 0, scale = 0;
    for (int k = 0; k < 3; k++) {
        const float a = t->v[0][k], b = t->v[1][k], c = t->v[2][k];
        const double lo = (double)fminf(a, fminf(b, c)), hi = (double)fmaxf(a, fmaxf(b, c));
        outside = fmax(outside, fmax(lo - (double)p[k], (double)p[k] - hi));
        const double o = (double)ray->origin[k];
        scale = fmax(scale, fmax(fmax(fabs(lo), fabs(hi)), fabs(o)));
        scale = fmax(scale, fmax(fabs(lo - o), fabs(hi - o)));
    }
    return outside / scale;
}

/* F-15: triangles 1 long and 10^-[1, 6] wide, rays at such angles to their plane. */
static void test_grazing(void)
{
    struct dice d = dice_make(15);
    double worst = 0;
    int hits = 0;
    for (int n = 0; n < 200; n++) {
        struct scenes s;
        scenes_init(&s, 1, 1);
        vec3 x = soup_direction(&d), y = vec3_unit(vec3_cross(x, soup_direction(&d)));
        if (n & 1) { /* a flat box, from which the slightest error leads outside */
            x = n & 2 ? vec3_make(1, 0, 0) : vec3_make(0, 1, 0);
            y = vec3_make(0, 0, 1);
        }
        const vec3 normal = vec3_cross(x, y), at = soup_point(&d, 10);
        const float thin = (float)pow(10, dice_range(&d, -6, -1));
        scenes_triangle(&s, scenes_diffuse(&s, rgb_gray(0.5f)), at, at + x,
                        at + 0.5f * x + thin * y);
        const struct stage *stage = scenes_stage(&s);
        const struct stage_triangle t = catalog_triangle(stage, 0);
        for (uint32_t i = 0; i < stat_tries(2000, 50000); i++) {
            const float angle = (float)pow(10, dice_range(&d, -6, -1));
            const float u = dice_float(&d), v = dice_float(&d) * (1 - u);
            const vec3 target = at + x * (u + 0.5f * v) + y * (v * thin);
            const vec3 dir = vec3_unit(x * (dice_float(&d) - 0.5f) + y * (dice_float(&d) - 0.5f)) +
                             normal * angle;
            const float distance = (float)pow(10, dice_range(&d, -2, 2));
            const struct ray ray = {target - dir * distance, dir, INFINITY, 0, 0};
            struct ray_hit hit;
            if (bvh_hit_closest(stage, &ray, &hit)) {
                hits++;
                worst = fmax(worst, outside_box(&t, surface_at(stage, &ray, &hit).p, &ray));
                worst = fmax(worst, outside_box(&t, ray.origin + hit.t * dir, &ray));
            }
        }
        scenes_release(&s);
    }
    /* What boxes are widened and padded by is 16 units of rounding, the point's own are 3. */
    ok(hits > 1000 && worst < 24 * 0x1p-24,
       "F-15: grazing hits on slivers lie on them: at most %.2g units of rounding off, %d hits",
       worst * 0x1p24, hits);
}

static double seconds_of(const struct stage *s, const struct ray *rays, int count, int *hits)
{
    struct timespec a, b;
    *hits = 0;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &a);
    for (int n = 0; n < 10; n++)
        for (int i = 0; i < count; i++) {
            struct ray_hit hit;
            *hits += bvh_hit_closest(s, &rays[i], &hit) + bvh_hit_any(s, &rays[i]);
        }
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &b);
    return (double)(b.tv_sec - a.tv_sec) + 1e-9 * (double)(b.tv_nsec - a.tv_nsec);
}

/* F-16 */
static void test_no_rays(void)
{
    enum { RAYS = 10000 };
    struct scenes s;
    scenes_init(&s, 1, 1);
    const uint32_t m = scenes_diffuse(&s, rgb_gray(0.5f));
    scenes_ball(&s, m, vec3_make(0, 0, 0), 1, 32, 0.2f, false);
    scenes_sphere(&s, m, vec3_make(0, 0, 0), 0.5f);
    scenes_disc(&s, m, vec3_make(0, 0, 0), vec3_make(0, 1, 0), 0.7f);
    scenes_cylinder(&s, m, vec3_make(0, -.3f, 0), vec3_make(.1f, .3f, 0), 0.3f);
    const struct stage *stage = scenes_stage(&s);
    struct dice d = dice_make(16);
    static struct ray rays[RAYS], odd[RAYS];
    static const float numbers[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < RAYS; i++) {
        odd[i] = rays[i] = (struct ray){soup_point(&d, 0.4), soup_direction(&d), INFINITY, 0, 0};
        const float number = numbers[dice_bits(&d) % countof(numbers)];
        const uint32_t where = dice_bits(&d) % 7;
        if (where < 3)
            odd[i].origin[where] = number;
        else if (where < 6)
            odd[i].dir[where - 3] = number;
        else
            odd[i].t_max = i & 1 ? NAN : -1;
    }
    int hits, odd_hits;
    const double usual = seconds_of(stage, rays, RAYS, &hits);
    const double time = seconds_of(stage, odd, RAYS, &odd_hits);
    ok(hits == 20 * RAYS && odd_hits == 0, "F-16: rays with NaN or infinity hit nothing (%d of %d)",
       odd_hits, 20 * RAYS);
    ok(time <= 2.5 * usual, "F-16: and take no longer than others: %.3g s, others %.3g s", time, usual);
    const struct ray still = {vec3_make(0, 0, 0), vec3_make(0, -0.0f, 0), INFINITY, 0, 0};
    struct ray_hit hit;
    ok(!bvh_hit_closest(stage, &still, &hit) && !bvh_hit_any(stage, &still),
       "a ray without direction hits nothing");
    scenes_release(&s);
}

/* Along the axes, with zeros of both signs, in the planes of faces and through edges and vertices.
 */
static void test_axes(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    scenes_box(&s, scenes_diffuse(&s, rgb_gray(0.5f)), vec3_make(-1, -1, -1), vec3_make(1, 1, 1),
               true);
    const struct stage *stage = scenes_stage(&s);
    int wrong = 0, beside = 0, differ = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < 2 * 4 * 81; i++) {
            const float sign = i & 1 ? -1 : 1;
            vec3 dir = {0}, origin = {0};
            for (int k = 0; k < 3; k++)
                dir[k] = i >> (k == (axis + 1) % 3 ? 1 : 2) & 1 ? -0.0f : 0.0f;
            dir[axis] = sign;
            origin[(axis + 1) % 3] = (float)(i / 8 % 9 - 4) / 4;
            origin[(axis + 2) % 3] = (float)(i / 72 % 9 - 4) / 4;
            struct ray_hit hit = {0}, plain = {0};
            const struct ray ray = {origin, dir, INFINITY, 0, 0};
            const struct ray same = {origin, dir + vec3_make(0, 0, 0), INFINITY, 0,
                                     0}; /* -0 + 0 is 0 */
            wrong += !bvh_hit_closest(stage, &ray, &hit) || hit.t != 1 || !bvh_hit_any(stage, &ray);
            differ += !bvh_hit_closest(stage, &same, &plain) || plain.prim != hit.prim;
            origin[(axis + 1) % 3] = 1.0000001f;
            const struct ray past = {origin, dir, INFINITY, 0, 0};
            beside += bvh_hit_any(stage, &past);
        }
    ok(wrong == 0, "rays along an axis hit a cube's side, edges and corners at 1 (%d not)", wrong);
    ok(differ == 0, "a direction's -0 is its 0 (%d not)", differ);
    ok(beside == 0, "rays beside the cube pass (%d not)", beside);
    scenes_release(&s);
}

/* F-17: the float formula loses it from 1e3 on. */
static void test_far_sphere(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    scenes_sphere(&s, scenes_diffuse(&s, rgb_gray(0.5f)), vec3_make(0, 0, 0), 0.1f);
    const struct stage *stage = scenes_stage(&s);
    const double height = (double)0.095f,
                 half = sqrt((double)0.1f * (double)0.1f - height * height);
    for (int i = 1; i <= 7; i++) {
        const float x = -(float)pow(10, i);
        const struct ray ray = {vec3_make(x, 0.095f, 0), vec3_make(1, 0, 0), INFINITY, 0, 0};
        struct ray_hit hit = {0};
        const bool found = bvh_hit_closest(stage, &ray, &hit);
        ok(found && fabs((double)hit.t + (double)x + half) <= -(double)x * 0x1p-23,
           "F-17: a sphere of .1 is hit from 1e%d away", i);
    }
    scenes_release(&s);
}

/* F-18: rays that touch the sphere to within few ulp, from all sides and from on it. */
static void test_tangents(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    const vec3 center = vec3_make(0.3f, -0.2f, 5);
    scenes_sphere(&s, scenes_diffuse(&s, rgb_gray(0.5f)), center, 0.7f);
    const struct stage *stage = scenes_stage(&s);
    struct dice d = dice_make(18);
    int bad = 0, hits = 0, wrong = 0;
    for (int i = 0; i < 100000 / STAT_SLOW; i++) {
        const vec3 out = soup_direction(&d), way = vec3_unit(vec3_cross(out, soup_direction(&d)));
        const int ulps = (int)(dice_bits(&d) % 65) - 32;
        const vec3 at = center + out * (0.7f * (1 + (float)ulps * 0x1p-23f));
        const float back = i % 4 == 0 ? 0 : (float)dice_range(&d, 0, 3);
        const struct ray ray = {at - way * back, way, INFINITY, 0, 0};
        struct ray_hit hit = {0};
        if (!bvh_hit_closest(stage, &ray, &hit))
            continue;
        hits++;
        const struct surface p = surface_at(stage, &ray, &hit);
        bad += !(hit.t > 0 && hit.t < 10 && fabsf(vec3_length(p.ng) - 1) < 1e-6f &&
                 p.p_error[0] + p.p_error[1] + p.p_error[2] < 1e-5f);
        /* How near the line passes, in double: a hit needs less than the radius. */
        double f[3], w[3], fw = 0, ww = 0, ff = 0;
        for (int k = 0; k < 3; k++) {
            f[k] = (double)ray.origin[k] - (double)center[k];
            w[k] = (double)way[k];
            fw += f[k] * w[k], ww += w[k] * w[k], ff += f[k] * f[k];
        }
        wrong += sqrt(ff - fw * fw / ww) > (double)0.7f * (1 + 1e-12);
    }
    ok(hits > 20000 / STAT_SLOW && bad == 0, "F-18: tangents to a sphere: no NaN, %d hits", hits);
    ok(wrong == 0, "F-18: tangents to a sphere: hits are within its radius (%d not)", wrong);
    scenes_release(&s);
}

int main(void)
{
    test_leaks();
    test_corners();
    test_grazing();
    test_no_rays();
    test_axes();
    test_far_sphere();
    test_tangents();
    return tap_done();
}
