/* The layers beside an image: what they are, that they add up to it, that it does not change for
 * them. SPDX-License-Identifier: MIT */
#include "common/layers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/image.h"
#include "tests/local.h"
#include "tests/scenes.h"
#include "tests/tap.h"

static const uint32_t everything = LAYER_SURFACE | 8 << 8;

/* Layers and image of a scene built in C. */
struct shown {
    struct film film;
    struct image image;
    struct arena arena;
};

static void show(struct shown *x, struct scenes *s, uint32_t layers, uint32_t spp)
{
    *x = (struct shown){0};
    s->scene.film.layers = layers;
    scenes_render(scenes_stage(s), spp, &x->film);
    x->image =
        image_from_film(&x->film, s->scene.film.width_px, s->scene.film.height_px, &x->arena);
}

static void hide(struct shown *x)
{
    film_release(&x->film);
    arena_release(&x->arena);
}

static float at(const struct shown *x, const char *channel, size_t pixel)
{
    return ((const float *)image_find(&x->image, channel)->pixels)[pixel];
}

static void places(void)
{
    bool good = true;
    for (uint32_t set = 0; set <= LAYER_SURFACE; set++)
        for (uint32_t bounces = 0; bounces <= LAYERS_MAX_BOUNCES; bounces++) {
            const uint32_t layers = layers_make(set, bounces);
            uint32_t next = set ? 1 : 0;
            for (uint32_t layer = LAYER_ALBEDO; layer <= LAYER_MATERIAL; layer *= 2) {
                good &= layers_at(layers, layer) == next;
                if (set & layer)
                    next += layer == LAYER_DEPTH || layer == LAYER_MATERIAL ? 1 : 3;
            }
            good &= layers_bounces_at(layers) == next && layers_are_known(layers) &&
                    layers_channels(layers) == next + (bounces ? 3 * bounces + 3 : 0) &&
                    layers_channels(layers) <= LAYERS_MAX_CHANNELS;
        }
    ok(good, "the layers of every set lie side by side");
    ok(!layers_are_known(1u << 5) && !layers_are_known(9u << 8) && !layers_are_known(1u << 24),
       "an unknown set is known as such");
}

/* --- the image, with layers and without --- */

static float ulp(float x)
{
    return nextafterf(x, INFINITY) - x;
}

static void adds_up(const char *path)
{
    struct local l;
    struct film plain, film;
    local_open(&l, path);
    struct scene *scene = &l.disk.scene;
    scene->film.crop_x_begin = scene->film.width_px / 3;
    scene->film.crop_y_begin = scene->film.height_px / 2;
    scene->film.crop_x_end = scene->film.crop_x_begin + 64;
    scene->film.crop_y_end = scene->film.crop_y_begin + 48;
    scene->settings.target.spp = 24;
    local_render(&l, 16, 2, &plain);
    scene->film.layers = everything;
    local_render(&l, 16, 2, &film);
    const size_t pixels = tile_rect_pixels(film.window);
    ok(!memcmp(plain.sum, film.sum, pixels * 3 * sizeof *film.sum) &&
           !memcmp(plain.replicate, film.replicate,
                   pixels * FILM_CHANNELS * sizeof *film.replicate),
       "%s: layers change no bit of the image", path);

    struct arena arena = {0};
    const struct image image =
        image_from_film(&film, scene->film.width_px, scene->film.height_px, &arena);
    double most = 0;
    for (int c = 0; c < 3; c++) {
        static const char *const terms[] = {"bounce0", "bounce1", "bounce2", "bounce3", "bounce4",
                                            "bounce5", "bounce6", "bounce7", "rest"};
        const char name[] = {"RGB"[c], '\0'};
        const float *color = image_find(&image, name)->pixels;
        for (size_t i = 0; i < pixels; i++) {
            double sum = 0;
            for (size_t k = 0; k < countof(terms); k++)
                sum += (double)((const float *)image_find(
                                    &image, arena_printf(&arena, "%s.%s", terms[k], name))
                                    ->pixels)[i];
            most = fmax(most, fabs(sum - (double)color[i]) / (double)ulp(color[i]));
        }
    }
    ok(most <= 4, "%s: bounce0 to rest add up to the image within 4 units in the last place (%.2f)",
       path, most);
    arena_release(&arena);
    film_release(&plain);
    film_release(&film);
    local_release(&l);
}

/* --- what they are --- */

/* In a closed body of albedo a and emission e each term is e a^k. A-01. */
static void furnace(void)
{
    struct scenes s;
    struct shown x;
    scenes_init(&s, 4, 4);
    const uint32_t gray = scenes_diffuse(&s, rgb_gray(.5f));
    struct shape *box = scenes_box(&s, gray, vec3_make(-1, -1, -1), vec3_make(1, 1, 1), true);
    for (int i = 0; i < 6; i++)
        box[i].emission = rgb_gray(1);
    show(&x, &s, layers_make(0, 5), 64);
    double want = 1;
    for (int k = 0; k < 5; k++, want /= 2) {
        char name[16] = "bounce0.R";
        name[6] = (char)('0' + k);
        double mean = 0;
        for (size_t i = 0; i < 16; i++)
            mean += (double)at(&x, name, i) / 16;
        near(mean, want, k == 0 ? 1e-6 : .03 * want, "A-01: light scattered %d times is e a^%d", k,
             k);
    }
    hide(&x);
    scenes_release(&s);
}

