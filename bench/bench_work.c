/* bench_work: are work units (work.h) the same seconds for every method and scene?
 *
 * Renders small images of scenes that differ, by every integrator, strategy and sampler, in turn,
 * one thread, and holds the CPU time of each (the least of the rounds) against its units. Per scene
 * the seconds per unit of each method over their geometric mean, then the rank correlation over
 * all.
 * --raw: the counts, for whoever fits new weights.
 * Last line: "bench-work: version V, seconds per unit within X % across methods, Y % across scenes
 * too, rank correlation Z". SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/clock.h"
#include "common/trace/bvh_cost.h"
#include "common/trace/prep.h"
#include "common/trace/render.h"
#include "common/trace/work.h"
#include "tests/scenes.h"

enum { ROUNDS = 5, SPP = 32, WIDTH = 64, HEIGHT = 48, MOST = 128 };

static const struct method {
    const char *name;
    enum integrator_kind integrator;
    enum strategy_kind strategy;
    enum sampler_kind sampler;
} methods[] = {
    {"path", INTEGRATOR_PATH, STRATEGY_MIS, SAMPLER_SOBOL},
    {"light", INTEGRATOR_PATH, STRATEGY_LIGHT, SAMPLER_SOBOL},
    {"bsdf", INTEGRATOR_PATH, STRATEGY_BSDF, SAMPLER_SOBOL},
    {"direct", INTEGRATOR_DIRECT, STRATEGY_MIS, SAMPLER_SOBOL},
    {"whitted", INTEGRATOR_WHITTED, STRATEGY_LIGHT, SAMPLER_SOBOL},
    {"independent", INTEGRATOR_PATH, STRATEGY_MIS, SAMPLER_INDEPENDENT},
    {"stratified", INTEGRATOR_PATH, STRATEGY_MIS, SAMPLER_STRATIFIED},
};

struct row {
    const char *scene, *method;
    struct film_work work;
    double cost, seconds, units;
    uint32_t emitters;
};

static struct row rows[MOST];
static uint32_t row_count;

static void time_of(const struct stage *s, struct row *r)
{
    struct arena arena = {0};
    struct film_samples out = film_samples_make((struct tile_rect){0, 0, WIDTH, HEIGHT},
                                                (struct tile_pass){0, SPP}, &arena);
    const int64_t begin = clock_thread_cpu_us();
    render_tile(s, &out);
    r->seconds = fmin(r->seconds, (double)(clock_thread_cpu_us() - begin) * 1e-6);
    r->work = out.work;
    r->cost = bvh_cost_of_ray(s);
    r->units = (double)out.work.units;
    r->emitters = (uint32_t)s->emitters.count;
    arena_release(&arena);
}

static void measure(const char *name, struct scene *scene)
{
    struct arena arena = {0}, scratch = {0};
    const struct stage *stages[countof(methods)];
    scene->film.width_px = scene->film.crop_x_end = WIDTH;
    scene->film.height_px = scene->film.crop_y_end = HEIGHT;
    scene->film.layers = 0;
    scene->settings.target.spp = SPP;
    for (size_t i = 0; i < countof(methods); i++) {
        struct err err;
        scene->settings.integrator = methods[i].integrator;
        scene->settings.strategy = methods[i].strategy;
        scene->settings.sampler = methods[i].sampler;
        if (!prep_stage(scene, NULL, &arena, &scratch, &stages[i], &err)) {
            fprintf(stderr, "%s: %s\n", name, err.text);
            exit(1);
        }
        rows[row_count + i] = (struct row){name, methods[i].name, {0}, 0, 1e30, 0, 0};
    }
    for (int round = 0; round < ROUNDS; round++)
        for (size_t i = 0; i < countof(methods); i++)
            time_of(stages[i], &rows[row_count + i]);
    row_count += countof(methods);
    arena_release(&scratch);
    arena_release(&arena);
}

static void measure_document(const char *name)
{
    struct scenes s;
    if (!scenes_open(&s, name))
        printf("scenes/%s.json is left out: it cannot be read\n", name);
    else
        measure(name, &s.scene);
    scenes_release(&s);
}

/* A wavy ball of 130 thousand triangles in a lit room; open: under a sky alone. */
static void measure_ball(bool open)
{
    struct scenes s;
    scenes_init(&s, WIDTH, HEIGHT);
    scenes_look(&s, vec3_make(0, 1, 3.4f), vec3_make(0, .8f, 0), .8);
    const uint32_t white = scenes_diffuse(&s, rgb_gray(.7f));
    scenes_ball(&s, white, vec3_make(0, .8f, 0), .7f, 256, .05f, false);
    if (open) {
        scenes_quad(&s, white, vec3_make(-5, 0, 5), vec3_make(10, 0, 0), vec3_make(0, 0, -10));
        scenes_sky(&s, rgb_gray(1));
    } else {
        scenes_box(&s, white, vec3_make(-1.5f, 0, -1.5f), vec3_make(1.5f, 2, 4), true);
        scenes_quad(&s, white, vec3_make(-.5f, 1.95f, -.5f), vec3_make(1, 0, 0), vec3_make(0, 0, 1))
            ->emission = rgb_gray(3);
    }
    measure(open ? "ball-sky" : "ball-room", &s.scene);
    scenes_release(&s);
}

