/* cylinder.h: far away, touching, along the axis, at the rims: hits and normals keep their digits.
 * SPDX-License-Identifier: MIT */
#include "common/trace/cylinder.h"

#include <math.h>

#include "common/trace/bvh.h"
#include "common/trace/surface.h"
#include "tests/soup.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

static const struct stage *one_cylinder(struct scenes *s, vec3 from, vec3 to, float radius)
{
    scenes_init(s, 1, 1);
    scenes_cylinder(s, scenes_diffuse(s, rgb_gray(0.5f)), from, to, radius);
    return scenes_stage(s);
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        out[k] = a[i] * b[j] - a[j] * b[i];
    }
}

/* Of points of both rims, in double. */
static void rim_extent(const struct stage_cylinder *c, int points, double lo[3], double hi[3])
{
    double z[3], x[3], y[3], xx = 0, yy = 0;
    for (int k = 0; k < 3; k++)
        z[k] = (double)c->axis[k];
    cross(z, fabs(z[0]) < fabs(z[1]) ? (double[3]){1, 0, 0} : (double[3]){0, 1, 0}, x);
    cross(z, x, y);
    for (int k = 0; k < 3; k++) {
        xx += x[k] * x[k], yy += y[k] * y[k];
        lo[k] = HUGE_VAL, hi[k] = -HUGE_VAL;
    }
    for (int n = 0; n < 2 * points; n++)
        for (int k = 0; k < 3; k++) {
            const double a = pi * n / points;
            const double out = cos(a) * x[k] / sqrt(xx) + sin(a) * y[k] / sqrt(yy);
            const double p = (double)c->from[k] + (n & 1 ? z[k] : 0) + (double)c->radius * out;
            lo[k] = fmin(lo[k], p), hi[k] = fmax(hi[k], p);
        }
}

