/* filter.h: sampled offsets follow each filter, weights of signed ones have the mean 1, an edge has
 * the profile that the filter's integral says, a constant stays one, and signs hide no error.
 * SPDX-License-Identifier: MIT */
#include "common/trace/filter.h"

#include <math.h>

#include "common/estimate.h"
#include "common/image.h"
#include "tests/dice.h"
#include "tests/scenes.h"
#include "tests/stat/chi2.h"
#include "tests/stat/ks.h"
#include "tests/stat/means.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

static const struct {
    const char *name;
    struct scene_film film;
} filters[] = {
    {"box", {.filter = FILTER_BOX, .filter_radius_px = .5f}},
    {"tent", {.filter = FILTER_TENT, .filter_radius_px = 1.5f}},
    {"gaussian", {.filter = FILTER_GAUSSIAN, .filter_radius_px = 1.5f, .filter_sigma_px = .5f}},
    {"gaussian cut early",
     {.filter = FILTER_GAUSSIAN, .filter_radius_px = 1, .filter_sigma_px = 16}},
    {"gaussian far from its cut",
     {.filter = FILTER_GAUSSIAN, .filter_radius_px = 16, .filter_sigma_px = .05f}},
    {"Blackman-Harris", {.filter = FILTER_BLACKMAN_HARRIS, .filter_radius_px = 1.5f}},
    {"Mitchell, 1/3, 1/3",
     {.filter = FILTER_MITCHELL, .filter_radius_px = 2, .filter_b = 1 / 3.f, .filter_c = 1 / 3.f}},
    {"Mitchell, 0, 1 (the largest lobe)",
     {.filter = FILTER_MITCHELL, .filter_radius_px = 3, .filter_b = 0, .filter_c = 1}},
    {"Mitchell, 1, 0 (a B-spline)",
     {.filter = FILTER_MITCHELL, .filter_radius_px = 2, .filter_b = 1, .filter_c = 0}},
    {"Mitchell, 0, 0 (nothing beyond 1)",
     {.filter = FILTER_MITCHELL, .filter_radius_px = 2, .filter_b = 0, .filter_c = 0}},
};

/* As the papers write them. */
static double shape(const struct scene_film *film, double x)
{
    const double r = (double)film->filter_radius_px, s = (double)film->filter_sigma_px;
    const double b = (double)film->filter_b, c = (double)film->filter_c, t = 2 * fabs(x) / r;
    const double w = pi * (x / r + 1);
    if (fabs(x) > r)
        return 0;
    switch (film->filter) {
    case FILTER_BOX:
        return 1;
    case FILTER_TENT:
        return 1 - fabs(x) / r;
    case FILTER_GAUSSIAN:
        return exp(-x * x / (2 * s * s));
    case FILTER_BLACKMAN_HARRIS:
        return 0.35875 - 0.48829 * cos(w) + 0.14128 * cos(2 * w) - 0.01168 * cos(3 * w);
    case FILTER_MITCHELL:
        if (t < 1)
            return ((12 - 9 * b - 6 * c) * t * t * t + (-18 + 12 * b + 6 * c) * t * t +
                    (6 - 2 * b)) /
                   6;
        return ((-b - 6 * c) * t * t * t + (6 * b + 30 * c) * t * t + (-12 * b - 48 * c) * t +
                (8 * b + 24 * c)) /
               6;
    }
    return 0;
}

enum { STEPS = 1 << 16 };

/* Integrals from -r up to each of STEPS + 1 places, by the trapezoid rule: of the filter and of its
 * absolute value. */
struct integral {
    double r, plain[STEPS + 1], absolute[STEPS + 1];
};

static void integrate(struct integral *in, const struct scene_film *film)
{
    in->r = (double)film->filter_radius_px;
    if (film->filter == FILTER_GAUSSIAN) /* beyond there is less than 1e-22 */
        in->r = fmin(in->r, 10 * (double)film->filter_sigma_px);
    in->plain[0] = in->absolute[0] = 0;
    for (int i = 1; i <= STEPS; i++) {
        const double h = 2 * in->r / STEPS;
        const double a = shape(film, -in->r + (i - 1) * h), b = shape(film, -in->r + i * h);
        in->plain[i] = in->plain[i - 1] + (a + b) / 2 * h;
        in->absolute[i] = in->absolute[i - 1] + (fabs(a) + fabs(b)) / 2 * h;
    }
}

