/* Scene to stage: fronts, shared edges, what is dropped, how lights are picked, where the camera
 * looks. SPDX-License-Identifier: MIT */
#include "common/trace/prep.h"

#include <math.h>
#include <string.h>

#include "common/trace/bvh.h"
#include "common/trace/camera.h"
#include "common/trace/surface.h"
#include "tests/catalog.h"
#include "tests/soup.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

/* A rotation with a scale; mirrored on request. */
static struct xform similarity(struct dice *d, float scale, bool mirrored)
{
    const vec3 x = soup_direction(d), y = vec3_unit(vec3_cross(x, soup_direction(d)));
    const vec3 z = vec3_cross(x, y) * (mirrored ? -scale : scale);
    const vec3 at = soup_point(d, 3);
    struct xform m;
    for (int i = 0; i < 3; i++) {
        const float row[4] = {x[i] * scale, y[i] * scale, z[i], at[i]};
        memcpy(m.m[i], row, sizeof row);
    }
    return m;
}

static bool has_vertex(const struct stage *s, uint32_t prim, const float v[3])
{
    const struct stage_triangle t = catalog_triangle(s, prim);
    for (int i = 0; i < 3; i++)
        if (memcmp(t.v[i], v, sizeof t.v[i]) == 0)
            return true;
    return false;
}

