/* light_map.h: an environment map is sampled as its density says, is seen where it should be, and
 * odd ones have their defined answers. F-30 and A-22 of docs/accuracy.md.
 * SPDX-License-Identifier: MIT */
#include "common/trace/light_map.h"

#include <math.h>

#include "common/estimate.h"
#include "common/trace/light.h"
#include "common/trace/render.h"
#include "tests/dice.h"
#include "tests/naive_path.h"
#include "tests/scenes.h"
#include "tests/stat/sphere_chi2.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

/* --- maps --- */

/* All pixels black, to be filled before the stage is made. */
static float (*add_map(struct scenes *s, uint32_t width, uint32_t height))[3]
{
    float *pixels = arena_new(&s->arena, float, 3 * (size_t)width * height);
    s->scene.images = arena_new(&s->arena, struct image_asset, 1);
    s->scene.images[0] = (struct image_asset){.format = IMAGE_FORMAT_EXR,
                                              .depth = IMAGE_DEPTH_FLOAT,
                                              .width_px = width,
                                              .height_px = height,
                                              .channels = 3,
                                              .pixels = pixels};
    s->scene.image_count = 1;
    struct light *l = scenes_light(s, LIGHT_ENVIRONMENT);
    l->environment.scale = rgb_gray(1);
    l->environment.to_world = xform_identity();
    return (float(*)[3])pixels;
}

static void turn(struct scenes *s, const float m[3][3])
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            s->scene.lights[0].environment.to_world.m[i][k] = m[i][k];
}

static const float askew[3][3] = {{.36f, .48f, -.8f}, {-.8f, .6f, 0}, {.48f, .64f, .6f}};

static void fill_gray(float (*pixels)[3], size_t count, float value)
{
    for (size_t i = 0; i < count; i++)
        vec3_store(pixels[i], rgb_gray(value));
}

static const struct stage_map *map_of(const struct stage *stage)
{
    return stage_at(stage, stage->maps);
}

/* --- the sampler --- */

static bool map_sample(const void *what, struct square q, vec3 *w, float *pdf_w)
{
    const struct stage *stage = what;
    const struct sobol_bits bits = {(uint32_t)((double)q.u * 0x1p32),
                                    (uint32_t)((double)q.v * 0x1p32)};
    const struct light_map_sample found = light_map_sample(stage, map_of(stage), bits);
    *w = found.dir;
    *pdf_w = found.pdf_w;
    return true;
}

static float map_pdf_w(const void *what, vec3 w)
{
    float pdf_w;
    light_map_pixel(what, map_of(what), w, &pdf_w);
    return pdf_w;
}

static void judge_map(struct scenes *s, const char *name)
{
    const struct stage *stage = scenes_stage(s);
    const struct stage_map *map = map_of(stage);
    const struct sphere_chi2 t = {.sample = map_sample,
                                  .pdf_w = map_pdf_w,
                                  .what = stage,
                                  .min_depth = 3,
                                  .pdf_most = 1e-30f}; /* see below */
    const struct sphere_chi2_result r = sphere_chi2_run(&t, 200000 / STAT_SLOW, 1);
    ok(r.chi2.p > stat_sidak(0.01, 4), "%s: directions follow the pdf (p %.3f)", name, r.chi2.p);
    ok(fabs(r.mass_off) < 2e-3 && r.invalid == 0, "%s: the pdf integrates to 1 (%.5f off)", name,
       r.mass_off);
    double mass = 0;
    const struct stage_map_row *rows = stage_at(stage, stage->map_rows);
    for (uint32_t y = 0; y < map->height; y++)
        for (uint32_t x = 0; x < map->width; x++) { /* in the middle of the pixel */
            const double a = pi * (y + .5) / map->height, b = 2 * pi * (x + .5) / map->width - pi;
            const double local[3] = {sin(a) * sin(b), cos(a), -sin(a) * cos(b)};
            vec3 dir = {0};
            for (int i = 0; i < 3; i++)
                for (int k = 0; k < 3; k++)
                    dir[k] += (float)local[i] * map->to_local[i][k];
            mass += (double)map_pdf_w(stage, vec3_unit(dir)) * (double)rows[y].solid_angle;
        }
    ok(fabs(mass - 1) < 1e-5, "%s: its pixels' probabilities sum to 1 (%.0e off)", name, mass - 1);
    /* Only where rounding puts a direction into the next pixel may the two densities differ. */
    struct dice dice = dice_make(2);
    uint32_t other = 0, black = 0;
    const uint32_t n = 200000;
    for (uint32_t i = 0; i < n; i++) {
        const struct sobol_bits q = {dice_bits(&dice), dice_bits(&dice)};
        const struct light_map_sample found = light_map_sample(stage, map, q);
        float pdf_w;
        const rgb pixel = light_map_pixel(stage, map, found.dir, &pdf_w);
        other += pdf_w != found.pdf_w || !rgb_is_black(pixel - found.pixel);
        black += rgb_is_black(found.pixel) || !(found.pdf_w > 0);
    }
    ok(other <= n / 5000 && black == 0,
       "%s: what is sampled is what is seen there (%u of %u beside)", name, other, n);
    scenes_release(s);
}

