/* glow.c: surfaces that shine as textures say, found by any strategy, and as several surfaces that
 * shine evenly would. SPDX-License-Identifier: MIT */
#include "common/trace/glow.h"

#include <math.h>
#include <string.h>

#include "tests/soup.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"
#include "tests/textures.h"

enum kind { SPHERE, DISC, CYLINDER, QUAD, MESH, MESH_COLORS, KINDS };

static const char *const names[] = {"sphere", "disc", "cylinder",
                                    "quad",   "mesh", "mesh's vertices"};

static struct shape *add_mesh(struct scenes *s, uint32_t m)
{
    static const float points[4][3] = {{-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2.5f, 1}};
    static const float uvs[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    static const float colors[4][3] = {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {1, 1, 1}};
    static const uint32_t triangles[2][3] = {{0, 1, 2}, {0, 2, 3}};
    const struct scenes_mesh mesh = scenes_mesh(s, m, 4, 2);
    memcpy(mesh.vertices, points, sizeof points);
    memcpy(mesh.triangles, triangles, sizeof triangles);
    s->scene.meshes[mesh.shape->mesh.mesh].uvs = uvs[0];
    s->scene.meshes[mesh.shape->mesh.mesh].colors = colors[0];
    return mesh.shape;
}

/* About two metres above the floor, its front towards it. */
static struct shape *add_lamp(struct scenes *s, enum kind kind)
{
    const uint32_t m = scenes_diffuse(s, rgb_gray(0));
    const vec3 up = vec3_make(0, 2, 0);
    switch (kind) {
    case SPHERE:
        return scenes_sphere(s, m, up, 0.7f);
    case DISC:
        return scenes_disc(s, m, up, vec3_unit(vec3_make(0.2f, -1, 0.1f)), 0.8f);
    case CYLINDER:
        return scenes_cylinder(s, m, vec3_make(-1, 2, 0), vec3_make(1, 1.6f, 0.2f), 0.4f);
    case QUAD:
        return scenes_quad(s, m, vec3_make(-1, 2, -1), vec3_make(2, 0, 0), vec3_make(0, 0, 2));
    case MESH:
    case MESH_COLORS:
        return add_mesh(s, m);
    case KINDS:
        break;
    }
    __builtin_unreachable();
}

static const struct texture *random_image(struct scenes *s)
{
    struct dice d = dice_make(1);
    float *pixels = arena_new(&s->arena, float, 3 * 4 * 4);
    for (size_t i = 0; i < (size_t)3 * 4 * 4; i++)
        pixels[i] = 2 * dice_float(&d) - 0.5f; /* some are below 0 */
    return textures_image(s, IMAGE_DEPTH_FLOAT, 4, 4, 3, pixels);
}

static void init_floor(struct scenes *s)
{
    scenes_init(s, 24, 24);
    scenes_look(s, vec3_make(0, 3, 6), vec3_make(0, 0, 0), 0.4);
    scenes_quad(s, scenes_diffuse(s, vec3_make(0.8f, 0.5f, 0.3f)), vec3_make(-3, 0, 3),
                vec3_make(6, 0, 0), vec3_make(0, 0, -6));
}

static const enum strategy_kind strategies[] = {STRATEGY_MIS, STRATEGY_LIGHT, STRATEGY_BSDF};

/* What is met by chance alone takes more. */
static uint32_t spp_of(enum strategy_kind strategy)
{
    /* not too few in slow builds: replicates need some, and a small bias is to be seen */
    return strategy == STRATEGY_BSDF ? max_u32(stat_tries(512, 8192), 256)
                                     : max_u32(stat_tries(64, 1024), 64);
}

static struct scenes_mean render(struct scenes *s, uint32_t spp, int channel)
{
    struct film film;
    scenes_render(scenes_stage(s), spp, &film);
    const struct scenes_mean mean = scenes_mean(&film, channel);
    film_release(&film);
    return mean;
}

static bool agree(const struct scenes_mean *a, const struct scenes_mean *b, double *bias)
{
    const double error = sqrt(a->error * a->error + b->error * b->error);
    const double limit = stat_z_limit(stat_sidak(0.01, 100)) * error;
    *bias = fmax(*bias, (limit + 2.33 * error) / b->mean);
    return fabs(a->mean - b->mean) < limit;
}

static void test_strategies(enum kind kind)
{
    struct scenes_mean mean[3][3];
    for (int i = 0; i < 3; i++) {
        struct scenes s;
        init_floor(&s);
        struct shape *lamp = add_lamp(&s, kind);
        lamp->emission = vec3_make(3, 2, 1);
        lamp->glow = 1 + textures_index(&s, kind == MESH_COLORS ? textures_vertex_color(&s)
                                                                : random_image(&s));
        s.scene.settings.strategy = strategies[i];
        for (int c = 0; c < 3; c++)
            mean[i][c] = render(&s, spp_of(strategies[i]), c);
        scenes_release(&s);
    }
    double bias = 0;
    bool good = true;
    for (int i = 1; i < 3; i++)
        for (int c = 0; c < 3; c++)
            good &= agree(&mean[i][c], &mean[0][c], &bias);
    ok(good && bias < 0.1,
       "%s: light that is aimed at and met by chance is the same: %.4f, %.4f, %.4f (detects %.2g)",
       names[kind], mean[0][0].mean, mean[1][0].mean, mean[2][0].mean, bias);
}

/* One quad of two halves, or of one colour, and quads that shine evenly: by each strategy. */
static void test_halves(void)
{
    static const float halves[6] = {1, 0.5f, 0, 0.25f, 0, 1};
    double bias = 0;
    bool good = true;
    for (int i = 0; i < 3; i++) {
        struct scenes_mean mean[2][3];
        for (int whole = 0; whole < 2; whole++) {
            struct scenes s;
            init_floor(&s);
            s.scene.settings.strategy = strategies[i];
            const uint32_t m = scenes_diffuse(&s, rgb_gray(0));
            for (int half = 0; half < (whole ? 1 : 2); half++) {
                struct shape *lamp =
                    scenes_quad(&s, m, vec3_make((float)half - 1, 2, -1),
                                vec3_make(whole ? 2 : 1, 0, 0), vec3_make(0, 0, 2));
                lamp->emission = 4 * vec3_load(halves + 3 * half);
                if (!whole)
                    continue;
                struct texture *t = textures_image(&s, IMAGE_DEPTH_FLOAT, 2, 1, 3, halves);
                t->image.filter = TEXTURE_NEAREST;
                lamp->emission = rgb_gray(4);
                lamp->glow = 1 + textures_index(&s, t);
            }
            for (int c = 0; c < 3; c++)
                mean[whole][c] = render(&s, spp_of(strategies[i]), c);
            scenes_release(&s);
        }
        for (int c = 0; c < 3; c++)
            good &= agree(&mean[1][c], &mean[0][c], &bias);
    }
    ok(good && bias < 0.1, "two halves of a texture are two lamps (detects %.2g)", bias);
}

/* Straight into the lamp: what is seen is the texture times the scale, on the front alone. */
static void test_seen(void)
{
    struct scenes s;
    scenes_init(&s, 16, 16);
    scenes_look(&s, vec3_make(0, 0, 5), vec3_make(0, 0, 0), 2 * atan(0.2));
    struct shape *lamp = scenes_quad(&s, scenes_diffuse(&s, rgb_gray(1)), vec3_make(-1, -1, 0),
                                     vec3_make(2, 0, 0), vec3_make(0, 2, 0));
    lamp->emission = vec3_make(1, 10, 100);
    lamp->glow = 1 + textures_index(&s, textures_checker(&s, vec3_make(1, 2, 3), rgb_gray(0), 4));
    s.scene.settings.max_bounces = 0;
    for (int back = 0; back < 2; back++) {
        struct film film;
        if (back)
            scenes_look(&s, vec3_make(0, 0, -5), vec3_make(0, 0, 0), 2 * atan(0.2));
        scenes_render(scenes_stage(&s), 4, &film);
        int wrong = 0;
        for (uint32_t i = 0; i < 16 * 16; i++) {
            const bool first = (i % 16 / 4 + (15 - i / 16) / 4) % 2 == 0 && !back;
            const double want[3] = {first ? 4 : 0, first ? 80 : 0, first ? 1200 : 0};
            for (uint32_t c = 0; c < 3; c++)
                wrong += film.sum[3 * i + c] != want[c];
        }
        ok(!wrong, back ? "and dark from behind" : "a lamp is seen as its texture says");
        film_release(&film);
    }
    scenes_release(&s);
}

/* A texture of one value is that much of the emission. */
static void test_even(void)
{
    static const float quarter = 0.25f;
    struct scenes_mean mean[2];
    for (int textured = 0; textured < 2; textured++) {
        struct scenes s;
        init_floor(&s);
        struct shape *lamp = add_lamp(&s, SPHERE);
        lamp->emission = rgb_gray(textured ? 8 : 2);
        if (textured)
            lamp->glow =
                1 + textures_index(&s, textures_image(&s, IMAGE_DEPTH_FLOAT, 1, 1, 1, &quarter));
        mean[textured] = render(&s, 16, 0);
        scenes_release(&s);
    }
    ok(fabs(mean[1].mean / mean[0].mean - 1) < 1e-6,
       "a texture of a quarter is a quarter of it: %.6f", mean[1].mean / mean[0].mean);
}

int main(void)
{
    for (int kind = 0; kind < KINDS; kind++)
        test_strategies((enum kind)kind);
    test_halves();
    test_seen();
    test_even();
    return tap_done();
}