/* The part of the whole up to x. */
static double part(const struct integral *in, const double sums[STEPS + 1], double x)
{
    const double at = (x / in->r + 1) / 2 * STEPS;
    if (at <= 0)
        return 0;
    if (at >= STEPS)
        return 1;
    const int i = (int)at;
    return (sums[i] + (at - i) * (sums[i + 1] - sums[i])) / sums[STEPS];
}

static struct integral in; /* too large for a stack */

/* A scene's stage with this filter; an edge at x = 0, light to its left. */
static const struct stage *stage_of(struct scenes *s, const struct scene_film *film)
{
    scenes_init(s, 16, 8);
    struct scene_film *f = &s->scene.film;
    f->filter = film->filter;
    f->filter_radius_px = film->filter_radius_px;
    f->filter_sigma_px = film->filter_sigma_px;
    f->filter_b = film->filter_b;
    f->filter_c = film->filter_c;
    scenes_look(s, vec3_make(.3f, 0, 1), vec3_make(.3f, 0, 0), 1);
    s->scene.camera.kind = CAMERA_ORTHOGRAPHIC;
    s->scene.camera.width = 16; /* a pixel is a metre */
    s->scene.camera.height = 0;
    scenes_quad(s, scenes_diffuse(s, rgb_gray(0)), vec3_make(-100, -100, 0), vec3_make(100, 0, 0),
                vec3_make(0, 200, 0))
        ->emission = rgb_gray(1);
    return scenes_stage(s);
}

static double offset(const struct stage *s, float u)
{
    return (double)filter_offset(s, f32x8_splat(u))[0];
}

/* --- the map from numbers to offsets --- */

static void inverts(const char *name, const struct stage *s)
{
    double worst = 0, before = -(double)INFINITY, gain = 0;
    bool rises = true;
    enum { N = 1 << 16 };
    for (int i = -1; i <= N; i++) {
        const float u = i < 0 ? 0 : i == N ? 1 - 0x1p-24f : ((float)i + .5f) / N;
        const double x = offset(s, u);
        rises &= x >= before && fabs(x) <= (double)s->film.filter_radius_px * (1 + 1e-7);
        before = x;
        worst = fmax(worst, fabs(part(&in, in.absolute, x) - (double)u));
        if (i >= 0 && i < N)
            gain += (double)s->filter.gain * (fabs(x) > (double)s->filter.zero_px ? -1 : 1) / N;
    }
    ok(rises && worst < 2e-5, "%s: offsets are the inverse of the integral, off by %.1e", name,
       worst);
    near(gain, 1, 1e-4, "%s: the mean weight is 1", name);
    near((double)s->filter.gain, in.absolute[STEPS] / in.plain[STEPS], 1e-4,
         "%s: gain %.4f is the mass of the absolute value", name, (double)s->filter.gain);
}

static void follows(const char *name, const struct stage *s, uint64_t seed)
{
    enum { BINS = 64, N = 20000 };
    const uint32_t tries = stat_tries(N, N);
    const double level = stat_sidak(0.01, 2 * countof(filters));
    struct dice d = dice_make(seed);
    static double place[N];
    uint32_t seen[BINS] = {0};
    double due[BINS];
    for (uint32_t i = 0; i < tries; i++) {
        const double x = offset(s, dice_float(&d));
        place[i] = part(&in, in.absolute, x);
        seen[(int)fmin((x / in.r + 1) / 2 * BINS, BINS - 1)]++;
    }
    for (int i = 0; i < BINS; i++)
        due[i] = tries * (part(&in, in.absolute, ((i + 1.) / BINS * 2 - 1) * in.r) -
                          part(&in, in.absolute, ((double)i / BINS * 2 - 1) * in.r));
    const struct chi2 chi = chi2_test(due, seen, BINS);
    const struct ks ks = ks_test(place, tries);
    ok(chi.p > level && ks.p > level,
       "%s: sampled offsets follow it (chi-square p %.3f, detects %.3f rms; K-S p %.3f, detects "
       "%.4f)",
       name, chi.p, chi2_detects(&chi, tries, level), ks.p, ks_detects(tries, level));
}

/* --- images --- */

