/* camera.h, prep_camera.c: pixels to rays against formulas in double, apertures that are even, what
 * a lens makes of points in and out of focus, the scale of a parallel projection, and a panorama
 * that is the whole sphere. SPDX-License-Identifier: MIT */
#include "common/trace/camera.h"

#include <math.h>
#include <stdlib.h>

#include "common/trace/sampler.h"
#include "tests/dice.h"
#include "tests/scenes.h"
#include "tests/stat/chi2.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

enum { WIDTH = 640, HEIGHT = 360 };

static const vec3 from = {1, 2, 3}, at = {-4, 1, 7};

static void setup(struct scenes *s, uint32_t width, uint32_t height, enum camera_kind kind)
{
    scenes_init(s, width, height);
    scenes_look(s, from, at, 0.9);
    s->scene.camera.kind = kind;
}

static void lens(struct scenes *s, float radius, float focus, uint32_t blades, float turn)
{
    struct scene_camera *c = &s->scene.camera;
    c->lens_radius = radius;
    c->focus = focus;
    c->blades = blades;
    c->blades_turn = turn;
}

/* The ray in the camera's own space: x right, y up, -z ahead. */
struct own_ray {
    double origin[3], dir[3];
};

static struct own_ray own(const struct scenes *s, const struct ray *ray)
{
    const struct xform *m = &s->scene.camera.to_world;
    struct own_ray o = {{0}, {0}};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            o.origin[i] += (double)m->m[k][i] * ((double)ray->origin[k] - (double)m->m[k][3]);
            o.dir[i] += (double)m->m[k][i] * (double)ray->dir[k];
        }
    return o;
}

