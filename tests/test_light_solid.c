/* light_solid.h, and what light.c makes of it: triangles and quads that are near are sampled by the
 * solid angle they fill, down to contact (F-33).
 * SPDX-License-Identifier: MIT */
#include "common/trace/light_solid.h"

#include <math.h>
#include <string.h>

#include "common/trace/bvh.h"
#include "common/trace/light.h"
#include "common/trace/warp.h"
#include "tests/catalog.h"
#include "tests/dice.h"
#include "tests/scenes.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

/* --- solid angles beside closed forms --- */

/* From a point h before the corner of a rectangle. */
static double corner_angle(double a, double b, double h)
{
    return atan2(a * b, h * sqrt(a * a + b * b + h * h));
}

/* Of [0, 2] x [0, 1] at z = 0, which faces +z, from p. */
static double rectangle_angle(vec3 p)
{
    const double x0 = -(double)p[0], x1 = 2 - (double)p[0], y0 = -(double)p[1],
                 y1 = 1 - (double)p[1], h = (double)p[2];
    return corner_angle(x1, y1, h) - corner_angle(x0, y1, h) - corner_angle(x1, y0, h) +
           corner_angle(x0, y0, h);
}

static const vec3 corners[4] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};

static double angle_of(const vec3 v[4], uint32_t count, vec3 p)
{
    const struct light_solid s = light_solid_make(v, count, p);
    return 2 * (s.half[0] + s.half[1]);
}

static void angles_are_right(void)
{
    struct dice dice = dice_make(1);
    double off = 0;
    int turned = 0;
    for (int i = 0; i < 100000; i++) { /* from 2^-40 before its plane on */
        const float h = (float)exp2(dice_range(&dice, -40, 3));
        const float x = (float)dice_range(&dice, -1, 3), y = (float)dice_range(&dice, -1, 2);
        const vec3 p = vec3_make(x, y, h);
        off = fmax(off, fabs(angle_of(corners, 4, p) - rectangle_angle(p)));
        turned += angle_of(corners, 4, vec3_make(x, y, -h)) != 0;
    }
    ok(off < 1e-10, "a rectangle fills its solid angle (%.1e off)", off);
    ok(turned == 0, "from behind it fills none");
}

static vec3 place_of(const struct light_solid_place *at)
{
    const vec3 b = corners[1 + at->triangle], c = corners[2 + at->triangle];
    return at->b.u * b + at->b.v * c; /* corner 0 is 0 */
}

/* The part of the solid angle that has been chosen up to u is u, and v runs from corner 0. */
static void places_are_even(void)
{
    struct dice dice = dice_make(2);
    double off = 0, beside = 0;
    for (int i = 0; i < 20000; i++) {
        const float h = (float)exp2(dice_range(&dice, -5, 2));
        const float x = (float)dice_range(&dice, -.5, 2.5), y = (float)dice_range(&dice, -.5, 1.5);
        const vec3 p = vec3_make(x, y, h);
        const uint32_t count = 3 + (i & 1);
        const struct light_solid s = light_solid_make(corners, count, p);
        const double u = dice_unit(&dice), v = dice_unit(&dice);
        const struct light_solid_place edge = light_solid_sample(&s, u, 1),
                                       at = light_solid_sample(&s, u, v);
        const vec3 end = place_of(&edge);
        vec3 cut[4] = {corners[0], corners[1], end, end};
        if (edge.triangle) {
            cut[2] = corners[2];
            cut[3] = end;
        }
        off =
            fmax(off, fabs(angle_of(cut, 3 + edge.triangle, p) - u * angle_of(corners, count, p)));
        const vec3 a = vec3_unit(corners[0] - p), aw = vec3_unit(place_of(&at) - p) - a,
                   ae = vec3_unit(end - p) - a;
        beside = fmax(beside, fabs((double)vec3_dot(aw, aw) - v * (double)vec3_dot(ae, ae)));
    }
    ok(off < 1e-5, "u is the part of the solid angle on one side (%.1e off)", off);
    ok(beside < 2e-5, "v is linear in the cosine from the corner (%.1e off)", beside);
}

