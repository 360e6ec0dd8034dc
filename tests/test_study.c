/* Studies: what no path from the eye can find is what light tracing says it is, the study's other
 * methods are those of documents, and plans do not hang on units, seeds or brightness.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/base.h"
#include "common/estimate.h"
#include "common/trace/prep.h"
#include "common/trace/render.h"
#include "common/trace/study.h"
#include "common/trace/study_shot.h"
#include "tests/scale.h"
#include "tests/scenes.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

static struct plan plan_of(struct scenes *s)
{
    struct plan plan;
    struct arena scratch = {0};
    study_make(scenes_stage(s), NULL, &scratch, &plan);
    arena_release(&scratch);
    return plan;
}

static double sum_of(const double of_class[])
{
    double sum = 0;
    for (int c = 0; c < PLAN_CLASSES; c++)
        sum += of_class[c];
    return sum;
}

/* --- light through glass --- */

/* A floor under a lamp of intensity 1 per channel at (0, 2, 0). */
static void floor_and_lamp(struct scenes *s, enum light_kind kind)
{
    scenes_look(s, vec3_make(.4f, 2.5f, 2), vec3_make(0, 0, 0), pi / 4);
    scenes_quad(s, scenes_diffuse(s, rgb_gray(.6f)), vec3_make(-2, 0, 2), vec3_make(4, 0, 0),
                vec3_make(0, 0, -4));
    struct light *l = scenes_light(s, kind);
    const float at[3] = {0, 2, 0}, down[3] = {0, -1, 0};
    if (kind == LIGHT_POINT) {
        memcpy(l->point.position, at, sizeof at);
        l->point.intensity = rgb_gray(1);
    } else if (kind == LIGHT_SPOT) {
        memcpy(l->spot.position, at, sizeof at);
        memcpy(l->spot.direction, down, sizeof down);
        l->spot.intensity = rgb_gray(1);
        l->spot.inner_rad = .2f;
        l->spot.outer_rad = .6f;
    } else {
        memcpy(l->distant.direction, down, sizeof down);
        l->distant.irradiance = rgb_gray(1);
    }
}

static double mean_of(struct scenes *s, uint32_t spp)
{
    struct film film;
    scenes_render(scenes_stage(s), spp, &film);
    const double mean = scenes_mean(&film, 1).mean;
    film_release(&film);
    return mean;
}

/* The same with more pixels: what is looked at of an image is in proportion to it. */
static void enlarge(struct scenes *s, uint32_t times)
{
    struct scene_film *f = &s->scene.film;
    f->width_px *= times;
    f->height_px *= times;
    f->crop_x_begin *= times;
    f->crop_y_begin *= times;
    f->crop_x_end *= times;
    f->crop_y_end *= times;
}

/* Behind glass that is none (its index is 1) the same light arrives, but no path from the eye finds
 * it: what is traced from the lamp must be what was found without. There is a sky, too, so that
 * there is something to be a share of. */
static void behind_nothing(enum light_kind kind, enum camera_kind camera, const char *name)
{
    double mean[2], missed[2];
    for (int pane = 0; pane < 2; pane++) {
        struct scenes s;
        scenes_init(&s, 256, 256);
        floor_and_lamp(&s, kind);
        scenes_sky(&s, rgb_gray(.02f));
        s.scene.camera.kind = camera;
        if (camera == CAMERA_ORTHOGRAPHIC)
            s.scene.camera.width = 3;
        if (camera != CAMERA_PANORAMIC) {
            s.scene.film.crop_x_begin = 20;
            s.scene.film.crop_y_begin = 100;
        }
        if (pane)
            scenes_quad(&s, scenes_glass(&s, 1), vec3_make(-3, 1.9f, 3), vec3_make(6, 0, 0),
                        vec3_make(0, 0, -6));
        mean[pane] = mean_of(&s, 8);
        enlarge(&s, 4);
        const struct plan plan = plan_of(&s);
        missed[pane] = sum_of(plan.light.missed);
        scenes_release(&s);
    }
    const double want = 1 - mean[1] / mean[0];
    ok(missed[0] == 0, "%s: where nothing is smooth nothing is missed", name);
    near(missed[1] / want, 1, .05,
         "%s behind glass: %.2f %% of the light is missed, in truth %.2f %%", name, 100 * missed[1],
         100 * want);
}

