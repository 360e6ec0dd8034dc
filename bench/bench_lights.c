/* bench_lights: many lights (F-31). N points on a sphere round a white patch, all seen or a tenth
 * of them: relative variance of one light sample as smalti chooses it, by power, and all alike,
 * computed in double over all lights; then the time of a whole sample (camera ray, light, shadow
 * ray, next ray) with 10^6 lights against 10^4, points and triangles of a mesh, in turn in one run.
 * Triangles are also met: the same with dark ones says what a ray to each sample takes of that.
 * Last line: "bench-lights: 10^6 for 10^4 lights: points X times the time, triangles Y; variance at
 * most Z of power's, W of all alike". SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/clock.h"
#include "common/trace/render.h"
#include "tests/dice.h"
#include "tests/swarm.h"

enum { FEW = 10000, MANY = 1000000, ROUNDS = 7, SPP = 2048 };

static void variances(double *of_power, double *of_uniform)
{
    printf("lights    seen  variance   by power  all alike   bytes per light\n");
    for (int occluded = 0; occluded < 2; occluded++)
        for (uint32_t count = 10; count <= MANY; count *= 10) {
            struct swarm w;
            swarm_init(&w, count, occluded, 3);
            const struct surface from = swarm_point(&w, vec3_make(.1f, 0, .03f));
            const struct swarm_law law = swarm_law(&w, &from);
            const struct stage *s = w.stage;
            const double bytes = (double)s->light_nodes.count * sizeof(struct stage_light_node);
            const char *seen = occluded ? "1/10" : "all";
            if (isnan(law.power))
                printf("%7u  %5s  none can be seen\n", count, seen);
            else
                printf("%7u  %5s  %8.3f   %8.3f   %8.3f   %8.0f%s\n", count, seen, law.ours,
                       law.power, law.uniform, bytes / count,
                       s->light_nodes.count ? "" : " (by power)");
            if (s->light_nodes.count) {
                *of_power = fmax(*of_power, law.ours / law.power);
                *of_uniform = fmax(*of_uniform, law.ours / law.uniform);
            }
            swarm_release(&w);
        }
}

/* Small triangles on the sphere that face the patch. */
static void init_mesh(struct swarm *w, uint32_t count, bool shines)
{
    struct dice dice = dice_make(4);
    const float size = .5f / sqrtf((float)count);
    scenes_init(&w->s, 8, 8);
    scenes_look(&w->s, vec3_make(0, .01f, 0), vec3_make(0, 0, 0), 1e-3);
    w->s.scene.settings.max_bounces = 1;
    scenes_disc(&w->s, scenes_diffuse(&w->s, rgb_gray(1)), vec3_make(0, 0, 0), vec3_make(0, 1, 0),
                .2f);
    const struct scenes_mesh m = scenes_mesh(&w->s, 0, 3 * count, count);
    for (uint32_t i = 0; i < count; i++) {
        const float z = (float)dice_range(&dice, -1, 1), r = sqrtf(1 - z * z);
        const double phi = dice_range(&dice, 0, 6.283185307179586);
        const vec3 n = vec3_make(r * (float)cos(phi), z, r * (float)sin(phi));
        const vec3 x = vec3_unit(vec3_cross(n, vec3_make(.6f, .8f, 0))), y = vec3_cross(n, x);
        const vec3 corner[3] = {n, n + size * y, n + size * x};
        for (uint32_t k = 0; k < 3; k++) {
            vec3_store(m.vertices[3 * i + k], corner[k]);
            m.triangles[i][k] = 3 * i + k;
        }
    }
    m.shape->emission = rgb_gray(shines ? 1 : 0);
    w->stage = scenes_stage(&w->s);
}

static double seconds_of(const struct stage *s)
{
    struct arena arena = {0};
    struct film_samples samples =
        film_samples_make((struct tile_rect){0, 0, 8, 8}, (struct tile_pass){0, SPP}, &arena);
    const int64_t begin = clock_thread_cpu_us();
    render_tile(s, &samples);
    const double seconds = (double)(clock_thread_cpu_us() - begin) * 1e-6;
    arena_release(&arena);
    return seconds;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The median of rounds. */
static double race(const char *name, const struct stage *few, const struct stage *many)
{
    double ratio[ROUNDS], ns = 0;
    for (int i = 0; i < ROUNDS; i++) {
        const double a = seconds_of(few), b = seconds_of(many);
        ratio[i] = b / a;
        ns += a * 1e9 / (64.0 * SPP * ROUNDS);
    }
    qsort(ratio, ROUNDS, sizeof *ratio, ascending);
    printf("%-9s  10^4: %.0f ns per sample; 10^6: %.2f times that (%.2f to %.2f)\n", name, ns,
           ratio[ROUNDS / 2], ratio[0], ratio[ROUNDS - 1]);
    return ratio[ROUNDS / 2];
}

static double race_meshes(const char *name, bool shines)
{
    struct swarm few, many;
    init_mesh(&few, FEW, shines);
    init_mesh(&many, MANY, shines);
    const double ratio = race(name, few.stage, many.stage);
    swarm_release(&few);
    swarm_release(&many);
    return ratio;
}

int main(void)
{
    double of_power = 0, of_uniform = 0;
    struct swarm few, many;
    variances(&of_power, &of_uniform);
    swarm_init(&few, FEW, false, 1);
    swarm_init(&many, MANY, false, 1);
    const double points = race("points", few.stage, many.stage);
    swarm_release(&few);
    swarm_release(&many);
    const double mesh = race_meshes("triangles", true);
    race_meshes("dark ones", false);
    printf("bench-lights: 10^6 for 10^4 lights: points %.2f times the time, triangles %.2f; "
           "variance at most %.2f of power's, %.2f of all alike\n",
           points, mesh, of_power, of_uniform);
    return 0;
}