/* --- what it says --- */

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static uint32_t rank_of(double value, const double sorted[])
{
    uint32_t rank = 0;
    while (sorted[rank] < value)
        rank++;
    return rank;
}

/* Spearman's. */
static double rank_correlation(void)
{
    double seconds[MOST], units[MOST], square = 0;
    for (uint32_t i = 0; i < row_count; i++) {
        seconds[i] = rows[i].seconds;
        units[i] = rows[i].units;
    }
    qsort(seconds, row_count, sizeof *seconds, ascending);
    qsort(units, row_count, sizeof *units, ascending);
    for (uint32_t i = 0; i < row_count; i++) {
        const double d = (double)rank_of(rows[i].seconds, seconds) - rank_of(rows[i].units, units);
        square += d * d;
    }
    const double n = row_count;
    return 1 - 6 * square / (n * (n * n - 1));
}

static double mean_rate(uint32_t begin, uint32_t end)
{
    double sum = 0;
    for (uint32_t i = begin; i < end; i++)
        sum += log(rows[i].seconds / rows[i].units);
    return exp(sum / (end - begin));
}

/* The largest factor that a rate of [begin, end) is away from their mean. */
static double spread(uint32_t begin, uint32_t end)
{
    const double mean = mean_rate(begin, end);
    double most = 1;
    for (uint32_t i = begin; i < end; i++) {
        const double r = rows[i].seconds / rows[i].units / mean;
        most = fmax(most, fmax(r, 1 / r));
    }
    return most;
}

static double print_scene(uint32_t begin)
{
    const uint32_t end = begin + (uint32_t)countof(methods);
    const double mean = mean_rate(begin, end);
    printf("%-16s %6.2f %8.3f ", rows[begin].scene, rows[begin].cost, mean * 1e9);
    for (uint32_t i = begin; i < end; i++)
        printf(" %11.3f", rows[i].seconds / rows[i].units / mean);
    putchar('\n');
    return spread(begin, end);
}

static void print_raw(void)
{
    for (uint32_t i = 0; i < row_count; i++) {
        const struct row *r = &rows[i];
        printf("%s,%s,%.6f,%.4f,%lu,%lu,%lu,%lu,%lu,%u\n", r->scene, r->method, r->seconds, r->cost,
               (unsigned long)r->work.camera_rays, (unsigned long)r->work.bounce_rays,
               (unsigned long)r->work.shadow_rays, (unsigned long)r->work.plain_vertices,
               (unsigned long)r->work.other_vertices, r->emitters);
    }
}

int main(int argc, char **argv)
{
    static const char *const documents[] = {"cornell-box", "glass-and-metal", "many-lights",
                                            "materials",   "tiles",           "bison"};
    for (size_t i = 0; i < countof(documents); i++)
        measure_document(documents[i]);
    measure_ball(false);
    measure_ball(true);
    if (argc > 1 && !strcmp(argv[1], "--raw")) {
        print_raw();
        return 0;
    }
    printf("%-16s %6s %8s ", "scene", "visits", "ns/unit");
    for (size_t i = 0; i < countof(methods); i++)
        printf(" %11s", methods[i].name);
    putchar('\n');
    double within = 1;
    for (uint32_t i = 0; i < row_count; i += (uint32_t)countof(methods))
        within = fmax(within, print_scene(i));
    printf("bench-work: version %d, seconds per unit within %.1f %% across methods, %.1f %% across "
           "scenes too, rank correlation %.3f\n",
           WORK_VERSION, 100 * (within - 1), 100 * (spread(0, row_count) - 1), rank_correlation());
    return 0;
}