static void test_shared_edges(void)
{
    int apart = 0, shared_diagonals = 0;
    for (uint64_t seed = 0; seed < 100; seed++) {
        struct dice d = dice_make(seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        const uint32_t m = scenes_diffuse(&s, rgb_gray(0.5f));
        const struct xform x = similarity(&d, 1.7f, seed & 1);
        const vec3 corner = soup_point(&d, 1), a = soup_point(&d, 1), b = soup_point(&d, 1);
        struct shape *first = scenes_quad(&s, m, corner, a, b);
        first->to_world = x;
        struct shape *second = scenes_quad(&s, m, corner + a, a, b);
        second->to_world = x;
        /* The same floats on the common edge, as an author writes them. */
        memcpy(second->quad.vertices[0], first->quad.vertices[1], sizeof first->quad.vertices[1]);
        memcpy(second->quad.vertices[3], first->quad.vertices[2], sizeof first->quad.vertices[2]);
        const struct stage *stage = scenes_stage(&s);
        int diagonal = 0, common = 0;
        for (int i = 0; i < 3; i++) {
            const struct stage_triangle a0 = catalog_triangle(stage, 0),
                                        a1 = catalog_triangle(stage, 1);
            diagonal += has_vertex(stage, 1, a0.v[i]);
            for (uint32_t t = 2; t < 4; t++)
                common += has_vertex(stage, t, a0.v[i]) || has_vertex(stage, t, a1.v[i]);
        }
        shared_diagonals += diagonal == 2;
        apart += common < 2;
        scenes_release(&s);
    }
    ok(shared_diagonals == 100, "a quad's triangles share the diagonal bit by bit");
    ok(apart == 0, "quads that share vertices share the edge bit by bit (%d do not)", apart);
}

/* What the author sees as the front of a shape, in its own space, is the front in the world. */
static void test_fronts(void)
{
    static const char *const names[] = {"mesh", "quad", "disc", "sphere", "cylinder"};
    int wrong[5] = {0};
    for (uint64_t seed = 0; seed < 500; seed++) {
        const uint32_t kind = (uint32_t)seed % 5;
        struct dice d = dice_make(seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        const uint32_t m = scenes_diffuse(&s, rgb_gray(0.5f));
        const vec3 at = soup_point(&d, 1), a = soup_direction(&d), b = soup_direction(&d);
        const vec3 front = vec3_unit(vec3_cross(a, b));
        struct shape *shape = kind == 0   ? scenes_triangle(&s, m, at, at + a, at + b)
                              : kind == 1 ? scenes_quad(&s, m, at, a, b)
                              : kind == 2 ? scenes_disc(&s, m, at, front, 1)
                              : kind == 3 ? scenes_sphere(&s, m, at, 0.5f)
                                          : scenes_cylinder(&s, m, at - a, at + a, 0.5f);
        const struct xform x = similarity(&d, 0.5f + dice_float(&d), seed / 5 & 1);
        shape->to_world = x;
        const struct stage *stage = scenes_stage(&s);
        /* From a point before the front, in object space, to a point of the shape. */
        const vec3 on = kind == 2   ? at + 0.4f * a - 0.4f * vec3_dot(a, front) * front
                        : kind >= 3 ? at
                                    : at + 0.3f * a + 0.3f * b;
        const vec3 eye = xform_point(&x, on + front), to = xform_point(&x, on);
        const struct ray ray = {eye, to - eye, INFINITY, 0, 0};
        struct ray_hit hit;
        if (!bvh_hit_closest(stage, &ray, &hit) ||
            !(vec3_dot(surface_at(stage, &ray, &hit).ng, ray.dir) < 0))
            wrong[kind]++;
        scenes_release(&s);
    }
    for (int i = 0; i < 5; i++)
        ok(wrong[i] == 0, "a %s keeps its front under mirroring (%d of 100 do not)", names[i],
           wrong[i]);
}

static void test_sizes(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    struct dice d = dice_make(3);
    const uint32_t m = scenes_diffuse(&s, rgb_gray(0.5f));
    const struct xform x = similarity(&d, 3, true);
    scenes_sphere(&s, m, vec3_make(1, 2, 3), 0.5f)->to_world = x;
    scenes_disc(&s, m, vec3_make(1, 2, 3), vec3_make(0, 1, 0), 0.25f)->to_world = x;
    const vec3 from = vec3_make(1, 2, 3), to = vec3_make(1, 2.5f, 3);
    scenes_cylinder(&s, m, from, to, 0.125f)->to_world = x;
    const struct stage *stage = scenes_stage(&s);
    const struct stage_sphere *sphere = stage_at(stage, stage->spheres);
    const struct stage_cylinder *cylinder = stage_at(stage, stage->cylinders);
    const struct stage_disc *disc = stage_at(stage, stage->discs);
    near((double)sphere->radius, 1.5, 1e-6, "a sphere's radius grows with the scale");
    near((double)disc->radius, 0.75, 1e-6, "a disc's radius, too");
    near((double)vec3_length(vec3_load(disc->normal)), 1, 1e-6, "a disc's normal stays unit");
    near((double)cylinder->radius, 0.375, 1e-6, "a cylinder's radius, too");
    const vec3 end = vec3_load(cylinder->from) + vec3_load(cylinder->axis);
    near((double)vec3_length(end - xform_point(&x, to)), 0, 1e-6,
         "its axis leads to the other end");
    const vec3 center = xform_point(&x, vec3_make(1, 2, 3));
    ok(vec3_length(center - vec3_load(sphere->center)) == 0, "the centre moves with the transform");
    scenes_release(&s);
}

static void test_dropped(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    const uint32_t m = scenes_diffuse(&s, rgb_gray(0.5f));
    float(*v)[3] = soup_vertices(&s, 7);
    for (uint32_t i = 0; i < 7; i++) {
        const float at[3][3] = {{0, 0, (float)i}, {1, 0, (float)i}, {0, 1, (float)i}};
        memcpy(v[3 * (size_t)i], at, sizeof at);
    }
    v[3 * 1][1] = NAN;
    v[3 * 2 + 1][0] = INFINITY;
    v[3 * 3 + 2][2] = -INFINITY;
    memcpy(v[3 * 4 + 1], v[3 * 4], sizeof v[0]); /* a repeated vertex */
    v[3 * 5 + 2][0] = 0.5f, v[3 * 5 + 2][1] = 0; /* collinear */
    soup_mesh(&s, m, v, 7);
    scenes_sphere(&s, m, vec3_make(0, 0, 20), 1);
    const struct stage *stage = scenes_stage(&s);
    ok(stage->dropped_nonfinite == 3, "3 triangles with NaN or infinity are dropped and counted");
    ok(stage->dropped_degenerate == 2, "2 triangles without area are dropped and counted");
    ok(stage->prim_count == 3, "the others stay");
    ok(catalog_triangle(stage, 0).v[0][2] == 0 && catalog_triangle(stage, 1).v[0][2] == 6,
       "in document order");
    ok(catalog_id(stage, 2).place.kind == STAGE_SPHERE && stage_shape_of(stage, 2) == 1 &&
           stage_shape_of(stage, 1) == 0,
       "prims belong to their shapes");
    ok(stage->bounds[0][2] == 0 && stage->bounds[1][2] >= 21 && stage->bounds[1][2] < 21.001f,
       "bounds are of what stays");
    scenes_release(&s);
}

static void test_empty(void)
{
    struct scenes s;
    scenes_init(&s, 4, 4);
    const struct stage *stage = scenes_stage(&s);
    const struct ray ray = {vec3_make(0, 0, 0), vec3_make(0, 0, 1), INFINITY, 0, 0};
    struct ray_hit hit;
    ok(!stage->prim_count && !stage->nodes.count && !stage->emitters.count,
       "an empty scene is empty");
    ok(!bvh_hit_closest(stage, &ray, &hit) && !bvh_hit_any(stage, &ray),
       "and nothing is hit there");
    scenes_release(&s);
}

/* Powers by hand: Lambertian surfaces pi A L, a point 4 pi I, a distant light pi R^2 E. */
static void test_picks(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    const uint32_t m = scenes_diffuse(&s, rgb_gray(0));
    scenes_quad(&s, m, vec3_make(-1, -1, -1), vec3_make(2, 0, 0), vec3_make(0, 2, 0))->emission =
        rgb_gray(3);
    scenes_sphere(&s, m, vec3_make(0, 0, 0), 0.5f)->emission = rgb_gray(2);
    scenes_disc(&s, m, vec3_make(0, 0, 1), vec3_make(0, 0, 1), 0.25f)->emission =
        vec3_make(0, 1, 0);
    scenes_quad(&s, m, vec3_make(-1, -1, 1), vec3_make(2, 0, 0), vec3_make(0, 2, 0)); /* no light */
    scenes_cylinder(&s, m, vec3_make(0, 0.5f, 0), vec3_make(0.3f, 0.9f, 0), 0.1f)->emission =
        rgb_gray(5);
    scenes_light(&s, LIGHT_POINT)->point.intensity = rgb_gray(1.5f);
    struct light *sun = scenes_light(&s, LIGHT_DISTANT);
    sun->distant.direction[1] = -1;
    sun->distant.irradiance = rgb_gray(0.75f);
    scenes_sky(&s, rgb_gray(0.25f));
    scenes_sky(&s, rgb_gray(0.5f));
    const struct stage *stage = scenes_stage(&s);
    const double power[] = {pi * 2 * 3,
                            pi * 2 * 3,
                            pi * pi * 2,
                            pi * pi / 16 * 0.7152,
                            pi * 2 * pi * 0.1 * 0.5 * 5,
                            4 * pi * 1.5,
                            pi * (4 + 4 + 4.0) / 4 * 0.75};
    double total = 0, sum = 0;
    for (size_t i = 0; i < countof(power); i++)
        total += power[i];
    const struct emitter *e = stage_at(stage, stage->emitters);
    const float *cdf = stage_at(stage, stage->pick_cdf);
    if (!ok(stage->emitters.count == countof(power), "seven emitters; the skies are none"))
        return;
    bool rises = cdf[0] == 0;
    for (size_t i = 0; i < countof(power); i++) {
        /* The scene's radius is that of its bounds, in which the disc has a cube. */
        near((double)e[i].pick, power[i] / total, i == 6 ? 0.03 : 0.01,
             "emitter %zu is picked by its power", i);
        sum += (double)e[i].pick;
        rises &= cdf[i + 1] > cdf[i];
        near((double)cdf[i + 1], sum, 1e-6, "the cumulative pick adds up to there");
    }
    near(sum, 1, 1e-6, "picks sum to 1");
    near((double)(e[1].pick / e[0].pick), 1, 1e-6, "both halves of the quad are picked alike");
    near((double)(e[2].pick / e[0].pick), pi / 3, 1e-6,
         "sphere against half quad: exactly by power");
    ok(rises && cdf[countof(power)] == 1, "the cumulative pick rises from 0 to 1");
    near((double)e[2].area, pi, 1e-6, "an emitter knows its area");
    const struct stage_shape *shapes = stage_at(stage, stage->shapes);
    ok(shapes[0].emitter_begin == 0 && shapes[1].emitter_begin == 2 &&
           shapes[3].emitter_begin == STAGE_NONE,
       "shapes know their emitters");
    bool found = true;
    for (uint32_t i = 0; i < 4; i++) {
        const struct stage_id id = catalog_id(stage, e[i].prim);
        found &= memcmp(&id.place, &e[i].place, sizeof id.place) == 0;
    }
    ok(found, "emitters know where they are");
    near((double)e[4].area, pi * 0.1, 1e-6, "a cylinder that of its side");
    near((double)stage->sky[0], 0.75, 0, "skies add up");
    scenes_release(&s);
}

/* The angle between two directions, in double. */
static double angle_of(vec3 a, const double b[3])
{
    double n[3], sine = 0, cosine = 0;
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        n[k] = (double)a[i] * b[j] - (double)a[j] * b[i];
        sine += n[k] * n[k];
        cosine += (double)a[k] * b[k];
    }
    return atan2(sqrt(sine), cosine);
}

static void test_camera(void)
{
    static const double fovs[] = {0.01, 0.7, pi / 2, 2.5};
    const vec3 from = vec3_make(1, 2, 3), at = vec3_make(-4, 1, 7);
    for (size_t f = 0; f < countof(fovs); f++) {
        struct scenes s;
        scenes_init(&s, 640, 360);
        scenes_look(&s, from, at, fovs[f]);
        const struct stage *stage = scenes_stage(&s);
        const struct xform *m = &s.scene.camera.to_world;
        const double half_y = tan((double)s.scene.camera.fov_y_rad / 2),
                     half_x = half_y * 640 / 360;
        double worst = 0;
        for (int y = -1; y <= 1; y++)
            for (int x = -1; x <= 1; x++) {
                double want[3];
                for (int k = 0; k < 3; k++)
                    want[k] = x * half_x * (double)m->m[k][0] - y * half_y * (double)m->m[k][1] -
                              (double)m->m[k][2];
                const struct ray ray =
                    camera_ray(&stage->camera, (float)(320 + 320 * x), (float)(180 + 180 * y));
                worst = fmax(worst, angle_of(ray.dir, want));
                worst = fmax(worst, (double)vec3_length(ray.origin - from));
            }
        near(worst, 0, 1e-6, "camera of %g rad: centre, sides and corners of the frame", fovs[f]);
        scenes_release(&s);
    }
    struct scenes s;
    scenes_init(&s, 640, 360);
    scenes_look(&s, from, at, 1);
    const struct stage *whole = scenes_stage(&s);
    s.scene.film.crop_x_begin = 100, s.scene.film.crop_y_begin = 50;
    s.scene.film.crop_x_end = 120, s.scene.film.crop_y_end = 60;
    const struct stage *part = scenes_stage(&s);
    ok(memcmp(&whole->camera, &part->camera, sizeof whole->camera) == 0,
       "a crop does not move the camera");
    ok(part->film.crop_x_begin == 100 && part->film.crop_y_end == 60, "and is kept");
    scenes_release(&s);
}

static void test_rays(void)
{
    struct scenes s;
    scenes_init(&s, 640, 360);
    scenes_look(&s, vec3_make(1, 2, 3), vec3_make(-4, 1, 0.5f), 1);
    const struct stage_camera *camera = &scenes_stage(&s)->camera;
    struct dice d = dice_make(6);
    int other = 0;
    for (int i = 0; i < 1000; i++) {
        f32x8 x, y;
        for (int k = 0; k < 8; k++) {
            x[k] = 640 * dice_float(&d);
            y[k] = 360 * dice_float(&d);
        }
        struct camera_rays eight;
        camera_rays(camera, x, y, &eight);
        for (uint32_t k = 0; k < 8; k++) {
            const struct ray a = camera_rays_at(camera, &eight, k),
                             b = camera_ray(camera, x[k], y[k]);
            for (int j = 0; j < 3; j++)
                other += a.dir[j] != b.dir[j] || a.origin[j] != b.origin[j];
            other += a.t_max != b.t_max;
        }
    }
    ok(other == 0, "eight camera rays at once are the eight rays: %d differ", other);
    scenes_release(&s);
}

/* Other arenas, other names' addresses: a pointer or a stray byte in the block would show. */
static void test_block(void)
{
    struct scenes s;
    scenes_init(&s, 16, 16);
    struct dice d = dice_make(5);
    const uint32_t m = scenes_diffuse(&s, rgb_gray(0.5f));
    scenes_glass(&s, 1.5f);
    scenes_metal(&s, rgb_gray(0.2f), rgb_gray(3), 0.1f);
    for (int i = 0; i < 20; i++) {
        scenes_sphere(&s, m, soup_point(&d, 1), 0.1f)->emission = rgb_gray(1);
        scenes_disc(&s, m, soup_point(&d, 1), soup_direction(&d), 0.1f);
        scenes_cylinder(&s, m, soup_point(&d, 1), soup_point(&d, 1), 0.1f);
        scenes_quad(&s, m, soup_point(&d, 1), soup_point(&d, 1), soup_point(&d, 1));
    }
    scenes_light(&s, LIGHT_POINT)->point.intensity = rgb_gray(1);
    const struct stage *a = scenes_stage(&s);
    for (uint32_t i = 0; i < s.scene.material_count; i++)
        s.scene.materials[i].name = arena_strdup(&s.arena, "another place");
    struct shape *elsewhere = arena_new(&s.arena, struct shape, s.scene.shape_count);
    memcpy(elsewhere, s.scene.shapes, s.scene.shape_count * sizeof *elsewhere);
    s.scene.shapes = elsewhere;
    const struct stage *b = scenes_stage(&s);
    ok(a != b && a->bytes == b->bytes && memcmp(a, b, a->bytes) == 0,
       "two preparations at different addresses are equal, byte for byte");
    const struct material *materials = stage_at(a, a->materials);
    ok(!materials[0].name && !materials[1].name, "there is no pointer to a name in it");
    ok(memcmp(a->magic, "SMSTAGE", 8) == 0 && a->version == STAGE_VERSION &&
           a->struct_bytes == sizeof *a && (uintptr_t)a % 64 == 0,
       "the block says what it is and is aligned");
    const struct stage_span spans[] = {a->shapes,    a->trees,    a->nodes,   a->blocks,
                                       a->instances, a->spheres,  a->discs,   a->cylinders,
                                       a->materials, a->emitters, a->pick_cdf};
    bool placed = true;
    for (size_t i = 0; i < countof(spans); i++)
        placed &=
            spans[i].offset % 64 == 0 && spans[i].offset >= sizeof *a && spans[i].offset < a->bytes;
    ok(placed, "arrays lie inside it, aligned");
    scenes_release(&s);
}

int main(void)
{
    test_shared_edges();
    test_fronts();
    test_sizes();
    test_dropped();
    test_empty();
    test_picks();
    test_camera();
    test_rays();
    test_block();
    return tap_done();
}