/* Paths cut after n scatterings are the first n + 1 terms. */
static void cut(void)
{
    struct scenes s;
    struct shown whole, cut;
    scenes_init(&s, 8, 8);
    const uint32_t gray = scenes_diffuse(&s, (rgb){.7f, .5f, .3f, 0}),
                   glass = scenes_glass(&s, 1.5f);
    scenes_box(&s, gray, vec3_make(-1, -1, -1), vec3_make(1, 1, 1), true)[3].emission = rgb_gray(2);
    scenes_sphere(&s, glass, vec3_make(0, -.3f, -.6f), .3f);
    show(&whole, &s, layers_make(0, 4), 32);
    for (uint32_t n = 0; n < 3; n++) {
        s.scene.settings.max_bounces = n;
        show(&cut, &s, 0, 32);
        double most = 0;
        for (size_t i = 0; i < 64; i++) {
            double sum = 0;
            for (uint32_t k = 0; k <= n; k++) {
                char name[16] = "bounce0.G";
                name[6] = (char)('0' + k);
                sum += (double)at(&whole, name, i);
            }
            most = fmax(most, fabs(sum - (double)at(&cut, "G", i)));
        }
        ok(most < 1e-5, "the first %u terms are the image of paths cut at %u (%.2g)", n + 1, n,
           most);
        hide(&cut);
    }
    hide(&whole);
    scenes_release(&s);
}

/* A floor of two halves seen from above, the sky beyond it. */
static void surfaces(void)
{
    struct scenes s;
    struct shown x;
    scenes_init(&s, 8, 8);
    const uint32_t red = scenes_diffuse(&s, (rgb){.8f, .1f, .2f, 0});
    const uint32_t mirror = scenes_mirror(&s, (rgb){.9f, .6f, .3f, 0});
    scenes_sky(&s, rgb_gray(1));
    scenes_quad(&s, red, vec3_make(0, 0, -1), vec3_make(0, 0, 2), vec3_make(1, 0, 0));
    /* Its back is up. */
    scenes_quad(&s, mirror, vec3_make(-1, 0, -1), vec3_make(1, 0, 0), vec3_make(0, 0, 2));
    scenes_look(&s, vec3_make(0, 3, 0), vec3_make(0, 0, 0),
                2 * atan(.5)); /* 3 m wide on the floor */
    show(&x, &s, LAYER_SURFACE, 16);
    const size_t left = 8 * 4 + 2, right = 8 * 4 + 5, corner = 7;
    near((double)at(&x, "albedo.R", left), .8, 1e-7, "the albedo of a diffuse floor is its albedo");
    near((double)at(&x, "albedo.G", right), .6, 1e-7, "of a mirror what it reflects");
    near((double)at(&x, "normal.Y", left), 1, 1e-6, "its normal is up");
    near((double)at(&x, "normal.Y", right), 1, 1e-6, "and on the side that is seen");
    near((double)at(&x, "Z", left), 3, 1e-5, "depth is measured along the view");
    near((double)at(&x, "position.Y", left), 0, 1e-6, "the position is on the floor");
    const float want = (.5f - 2.5f / 8) * 3; /* from above, x is to the left */
    near((double)at(&x, "position.X", left), (double)want, .2, "where the pixel looks");
    const uint32_t *material = image_find(&x.image, "material")->pixels;
    ok(material[left] == 1 + red && material[right] == 1 + mirror && material[corner] == 0,
       "materials are told by their number");
    ok(isinf(at(&x, "Z", corner)) && isinf(at(&x, "position.X", corner)) &&
           at(&x, "normal.Y", corner) == 0 && at(&x, "albedo.G", corner) == 0,
       "where nothing is met depth is infinite, normal and albedo are 0");
    hide(&x);
    scenes_release(&s);
}

/* Clear glass returns all light, though refraction changes its radiance. */
static void glass(void)
{
    struct scenes s;
    struct shown x;
    scenes_init(&s, 8, 8);
    const uint32_t clear = scenes_glass(&s, 1.5f);
    scenes_sky(&s, rgb_gray(1));
    scenes_sphere(&s, clear, vec3_make(0, 0, -3), 2.9f);
    show(&x, &s, LAYER_ALBEDO, 16);
    double off = 0;
    for (size_t i = 0; i < 64; i++)
        off = fmax(off, fabs((double)at(&x, "albedo.R", i) - 1));
    ok(off < 1e-6, "the albedo of clear glass is 1 (off by %.2g)", off);
    hide(&x);
    scenes_release(&s);
}

static void empty(void)
{
    struct scenes s;
    struct shown x;
    scenes_init(&s, 2, 2);
    scenes_sky(&s, rgb_gray(.5f));
    show(&x, &s, everything, 8);
    ok(at(&x, "bounce0.R", 0) == .5f && at(&x, "rest.R", 0) == 0 && isinf(at(&x, "Z", 3)),
       "a scene of nothing but sky has layers, too");
    bool sorted = true;
    for (size_t c = 1; c < x.image.channel_count; c++)
        sorted &= strcmp(x.image.channels[c - 1].name, x.image.channels[c].name) < 0;
    ok(sorted && x.image.channel_count == 10 + 11 + 27, "all %zu channels are sorted by name",
       x.image.channel_count);
    hide(&x);
    scenes_release(&s);
}

int main(void)
{
    places();
    adds_up("scenes/cornell-box.json");
    adds_up("scenes/glass-and-metal.json");
    furnace();
    cut();
    surfaces();
    glass();
    empty();
    return tap_done();
}