/* A cylinder's box holds both rims, and is no larger than they are but for rounding. */
static void test_box(void)
{
    enum { CYLINDERS = 1000, POINTS = 360 };
    int outside = 0;
    double loose = 0;
    for (uint64_t seed = 0; seed < CYLINDERS; seed++) {
        struct dice d = dice_make(seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        vec3 axis = soup_point(&d, pow(10, dice_range(&d, -3, 3)));
        for (uint64_t k = 0; k < 3 && seed % 3 == 0; k++) /* along an axis of the world */
            axis[k] = k == seed / 3 % 3 ? axis[k] : 0;
        const float radius = (float)pow(10, dice_range(&d, -2, 2));
        const vec3 from = soup_point(&d, 10);
        scenes_cylinder(&s, scenes_diffuse(&s, rgb_gray(0.5f)), from, from + axis, radius);
        const struct stage *stage = scenes_stage(&s);
        double lo[3], hi[3];
        rim_extent(stage_at(stage, stage->cylinders), POINTS, lo, hi);
        const double size = (double)(radius + vec3_length(axis)) + 20;
        const double between = (1 - cos(pi / POINTS)) * (double)radius; /* points of a rim */
        for (int k = 0; k < 3; k++) {
            const double below = lo[k] - (double)stage->bounds[0][k];
            const double above = (double)stage->bounds[1][k] - hi[k];
            outside += below < 0 || above < 0;
            loose = fmax(loose, (fmax(below, above) - between) / size);
        }
        scenes_release(&s);
    }
    ok(outside == 0, "a cylinder's box holds its rims (%d sides do not)", outside);
    ok(loose < 4 * 0x1p-24, "and is no larger (by %.1e of its size)", loose);
}

/* F-17. The normal is asked, too: from 1e6 on, the rounding of t is more than the radius. */
static void test_far(void)
{
    struct scenes s;
    const struct stage *stage = one_cylinder(&s, vec3_make(0, 0, -3), vec3_make(0, 0, 5), 0.1f);
    const double radius = (double)0.1f, height = (double)0.095f;
    const double half = sqrt(radius * radius - height * height);
    for (int i = 1; i <= 7; i++) {
        const float x = -(float)pow(10, i);
        const struct ray ray = {vec3_make(x, 0.095f, 0), vec3_make(1, 0, 0), INFINITY, 0, 0};
        struct ray_hit hit = {0};
        const bool found = bvh_hit_closest(stage, &ray, &hit);
        ok(found && fabs((double)hit.t + (double)x + half) <= -(double)x * 0x1p-23,
           "F-17: a cylinder of radius .1 is hit from 1e%d away", i);
        const struct surface at = surface_at(stage, &ray, &hit);
        const double off =
            fmax(fabs((double)at.ng[0] + half / radius), fabs((double)at.ng[1] - height / radius));
        ok(off < 1e-6 && fabs((double)at.p[0] + half) < 1e-6,
           "and there, to the digit: its normal is off by %.1e", off);
    }
    scenes_release(&s);
}

/* F-18: rays that touch the side to within few ulp, under all angles and from on it. */
static void test_tangents(void)
{
    const vec3 from = vec3_make(0.3f, -0.2f, 5), axis = vec3_make(1, 3, -2);
    struct scenes s;
    const struct stage *stage = one_cylinder(&s, from, from + axis, 0.7f);
    const struct stage_cylinder *c = stage_at(stage, stage->cylinders);
    struct dice d = dice_make(18);
    int bad = 0, hits = 0, wrong = 0;
    for (int i = 0; i < 100000 / STAT_SLOW; i++) {
        const vec3 out = vec3_unit(vec3_cross(axis, soup_direction(&d)));
        const vec3 way = vec3_unit(vec3_cross(out, soup_direction(&d)));
        const int ulps = (int)(dice_bits(&d) % 65) - 32;
        const vec3 at = from + axis * dice_float(&d) + out * (0.7f * (1 + (float)ulps * 0x1p-23f));
        const float back = i % 4 == 0 ? 0 : (float)dice_range(&d, 0, 3);
        const struct ray ray = {at - way * back, way, INFINITY, 0, 0};
        struct ray_hit hit = {0};
        if (!bvh_hit_closest(stage, &ray, &hit))
            continue;
        hits++;
        const struct surface p = surface_at(stage, &ray, &hit);
        bad += !(hit.t > 0 && hit.t < 10 && fabsf(vec3_length(p.ng) - 1) < 1e-6f &&
                 p.p_error[0] + p.p_error[1] + p.p_error[2] < 1e-5f);
        /* How near the line passes the axis, in double: the volume over the base. */
        double f[3], w[3], a[3], n[3];
        for (int k = 0; k < 3; k++) {
            f[k] = (double)ray.origin[k] - (double)c->from[k];
            w[k] = (double)way[k], a[k] = (double)c->axis[k];
        }
        cross(w, a, n);
        const double nn = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        const double volume = fabs(f[0] * n[0] + f[1] * n[1] + f[2] * n[2]);
        wrong += volume > (double)c->radius * sqrt(nn) * (1 + 1e-12);
    }
    ok(hits > 20000 / STAT_SLOW && bad == 0, "F-18: tangents: no NaN, %d hits", hits);
    ok(wrong == 0, "F-18: tangents: hits are within the radius (%d not)", wrong);
    scenes_release(&s);
}

/* Through a cylinder of radius 1 and height 2 about each axis of the world, with zeros of both
 * signs: from its middle, from outside, beside it, and past its ends. */
static void test_axes(void)
{
    int wrong = 0, beside = 0, along = 0;
    for (int i = 0; i < 3 * 2 * 2 * 8; i++) {
        const int axis = i % 3, other = (axis + 1 + i / 3 % 2) % 3;
        const float sign = i / 6 % 2 ? -1 : 1;
        vec3 z = {0}, way = {0}, aside = {0};
        z[axis] = 1;
        for (int k = 0; k < 3; k++)
            way[k] = i / 12 >> k & 1 ? -0.0f : 0.0f;
        const vec3 up = way + z * sign;
        way[other] = sign;
        aside[3 - axis - other] = 1;
        struct scenes s;
        const struct stage *stage = one_cylinder(&s, -z, z, 1);
        struct ray_hit hit;
        const struct ray out = {vec3_make(0, 0, 0), way, INFINITY, 0, 0};
        wrong += !bvh_hit_closest(stage, &out, &hit) || hit.t != 1;
        for (int k = -1; k <= 1; k++) { /* the rims belong to it */
            const struct ray in = {z * (float)k - way * 3, way, INFINITY, 0, 0};
            wrong += !bvh_hit_closest(stage, &in, &hit) || hit.t != 2;
            const struct ray past = {z * ((float)k * 1.0000001f) - way * 3, way, INFINITY, 0, 0};
            beside += k && bvh_hit_any(stage, &past);
            const struct ray side = {aside * 1.0000001f + z * (float)k - way * 3, way, INFINITY, 0,
                                     0};
            beside += bvh_hit_any(stage, &side);
        }
        for (int k = 0; k <= 4; k++) { /* in the axis, inside, on the side, outside */
            const struct ray parallel = {aside * ((float)k * 0.5f) - up * 3, up, INFINITY, 0, 0};
            along += bvh_hit_any(stage, &parallel);
        }
        scenes_release(&s);
    }
    ok(wrong == 0, "rays across the axis hit the side and its rims where they are (%d not)", wrong);
    ok(beside == 0, "rays beside it and past its ends pass (%d do not)", beside);
    ok(along == 0, "rays along the axis hit nothing (%d do)", along);
}

/* From a point of the axis, at 10^-[1, 7] rad to it: met at t = radius / sine, to the last bit. */
static void test_along(void)
{
    struct scenes s;
    const struct stage *stage = one_cylinder(&s, vec3_make(0, 0, -10), vec3_make(0, 0, 1e8f), 0.5f);
    for (int i = 1; i <= 7; i++) {
        const float slope = (float)pow(10, -i);
        double worst = 0;
        for (int k = 0; k < 16; k++) {
            const float a = slope * (float)cos(0.4 * k), b = slope * (float)sin(0.4 * k);
            const struct ray ray = {vec3_make(0, 0, 7), vec3_make(a, b, 1), INFINITY, 0, 0};
            struct ray_hit hit;
            const double t = 0.5 / hypot((double)a, (double)b);
            const bool found = bvh_hit_closest(stage, &ray, &hit);
            worst = fmax(worst, found ? fabs((double)hit.t / t - 1) : HUGE_VAL);
            if (found)
                worst = fmax(worst,
                             fabs((double)surface_at(stage, &ray, &hit).ng[0] - (double)a * t * 2));
        }
        ok(worst < 0x1p-23, "inside, 1e-%d rad from the axis: off by %.1e", i, worst);
    }
    scenes_release(&s);
}

int main(void)
{
    test_box();
    test_far();
    test_tangents();
    test_axes();
    test_along();
    return tap_done();
}