/* F-07: a caustic. In truth: what a small sphere in the point's place brings more. */
static void caustic(void)
{
    double mean[2], missed = 0;
    for (int point = 0; point < 2; point++) {
        struct scenes s;
        scenes_init(&s, 128, 128);
        scenes_look(&s, vec3_make(1.5f, 1, 1.5f), vec3_make(0, 0, 0), 40 * pi / 180);
        scenes_quad(&s, scenes_diffuse(&s, rgb_gray(.6f)), vec3_make(-4, 0, 4), vec3_make(8, 0, 0),
                    vec3_make(0, 0, -8));
        scenes_sphere(&s, scenes_glass(&s, 1.5f), vec3_make(0, 1.6f, 0), .5f);
        const float radius = .15f, at[3] = {0, 4, 0};
        if (point) {
            struct light *l = scenes_light(&s, LIGHT_POINT);
            memcpy(l->point.position, at, sizeof at);
            l->point.intensity = rgb_gray((float)pi * radius * radius);
        } else {
            scenes_sphere(&s, scenes_diffuse(&s, rgb_gray(0)), vec3_load(at), radius)->emission =
                rgb_gray(1);
        }
        mean[point] = mean_of(&s, 256);
        enlarge(&s, 8);
        const struct plan plan = plan_of(&s);
        missed += plan.light.missed[PLAN_LSDE];
        diag("%s: LS+DE found %.4f missed %.4f, all missed %.4f", point ? "point" : "sphere",
             plan.light.found[PLAN_LSDE], plan.light.missed[PLAN_LSDE], sum_of(plan.light.missed));
        scenes_release(&s);
    }
    const double want = 1 - mean[1] / mean[0];
    near(missed / want, 1, .1, "F-07: LS+DE is missing with %.2f %% of the light, in truth %.2f %%",
         100 * missed, 100 * want);
}

/* --- the same scene by other methods --- */

/* A box with a lamp, a glass and a metal ball. */
static void room(struct scenes *s, uint32_t side_px)
{
    scenes_init(s, side_px, side_px);
    scenes_look(s, vec3_make(0, 0, 2.9f), vec3_make(0, -.2f, 0), pi / 3);
    scenes_box(s, scenes_diffuse(s, rgb_gray(.6f)), vec3_make(-1.5f, -1, -1.5f),
               vec3_make(1.5f, 1, 3), true);
    scenes_sphere(s, scenes_glass(s, 1.5f), vec3_make(-.5f, -.6f, 0), .4f);
    scenes_sphere(s, scenes_metal(s, rgb_gray(.2f), rgb_gray(3), .2f), vec3_make(.5f, -.6f, 0),
                  .4f);
    scenes_quad(s, scenes_diffuse(s, rgb_gray(0)), vec3_make(-.4f, .99f, -.4f),
                vec3_make(.8f, 0, 0), vec3_make(0, 0, .8f))
        ->emission = rgb_gray(10);
    s->scene.settings.target = (struct scene_target){.error = .02, .spp = SCENE_MAX_SPP};
}

static bool same_films(const struct film *a, const struct film *b)
{
    return !memcmp(a->sum, b->sum, 3 * tile_rect_pixels(a->window) * sizeof *a->sum) &&
           !memcmp(&a->work, &b->work, sizeof a->work);
}

static void methods_are_those_of_documents(void)
{
    struct scenes s;
    room(&s, 24);
    const struct stage *usual = scenes_stage(&s);
    struct stage *copy = study_stage(usual, &s.arena);
    const struct plan plan = {.sampler = SAMPLER_SOBOL};
    uint32_t differ = 0;
    struct film first;
    scenes_render(usual, 16, &first);
    for (int k = PLAN_REAL; k-- > 0;) {
        const struct plan_method m = plan_method_of(&plan, (enum plan_candidate_kind)k);
        struct film mine, documents;
        s.scene.settings.integrator = m.integrator;
        s.scene.settings.strategy = m.strategy;
        s.scene.settings.sampler = m.sampler;
        study_set_method(copy, usual, m);
        scenes_render(copy, 16, &mine);
        scenes_render(scenes_stage(&s), 16, &documents);
        ok(same_films(&mine, &documents), "%s: the same pixels and work as a document's",
           plan_candidate_name((enum plan_candidate_kind)k));
        differ += !same_films(&mine, &first);
        film_release(&mine);
        film_release(&documents);
    }
    ok(differ == PLAN_REAL - 1, "and they are different methods");
    film_release(&first);
    scenes_release(&s);
}

/* --- what plans do not hang on --- */

static bool same_plans(const struct plan *a, const struct plan *b)
{
    struct buf x = {0}, y = {0};
    plan_print(a, &x);
    plan_print(b, &y);
    const bool same = x.size == y.size && !memcmp(x.data, y.data, x.size);
    buf_release(&x);
    buf_release(&y);
    return same;
}

