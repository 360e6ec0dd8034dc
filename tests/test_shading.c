/* F-27 and F-28: meshes with vertex normals have no hard terminator and no black rims, and let no
 * light through walls; nor does any shape under a normal map. SPDX-License-Identifier: MIT */
#include "common/trace/shading.h"

#include <math.h>

#include "common/trace/bvh.h"
#include "common/trace/surface.h"
#include "tests/soup.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"
#include "tests/textures.h"

/* --- the bent normal --- */

static vec3 above(struct dice *d, vec3 ng)
{
    const vec3 w = soup_direction(d);
    return vec3_unit(vec3_dot(w, ng) < 0 ? -w : w);
}

static void test_bend(void)
{
    struct dice d = dice_make(1);
    int bad = 0, changed = 0, valid_changed = 0, far = 0;
    const uint32_t tries = stat_tries(100000, 5000000);
    for (uint32_t i = 0; i < tries; i++) {
        const vec3 ng = vec3_unit(soup_direction(&d)), ns = above(&d, ng);
        vec3 wo = above(&d, ng);
        if (i % 2) /* grazing */
            wo =
                vec3_unit(wo - (1 - (float)pow(10, dice_range(&d, -5, 0))) * vec3_dot(wo, ng) * ng);
        if (!(vec3_dot(wo, ng) > 1e-4f)) /* all but rounding */
            continue;
        /* The half vector of directions that are all but opposite is off by rounding over their
         * sum. */
        const float low = vec3_dot(wo, ng) < 0x1p-11f ? -0x1p-9f : 0;
        const vec3 b = shading_bend(ns, ng, wo);
        const vec3 r = 2 * vec3_dot(ns, wo) * ns - wo, rb = 2 * vec3_dot(b, wo) * b - wo;
        bad += !(vec3_dot(rb, ng) > low && vec3_dot(b, wo) > low && vec3_dot(b, ng) > 0 &&
                 fabsf(vec3_length(b) - 1) < 1e-6f);
        changed += vec3_length(b - ns) > 0;
        valid_changed += vec3_length(b - ns) > 0 && vec3_dot(r, ng) > SHADING_LEAST_RISE;
        /* A normal a little off, a result a little off. */
        const vec3 beside = vec3_unit(ns + 1e-4f * soup_direction(&d));
        far += vec3_length(shading_bend(beside, ng, wo) - b) > 0.05f;
    }
    ok(!bad && changed > 1000 && !valid_changed,
       "F-28: a bent normal reflects above the surface, a valid one stays (%d not, %d bent, %d in "
       "vain)",
       bad, changed, valid_changed);
    ok(far < (int)(tries / 1000), "and moves with the normal it is bent from (%d of %u jump)", far,
       tries);
    bad = 0;
    for (int i = 0; i < 1000; i++) {
        const vec3 ng = vec3_unit(soup_direction(&d));
        bad += vec3_length(shading_bend(ng, ng, above(&d, ng)) - ng) > 0;
    }
    ok(!bad, "the geometric normal is never bent");
}

/* --- balls --- */

enum { SIDE = 64 };
#define DISTANCE  20.0f
#define HALF_VIEW 1.05f

/* Normals of the true sphere, each turned by the angle about a random axis across it. */
static void give_normals(struct scenes *s, struct mesh *mesh, double turn_rad)
{
    struct dice d = dice_make(2);
    float *n = arena_new(&s->arena, float, 3 * (size_t)mesh->vertex_count);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        const vec3 up = vec3_unit(vec3_load(mesh->vertices + 3 * (size_t)i));
        const vec3 side = vec3_unit(vec3_cross(up, soup_direction(&d)));
        vec3_store(n + 3 * (size_t)i, up * (float)cos(turn_rad) + side * (float)sin(turn_rad));
    }
    mesh->normals = n;
}

static void init_view(struct scenes *s)
{
    scenes_init(s, SIDE, SIDE);
    scenes_look(s, vec3_make(0, 0, DISTANCE), vec3_make(0, 0, 0),
                2 * atan((double)(HALF_VIEW / DISTANCE)));
    s->scene.film.filter_radius_px = 0.01f; /* the middle of each pixel */
}

static struct ray ray_of_pixel(uint32_t x, uint32_t y)
{
    const float step = 2 * HALF_VIEW / SIDE;
    const vec3 to =
        vec3_make(((float)x + 0.5f) * step - HALF_VIEW, HALF_VIEW - ((float)y + 0.5f) * step, 0);
    const vec3 from = vec3_make(0, 0, DISTANCE);
    return (struct ray){from, to - from, INFINITY, 0, 0};
}

/* --- F-27 --- */

struct shade {
    double rms, least; /* least: of the ratio to truth where the cosine is above .1 */
    int lit;
};

