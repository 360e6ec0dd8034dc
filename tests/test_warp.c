/* warp.h: every map follows its pdf and is finite at the corners of the square.
 * SPDX-License-Identifier: MIT */
#include "common/trace/warp.h"

#include <math.h>

#include "tests/dice.h"
#include "tests/stat/chi2.h"
#include "tests/stat/sphere_chi2.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const uint32_t samples = 1000000 / STAT_SLOW;

static bool cosine_sample(const void *what, struct square q, vec3 *w, float *pdf_w)
{
    (void)what;
    *w = warp_cosine(q);
    *pdf_w = warp_cosine_pdf_w((*w)[2]);
    return *pdf_w > 0;
}

static float cosine_pdf_w(const void *what, vec3 w)
{
    (void)what;
    return w[2] > 0 ? warp_cosine_pdf_w(w[2]) : 0;
}

static bool cap_sample(const void *what, struct square q, vec3 *w, float *pdf_w)
{
    const float k = *(const float *)what;
    *w = warp_cap(q, k);
    *pdf_w = warp_cap_pdf_w(k);
    return true;
}

static float cap_pdf_w(const void *what, vec3 w)
{
    const float k = *(const float *)what;
    return 1 - w[2] <= k * 1.0000002f ? warp_cap_pdf_w(k) : 0;
}

static void follows(const struct sphere_chi2 *t, const char *name)
{
    const struct sphere_chi2_result r = sphere_chi2_run(t, samples, 1);
    ok(r.chi2.p > stat_sidak(0.01, 6), "F-03: %s: samples follow the pdf (p %.3f)", name, r.chi2.p);
    near(r.mass_off, 0, 1e-3, "F-03: %s: pdf integrates to 1", name);
    ok(r.pdf_off < 1e-4, "F-03: %s: pdf of a sample is the pdf of its direction", name);
}

static void directions_follow(void)
{
    follows(&(struct sphere_chi2){cosine_sample, cosine_pdf_w, NULL, 0, 0, NULL, 0, false, 0},
            "cosine hemisphere");
    const float whole = 2, half = 1, some = 2 * 4 / 51.f;
    follows(&(struct sphere_chi2){cap_sample, cap_pdf_w, &whole, 0, 0, NULL, 0, false, 0},
            "whole sphere");
    follows(&(struct sphere_chi2){cap_sample, cap_pdf_w, &half, 0, 0, NULL, 0, false, 0},
            "half sphere");
    follows(&(struct sphere_chi2){cap_sample, cap_pdf_w, &some, 0, 0, NULL, 0, false, 0}, "cap");
}

/* A far sphere's cone: its radius must keep its digits. */
static void small_caps_keep_their_digits(void)
{
    const float k = 0x1p-60f;
    double worst = 0;
    for (int i = 0; i < 1000; i++) {
        const vec3 w = warp_cap((struct square){(float)i / 1000, (float)(i * 7 % 1000) / 1000}, k);
        const double r = hypot((double)w[0], (double)w[1]);
        worst = fmax(worst, fabs(r * r - 2 * (double)k * i / 1000));
    }
    ok(worst < 1e-6 * (double)k, "a cap of 1 - cos = 2^-60 is resolved");
}

static void plane_maps_follow(void)
{
    enum { SIDE = 20 };
    uint32_t disc[SIDE * SIDE] = {0}, triangle[SIDE * SIDE] = {0};
    double due[SIDE * SIDE];
    struct dice dice = dice_make(3);
    bool inside = true;
    for (uint32_t i = 0; i < samples; i++) {
        struct square q;
        q.u = dice_float(&dice);
        q.v = dice_float(&dice);
        const vec3 d = warp_disc(q);
        const double rr = (double)(d[0] * d[0] + d[1] * d[1]);
        const double turn = atan2((double)d[1], (double)d[0]) / 6.283185307179587;
        inside &= rr <= 1.000001;
        disc[(int)(fmin(rr, 0.999999) * SIDE) * SIDE +
             (int)((turn + (turn < 0)) * 0.999999 * SIDE)]++;
        /* Uniform weights (b1, b2) of a triangle: 1 - b0 has the square root's distribution. */
        const struct square b = warp_triangle(q);
        inside &= b.u >= 0 && b.v >= 0 && b.u + b.v <= 1;
        const double s = (double)b.u + (double)b.v, x = s > 0 ? (double)b.u / s : 0;
        triangle[(int)(fmin(s * s, 0.999999) * SIDE) * SIDE + (int)(fmin(x, 0.999999) * SIDE)]++;
    }
    for (int i = 0; i < SIDE * SIDE; i++)
        due[i] = (double)samples / (SIDE * SIDE);
    const double level = stat_sidak(0.01, 5);
    ok(inside, "points of disc and triangle lie inside");
    ok(chi2_test(due, disc, SIDE * SIDE).p > level, "points of the disc are uniform");
    ok(chi2_test(due, triangle, SIDE * SIDE).p > level, "points of the triangle are uniform");
}

static void corners_are_finite(void)
{
    static const float edge[] = {0,    0x1p-24f,        0x1p-23f, 0.25f,        0.5f - 0x1p-24f,
                                 0.5f, 0.5f + 0x1p-24f, 0.75f,    1 - 0x1p-23f, 1 - 0x1p-24f};
    bool finite = true;
    for (size_t i = 0; i < countof(edge); i++)
        for (size_t j = 0; j < countof(edge); j++) {
            const struct square q = {edge[i], edge[j]}, b = warp_triangle(q);
            const vec3 c = warp_cosine(q), s = warp_cap(q, 2), t = warp_cap(q, 1e-30f);
            finite &= fabsf(vec3_length(c) - 1) < 1e-6f && fabsf(vec3_length(s) - 1) < 1e-6f &&
                      fabsf(vec3_length(t) - 1) < 1e-6f && c[2] >= 0 && b.u + b.v <= 1;
        }
    ok(finite, "corners of the square give unit directions");
}

static void frames_are_orthonormal(void)
{
    struct dice dice = dice_make(5);
    double worst = 0;
    for (int i = 0; i < 100000; i++) {
        const struct square q = {dice_float(&dice), 0.37f};
        vec3 z = warp_cap((struct square){q.u, (float)(i % 997) / 997}, 2);
        if (i < 8) /* along axes, and the pole where older constructions divide by zero */
            z = vec3_make(0, i & 1 ? -0.f : 0.f, i & 2 ? -1 : 1);
        const struct warp_frame f = warp_frame_make(z);
        const vec3 c = vec3_cross(f.x, f.y) - z;
        worst = fmax(worst, (double)fabsf(vec3_dot(f.x, f.y)));
        worst = fmax(worst, (double)fabsf(vec3_dot(f.x, f.z)));
        worst = fmax(worst, (double)fabsf(vec3_dot(f.x, f.x) - 1));
        worst = fmax(worst, (double)vec3_length(c));
        const vec3 back = warp_to_local(&f, warp_to_world(&f, vec3_make(.6f, 0, .8f)));
        worst = fmax(worst, (double)vec3_length(back - vec3_make(.6f, 0, .8f)));
    }
    ok(worst < 1e-6, "frames are right-handed and orthonormal: %g", worst);
}

int main(void)
{
    directions_follow();
    small_caps_keep_their_digits();
    plane_maps_follow();
    corners_are_finite();
    frames_are_orthonormal();
    return tap_done();
}
