/* SPDX-License-Identifier: MIT */
#include "tests/scenes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/estimate.h"
#include "common/scene_disk.h"
#include "common/trace/prep.h"
#include "common/trace/render.h"

static const double pi = 3.14159265358979323846;

void scenes_init(struct scenes *s, uint32_t width_px, uint32_t height_px)
{
    *s = (struct scenes){0};
    struct scene *scene = &s->scene;
    scene->title = "";
    scene->film = (struct scene_film){.width_px = width_px,
                                      .height_px = height_px,
                                      .crop_x_end = width_px,
                                      .crop_y_end = height_px,
                                      .filter = FILTER_BOX,
                                      .filter_radius_px = 0.5f};
    scene->settings = (struct scene_settings){.max_bounces = 64, .seed = 1, .target = {.spp = 64}};
    scene->materials = arena_new(&s->arena, struct material, SCENES_MAX);
    scene->shapes = arena_new(&s->arena, struct shape, SCENES_MAX_SHAPES);
    scene->meshes = arena_new(&s->arena, struct mesh, SCENES_MAX);
    scene->lights = arena_new(&s->arena, struct light, SCENES_MAX);
    scenes_look(s, vec3_make(0, 0, 0), vec3_make(0, 0, -1), pi / 2);
}

bool scenes_open(struct scenes *s, const char *name)
{
    char path[64];
    struct scene_disk disk;
    struct scene_errors errors = {0};
    uint32_t unread = 0;
    *s = (struct scenes){0};
    snprintf(path, sizeof path, "scenes/%s.json", name);
    if (!scene_disk_open(&disk, path, &s->arena, &errors) ||
        !scene_disk_load(&disk, &s->arena, &unread, &errors) || unread)
        return false;
    s->scene = disk.scene;
    return true;
}

void scenes_release(struct scenes *s)
{
    arena_release(&s->arena);
}

void scenes_look(struct scenes *s, vec3 from, vec3 at, double fov_y_rad)
{
    const vec3 back = vec3_unit(from - at);
    const vec3 up = fabsf(back[1]) < 0.9f ? vec3_make(0, 1, 0) : vec3_make(0, 0, 1);
    const vec3 x = vec3_unit(vec3_cross(up, back)), y = vec3_cross(back, x);
    struct scene_camera *c = &s->scene.camera;
    for (int i = 0; i < 3; i++) {
        c->to_world.m[i][0] = x[i];
        c->to_world.m[i][1] = y[i];
        c->to_world.m[i][2] = back[i];
        c->to_world.m[i][3] = from[i];
    }
    c->fov_y_rad = (float)fov_y_rad;
}

static struct material *add_material(struct scenes *s, enum material_kind kind)
{
    if (s->scene.material_count == SCENES_MAX)
        abort();
    struct material *m = &s->scene.materials[s->scene.material_count++];
    *m = (struct material){.name = "m", .kind = kind};
    return m;
}

uint32_t scenes_material(struct scenes *s, struct material m)
{
    struct material *to = add_material(s, m.kind);
    const char *name = to->name;
    *to = m;
    to->name = name;
    return s->scene.material_count - 1;
}

uint32_t scenes_diffuse(struct scenes *s, rgb albedo)
{
    add_material(s, MATERIAL_DIFFUSE)->diffuse.albedo = albedo;
    return s->scene.material_count - 1;
}

uint32_t scenes_mirror(struct scenes *s, rgb reflectance)
{
    add_material(s, MATERIAL_MIRROR)->mirror.reflectance = reflectance;
    return s->scene.material_count - 1;
}

uint32_t scenes_glass(struct scenes *s, float ior)
{
    add_material(s, MATERIAL_DIELECTRIC)->dielectric.ior = ior;
    return s->scene.material_count - 1;
}

uint32_t scenes_metal(struct scenes *s, rgb eta, rgb k, float alpha)
{
    struct material *m = add_material(s, MATERIAL_CONDUCTOR);
    m->conductor.eta = eta;
    m->conductor.k = k;
    m->conductor.alpha = alpha;
    return s->scene.material_count - 1;
}