static struct shade shade_of(const struct stage *stage, vec3 to_light)
{
    struct film film;
    struct shade r = {.least = 1e9};
    scenes_render(stage, 1, &film);
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        struct ray_hit hit;
        const struct ray ray = ray_of_pixel(i % SIDE, i / SIDE);
        if (!bvh_hit_closest(stage, &ray, &hit))
            continue;
        const double cosine =
            (double)vec3_dot(vec3_unit(surface_at(stage, &ray, &hit).p), to_light);
        if (!(cosine > 0))
            continue;
        const double got = film.sum[3 * i] * 3.14159265358979323846; /* albedo and irradiance 1 */
        r.lit++;
        r.rms += (got - cosine) * (got - cosine);
        if (cosine > 0.1)
            r.least = fmin(r.least, got / cosine);
    }
    r.rms = sqrt(r.rms / r.lit);
    film_release(&film);
    return r;
}

static void test_terminator(void)
{
    struct shade worst = {.least = 1e9}, flat_worst = {.least = 1e9};
    for (int angle = 0; angle <= 150; angle += 30)
        for (int flat = 0; flat < 2; flat++) {
            const double a = angle * 3.14159265358979323846 / 180;
            const vec3 to_light = vec3_unit(vec3_make((float)sin(a), 0.3f, (float)cos(a)));
            struct scenes s;
            init_view(&s);
            struct shape *ball = scenes_ball(&s, scenes_diffuse(&s, rgb_gray(1)),
                                             vec3_make(0, 0, 0), 1, 8, 0, false);
            give_normals(&s, &s.scene.meshes[0], 0);
            ball->mesh.normals = flat ? MESH_NORMALS_FLAT : MESH_NORMALS_GIVEN;
            struct light *light = scenes_light(&s, LIGHT_DISTANT);
            vec3_store(light->distant.direction, -to_light);
            light->distant.irradiance = rgb_gray(1);
            s.scene.settings.max_bounces = 1;
            const struct shade r = shade_of(scenes_stage(&s), to_light);
            struct shade *to = flat ? &flat_worst : &worst;
            to->rms = fmax(to->rms, r.rms);
            to->least = fmin(to->least, r.least);
            to->lit += r.lit;
            scenes_release(&s);
        }
    ok(worst.lit > 5000 && worst.rms <= 0.05 && worst.least >= 0.5,
       "F-27: a ball of 16 x 8 is lit like a sphere: RMS %.4f of the peak, least %.2f of truth "
       "(%d pixels; flat: %.3f, %.2f)",
       worst.rms, worst.least, worst.lit, flat_worst.rms, flat_worst.least);
}

/* --- F-28 --- */

enum surface_kind { MIRROR, GGX, DIFFUSE, SURFACES };

static const char *const surface_names[] = {"mirror", "GGX", "diffuse"};

static uint32_t add_material(struct scenes *s, enum surface_kind kind)
{
    switch (kind) {
    case MIRROR:
        return scenes_mirror(s, rgb_gray(1));
    case GGX:
        return scenes_metal(s, rgb_gray(0.2f), rgb_gray(4), 0.3f);
    case DIFFUSE:
    case SURFACES:
        break;
    }
    return scenes_diffuse(s, rgb_gray(1));
}

static void map_normals(struct scenes *s, uint32_t material, double turn_rad)
{
    textures_relief(s, material)->normal_map = textures_index(s, textures_tilted(s, turn_rad));
}

/* Any, but such that each triangle has directions. */
static void give_uvs(struct scenes *s, struct mesh *mesh)
{
    struct dice d = dice_make(3);
    float *uvs = arena_new(&s->arena, float, 2 * (size_t)mesh->vertex_count);
    for (size_t i = 0; i < 2 * (size_t)mesh->vertex_count; i++)
        uvs[i] = dice_float(&d);
    mesh->uvs = uvs;
}

enum tilt { BY_VERTICES, BY_MAP, BY_MAP_ON_SPHERE, TILTS };

static const char *const tilt_names[] = {"normals", "a map's normals",
                                         "a map's normals on a sphere"};