static double apart(const double a[3], const double b[3])
{
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

static void unit(double v[3])
{
    const double length = hypot(hypot(v[0], v[1]), v[2]);
    for (int k = 0; k < 3; k++)
        v[k] /= length;
}

/* What a pixel's ray is by the books. */
static struct own_ray by_the_book(const struct scene_camera *c, double x, double y)
{
    struct own_ray o = {{0, 0, 0}, {0, 0, -1}};
    const double right = (x - WIDTH / 2.) / HEIGHT, up = (HEIGHT / 2. - y) / HEIGHT;
    if (c->kind == CAMERA_ORTHOGRAPHIC) {
        const double height = c->height > 0 ? (double)c->height : (double)c->width * HEIGHT / WIDTH;
        o.origin[0] = right * height;
        o.origin[1] = up * height;
    } else if (c->kind == CAMERA_PANORAMIC) {
        const double longitude = 2 * pi * (x / WIDTH - .5), latitude = pi * (.5 - y / HEIGHT);
        o.dir[0] = sin(longitude) * cos(latitude);
        o.dir[1] = sin(latitude);
        o.dir[2] = -cos(longitude) * cos(latitude);
    } else {
        const double span = 2 * tan((double)c->fov_y_rad / 2);
        o.dir[0] = right * span;
        o.dir[1] = up * span;
        unit(o.dir);
    }
    return o;
}

static void rays_are_right(const char *name, const struct scenes *s, const struct stage *stage)
{
    struct dice d = dice_make(3);
    double worst = 0;
    for (int i = 0; i < 20000; i++) {
        const float x = WIDTH * dice_float(&d), y = HEIGHT * dice_float(&d);
        const struct ray ray = camera_ray(&stage->camera, x, y);
        const struct own_ray got = own(s, &ray);
        const struct own_ray want = by_the_book(&s->scene.camera, (double)x, (double)y);
        worst = fmax(worst, apart(got.origin, want.origin));
        worst = fmax(worst, apart(got.dir, want.dir));
    }
    ok(worst < 1e-6, "%s: rays as by the book, off by %.1e at most", name, worst);
}

static void kinds(void)
{
    static const char *const names[] = {"perspective", "thin lens, its middle", "orthographic",
                                        "panoramic", "orthographic by its width"};
    for (int i = 0; i < 5; i++) {
        struct scenes s;
        setup(&s, WIDTH, HEIGHT, i == 4 ? CAMERA_ORTHOGRAPHIC : (enum camera_kind)i);
        if (i == CAMERA_THIN_LENS)
            lens(&s, .1f, 2, 0, 0);
        if (s.scene.camera.kind == CAMERA_ORTHOGRAPHIC) {
            s.scene.camera.width = i == 4 ? 2.5f : 0;
            s.scene.camera.height = i == 4 ? 0 : 1.5f;
        }
        rays_are_right(names[i], &s, scenes_stage(&s));
        scenes_release(&s);
    }
}

/* --- the lens --- */

/* In the regular polygon of n corners on the unit circle, or in the circle. */
static bool in_aperture(double x, double y, uint32_t n, double turn)
{
    if (!n)
        return x * x + y * y <= 1;
    const double inner = cos(pi / n), step = 2 * pi / n;
    for (uint32_t i = 0; i < n; i++) {
        const double a = 2 * pi * turn + (i + .5) * step;
        if (x * cos(a) + y * sin(a) > inner)
            return false;
    }
    return true;
}

enum { CELLS = 24, FINE = 40 };

static void expect(double due[CELLS * CELLS], uint32_t blades, double turn, double samples)
{
    double all = 0;
    for (int i = 0; i < CELLS * CELLS * FINE * FINE; i++) {
        const int row = i / (CELLS * FINE), column = i % (CELLS * FINE);
        const double x = (column + .5) / (CELLS * FINE) * 2 - 1;
        const double y = (row + .5) / (CELLS * FINE) * 2 - 1;
        const bool in = in_aperture(x, y, blades, turn);
        due[row / FINE * CELLS + column / FINE] += in;
        all += in;
    }
    for (int i = 0; i < CELLS * CELLS; i++)
        due[i] *= samples / all;
}

static void aperture_is_even(uint32_t blades, float turn)
{
    const uint32_t samples = stat_tries(200000, 2000000);
    const double radius = .125;
    struct scenes s;
    setup(&s, WIDTH, HEIGHT, CAMERA_THIN_LENS);
    lens(&s, (float)radius, 2, blades, turn);
    const struct stage *stage = scenes_stage(&s);
    uint32_t seen[CELLS * CELLS] = {0}, outside = 0;
    double due[CELLS * CELLS] = {0}, off = 0;
    struct dice d = dice_make(blades + 1);
    for (uint32_t i = 0; i < samples; i++) {
        const struct square q = {dice_float(&d), dice_float(&d)};
        const struct ray ray = camera_ray_through(&stage->camera, 100, 200, q);
        const struct own_ray o = own(&s, &ray);
        const double x = o.origin[0] / radius, y = o.origin[1] / radius;
        off = fmax(off, fabs(o.origin[2]));
        outside += !in_aperture(x * (1 - 1e-5), y * (1 - 1e-5), blades, (double)turn);
        const int column = (int)fmin(fmax((x + 1) / 2 * CELLS, 0), CELLS - 1);
        const int row = (int)fmin(fmax((y + 1) / 2 * CELLS, 0), CELLS - 1);
        seen[row * CELLS + column]++;
    }
    expect(due, blades, (double)turn, samples);
    const struct chi2 chi = chi2_test(due, seen, CELLS * CELLS);
    const double level = stat_sidak(0.01, 6);
    ok(outside == 0 && off < 1e-6 && chi.p > level,
       "an aperture of %u blades is even (p %.3f, detects %.3f rms)", blades, chi.p,
       chi2_detects(&chi, samples, level));
    scenes_release(&s);
}

/* Where the ray meets the plane at a depth, as a point of the image plane one metre ahead. */
static void at_depth(const struct own_ray *r, double depth, double p[2])
{
    for (int k = 0; k < 2; k++)
        p[k] = (r->origin[k] + r->dir[k] / -r->dir[2] * depth) / depth;
}

static void focus(float radius, float focus_m)
{
    struct scenes s;
    setup(&s, WIDTH, HEIGHT, CAMERA_THIN_LENS);
    lens(&s, radius, focus_m, 0, 0);
    const struct stage *stage = scenes_stage(&s);
    const double f = (double)focus_m, r = (double)radius;
    const double depths[] = {f, f / 3, 2 * f, 50 * f};
    struct dice d = dice_make(4);
    double blur = 0, circle = 0;
    for (int i = 0; i < 5000; i++) {
        const float x = WIDTH * dice_float(&d), y = HEIGHT * dice_float(&d);
        /* Its edges to the left and right and one point: u, v at their ends lie on the circle. */
        const struct square q[3] = {
            {0, .5f}, {1 - 0x1p-24f, .5f}, {dice_float(&d), dice_float(&d)}};
        const struct ray middle = camera_ray(&stage->camera, x, y);
        const struct own_ray m = own(&s, &middle);
        for (size_t k = 0; k < countof(depths); k++) {
            double p[3][2], c[2];
            at_depth(&m, depths[k], c);
            for (int j = 0; j < 3; j++) {
                const struct ray ray = camera_ray_through(&stage->camera, x, y, q[j]);
                const struct own_ray o = own(&s, &ray);
                at_depth(&o, depths[k], p[j]);
            }
            const double most = hypot(p[0][0] - p[1][0], p[0][1] - p[1][1]);
            const double want = 2 * r * fabs(1 / depths[k] - 1 / f);
            if (k == 0)
                blur = fmax(blur, hypot(p[2][0] - c[0], p[2][1] - c[1]));
            else
                circle = fmax(circle, fabs(most - want));
        }
    }
    /* In the image plane a metre ahead. Of a lens at (1, 2, 3) coordinates are known to 2^-23 m. */
    ok(blur < 1e-6, "focus at %g m, R %g: sharp to %.1e", f, r, blur);
    ok(circle < 1e-6, "circles of confusion are 2 R |1/z - 1/f| (%.4f far away) to %.1e",
       2 * r * (1 / f - 1 / (50 * f)), circle);
    scenes_release(&s);
}

/* The rendered image of a small ball out of focus: a disc, whose points lie r / 2 rms from the
 * middle along each axis. */
static void blurred_ball(void)
{
    const double depth = 4, f = 1.5, radius = .1, ball = .1;
    struct scenes s;
    scenes_init(&s, 64, 64);
    scenes_look(&s, vec3_make(0, 0, 0), vec3_make(0, 0, -1), .25);
    s.scene.camera.kind = CAMERA_THIN_LENS;
    lens(&s, (float)radius, (float)f, 0, 0);
    scenes_sphere(&s, scenes_diffuse(&s, rgb_gray(0)), vec3_make(0, 0, (float)-depth), (float)ball)
        ->emission = rgb_gray(1);
    struct film film;
    scenes_render(scenes_stage(&s), stat_tries(256, 2048), &film);
    const double px = 2 * tan(.125) / 64; /* of the plane one metre ahead */
    double sum = 0, square[2] = {0, 0};
    for (size_t i = 0; i < tile_rect_pixels(film.window); i++) {
        double mean[3];
        film_mean(&film, i, mean);
        const double x = ((double)(i % 64) + .5 - 32) * px, y = ((double)(i / 64) + .5 - 32) * px;
        sum += mean[1];
        square[0] += mean[1] * x * x;
        square[1] += mean[1] * y * y;
    }
    const double c = radius * fabs(1 / depth - 1 / f), own_size = ball / depth;
    const double want = c * c / 4 + own_size * own_size / 4 + px * px / 12;
    for (int k = 0; k < 2; k++)
        near(square[k] / sum / want, 1, STAT_SLOW == 1 ? .01 : .1,
             "a ball out of focus is a disc of the right size, axis %d", k);
    film_release(&film);
    scenes_release(&s);
}

static void closed_lens_is_a_pinhole(void)
{
    struct scenes s;
    setup(&s, WIDTH, HEIGHT, CAMERA_PERSPECTIVE);
    const struct stage *pinhole = scenes_stage(&s);
    s.scene.camera.kind = CAMERA_THIN_LENS;
    lens(&s, 0, 2, 7, .1f);
    const struct stage *closed = scenes_stage(&s);
    struct dice d = dice_make(9);
    int other = 0;
    for (int i = 0; i < 10000; i++) {
        const float x = WIDTH * dice_float(&d), y = HEIGHT * dice_float(&d);
        const struct square q = {dice_float(&d), dice_float(&d)};
        const struct ray a = camera_ray(&pinhole->camera, x, y);
        const struct ray b = camera_ray_through(&closed->camera, x, y, q);
        for (int k = 0; k < 3; k++)
            other += a.dir[k] != b.dir[k] || a.origin[k] != b.origin[k];
    }
    ok(other == 0, "a lens of radius 0 is a pinhole, bit by bit");
    scenes_release(&s);
}

static void siblings_share_the_lens(void)
{
    const struct scene_settings sobol = {.sampler = SAMPLER_SOBOL};
    struct rng_pixel p;
    rng_pixel_init(&p, 7, 12, 34);
    int other = 0, same = 0;
    float before = 2;
    for (uint32_t index = 0; index < 64; index++) {
        rng_pixel_go(&p, index);
        const struct sobol8_square eight = sampler_elders(&sobol, &p, RNG_LENS);
        for (uint32_t r = 0; r < FILM_REPLICATES; r++) {
            const struct rng rng = rng_make(7, 12, 34, index / 2 * FILM_REPLICATES + r);
            const struct square q = rng_pair(&rng, RNG_LENS);
            other += q.u != eight.u[r] || q.v != eight.v[r];
        }
        same += eight.u[0] == before;
        before = eight.u[0];
    }
    ok(other == 0 && same == 32, "the place on the lens is the elder's, for both siblings");
}

/* --- parallel and panoramic images --- */

/* Quads in planes at any depth, each so many pixels as it has area. */
static void parallel_scale(void)
{
    struct scenes s;
    scenes_init(&s, 64, 48);
    scenes_look(&s, vec3_make(0, 0, 2), vec3_make(0, 0, 0), 1);
    s.scene.camera.kind = CAMERA_ORTHOGRAPHIC;
    s.scene.camera.width = 0;
    s.scene.camera.height = 3;
    const uint32_t black = scenes_diffuse(&s, rgb_gray(0));
    const float depths[3] = {1.5f, -5, -400};
    for (int i = 0; i < 3; i++)
        scenes_quad(&s, black, vec3_make(-1.7f + 1.2f * (float)i, -.3f, depths[i]),
                    vec3_make(.7f, .2f, 0), vec3_make(.1f, .9f, 0))
            ->emission = rgb_gray(1);
    scenes_quad(&s, black, vec3_make(-5, -5, 3), vec3_make(9, 0, 0), vec3_make(0, 9, 0))->emission =
        rgb_gray(50); /* behind the camera */
    struct film film;
    scenes_render(scenes_stage(&s), 256, &film);
    const double area = scenes_mean(&film, 1).mean * 3 * 4;
    near(area / (3 * (.7 * .9 - .2 * .1)), 1, 5e-4, "parallel: areas are to scale at any depth");
    film_release(&film);
    scenes_release(&s);
}

/* Sums of pixels by their solid angle. */
static double over_the_sphere(const struct film *film)
{
    const uint32_t width = film->window.x_end, height = film->window.y_end;
    double sum = 0;
    for (uint32_t y = 0; y < height; y++) {
        const double strip = cos(pi * y / height) - cos(pi * (y + 1) / height);
        for (uint32_t x = 0; x < width; x++) {
            double mean[3];
            film_mean(film, (size_t)y * width + x, mean);
            sum += mean[1] * strip * 2 * pi / width;
        }
    }
    return sum;
}

static void panorama_is_the_sphere(void)
{
    static const struct {
        vec3 to;
        float radius, radiance;
    } balls[] = {{{0, 0, -3}, 1, 1},
                 {{.2f, .1f, 4}, .7f, 3},
                 {{0, 5, 0}, 2, .5f},
                 {{.1f, -3, .2f}, 1, 2},
                 {{-4, 2, 1}, .5f, 10}};
    struct scenes s;
    setup(&s, 160, 80, CAMERA_PANORAMIC);
    scenes_sky(&s, rgb_gray(1));
    struct film film;
    scenes_render(scenes_stage(&s), 8, &film);
    near(over_the_sphere(&film), 4 * pi, 1e-5, "panorama: solid angles add up to 4 pi");
    film_release(&film);

    const uint32_t black = scenes_diffuse(&s, rgb_gray(0));
    double want = 4 * pi;
    for (size_t i = 0; i < countof(balls); i++) {
        scenes_sphere(&s, black, from + balls[i].to, balls[i].radius)->emission =
            rgb_gray(balls[i].radiance);
        const double d = (double)vec3_length(balls[i].to), sine = (double)balls[i].radius / d;
        want += 2 * pi * (1 - sqrt(1 - sine * sine)) * ((double)balls[i].radiance - 1);
    }
    scenes_render(scenes_stage(&s), stat_tries(128, 1024), &film);
    near(over_the_sphere(&film) / want, 1, STAT_SLOW == 1 ? 5e-4 : 5e-3,
         "balls ahead, behind, above, below: each by its solid angle");
    film_release(&film);
    scenes_release(&s);
}

static void panorama_goes_around(void)
{
    struct scenes s;
    setup(&s, WIDTH, HEIGHT, CAMERA_PANORAMIC);
    const struct stage_camera *c = &scenes_stage(&s)->camera;
    double seam = 0, pole = 0;
    struct dice d = dice_make(11);
    for (int i = 0; i < 1000; i++) {
        const float x = WIDTH * dice_float(&d), y = HEIGHT * dice_float(&d),
                    out = 16 * dice_float(&d);
        seam = fmax(seam, (double)vec3_length(camera_ray(c, -out, y).dir -
                                              camera_ray(c, WIDTH - out, y).dir));
        pole = fmax(pole, (double)vec3_length(camera_ray(c, x, -out).dir -
                                              camera_ray(c, x + WIDTH / 2, out).dir));
        pole = fmax(pole, (double)vec3_length(camera_ray(c, x, HEIGHT + out).dir -
                                              camera_ray(c, x + WIDTH / 2, HEIGHT - out).dir));
    }
    ok(seam < 2e-6 && pole < 2e-6,
       "beyond the panorama's edge there is the other side (%.1e), the far side of the pole (%.1e)",
       seam, pole);
    scenes_release(&s);
}

int main(void)
{
    kinds();
    aperture_is_even(0, 0);
    aperture_is_even(3, .3f);
    aperture_is_even(5, 0);
    aperture_is_even(6, .11f);
    aperture_is_even(9, .9f);
    aperture_is_even(64, .5f);
    focus(.1f, 2);
    focus(.5f, .5f);
    focus(.02f, 30);
    blurred_ball();
    closed_lens_is_a_pinhole();
    siblings_share_the_lens();
    parallel_scale();
    panorama_is_the_sphere();
    panorama_goes_around();
    return tap_done();
}