static struct shape *add_shape(struct scenes *s, enum shape_kind kind, uint32_t material)
{
    if (s->scene.shape_count == SCENES_MAX_SHAPES)
        abort();
    struct shape *shape = &s->scene.shapes[s->scene.shape_count++];
    *shape = (struct shape){.kind = kind, .material = material, .to_world = xform_identity()};
    return shape;
}

struct shape *scenes_sphere(struct scenes *s, uint32_t material, vec3 center, float radius)
{
    struct shape *shape = add_shape(s, SHAPE_SPHERE, material);
    vec3_store(shape->sphere.center, center);
    shape->sphere.radius = radius;
    return shape;
}

struct shape *scenes_disc(struct scenes *s, uint32_t material, vec3 center, vec3 normal,
                          float radius)
{
    struct shape *shape = add_shape(s, SHAPE_DISC, material);
    vec3_store(shape->disc.center, center);
    vec3_store(shape->disc.normal, vec3_unit(normal));
    shape->disc.radius = radius;
    return shape;
}

struct shape *scenes_cylinder(struct scenes *s, uint32_t material, vec3 from, vec3 to, float radius)
{
    struct shape *shape = add_shape(s, SHAPE_CYLINDER, material);
    vec3_store(shape->cylinder.from, from);
    vec3_store(shape->cylinder.axis, to - from);
    shape->cylinder.radius = radius;
    return shape;
}

struct shape *scenes_quad(struct scenes *s, uint32_t material, vec3 corner, vec3 a, vec3 b)
{
    struct shape *shape = add_shape(s, SHAPE_QUAD, material);
    vec3_store(shape->quad.vertices[0], corner);
    vec3_store(shape->quad.vertices[1], corner + a);
    vec3_store(shape->quad.vertices[2], corner + a + b);
    vec3_store(shape->quad.vertices[3], corner + b);
    return shape;
}

struct shape *scenes_box(struct scenes *s, uint32_t material, vec3 lo, vec3 hi, bool inside)
{
    const vec3 d = hi - lo, x = vec3_make(d[0], 0, 0), y = vec3_make(0, d[1], 0),
               z = vec3_make(0, 0, d[2]);
    const vec3 side[6][3] = {{lo, y, x},     {lo, z, y},     {lo, x, z},
                             {lo + z, x, y}, {lo + x, y, z}, {lo + y, z, x}};
    struct shape *first = NULL;
    for (int i = 0; i < 6; i++) {
        struct shape *q =
            scenes_quad(s, material, side[i][0], side[i][1 + inside], side[i][2 - inside]);
        first = first ? first : q;
    }
    return first;
}

void scenes_cube(struct scenes *s, uint32_t width_px, uint32_t height_px, int light)
{
    scenes_init(s, width_px, height_px);
    s->scene.settings.max_bounces = 1;
    scenes_box(s, scenes_diffuse(s, rgb_gray(1)), vec3_make(-.5f, -.5f, -.5f),
               vec3_make(.5f, .5f, .5f), true);
    s->scene.shapes[light].emission = rgb_gray(1);
}

struct scenes_mesh scenes_mesh(struct scenes *s, uint32_t material, uint32_t vertices,
                               uint32_t triangles)
{
    if (s->scene.mesh_count == SCENES_MAX)
        abort();
    float *v = arena_new(&s->arena, float, 3 * (size_t)vertices);
    uint32_t *i = arena_new(&s->arena, uint32_t, 3 * (size_t)triangles);
    struct shape *shape = add_shape(s, SHAPE_MESH, material);
    shape->mesh.mesh = s->scene.mesh_count;
    s->scene.meshes[s->scene.mesh_count++] = (struct mesh){.format = MESH_INLINE,
                                                           .vertices = v,
                                                           .indices = i,
                                                           .vertex_count = vertices,
                                                           .triangle_count = triangles};
    return (struct scenes_mesh){shape, (float(*)[3])v, (uint32_t(*)[3])i};
}

struct shape *scenes_triangle(struct scenes *s, uint32_t material, vec3 a, vec3 b, vec3 c)
{
    const struct scenes_mesh m = scenes_mesh(s, material, 3, 1);
    vec3_store(m.vertices[0], a);
    vec3_store(m.vertices[1], b);
    vec3_store(m.vertices[2], c);
    for (uint32_t k = 0; k < 3; k++)
        m.triangles[0][k] = k;
    return m.shape;
}