static void maps_follow(void)
{
    struct scenes s;
    struct dice dice = dice_make(3);
    scenes_init(&s, 1, 1);
    float(*p)[3] = add_map(&s, 8, 4);
    for (int i = 0; i < 32; i++)
        vec3_store(p[i], rgb_gray((float)pow(10, dice_range(&dice, -1, 1))));
    turn(&s, askew);
    judge_map(&s, "8 x 4 pixels, turned");
    scenes_init(&s, 1, 1);
    p = add_map(&s, 1, 5);
    for (int i = 0; i < 5; i++)
        vec3_store(p[i], vec3_make((float)i, 1, 0));
    judge_map(&s, "1 x 5 pixels");
    scenes_init(&s, 1, 1);
    p = add_map(&s, 7, 1);
    for (int i = 0; i < 7; i++)
        vec3_store(p[i], vec3_make(0, 1, (float)(i * i)));
    judge_map(&s, "7 x 1 pixels");
    scenes_init(&s, 1, 1);
    p = add_map(&s, 64, 32);
    for (int i = 0; i < 64 * 32; i++)
        vec3_store(p[i], rgb_gray((float)(1 + .5 * sin(i * .1) * cos(i * .013))));
    vec3_store(p[64 * 5 + 20], rgb_gray(100));
    judge_map(&s, "64 x 32 pixels, one bright");
}

/* --- where it is --- */

static void seen_where_it_is(void)
{
    static const struct {
        float dir[3];
        uint32_t x, y;
    } places[] = {{{.1f, .1f, -1}, 4, 1}, {{-.1f, -.1f, -1}, 3, 2}, {{1, .1f, -.1f}, 5, 1},
                  {{1, .1f, .1f}, 6, 1},  {{-1, .1f, -.1f}, 2, 1},  {{.01f, -1, -.02f}, 4, 3},
                  {{.1f, .1f, 1}, 7, 1},  {{-.1f, .1f, 1}, 0, 1},   {{-.01f, 1, .02f}, 0, 0}};
    struct scenes s;
    scenes_init(&s, 1, 1);
    float(*p)[3] = add_map(&s, 8, 4);
    for (int i = 0; i < 32; i++)
        vec3_store(p[i], vec3_make((float)(i % 8), (float)(i / 8), 1));
    const struct stage *stage = scenes_stage(&s);
    bool right = true;
    for (size_t i = 0; i < countof(places); i++) {
        float pdf_w;
        const rgb c =
            light_map_pixel(stage, map_of(stage), vec3_unit(vec3_load(places[i].dir)), &pdf_w);
        right &= c[0] == (float)places[i].x && c[1] == (float)places[i].y;
    }
    ok(right, "-z is in the middle of the map, +x right of it, +y at its top");
    scenes_release(&s);

    /* The same sight by a panoramic camera, and turned with the map as without. */
    bool same = true;
    for (int turned = 0; turned < 2; turned++) {
        scenes_init(&s, 8, 4);
        p = add_map(&s, 8, 4);
        for (int i = 0; i < 32; i++)
            vec3_store(p[i], vec3_make((float)(i % 8), (float)(i / 8), 1));
        s.scene.camera.kind = CAMERA_PANORAMIC;
        s.scene.camera.to_world = xform_identity();
        if (turned) {
            turn(&s, askew);
            s.scene.camera.to_world = s.scene.lights[0].environment.to_world;
        }
        stage = scenes_stage(&s);
        for (uint32_t i = 0; i < 32; i++) {
            const rgb c = render_sample(stage, i % 8, i / 8, 3);
            same &= c[0] == p[i][0] && c[1] == p[i][1] && c[2] == 1;
        }
        scenes_release(&s);
    }
    ok(same, "a panoramic camera sees the map's own pixels, turned or not");
}

