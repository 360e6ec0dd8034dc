/* The work that film.h counts: what each sample asks for by itself, whoever traces it beside which
 * others; and bvh_cost.h, what a ray costs. SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/trace/bvh_cost.h"
#include "common/trace/render.h"
#include "common/trace/work.h"
#include "tests/scenes.h"
#include "tests/tap.h"

static bool same(const struct film_work *a, const struct film_work *b)
{
    return memcmp(a, b, sizeof *a) == 0;
}

static uint64_t rays(const struct film_work *w)
{
    return w->camera_rays + w->bounce_rays + w->shadow_rays;
}

/* --- a sum over samples --- */

static const struct tile_rect frame = {0, 0, 12, 8};

/* The pass in the given order: by tile, by rows from the bottom, pixel by pixel, sample by sample.
 */
enum way { BY_TILE, BY_ROW, BY_PIXEL, BY_SAMPLE };

static struct film_work work_by(const struct stage *s, struct tile_pass pass, enum way way)
{
    struct arena arena = {0};
    struct film_work sum = {0};
    const uint32_t step = way == BY_SAMPLE ? 1 : pass.s_end - pass.s_begin;
    const uint32_t side = way == BY_PIXEL || way == BY_SAMPLE ? 1 : 12;
    for (uint32_t i = pass.s_begin; i < pass.s_end; i += step)
        for (uint32_t y = 0; y < frame.y_end; y += side)
            for (uint32_t x = 0; x < frame.x_end; x += side) {
                const struct tile_rect rect = {x, y, x + side, min_u32(y + side, frame.y_end)};
                struct film_samples out =
                    film_samples_make(rect, (struct tile_pass){i, i + step}, &arena);
                if (way == BY_ROW)
                    for (uint32_t row = rect.y_end; row-- > rect.y_begin;)
                        render_row(s, &out, row);
                else
                    render_tile(s, &out);
                film_work_add(&sum, &out.work);
                arena_reset(&arena);
            }
    arena_release(&arena);
    return sum;
}

/* layers: asked for as well, which changes the way of the octets. */
static struct film_work work_in_film(const struct stage *s, uint32_t spp, uint32_t layers)
{
    struct arena arena = {0};
    struct film film;
    const struct tile_grid grid = tile_grid_make(frame, 8);
    film_init(&film, frame);
    film_add_layers(&film, layers);
    for (uint32_t tile = tile_count(&grid); tile-- > 0;)
        for (uint32_t p = 0; p < tile_pass_count(spp); p++) {
            struct film_samples out =
                film_samples_make(tile_rect_of(&grid, tile), tile_pass_of(p, spp), &arena);
            film_samples_add_layers(&out, layers, &arena);
            render_tile(s, &out);
            film_merge(&film, &out);
        }
    const struct film_work work = film.work;
    film_release(&film);
    arena_release(&arena);
    return work;
}

static void is_a_sum(const struct stage *s, const char *name)
{
    const struct tile_pass all = {0, 32}, odd[] = {{0, 5}, {5, 11}, {11, 27}, {27, 32}};
    const struct film_work tile = work_by(s, all, BY_TILE), row = work_by(s, all, BY_ROW),
                           pixel = work_by(s, all, BY_PIXEL), sample = work_by(s, all, BY_SAMPLE),
                           film = work_in_film(s, 32, 0),
                           layers = work_in_film(s, 32, LAYER_SURFACE | 4 << 8);
    struct film_work cut = {0};
    for (size_t i = 0; i < countof(odd); i++) {
        const struct film_work part = work_by(s, odd[i], BY_TILE);
        film_work_add(&cut, &part);
    }
    ok(same(&tile, &row) && same(&tile, &pixel) && same(&tile, &sample) && same(&tile, &cut) &&
           same(&tile, &film) && same(&tile, &layers),
       "%s: the same work by tile, row, pixel, sample, odd passes, film and with layers", name);
    ok(tile.units == work_units(s, &tile) && tile.units > 100 * (rays(&tile) - tile.camera_rays),
       "%s: %lu units of work, the sum of the parts' prices", name, (unsigned long)tile.units);
    ok(tile.camera_rays == 12 * 8 * 32 / 2, "%s: siblings have one camera ray", name);
    ok(rays(&tile) > tile.camera_rays && tile.plain_vertices + tile.other_vertices > 0,
       "%s: %lu + %lu + %lu rays, %lu + %lu vertices", name, (unsigned long)tile.camera_rays,
       (unsigned long)tile.bounce_rays, (unsigned long)tile.shadow_rays,
       (unsigned long)tile.plain_vertices, (unsigned long)tile.other_vertices);
}

static void of_document(const char *name, enum sampler_kind sampler,
                        enum integrator_kind integrator)
{
    struct scenes s;
    char what[96];
    snprintf(what, sizeof what, "%s, sampler %d, integrator %d", name, (int)sampler,
             (int)integrator);
    if (ok(scenes_open(&s, name), "%s opens", name)) {
        struct scene_film *f = &s.scene.film;
        f->width_px = f->crop_x_end = frame.x_end;
        f->height_px = f->crop_y_end = frame.y_end;
        s.scene.settings.sampler = sampler;
        s.scene.settings.integrator = integrator;
        s.scene.settings.max_bounces = min_u32(s.scene.settings.max_bounces, 12);
        is_a_sum(scenes_stage(&s), what);
    }
    scenes_release(&s);
}