/* Rows of latitude 0..n, columns of longitude 0..2n - 1; the poles' quadrangles are degenerate on
 * one side, which prep drops. */
struct shape *scenes_ball(struct scenes *s, uint32_t material, vec3 center, float radius,
                          uint32_t n, float wave, bool inside)
{
    const uint32_t columns = 2 * n;
    const struct scenes_mesh m = scenes_mesh(s, material, (n + 1) * columns, 2 * n * columns);
    float *v = m.vertices[0];
    uint32_t *index = m.triangles[0];
    for (uint32_t row = 0; row <= n; row++)
        for (uint32_t column = 0; column < columns; column++, v += 3) {
            const bool pole = row == 0 || row == n;
            const double t = pi * row / n, p = 2 * pi * column / columns;
            const double st = pole ? 0 : sin(t);
            const double r = (double)radius * (1 + (double)wave * st * sin(5 * p) * sin(6 * t));
            const vec3 d =
                vec3_make((float)(r * st * sin(p)), (float)(r * cos(t)), (float)(r * st * cos(p)));
            vec3_store(v, center + d);
        }
    for (uint32_t row = 0; row < n; row++)
        for (uint32_t column = 0; column < columns; column++, index += 6) {
            const uint32_t next = (column + 1) % columns;
            const uint32_t a = row * columns + column, b = row * columns + next;
            const uint32_t corner[4] = {a, a + columns, b + columns, b};
            for (int k = 0; k < 3; k++) {
                index[k] = corner[inside ? 2 - k : k];
                index[3 + k] = corner[(inside ? 4 - k : k + 2) % 4];
            }
        }
    return m.shape;
}

struct light *scenes_light(struct scenes *s, enum light_kind kind)
{
    if (s->scene.light_count == SCENES_MAX)
        abort();
    struct light *light = &s->scene.lights[s->scene.light_count++];
    *light = (struct light){.kind = kind};
    return light;
}

void scenes_sky(struct scenes *s, rgb radiance)
{
    scenes_light(s, LIGHT_SKY)->sky.radiance = radiance;
}

const struct stage *scenes_stage(struct scenes *s)
{
    const struct stage *stage;
    struct arena scratch = {0};
    struct err err;
    if (!prep_stage(&s->scene, NULL, &s->arena, &scratch, &stage, &err)) {
        fprintf(stderr, "%s\n", err.text);
        abort();
    }
    arena_release(&scratch);
    return stage;
}

void scenes_render(const struct stage *stage, uint32_t spp, struct film *film)
{
    const struct scene_film *f = &stage->film;
    const struct tile_rect frame = {f->crop_x_begin, f->crop_y_begin, f->crop_x_end, f->crop_y_end};
    film_init(film, frame);
    film_add_layers(film, stage->film.layers);
    struct arena arena = {0};
    for (uint32_t pass = 0; pass < tile_pass_count(spp); pass++) {
        struct film_samples samples = film_samples_make(frame, tile_pass_of(pass, spp), &arena);
        film_samples_add_layers(&samples, film->layers, &arena);
        render_tile(stage, &samples);
        film_merge(film, &samples);
        arena_reset(&arena);
    }
    arena_release(&arena);
}

void scenes_follow(const struct stage *stage, uint32_t which, const struct wave_starts *starts,
                   const struct rng rngs[], uint32_t roulette_begin, rgb radiance[])
{
    struct wave wave;
    wave_init(&wave, stage, roulette_begin, NULL, radiance);
    wave_put(&wave, which, starts, rngs, 0);
    wave_finish(&wave);
}

struct scenes_mean scenes_mean(const struct film *film, int channel)
{
    const size_t pixels = tile_rect_pixels(film->window);
    double sum = 0, square = 0;
    for (size_t i = 0; i < pixels; i++) {
        double mean[3], error[3];
        film_mean(film, i, mean);
        estimate_pixel(film, i, error);
        sum += mean[channel];
        square += error[channel] * error[channel];
    }
    return (struct scenes_mean){sum / (double)pixels, sqrt(square) / (double)pixels};
}