/* --- odd maps --- */

static void odd_maps(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    float(*p)[3] = add_map(&s, 1, 1);
    vec3_store(p[0], vec3_make(1, 2, 3));
    s.scene.lights[0].environment.scale = vec3_make(1, .5f, 2);
    const struct stage *stage = scenes_stage(&s);
    ok(stage->emitters.count == 0 && stage->sky[0] == 1 && stage->sky[1] == 1 && stage->sky[2] == 6,
       "a map of one pixel is a sky");
    scenes_release(&s);

    scenes_init(&s, 1, 1);
    p = add_map(&s, 64, 32);
    fill_gray(p, 64 * 32, .25f);
    stage = scenes_stage(&s);
    ok(stage->emitters.count == 0 && stage->sky[0] == .25f,
       "F-30: a uniform map is a sky, and costs what a sky costs");
    scenes_release(&s);

    scenes_init(&s, 1, 1);
    add_map(&s, 16, 8);
    stage = scenes_stage(&s);
    ok(stage->emitters.count == 0 && rgb_is_black(stage->sky) &&
           rgb_is_black(render_sample(stage, 0, 0, 0)),
       "a black map is darkness");
    scenes_release(&s);

    scenes_init(&s, 1, 1);
    p = add_map(&s, 2, 1);
    vec3_store(p[0], vec3_make(-1, 3, -1e30f));
    vec3_store(p[1], vec3_make(0, 0, -0.f));
    stage = scenes_stage(&s);
    const struct stage_map_pixel *pixels = stage_at(stage, stage->map_pixels);
    ok(pixels[0].rgb[0] == 0 && pixels[0].rgb[1] == 3 && pixels[0].rgb[2] == 0 &&
           pixels[1].rgb[2] == 0,
       "values below 0 count as 0");
    scenes_release(&s);

    scenes_init(&s, 1, 1);
    p = add_map(&s, 16, 8);
    vec3_store(p[37], rgb_gray(1e18f));
    vec3_store(p[38], rgb_gray(1e-30f));
    s.scene.lights[0].environment.scale = rgb_gray(1e18f);
    stage = scenes_stage(&s);
    bool good = true;
    for (uint32_t i = 0; i < 64; i++) {
        const struct light_map_sample found = light_map_sample(
            stage, map_of(stage), (struct sobol_bits){i * 0x04104104u, (63 - i) * 0x04000000u});
        good &= found.pixel[0] == 1e18f && found.pdf_w > 0 && isfinite(found.pdf_w) &&
                fabsf(vec3_length(found.dir) - 1) < 1e-6f;
    }
    ok(good, "a single pixel of 1e18 times 1e18 is found by every number");
    scenes_release(&s);
}