/* Under a sky of 1 each point of a ball is lit. */
static void test_rims(enum surface_kind kind, enum tilt tilt)
{
    const double turn = 3.14159265358979323846 / 3;
    struct scenes s;
    init_view(&s);
    const uint32_t m = add_material(&s, kind);
    if (tilt == BY_MAP_ON_SPHERE)
        scenes_sphere(&s, m, vec3_make(0, 0, 0), 1);
    else
        scenes_ball(&s, m, vec3_make(0, 0, 0), 1, 5, 0, false);
    if (tilt == BY_VERTICES)
        give_normals(&s, &s.scene.meshes[0], turn);
    else
        map_normals(&s, m, turn);
    if (tilt == BY_MAP)
        give_uvs(&s, &s.scene.meshes[0]);
    scenes_sky(&s, rgb_gray(1));
    const struct stage *stage = scenes_stage(&s);
    const uint32_t spp = 16;
    struct film film;
    scenes_render(stage, spp, &film);
    int pixels = 0, black = 0;
    double most = 0, sum = 0;
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        struct ray_hit hit;
        const struct ray ray = ray_of_pixel(i % SIDE, i / SIDE);
        if (!bvh_hit_closest(stage, &ray, &hit))
            continue;
        const double got = film.sum[3 * i] / spp;
        pixels++;
        black += !(got > 0);
        most = fmax(most, got);
        sum += got;
    }
    ok(pixels > 2000 && black * 1000 <= pixels && most < 1.001,
       "F-28: %s, %s turned by 60 degrees: %d of %d pixels black, mean %.3f, at most %.3f",
       surface_names[kind], tilt_names[tilt], black, pixels, sum / pixels, most);
    film_release(&film);
    scenes_release(&s);
}

static void add_lights(struct scenes *s) /* outside of the cube from -1.5 to 1.5 */
{
    scenes_sky(s, rgb_gray(1));
    struct light *point = scenes_light(s, LIGHT_POINT);
    vec3_store(point->point.position, vec3_make(3, 2, 1));
    point->point.intensity = rgb_gray(100);
    struct light *distant = scenes_light(s, LIGHT_DISTANT);
    vec3_store(distant->distant.direction, vec3_unit(vec3_make(-1, -2, 0.5f)));
    distant->distant.irradiance = rgb_gray(100);
    scenes_sphere(s, scenes_diffuse(s, rgb_gray(0)), vec3_make(-3, 1, 1), 1)->emission =
        rgb_gray(100);
    scenes_quad(s, scenes_diffuse(s, rgb_gray(0)), vec3_make(-5, -2.5f, -5), vec3_make(0, 0, 10),
                vec3_make(10, 0, 0))
        ->emission = rgb_gray(100);
}

/* A cube from -1 to 1 whose faces have normals of their own, turned towards one corner, by 0 to 80
 * degrees: what reflects there sends a ray deeper and deeper into it. */
static void add_cube(struct scenes *s, uint32_t material, double turn_rad, bool inside)
{
    const struct scenes_mesh m = scenes_mesh(s, material, 24, 12);
    float *normals = arena_new(&s->arena, float, 72);
    for (uint32_t face = 0; face < 6; face++) {
        const int k = (int)face / 2;
        const float side = face % 2 ? 1 : -1;
        vec3 up = {0}, corner = vec3_make(1, 1, 1);
        up[k] = inside ? -side : side;
        corner[k] = 0;
        for (uint32_t v = 0; v < 4; v++) {
            float *p = m.vertices[4 * face + v];
            p[k] = side;
            p[(k + 1) % 3] = v == 1 || v == 2 ? 1 : -1;
            p[(k + 2) % 3] = v >= 2 ? side : -side;
            const vec3 n = up * (float)cos(turn_rad) + vec3_unit(corner) * (float)sin(turn_rad);
            vec3_store(normals + 3 * (4 * face + v), n);
        }
        for (uint32_t t = 0; t < 2; t++) {
            const uint32_t of[3] = {0, t + 1, t + 2};
            for (int c = 0; c < 3; c++)
                m.triangles[2 * face + t][c] = 4 * face + of[inside ? 2 - c : c];
        }
    }
    s->scene.meshes[m.shape->mesh.mesh].normals = normals;
}

/* A closed mesh with any normals, its front inside or outside, all lights outside, the camera
 * inside. (In corners of a few degrees rays may start beyond the other wall, however flat the
 * shading.) */
static void add_room(struct scenes *s, uint32_t m, int i)
{
    const double turn = 0.35 * (i % 5);
    if (i % 3 == 0) {
        add_cube(s, m, turn, i % 2);
    } else {
        scenes_ball(s, m, vec3_make(0, 0, 0), 1, i % 3 == 1 ? 4 : 16, 0.1f, i % 2);
        give_normals(s, &s->scene.meshes[0], turn);
    }
}

/* The same of quads, of a sphere, of a cylinder with two discs, of a mesh with vertex normals as
 * well; the map turns normals by up to 80 degrees. */