/* Smooth normals: rays are traced to find out where light may be gathered. */
static void of_smooth_ball(bool masked)
{
    struct scenes s;
    scenes_init(&s, frame.x_end, frame.y_end);
    scenes_look(&s, vec3_make(0, 0, 4), vec3_make(0, 0, 0), .7);
    s.scene.settings.max_bounces = 8;
    uint32_t m = scenes_metal(&s, vec3_make(.2f, .9f, 1.1f), vec3_make(3.9f, 2.4f, 2.2f), .3f);
    if (masked) {
        struct material mask = {.kind = MATERIAL_MASK};
        mask.mask.of = m;
        mask.mask.opacity = .6f;
        m = scenes_material(&s, mask);
    }
    scenes_ball(&s, m, vec3_make(0, 0, 0), 1, 6, 0, false);
    struct mesh *mesh = &s.scene.meshes[0];
    mesh->normals = mesh->vertices;
    scenes_quad(&s, m, vec3_make(-3, 3, -3), vec3_make(6, 0, 0), vec3_make(0, 0, 6))->emission =
        rgb_gray(1);
    scenes_quad(&s, m, vec3_make(-3, -1.1f, 3), vec3_make(6, 0, 0), vec3_make(0, 0, -6));
    is_a_sum(scenes_stage(&s), masked ? "a smooth ball, masked" : "a smooth ball");
    scenes_release(&s);
}

/* --- counts that are known --- */

static void in_a_furnace(void)
{
    struct scenes s;
    scenes_init(&s, 4, 4);
    s.scene.settings.max_bounces = 3;
    scenes_box(&s, scenes_diffuse(&s, rgb_gray(.9f)), vec3_make(-1, -1, -1), vec3_make(1, 1, 1),
               true);
    struct film film;
    scenes_render(scenes_stage(&s), 64, &film);
    const struct film_work dark = {16 * 32, 3 * 16 * 64, 0, 3 * 16 * 64, 0, film.work.units};
    ok(same(&film.work, &dark), "in a dark box each path has three vertices and three rays");
    film_release(&film);

    scenes_light(&s, LIGHT_POINT)->point.intensity = rgb_gray(1);
    scenes_render(scenes_stage(&s), 64, &film);
    const struct film_work lit = {16 * 32,     3 * 16 * 64, 3 * 16 * 64,
                                  3 * 16 * 64, 0,           film.work.units};
    ok(same(&film.work, &lit), "and looks at a lamp in the middle from each of them");
    film_release(&film);

    s.scene.settings.integrator = INTEGRATOR_DIRECT;
    scenes_render(scenes_stage(&s), 24, &film);
    const struct film_work once = {16 * 16, 16 * 24, 16 * 24, 16 * 24, 0, film.work.units};
    ok(same(&film.work, &once), "direct light has one; of 24 samples 16 are elders");
    film_release(&film);
    scenes_release(&s);
}

static void under_a_sky(void)
{
    struct scenes s;
    scenes_init(&s, 4, 4);
    scenes_sky(&s, rgb_gray(1));
    struct film film;
    scenes_render(scenes_stage(&s), 16, &film);
    const struct film_work work = {16 * 8, 0, 0, 0, 0, film.work.units};
    ok(same(&film.work, &work), "where there is nothing there are camera rays and nothing else");
    film_release(&film);
    scenes_release(&s);
}

/* --- what a ray costs --- */

static double cost_of(void build(struct scenes *, float scale), float scale)
{
    struct scenes s;
    scenes_init(&s, 4, 4);
    build(&s, scale);
    const double cost = bvh_cost_of_ray(scenes_stage(&s));
    scenes_release(&s);
    return cost;
}

static void nothing(struct scenes *s, float scale)
{
    (void)s;
    (void)scale;
}

static void one_ball(struct scenes *s, float scale)
{
    scenes_sphere(s, scenes_diffuse(s, rgb_gray(1)), vec3_make(0, 0, 0), scale);
}

/* Boxes of side 2 in one of 2 x 2 x 22: half areas 12 each, and 92. */
static void two_balls(struct scenes *s, float scale)
{
    one_ball(s, scale);
    scenes_sphere(s, 0, vec3_make(0, 0, 20 * scale), scale);
}

static void crowd(struct scenes *s, float scale)
{
    const uint32_t white = scenes_diffuse(s, rgb_gray(1));
    for (int i = 0; i < 200; i++)
        scenes_sphere(s, white,
                      vec3_make((float)(i * 37 % 200), (float)(i * 91 % 200), (float)i) * scale,
                      scale);
}

static void costs(void)
{
    ok(cost_of(nothing, 1) == 1, "a ray in an empty scene costs one look");
    near(cost_of(two_balls, 1), 1 + 2 * 12. / 92, 1e-4, "two balls apart: the areas' quotients");
    ok(cost_of(one_ball, 1) == 1 || cost_of(one_ball, 1) == 2,
       "one ball costs itself and its node");
    const double many = cost_of(crowd, 1);
    ok(many > 2 && many < 40, "200 balls: %g of 200", many);
    near(cost_of(crowd, 1024), many, 1e-5 * many, "a scene 1024 times as large costs the same");
}

int main(void)
{
    in_a_furnace();
    under_a_sky();
    of_document("cornell-box", SAMPLER_SOBOL, INTEGRATOR_PATH);
    of_document("cornell-box", SAMPLER_INDEPENDENT, INTEGRATOR_PATH);
    of_document("glass-and-metal", SAMPLER_SOBOL, INTEGRATOR_PATH);
    of_document("glass-and-metal", SAMPLER_STRATIFIED, INTEGRATOR_WHITTED);
    of_document("many-lights", SAMPLER_SOBOL, INTEGRATOR_PATH);
    of_document("materials", SAMPLER_SOBOL, INTEGRATOR_PATH);
    of_document("tiles", SAMPLER_SOBOL, INTEGRATOR_PATH);
    of_smooth_ball(false);
    of_smooth_ball(true);
    costs();
    return tap_done();
}