/* Were it merely improbable, strategy "light" would leave it to aiming, which does not find it. */
static void dim_pixels_are_not_aimed_at(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    float(*p)[3] = add_map(&s, 16, 8);
    fill_gray(p, 16 * 8, .5f);
    fill_gray(p + 37, 1, 9);
    const struct stage *stage = scenes_stage(&s);
    const struct light_map_sample last =
        light_map_sample(stage, map_of(stage), (struct sobol_bits){UINT32_MAX, UINT32_MAX});
    struct dice d = dice_make(5);
    int aimed_at = 0;
    for (int i = 0; i < 20000; i++) {
        vec3 dir = {0};
        float pdf_w;
        for (int k = 0; k < 3; k++)
            dir[k] = (float)dice_normal(&d);
        const rgb seen = light_map_pixel(stage, map_of(stage), vec3_unit(dir), &pdf_w);
        aimed_at += seen[0] < 1 && pdf_w != 0;
    }
    ok(aimed_at == 0 && last.pixel[0] == 9 && isfinite(last.pdf_w),
       "pixels that are not above the mean have no chance at all, the last ones neither: %d have",
       aimed_at);
    scenes_release(&s);
}

/* --- A-22, F-30 --- */

enum { W = 1024, H = 512 };

struct sun { /* pixels of 1e6 where the rest is 1 */
    uint32_t x, y, side;
};

static void add_sun_pixels(struct scenes *s, struct sun sun)
{
    float(*p)[3] = add_map(s, W, H);
    fill_gray(p, (size_t)W * H, 1);
    for (uint32_t i = 0; i < sun.side * sun.side; i++)
        vec3_store(p[(size_t)(sun.y + i / sun.side) * W + (sun.x + i % sun.side) % W],
                   rgb_gray(1e6f));
}

/* E = pi + (1e6 - 1) times the integral of the cosine, over pixels by many points each. */
static double sun_irradiance(struct sun sun, vec3 n, double *solid)
{
    const int fine = 200;
    double e = 0;
    *solid = 0;
    for (uint32_t i = 0; i < sun.side * sun.side; i++)
        for (int k = 0; k < fine * fine; k++) {
            const double y = sun.y + i / sun.side, x = sun.x + i % sun.side;
            const double a = pi * (y + (k / fine + .5) / fine) / H;
            const double b = 2 * pi * (x + (k % fine + .5) / fine) / W - pi;
            const double dw = sin(a) * (pi / H / fine) * (2 * pi / W / fine);
            const double cosine = sin(a) * sin(b) * (double)n[0] + cos(a) * (double)n[1] -
                                  sin(a) * cos(b) * (double)n[2];
            e += cosine > 0 ? cosine * dw : 0;
            *solid += dw;
        }
    return pi + (1e6 - 1) * e;
}

static void receiver(struct scenes *s, vec3 n)
{
    scenes_init(s, 8, 8);
    scenes_look(s, n * 0.01f, vec3_make(0, 0, 0), 1e-3);
    s->scene.settings.max_bounces = 1;
    scenes_disc(s, scenes_diffuse(s, rgb_gray(1)), vec3_make(0, 0, 0), n, 1e-3f);
}

static void sun_pixels(struct sun sun, vec3 normal, const char *name)
{
    struct scenes s;
    struct film film;
    double solid;
    const vec3 n = vec3_unit(normal);
    receiver(&s, n);
    add_sun_pixels(&s, sun);
    const double truth = sun_irradiance(sun, n, &solid) / pi;
    scenes_render(scenes_stage(&s), stat_tries(1024, 8192), &film);
    const struct scenes_mean m = scenes_mean(&film, 1);
    const double off = fabs(m.mean - truth);
    ok(off < 3.9 * m.error + 2e-5 * truth && (STAT_SLOW > 1 || 6.23 * m.error < 1e-3 * truth) &&
           film.invalid_count == 0,
       "A-22: %s: %.6g is %.6g (%.4f %% off, detects %.3f %%)", name, truth, m.mean,
       100 * off / truth, 623 * m.error / truth);
    film_release(&film);
    scenes_release(&s);
}