static void add_mapped_room(struct scenes *s, uint32_t m, int i)
{
    const vec3 o = vec3_make(0, 0, 0), lo = vec3_make(0, -1, 0), hi = vec3_make(0, 1, 0);
    map_normals(s, m, 0.35 * (1 + i / 4));
    switch (i % 4) {
    case 0:
        scenes_box(s, m, vec3_make(-1, -1, -1), vec3_make(1, 1, 1), i / 4 % 2);
        break;
    case 1:
        scenes_sphere(s, m, o, 1);
        break;
    case 2:
        scenes_cylinder(s, m, lo, hi, 1);
        scenes_disc(s, m, lo, lo, 1);
        scenes_disc(s, m, hi, hi, 1);
        break;
    case 3:
        scenes_ball(s, m, o, 1, i / 4 % 2 ? 4 : 16, 0.1f, i / 8);
        give_uvs(s, &s->scene.meshes[0]);
        give_normals(s, &s->scene.meshes[0], 0.35 * (i / 4 % 3));
        break;
    }
}

static double light_in_room(enum surface_kind kind, bool mapped, int i, uint32_t spp)
{
    struct scenes s;
    scenes_init(&s, 32, 32);
    scenes_look(&s, vec3_make(0.1f, 0, 0.2f), vec3_make(1, 0.2f * (float)i - 1, 0.3f), 2);
    const uint32_t m = add_material(&s, kind);
    if (mapped)
        add_mapped_room(&s, m, i);
    else
        add_room(&s, m, i);
    add_lights(&s);
    struct film film;
    double light = 0;
    scenes_render(scenes_stage(&s), spp, &film);
    for (uint32_t k = 0; k < 3 * 32 * 32; k++)
        light += film.sum[k];
    film_release(&film);
    scenes_release(&s);
    return light;
}

static void test_dark_room(enum surface_kind kind, bool mapped)
{
    const int all = mapped ? 16 : 30, rooms = stat_is_long() ? all : all / 3;
    const uint32_t spp = max_u32(stat_tries(6, 256), 1);
    double light = 0;
    for (int i = 0; i < rooms; i++) /* 7 has no divisor in common with 16 and 30 */
        light += light_in_room(kind, mapped, 7 * i % all, spp);
    ok(light == 0, "F-28: %s, %s: closed rooms are dark, exactly (%g of light in %d rooms, %u spp)",
       surface_names[kind], tilt_names[mapped ? BY_MAP : BY_VERTICES], light, rooms, spp);
}

/* --- the same light, however it is found --- */

static struct scenes_mean render_ball(enum surface_kind kind, double turn_rad, bool lamp)
{
    struct scenes s;
    scenes_init(&s, 48, 48);
    scenes_look(&s, vec3_make(0, 0, 3), vec3_make(0, 0, 0), 0.75);
    scenes_ball(&s, add_material(&s, kind), vec3_make(0, 0, 0), 1, 6, 0.1f, false);
    give_normals(&s, &s.scene.meshes[0], turn_rad);
    if (lamp)
        scenes_ball(&s, scenes_diffuse(&s, rgb_gray(0)), vec3_make(0, 0, 0), 4, 8, 0, true)
            ->emission = rgb_gray(1);
    else
        scenes_sky(&s, rgb_gray(1));
    struct film film;
    scenes_render(scenes_stage(&s), max_u32(stat_tries(16, 2048), 16), &film);
    const struct scenes_mean mean = scenes_mean(&film, 0);
    film_release(&film);
    scenes_release(&s);
    return mean;
}

/* A sky is found by scattering alone, a lamp all around by next-event estimation, too: what may
 * arrive from where, and with which density, must be the same. */
static void test_agreement(enum surface_kind kind, double turn_rad)
{
    const struct scenes_mean sky = render_ball(kind, turn_rad, false);
    const struct scenes_mean lamp = render_ball(kind, turn_rad, true);
    const double error = sqrt(sky.error * sky.error + lamp.error * lamp.error);
    const double bias = (stat_z_limit(stat_sidak(0.01, 6)) + 2.33) * error;
    ok(fabs(sky.mean - lamp.mean) < stat_z_limit(stat_sidak(0.01, 6)) * error &&
           bias < 0.02 * sky.mean,
       "%s, normals turned by %.0f degrees: a sky and a lamp all around give the same light: "
       "%.4f, %.4f (detects %.1g)",
       surface_names[kind], turn_rad * 180 / 3.14159265358979323846, sky.mean, lamp.mean,
       bias / sky.mean);
}

int main(void)
{
    test_bend();
    test_terminator();
    for (int kind = 0; kind < SURFACES; kind++) {
        for (int tilt = 0; tilt < TILTS; tilt++)
            test_rims((enum surface_kind)kind, (enum tilt)tilt);
        test_dark_room((enum surface_kind)kind, false);
        test_dark_room((enum surface_kind)kind, true);
    }
    for (int kind = GGX; kind < SURFACES; kind++)
        for (int i = 0; i < 3; i++)
            test_agreement((enum surface_kind)kind, 0.5 * i);
    return tap_done();
}