static void stable(void)
{
    struct scenes s;
    room(&s, 128);
    const struct plan first = plan_of(&s), again = plan_of(&s);
    ok(same_plans(&first, &again), "the same plan twice, to the last digit");
    diag("%s; outlook of %u pixels, all is %.2f %% of the forecast",
         first.candidates[first.chosen].why, first.outlook.pixels,
         100 * first.studied / first.forecast);
    scenes_release(&s);
    uint32_t others = 0;
    for (uint32_t i = 0; i < 10; i++) {
        room(&s, 128);
        scale_lengths(&s.scene, i == 0 ? 1e-3f : i == 1 ? 1e3f : 1);
        scale_radiance(&s.scene, i == 2 ? 1e-6f : i == 3 ? 1e6f : 1);
        s.scene.settings.seed = i < 4 ? 1 : i;
        const struct plan plan = plan_of(&s);
        others += plan.chosen != first.chosen;
        if (i < 4)
            near(plan.forecast / first.forecast, 1, .05, "much the same forecast in other units");
        scenes_release(&s);
    }
    ok(others == 0, "the same choice in other units, brightness and with other seeds");
}

/* A box whose walls all shine. */
static void furnace(struct scenes *s)
{
    scenes_init(s, 128, 96);
    scenes_box(s, scenes_diffuse(s, rgb_gray(.5f)), vec3_make(-1, -1, -1), vec3_make(1, 1, 1),
               true);
    for (uint32_t i = 0; i < s->scene.shape_count; i++)
        s->scene.shapes[i].emission = rgb_gray(1);
}

/* All of it but what is of the target. */
static struct plan without_target(struct plan p)
{
    p.error = p.studied = p.forecast = p.forecast_low = p.forecast_high = p.forecast_spp = 0;
    p.is_asked = false;
    p.outlook = (struct plan_pilot){.pixels = 0};
    return p;
}

/* A job that goes on to another target keeps its method: it must be the one that the other target
 * alone would have been given. */
static void whatever_the_target(void (*make)(struct scenes *), const char *name)
{
    const struct scene_target targets[] = {{.error = .3, .spp = SCENE_MAX_SPP},
                                           {.error = .02, .spp = SCENE_MAX_SPP},
                                           {.error = .0005, .spp = SCENE_MAX_SPP},
                                           {.error = .001, .spp = 64},
                                           {.spp = 1},
                                           {.spp = 4096}};
    struct plan first = {.pixels = 0};
    uint32_t same = 0, forecasts = 0;
    for (size_t i = 0; i < countof(targets); i++) {
        struct scenes s;
        make(&s);
        s.scene.settings.target = targets[i];
        const struct plan plan = plan_of(&s), bare = without_target(plan);
        first = i == 0 ? plan : first;
        const struct plan first_bare = without_target(first);
        same += same_plans(&bare, &first_bare);
        forecasts += plan.forecast != first.forecast;
        scenes_release(&s);
    }
    ok(same == countof(targets) && forecasts == countof(targets) - 1,
       "%s: whatever the target, the same method for the same reasons, but another forecast", name);
}

static void medium_room(struct scenes *s)
{
    room(s, 128);
}

/* --- forecasts --- */

/* The variance that a shot of that scene has, 64 samples deep: of all blocks, or of those picked.
 */
static struct plan_pilot shot_of(struct scenes *s, uint32_t picked)
{
    struct arena arena = {0};
    struct study_shot shot;
    const struct study study = {.stage = scenes_stage(s)};
    study_shot_init(&shot, study.stage, &arena);
    if (!study_shot_go(&shot, &study, 256, picked ? STUDY_FIRST : STUDY_DEEP))
        abort();
    study_shot_scale(&shot);
    const double price = study_shot_price(&shot);
    if (picked && (!(price > 0) || !study_shot_deepen(&shot, &study, picked, STUDY_DEEP)))
        abort();
    study_shot_scale(&shot);
    const struct plan_pilot p = study_shot_sum(&shot, &shot);
    arena_release(&arena);
    return p;
}

static void picked_blocks(void (*make)(struct scenes *), const char *name)
{
    enum { SEEDS = 8, PICKED = 32 };
    double mean = 0, off2 = 0, spread2 = 0;
    for (uint32_t i = 0; i < SEEDS; i++) {
        struct scenes s;
        make(&s);
        s.scene.settings.seed = i;
        const struct plan_pilot all = shot_of(&s, 0), some = shot_of(&s, PICKED);
        const double off = log(some.variance / all.variance);
        mean += some.variance / all.variance / SEEDS;
        off2 += off * off / SEEDS;
        spread2 += some.spread * some.spread / SEEDS;
        scenes_release(&s);
    }
    near(mean, 1, .2, "%s: an eighth of the blocks, picked, says what all say", name);
    ok(off2 < 1.2 * spread2 && spread2 < .5, "within what it is said to spread: %.2f, said %.2f",
       sqrt(off2), sqrt(spread2));
}

