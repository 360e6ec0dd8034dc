/* report.c and what it is made of: the light that limits take away.
 * SPDX-License-Identifier: MIT */
#include "server/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/status_report.h"
#include "tests/scenes.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

/* Of a scene with these bounds; the film is released. */
static struct store_report report_of(struct scenes *s, uint32_t max_bounces, float clamp,
                                     uint32_t spp)
{
    struct film f;
    s->scene.settings.max_bounces = max_bounces;
    s->scene.settings.clamp = clamp;
    scenes_render(scenes_stage(s), spp, &f);
    const struct store_report r = report_make(&f);
    film_release(&f);
    return r;
}

/* a closed body of emission 1 and albedo a. What paths of d bounces leave out is a^(d + 1) /
 * (1 - a). */
static void furnace(float albedo, uint32_t bounces)
{
    struct scenes s;
    scenes_init(&s, 32, 32);
    scenes_box(&s, scenes_diffuse(&s, rgb_gray(albedo)), (vec3){-1, -1, -1}, (vec3){1, 1, 1}, true);
    for (uint32_t i = 0; i < s.scene.shape_count; i++)
        s.scene.shapes[i].emission = rgb_gray(1);
    const double a = (double)albedo, truth = pow(a, bounces + 1) / (1 - a);
    const struct store_report r = report_of(&s, bounces, 0, stat_tries(256, 1024));
    near(r.cut / truth, 1, .2, "F-06: furnace of albedo %g, %u bounces: %.3f of %.3f is cut", a,
         bounces, r.cut, truth);
    near((r.energy + r.cut) * (1 - a), 1, .1, "and is what is missing");
    scenes_release(&s);
}

/* a glass ball under a sky of 1; every pixel would be 1. */
static void ball(uint32_t bounces)
{
    struct scenes s;
    scenes_init(&s, 32, 32);
    scenes_sphere(&s, scenes_glass(&s, 1.5f), (vec3){0, 0, -3}, 1);
    scenes_sky(&s, rgb_gray(1));
    const struct store_report r = report_of(&s, bounces, 0, stat_tries(512, 4096));
    const double truth = 1 - r.energy;
    near(r.cut / truth, 1, .2, "F-06: glass ball, %u bounces: %.4f of %.4f is cut", bounces, r.cut,
         truth);
    scenes_release(&s);
}

static void nothing_cut(void)
{
    struct scenes s;
    scenes_init(&s, 16, 16);
    scenes_sphere(&s, scenes_diffuse(&s, rgb_gray(.5f)), (vec3){0, 0, -3}, 1);
    scenes_sky(&s, rgb_gray(1));
    const struct store_report r = report_of(&s, 64, 0, 16);
    ok(r.cut == 0 && r.clamped == 0, "where no path is that long nothing is cut, or clamped");
    scenes_release(&s);
}

/* F-34: a caustic, by glass between a small lamp and a floor. What the clamp says it takes is what
 * the image lacks beside one without. */
static void caustic_make(struct scenes *s)
{
    scenes_init(s, 32, 32);
    const uint32_t gray = scenes_diffuse(s, rgb_gray(.8f));
    scenes_quad(s, gray, (vec3){-3, 0, 3}, (vec3){6, 0, 0}, (vec3){0, 0, -6});
    scenes_sphere(s, scenes_glass(s, 1.5f), (vec3){0, 1.2f, 0}, .7f);
    scenes_sphere(s, gray, (vec3){0, 4, 0}, .15f)->emission = rgb_gray(600);
    scenes_look(s, (vec3){0, 3, 4}, (vec3){0, .3f, 0}, .6);
}

static void clamped(float limit)
{
    struct scenes s;
    const uint32_t spp = stat_tries(256, 2048);
    caustic_make(&s);
    const struct store_report all = report_of(&s, 64, 0, spp);
    const struct store_report less = report_of(&s, 64, limit, spp);
    const double truth = all.energy - less.energy;
    ok(truth > .01 * all.energy, "clamp %g takes %.1f %% of a caustic's picture", (double)limit,
       100 * truth / all.energy);
    near(less.clamped / truth, 1, .1, "F-34: it says so: %.5f of %.5f", less.clamped, truth);
    ok(all.clamped == 0, "without it nothing is taken");
    scenes_release(&s);
}