/* --- F-33: a wall that shines, on a black floor, seen from a point of the floor --- */

struct wall {
    struct scenes s;
    const struct stage *stage;
    struct surface from;
};

static void wall_init(struct wall *w, float away)
{
    scenes_init(&w->s, 1, 1);
    const uint32_t black = scenes_diffuse(&w->s, rgb_gray(0));
    scenes_disc(&w->s, black, vec3_make(0, 0, 0), vec3_make(0, 1, 0), 1e-3f);
    scenes_quad(&w->s, black, vec3_make(away, 0, -1), vec3_make(0, 0, 2), vec3_make(0, 1, 0))
        ->emission = rgb_gray(1);
    w->stage = scenes_stage(&w->s);
    w->from = surface_on_disc(w->stage, catalog_id(w->stage, 0), vec3_make(0, 0, 0));
}

struct spread {            /* of one sample of the irradiance */
    double mean, variance; /* relative */
};

static struct spread spread_of(double sum, double squares, double n)
{
    return (struct spread){sum / n, squares * n / (sum * sum) - 1};
}

enum { SIDE = 512 };

static struct spread ours(const struct wall *w)
{
    double sum = 0, squares = 0;
    for (uint32_t i = 0; i < SIDE; i++)
        for (uint32_t k = 0; k < SIDE; k++) {
            struct light_sample light;
            const uint32_t half = UINT32_MAX / SIDE / 2;
            const struct sobol_bits bits = {(2 * i + 1) * half, (2 * k + 1) * half};
            if (!light_sample(w->stage, &w->from, bits, &light))
                continue;
            const double e = (double)light.value[0] * (double)light.wi[1];
            sum += e;
            squares += e * e;
        }
    return spread_of(sum, squares, (double)SIDE * SIDE);
}

/* By area: heights in geometric steps, so that the foot of the wall is not missed. */
static struct spread by_area(double away)
{
    enum { N = 2000 };
    double sum = 0, squares = 0;
    for (int i = 0; i < N; i++) { /* h = away * (e^t - 1), both ways */
        const double top = log1p(1 / away), t = (i + .5) / N * top;
        const double h = away * expm1(t), dh = away * exp(t) * top / N;
        for (int k = 0; k < N; k++) {
            const double t2 = (k + .5) / N * top, z = away * expm1(t2);
            const double dz = 2 * away * exp(t2) * top / N, dd = away * away + h * h + z * z;
            const double e = 2 * h * away / (dd * dd); /* times the area, 2 */
            sum += e * dh * dz / 2;
            squares += e * e * dh * dz / 2;
        }
    }
    return spread_of(sum, squares, 1);
}

/* wall and floor at right angles, the floor's point in the middle before the wall. */
static double truth_of(double away)
{
    const double Y = away, X = 1, a = sqrt(X * X + Y * Y); /* of each half: width 1, height 1 */
    return atan(1 / Y) - Y / a * atan(1 / a);
}

static void contact_is_finite(void)
{
    static const float away[] = {1, .1f, 1e-2f, 1e-3f, 1e-4f, 1e-6f};
    for (size_t i = 0; i < countof(away); i++) {
        struct wall w;
        wall_init(&w, away[i]);
        const struct spread o = ours(&w), a = by_area((double)away[i]);
        near(o.mean, truth_of((double)away[i]), 2e-4, "A-04: a wall %g m away", (double)away[i]);
        ok(o.variance < .34 && (o.variance < a.variance || i == 0),
           "F-33: relative variance of a light sample %.3f, by area %.3g", o.variance, a.variance);
        scenes_release(&w.s);
    }
}

/* --- edges and corners --- */

static bool is_sane(const struct light_sample *l)
{
    return l->value[0] >= 0 && isfinite(l->value[0]) && l->pdf_w > 0 && isfinite(l->pdf_w) &&
           fabsf(vec3_length(l->wi) - 1) < 1e-6f;
}