/* Samples of a pixel until the error is there, doubled and interpolated. */
static double spp_until(struct scenes *s, double error)
{
    const struct stage *stage = scenes_stage(s);
    double before = 0, e = 0;
    uint32_t spp = FILM_REPLICATES;
    for (;; spp *= 2) {
        struct film film;
        scenes_render(stage, spp, &film);
        before = e;
        e = estimate_error(&film);
        film_release(&film);
        if (e <= error || spp >= 4096)
            break;
    }
    return before > 0 ? spp / 2 * pow(2, log(before / error) / log(before / e)) : spp;
}

static void foretold(void (*make)(struct scenes *), double error, const char *name)
{
    struct scenes s;
    make(&s);
    s.scene.settings.target = (struct scene_target){.error = error, .spp = SCENE_MAX_SPP};
    const struct plan plan = plan_of(&s);
    const struct plan_method m = plan_method_of(&plan, plan.chosen);
    s.scene.settings.integrator = m.integrator;
    s.scene.settings.strategy = m.strategy;
    const double spp = spp_until(&s, error);
    ok(plan.forecast_spp < 2.5 * spp && spp < 2.5 * plan.forecast_spp,
       "%s: forecast of %.0f samples of a pixel, it took %.0f; planning %.2f %%", name,
       plan.forecast_spp, spp, 100 * plan.studied / plan.forecast);
    scenes_release(&s);
}

/* --- scenes of a kind --- */

static void no_light(void)
{
    struct scenes s;
    room(&s, 16);
    s.scene.shapes[s.scene.shape_count - 1].emission = rgb_gray(0);
    const struct plan plan = plan_of(&s);
    ok(plan.chosen == PLAN_PATH_MIS && plan.outlook.variance == 0 && plan.forecast_spp == 8,
       "a scene without light: the usual method, no more than eight samples");
    ok(sum_of(plan.light.found) == 0 && sum_of(plan.light.missed) == 0, "and no class has any");
    scenes_release(&s);
}

static void all_light(void)
{
    struct scenes s;
    furnace(&s);
    s.scene.settings.target = (struct scene_target){.error = .003, .spp = SCENE_MAX_SPP};
    const struct plan plan = plan_of(&s);
    near(plan.light.found[PLAN_LE], .5, .02, "a furnace: half of the light comes straight");
    near(plan.light.found[PLAN_LDE], .25, .02, "a quarter by one scattering");
    ok(plan.chosen == PLAN_PATH_BSDF, "and shadow rays are not worth their price: %s, %s",
       plan_candidate_name(plan.chosen), plan.candidates[plan.chosen].why);
    scenes_release(&s);
}

static void one_pixel(void)
{
    struct scenes s;
    room(&s, 1);
    const struct plan plan = plan_of(&s);
    ok(plan.chosen == PLAN_PATH_MIS && plan.pixels == 1 && plan.forecast > 0, "one pixel: %s",
       plan.candidates[plan.chosen].why);
    scenes_release(&s);
}

static bool at_once(const void *user)
{
    (void)user;
    return true;
}

static void halted(void)
{
    struct scenes s;
    struct plan plan;
    struct arena scratch = {0};
    room(&s, 64);
    const struct study_halt halt = {at_once, NULL};
    ok(!study_make(scenes_stage(&s), &halt, &scratch, &plan), "a study can be halted");
    arena_release(&scratch);
    scenes_release(&s);
}

int main(void)
{
    behind_nothing(LIGHT_POINT, CAMERA_PERSPECTIVE, "a point");
    behind_nothing(LIGHT_SPOT, CAMERA_ORTHOGRAPHIC, "a spot");
    behind_nothing(LIGHT_DISTANT, CAMERA_PERSPECTIVE, "a distant light");
    behind_nothing(LIGHT_POINT, CAMERA_PANORAMIC, "a point, all around");
    caustic();
    methods_are_those_of_documents();
    stable();
    whatever_the_target(medium_room, "a room");
    whatever_the_target(furnace, "a furnace");
    picked_blocks(medium_room, "a room");
    foretold(medium_room, .15, "a room");
    foretold(furnace, .02, "a furnace");
    no_light();
    all_light();
    one_pixel();
    halted();
    return tap_done();
}