/* Of an image of a ball on a floor, as its replicates tell. */
static double relative_error(struct scenes *s)
{
    struct film film;
    double sum = 0;
    scenes_look(s, vec3_make(0, 2, 5), vec3_make(0, .5f, 0), .6);
    s->scene.settings.max_bounces = 3;
    const uint32_t gray = scenes_diffuse(s, rgb_gray(.5f));
    scenes_quad(s, gray, vec3_make(-5, 0, 5), vec3_make(10, 0, 0), vec3_make(0, 0, -10));
    scenes_sphere(s, gray, vec3_make(0, 1, 0), 1);
    scenes_render(scenes_stage(s), 64, &film);
    const size_t count = tile_rect_pixels(film.window);
    for (size_t i = 0; i < count; i++) {
        double mean[3], error[3];
        film_mean(&film, i, mean);
        estimate_pixel(&film, i, error);
        sum += error[1] * error[1] / (mean[1] * mean[1] + 1e-2) / (double)count;
    }
    film_release(&film);
    scenes_release(s);
    return sum;
}

static void as_good_as_a_disc(void)
{
    struct scenes s;
    const struct sun sun = {600, 120, 1};
    double solid;
    sun_irradiance(sun, vec3_make(0, 1, 0), &solid);
    scenes_init(&s, 64, 64);
    add_sun_pixels(&s, sun);
    const double map = relative_error(&s);
    scenes_init(&s, 64, 64);
    scenes_sky(&s, rgb_gray(1));
    struct light *disc = scenes_light(&s, LIGHT_SUN);
    const double a = pi * 120.5 / H, b = 2 * pi * 600.5 / W - pi;
    vec3_store(disc->sun.direction,
               -vec3_make((float)(sin(a) * sin(b)), (float)cos(a), (float)(-sin(a) * cos(b))));
    disc->sun.radius_rad = (float)sqrt(solid / pi);
    disc->sun.radiance = rgb_gray(1e6f);
    const double reference = relative_error(&s);
    ok(map < 2 * reference, "F-30: a sun pixel: relMSE %.3g at 64 spp, a disc of its power %.3g",
       map, reference);
}

/* --- whole paths --- */

static void paths_agree(void)
{
    struct scenes s;
    struct film film;
    struct dice dice = dice_make(5);
    scenes_init(&s, 8, 8);
    scenes_look(&s, vec3_make(0, 1, 1.5f), vec3_make(0, 0, 0), .2);
    s.scene.settings.max_bounces = 3;
    scenes_disc(&s, scenes_metal(&s, rgb_gray(.2f), rgb_gray(3), .3f), vec3_make(0, 0, 0),
                vec3_make(0, 1, 0), 1);
    scenes_sphere(&s, scenes_diffuse(&s, rgb_gray(.7f)), vec3_make(0, .3f, -.6f), .3f);
    float(*p)[3] = add_map(&s, 32, 16);
    for (int i = 0; i < 32 * 16; i++)
        vec3_store(p[i], rgb_gray((float)pow(10, dice_range(&dice, -1, .7))));
    turn(&s, askew);
    const struct stage *stage = scenes_stage(&s);
    scenes_render(stage, stat_tries(1024, 8192), &film);
    const struct scenes_mean ours = scenes_mean(&film, 1);
    const struct stat_mean naive = naive_path_mean(stage, stat_tries(600000, 4000000), 5);
    const double error = hypot(ours.error, stat_error(&naive));
    ok(fabs(ours.mean - naive.mean) < 3.9 * error &&
           (STAT_SLOW > 1 || 6.23 * error < .02 * naive.mean),
       "a ball and a plate of metal under a map: %.5f is %.5f by directions alone (detects %.2f "
       "%%)",
       ours.mean, naive.mean, 623 * error / naive.mean);
    film_release(&film);
    scenes_release(&s);
}

int main(void)
{
    maps_follow();
    seen_where_it_is();
    odd_maps();
    dim_pixels_are_not_aimed_at();
    sun_pixels((struct sun){600, 120, 1}, vec3_make(0, 1, 0), "sun pixel");
    sun_pixels((struct sun){100, 250, 1}, vec3_make(-.3f, 1, .2f), "sun pixel near the horizon");
    sun_pixels((struct sun){300, 0, 2}, vec3_make(0, 1, 0), "2 x 2 at the pole");
    sun_pixels((struct sun){W - 1, 200, 2}, vec3_make(0, .3f, 1), "2 x 2 across the seam");
    as_good_as_a_disc();
    paths_agree();
    return tap_done();
}