/* From on its edges, its corners, in its plane, and a hair's breadth off. */
static void odd_places(void)
{
    static const float heights[] = {0, 0x1p-149f, 1e-30f, 1e-12f, 1e-6f, 1e-3f};
    static const uint32_t bits[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffff00, 0xffffffff};
    struct scenes s;
    scenes_init(&s, 1, 1);
    const uint32_t black = scenes_diffuse(&s, rgb_gray(0));
    scenes_quad(&s, black, vec3_make(0, 0, 0), vec3_make(2, 0, 0), vec3_make(0, 1, 0))->emission =
        rgb_gray(1);
    scenes_triangle(&s, black, vec3_make(0, 0, 9), vec3_make(1, 0, 9), vec3_make(.5f, 1e-6f, 9))
        ->emission = rgb_gray(1e3f);
    const struct stage *stage = scenes_stage(&s);
    const struct emitter *e = stage_at(stage, stage->emitters);
    int bad = 0, asked = 0;
    for (size_t n = 0; n < 25 * countof(heights) * countof(bits) * countof(bits); n++) {
        const float h = heights[n / 25 % countof(heights)];
        const vec3 p =
            vec3_make((float)(n % 5) * .5f, (float)(n / 5 % 5) * .25f, (n & 1) ? h : h + 9);
        const struct surface from = {
            .p = p, .p_error = vec3_splat(1e-9f), .ng = vec3_make(0, 1, 0), .prim = 99};
        const struct sobol_bits q = {bits[n / 25 / countof(heights) % countof(bits)],
                                     bits[n / 25 / countof(heights) / countof(bits)]};
        struct light_sample l;
        if (light_sample(stage, &from, q, &l)) {
            bad += !is_sane(&l);
            asked++;
        }
        for (uint32_t i = 0; i < stage->emitters.count; i++) {
            const struct stage_id id = {e[i].prim, e[i].place, STAGE_NONE};
            struct surface at = surface_on_triangle(stage, id, .25f, .25f);
            at.emitter = i;
            const float pdf_w = light_pdf_w(stage, &from, &at);
            bad += !(pdf_w >= 0 && (isfinite(pdf_w) || vec3_dot(at.p - p, at.ng) > -1e-20f));
        }
    }
    ok(bad == 0 && asked > 1000,
       "on edges and corners samples and densities are finite (%d bad of %d)", bad, asked);
    scenes_release(&s);
}

/* Both halves of a quad are one light: each gets as many points as the solid angle it fills. */
static void halves_share(void)
{
    struct wall w;
    wall_init(&w, .01f);
    w.from.p = vec3_make(0, .3f, .4f);
    const struct emitter *e = stage_at(w.stage, w.stage->emitters);
    double half[2];
    for (int i = 0; i < 2; i++) {
        const struct stage_triangle t = stage_triangle_at(w.stage, e[i].place.index, STAGE_NONE);
        const vec3 v[4] = {vec3_load(t.v[0]), vec3_load(t.v[1]), vec3_load(t.v[2])};
        half[i] = light_solid_make(v, 3, w.from.p).half[0];
    }
    uint32_t first = 0;
    const uint32_t n = 100000;
    float least = INFINITY, most = 0;
    for (uint32_t i = 0; i < n; i++) {
        struct light_sample l;
        if (!light_sample(w.stage, &w.from, (struct sobol_bits){i * 42949u, i * 0x9e3779b1u}, &l))
            continue;
        first += l.shadow.to == e[0].prim + 1;
        least = fminf(least, l.pdf_w);
        most = fmaxf(most, l.pdf_w);
    }
    const double due = half[0] / (half[0] + half[1]);
    ok(fabs(first / (double)n - due) < 1e-4, "a quad's halves get %.4f is %.4f", first / (double)n,
       due);
    near((double)least, 1 / (2 * (half[0] + half[1])), 1e-6, "with one density, of the whole quad");
    ok(most <= least * 1.000001f, "the same in both");
    scenes_release(&w.s);
}

int main(void)
{
    angles_are_right();
    places_are_even();
    contact_is_finite();
    odd_places();
    halves_share();
    return tap_done();
}