/* Under a signed filter, and with layers: what is clamped is missing there, too. */
static void clamped_layers(void)
{
    struct scenes s;
    struct film f;
    caustic_make(&s);
    s.scene.film.filter = FILTER_MITCHELL;
    s.scene.film.filter_radius_px = 2;
    s.scene.film.filter_b = s.scene.film.filter_c = 1 / 3.f;
    s.scene.film.layers = layers_make(0, 4);
    s.scene.settings.clamp = 10;
    scenes_render(scenes_stage(&s), 64, &f);
    double off = 0, most = 0;
    for (size_t i = 0; i < tile_rect_pixels(f.window); i++)
        for (uint32_t c = 0; c < 3; c++) {
            double sum = 0;
            for (uint32_t k = 0; k < 5; k++)
                sum += f.layer[i * layers_channels(f.layers) + 3 * k + c];
            off = fmax(off, fabs(sum - f.sum[3 * i + c]));
            most = fmax(most, fabs(f.sum[3 * i + c]));
        }
    ok(off < 1e-6 * most, "layers of clamped samples still add up to the image: %g of %g", off,
       most);
    ok(report_make(&f).clamped > 0, "under a filter with a sign the clamp's share is counted");
    film_release(&f);
    scenes_release(&s);
}

static void says_it_in_json(void)
{
    const struct store_job row = {.error = .125,
                                  .report = {.error_low = .1,
                                             .error_high = .15,
                                             .unknown = .25,
                                             .heavy = .5,
                                             .energy = 3,
                                             .clamped = 1,
                                             .cut = 0,
                                             .work = {1, 2, 3, 4, 5, 6},
                                             .dropped = {6, 7},
                                             .spp_least = 16,
                                             .spp_most = 64,
                                             .spp_mean = 20.5,
                                             .stopped = .75},
                                  .invalid_count = 1,
                                  .key_count = 1,
                                  .keys = {{8, 9, 10}}};
    char *text = status_report_text(&row);
    static const char want[] =
        "{\"error\":{\"estimate\":0.125,\"interval\":[0.10000000000000001,0.14999999999999999],"
        "\"coverage\":\"untrusted\"},\"pixels\":{\"trusted\":0.25,\"unknown\":0.25,"
        "\"heavy_tail\":0.5},\"spp\":{\"least\":16,\"mean\":20.5,\"most\":64},\"stopped\":0.75,"
        "\"mean_luminance\":3.0,\"removed\":{\"max_bounces\":{\"luminance\":0.0,"
        "\"share\":0.0},\"clamp\":{\"luminance\":1.0,\"share\":0.25}},\"invalid_samples\":{"
        "\"count\":1,"
        "\"keys\":[[8,9,10]]},\"triangles_dropped\":{\"degenerate\":6,\"not_finite\":7},\"work\":{"
        "\"camera_rays\":1,\"bounce_rays\":2,\"shadow_rays\":3,\"plain_vertices\":4,"
        "\"other_vertices\":5,\"units\":6}}";
    if (!ok(text && !strcmp(text, want), "a report is said in JSON"))
        diag("%s", text ? text : "(none)");
    free(text);
    struct store_job fresh = {.error = -1, .report = report_none()};
    text = status_report_text(&fresh);
    ok(text && strstr(text, "\"estimate\":null,\"interval\":null,\"coverage\":\"unknown\"") &&
           strstr(text, "\"trusted\":null"),
       "what is not known yet is null");
    free(text);
}

int main(void)
{
    furnace(.95f, 8);
    furnace(.5f, 2);
    furnace(.8f, 0);
    ball(1);
    nothing_cut();
    clamped(10);
    clamped_layers();
    says_it_in_json();
    return tap_done();
}