/* Each column beside the edge, which lies .3 pixels left of the middle of the frame. */
static void edge(const char *name, const struct stage *s)
{
    struct film film;
    scenes_render(s, max_u32(stat_tries(2048, 32768), 2048), &film);
    double worst = 0, least = (double)INFINITY, most = -least, bar = 0;
    for (uint32_t x = 0; x < 16; x++) {
        const double want = part(&in, in.plain, -((double)x + .5 - (8 - (double).3f)));
        double sum = 0, square = 0;
        for (uint32_t y = 0; y < 8; y++) {
            double mean[3], error[3];
            film_mean(&film, y * 16 + x, mean);
            estimate_pixel(&film, y * 16 + x, error);
            sum += mean[1] / 8;
            square += error[1] * error[1] / 64;
        }
        worst = fmax(worst, fabs(sum - want) / (sqrt(square) + 2e-5));
        bar = fmax(bar, sqrt(square));
        least = fmin(least, sum);
        most = fmax(most, sum);
    }
    ok(worst < 4.5 && bar < .01,
       "%s: an edge is its integral in 16 columns (z %.1f, errors %.1e; from %.3f to %.3f)", name,
       worst, bar, least, most);
    ok(film.invalid_count == 0, "%s: a negative weight is no invalid sample", name);
    film_release(&film);
}

static void constant(const char *name, const struct scene_film *film)
{
    struct scenes s;
    struct film out;
    stage_of(&s, film);
    s.scene.shape_count = 0;
    scenes_sky(&s, rgb_gray(.75f));
    const struct stage *stage = scenes_stage(&s);
    scenes_render(stage, stat_tries(1024, 8192), &out);
    struct stat_mean m = {0};
    double off = 0;
    for (size_t i = 0; i < tile_rect_pixels(out.window); i++) {
        double mean[3];
        film_mean(&out, i, mean);
        stat_add(&m, mean[0]);
        off = fmax(off, fabs(mean[0] - .75));
    }
    if (filter_is_signed(stage)) {
        const struct means t = means_from_truth(&m, .75);
        const double margin = STAT_SLOW > 1 ? .1 : stat_is_long() ? .004 : .01;
        ok(means_unequal_p(&t, margin) < 0.01, "%s: a constant stays one, within %g (%.5f)", name,
           margin, m.mean);
    } else {
        ok(off == 0, "%s: a constant stays one, exactly", name);
    }
    film_release(&out);
    scenes_release(&s);
}

/* What is invalid is so before the sign. */
static void errors_show(const struct scene_film *film)
{
    struct scenes s;
    stage_of(&s, film);
    s.scene.shapes[0].emission = rgb_gray(3e38f);
    const struct stage *bad = scenes_stage(&s);
    struct film out;
    scenes_render(bad, 64, &out);
    bool finite = true;
    for (size_t i = 0; i < 3 * (size_t)tile_rect_pixels(out.window); i++)
        finite &= isfinite(out.sum[i]) && out.sum[i] == 0;
    near((double)out.invalid_count / (16 * 8 * 64), 7.7 / 16, .01,
         "under a signed filter too-bright samples are noted, and black");
    ok(finite, "whatever their sign");
    film_release(&out);
    scenes_release(&s);
}

/* The terms of the light carry the sign of their sample. */
static void terms_add_up(const struct scene_film *film)
{
    struct scenes s;
    struct film out;
    stage_of(&s, film);
    s.scene.film.layers = layers_make(0, 1);
    s.scene.materials[0].diffuse.albedo = rgb_gray(.5f);
    scenes_sky(&s, rgb_gray(.25f));
    scenes_render(scenes_stage(&s), 64, &out);
    struct arena arena = {0};
    const struct image image = image_from_film(&out, 16, 8, &arena);
    const float *whole = image_find(&image, "R")->pixels;
    const float *first = image_find(&image, "bounce0.R")->pixels;
    const float *rest = image_find(&image, "rest.R")->pixels;
    double off = 0, scattered = 0;
    for (size_t i = 0; i < 16 * 8; i++) {
        off = fmax(off, fabs((double)first[i] + (double)rest[i] - (double)whole[i]));
        scattered += (double)rest[i];
    }
    ok(off < 1e-6 && scattered > 1, "bounce layers add up under a signed filter, too (%.1e)", off);
    arena_release(&arena);
    film_release(&out);
    scenes_release(&s);
}

int main(void)
{
    for (size_t i = 0; i < countof(filters); i++) {
        struct scenes s;
        const struct stage *stage = stage_of(&s, &filters[i].film);
        integrate(&in, &filters[i].film);
        inverts(filters[i].name, stage);
        follows(filters[i].name, stage, i);
        edge(filters[i].name, stage);
        scenes_release(&s);
        constant(filters[i].name, &filters[i].film);
    }
    errors_show(&filters[7].film);
    terms_add_up(&filters[7].film);
    return tap_done();
}
