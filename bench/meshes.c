/* SPDX-License-Identifier: MIT */
#include "bench/meshes.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

#include "bench/noise.h"
#include "common/buf.h"
#include "common/mesh.h"
#include "tests/soup.h"

enum { SIDE_PX = 768 };

static const double pi = 3.14159265358979323846;

const char *meshes_name(enum meshes_kind kind)
{
    static const char *const names[] = {"bunny",  "interior", "terrain",
                                        "sphere", "soup",     "cornell"};
    _Static_assert(countof(names) == MESHES_KINDS, "a name for each");
    return names[kind];
}

/* --- the parts --- */

static void put_on_ball(float out[3], const struct meshes_ball *b, double cosine, double turn)
{
    const double sine = sqrt(fmax(0, 1 - cosine * cosine)), phi = 2 * pi * turn;
    const double dir[3] = {sine * sin(phi), cosine, sine * cos(phi)};
    const double at[3] = {4 * dir[0], 4 * dir[1], 4 * dir[2]};
    const double r = (double)b->radius * (1 + (double)b->bump * noise_fbm(at, 7));
    for (int k = 0; k < 3; k++)
        out[k] = (float)((double)b->center[k] + r * dir[k]);
}

static void set_triangle(uint32_t out[3], uint32_t a, uint32_t b, uint32_t c)
{
    out[0] = a;
    out[1] = b;
    out[2] = c;
}

/* Vertices: the north pole, the circles from north to south, the south pole. */
struct shape *meshes_add_ball(struct scenes *s, uint32_t material, const struct meshes_ball *b)
{
    const uint32_t columns = b->columns, circles = b->rings - 1;
    const struct scenes_mesh m =
        scenes_mesh(s, material, circles * columns + 2, 2 * columns * circles);
    const uint32_t south = circles * columns + 1;
    put_on_ball(m.vertices[0], b, 1, 0);
    put_on_ball(m.vertices[south], b, -1, 0);
    for (uint32_t i = 0; i < circles; i++)
        for (uint32_t j = 0; j < columns; j++)
            put_on_ball(m.vertices[1 + i * columns + j], b, cos(pi * (i + 1) / b->rings),
                        (double)j / columns);
    uint32_t(*t)[3] = m.triangles;
    for (uint32_t j = 0; j < columns; j++) {
        const uint32_t k = (j + 1) % columns, last = 1 + (circles - 1) * columns;
        set_triangle(*t++, 0, 1 + j, 1 + k);
        for (uint32_t i = 0; i + 1 < circles; i++) {
            const uint32_t a = 1 + i * columns, c = a + columns;
            set_triangle(*t++, a + j, c + j, c + k);
            set_triangle(*t++, a + j, c + k, a + k);
        }
        set_triangle(*t++, last + j, south, last + k);
    }
    return m.shape;
}

struct shape *meshes_add_terrain(struct scenes *s, uint32_t material, uint32_t n, float side)
{
    const uint32_t row = n + 1;
    const struct scenes_mesh m = scenes_mesh(s, material, row * row, 2 * n * n);
    for (uint32_t i = 0; i < row; i++)
        for (uint32_t j = 0; j < row; j++) {
            const double x = (double)j / n - 0.5, z = (double)i / n - 0.5;
            const double at[3] = {5 * x, 0, 5 * z};
            float *v = m.vertices[i * row + j];
            v[0] = side * (float)x;
            v[1] = 0.1f * side * (float)noise_fbm(at, 9);
            v[2] = side * (float)z;
        }
    uint32_t(*t)[3] = m.triangles;
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = 0; j < n; j++) {
            const uint32_t a = i * row + j, b = a + row;
            set_triangle(*t++, a, b, b + 1);
            set_triangle(*t++, a, b + 1, a + 1);
        }
    return m.shape;
}

struct shape *meshes_add_soup(struct scenes *s, uint32_t material, uint32_t triangles, float size)
{
    struct dice d = dice_make(1);
    float(*v)[3] = soup_vertices(s, triangles);
    for (uint32_t i = 0; i < triangles; i++) {
        const vec3 center = soup_point(&d, 1 - (double)size / 2);
        for (uint32_t k = 0; k < 3; k++)
            vec3_store(v[3 * i + k], center + soup_point(&d, (double)size / 2));
    }
    return soup_mesh(s, material, v, triangles);
}

struct shape *meshes_add_file(struct scenes *s, uint32_t material, const char *path,
                              struct err *err)
{
    enum { MOST_BYTES = 1 << 30 };
    struct mesh mesh = {0};
    if (!mesh_format_of(path, &mesh.format)) {
        err_set(err, ERR_INPUT, "%s: expected a name that ends in .obj or .ply", path);
        return NULL;
    }
    struct buf bytes = {0};
    const bool good =
        buf_read_file(&bytes, path, MOST_BYTES, err) &&
        (mesh_read(&mesh, bytes.data, bytes.size, &s->arena, err) || err_at(err, "%s", path));
    buf_release(&bytes);
    if (!good)
        return NULL;
    struct shape *shape = scenes_mesh(s, material, 0, 0).shape;
    s->scene.meshes[shape->mesh.mesh] = mesh;
    return shape;
}

struct shape *meshes_add_bunny(struct scenes *s, uint32_t material, const char *assets,
                               const char **what, struct err *err)
{
    const char *path = arena_printf(&s->arena, "%s/stanford-bunny.obj", assets);
    if (!access(path, F_OK)) {
        *what = "the Stanford bunny";
        return meshes_add_file(s, material, path, err);
    }
    *what = arena_printf(&s->arena, "no %s: a bumpy ball in place of the bunny", path);
    return meshes_add_ball(s, material,
                           &(struct meshes_ball){.center = vec3_make(-0.017f, 0.11f, 0),
                                                 .radius = 0.065f,
                                                 .bump = 0.15f,
                                                 .rings = 188,
                                                 .columns = 186});
}

/* --- the scenes --- */

static void set_lamp(struct meshes *m, vec3 corner, float a, float b)
{
    m->lamp[0] = corner;
    m->lamp[1] = vec3_make(a, 0, 0);
    m->lamp[2] = vec3_make(0, 0, b); /* a x b looks down */
}

static void add_ground(struct scenes *s, uint32_t material, float height, float side)
{
    scenes_quad(s, material, vec3_make(-side / 2, height, -side / 2), vec3_make(0, 0, side),
                vec3_make(side, 0, 0));
}

static bool make_bunny(struct meshes *m, const char *assets, struct err *err)
{
    struct scenes *s = &m->scenes;
    const uint32_t clay = scenes_diffuse(s, rgb_gray(0.7f));
    const float ground = 0.0329f; /* under its feet */
    add_ground(s, clay, ground, 0.8f);
    scenes_look(s, vec3_make(0.05f, 0.2f, 0.34f), vec3_make(-0.017f, 0.1f, 0), 0.6);
    set_lamp(m, vec3_make(-0.5f, 0.7f, -0.2f), 0.3f, 0.3f);
    scenes_sky(s, rgb_gray(1));
    const char *what;
    if (!meshes_add_bunny(s, clay, assets, &what, err))
        return false;
    m->what = arena_printf(&s->arena, "%s, on a ground", what);
    return true;
}

/* [-1, 1]^3, open towards +z. */
static void add_walls(struct scenes *s, uint32_t white)
{
    const vec3 x = vec3_make(2, 0, 0), y = vec3_make(0, 2, 0), z = vec3_make(0, 0, 2);
    const vec3 lo = vec3_make(-1, -1, -1);
    scenes_quad(s, white, lo, z, x);
    scenes_quad(s, white, lo + y, x, z);
    scenes_quad(s, white, lo, x, y);
    scenes_quad(s, scenes_diffuse(s, vec3_make(0.63f, 0.06f, 0.05f)), lo, y, z);
    scenes_quad(s, scenes_diffuse(s, vec3_make(0.14f, 0.45f, 0.09f)), lo + x, z, y);
    scenes_look(s, vec3_make(0, 0, 3.5f), vec3_make(0, 0, 0), 0.75);
}

static void make_interior(struct meshes *m, uint32_t triangles)
{
    struct scenes *s = &m->scenes;
    const uint32_t white = scenes_diffuse(s, rgb_gray(0.7f));
    add_walls(s, white);
    scenes_sky(s, rgb_gray(1));
    set_lamp(m, vec3_make(-0.25f, 0.99f, -0.25f), 0.5f, 0.5f);
    const uint32_t n = triangles ? max_u32(2, (uint32_t)lround(sqrt(triangles / 6.0))) : 420;
    const vec3 centers[] = {{-0.49f, -0.49f, -0.3f}, {0.49f, -0.49f, 0.25f}, {0, 0.42f, -0.4f}};
    for (size_t i = 0; i < countof(centers); i++)
        meshes_add_ball(s, white,
                        &(struct meshes_ball){.center = centers[i],
                                              .radius = 0.45f,
                                              .bump = 0.12f,
                                              .rings = n + 1,
                                              .columns = n});
    m->what = "a Cornell box with three bumpy balls";
}

static void make_terrain(struct meshes *m, uint32_t triangles)
{
    struct scenes *s = &m->scenes;
    const uint32_t n = triangles ? max_u32(1, (uint32_t)lround(sqrt(triangles / 2.0))) : 724;
    meshes_add_terrain(s, scenes_diffuse(s, rgb_gray(0.5f)), n, 10);
    scenes_look(s, vec3_make(0, 2.6f, 6), vec3_make(0, 0, 0.6f), 0.8);
    scenes_sky(s, rgb_gray(1));
    set_lamp(m, vec3_make(-4, 5, -4), 2, 2);
    m->what = "a height field";
}

static void make_sphere(struct meshes *m, uint32_t triangles)
{
    struct scenes *s = &m->scenes;
    const uint32_t clay = scenes_diffuse(s, rgb_gray(0.7f));
    const uint32_t n = triangles ? max_u32(2, (uint32_t)lround(sqrt(triangles / 2.0))) : 1600;
    meshes_add_ball(
        s, clay, &(struct meshes_ball){.radius = 1, .bump = 0.15f, .rings = n + 1, .columns = n});
    add_ground(s, clay, -1.2f, 8);
    scenes_look(s, vec3_make(0, 0.8f, 3.4f), vec3_make(0, -0.1f, 0), 0.7);
    scenes_sky(s, rgb_gray(1));
    set_lamp(m, vec3_make(-2.5f, 3, 0.5f), 1, 1);
    m->what = "a bumpy ball on a ground";
}

static void make_soup(struct meshes *m, uint32_t triangles)
{
    struct scenes *s = &m->scenes;
    const uint32_t n = triangles ? triangles : 1000000;
    /* As dense for the eye, however many there are. */
    meshes_add_soup(s, scenes_diffuse(s, rgb_gray(0.5f)), n, 0.02f * (float)sqrt(1e6 / n));
    scenes_look(s, vec3_make(0.5f, 0.7f, 3.6f), vec3_make(0, 0, 0), 0.7);
    scenes_sky(s, rgb_gray(1));
    set_lamp(m, vec3_make(-0.5f, 3, -0.5f), 1, 1);
    m->what = "small triangles at random places";
}

/* A box of twelve triangles on the floor, turned about the vertical. */
static void add_block(struct scenes *s, uint32_t material, vec3 at, vec3 half, double angle)
{
    struct shape *side = scenes_box(s, material, -half, half, false);
    const float c = (float)cos(angle), sine = (float)sin(angle);
    for (int i = 0; i < 6; i++)
        side[i].to_world =
            (struct xform){{{c, 0, sine, at[0]}, {0, 1, 0, at[1]}, {-sine, 0, c, at[2]}}};
}

static void make_cornell(struct meshes *m)
{
    struct scenes *s = &m->scenes;
    const uint32_t white = scenes_diffuse(s, rgb_gray(0.72f));
    add_walls(s, white);
    set_lamp(m, vec3_make(-0.25f, 0.99f, -0.25f), 0.5f, 0.5f);
    scenes_quad(s, white, m->lamp[0], m->lamp[1], m->lamp[2])->emission = vec3_make(17, 12, 4);
    add_block(s, white, vec3_make(0.33f, -0.69f, 0.35f), vec3_make(0.3f, 0.3f, 0.3f), 0.29);
    add_block(s, white, vec3_make(-0.33f, -0.39f, -0.3f), vec3_make(0.3f, 0.6f, 0.3f), -0.31);
    m->what = "a Cornell box with two blocks and its lamp";
}

static uint32_t count_triangles(const struct scene *scene)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < scene->shape_count; i++)
        n += scene->shapes[i].kind == SHAPE_QUAD
                 ? 2
                 : scene->meshes[scene->shapes[i].mesh.mesh].triangle_count;
    return n;
}

bool meshes_init(struct meshes *m, enum meshes_kind kind, uint32_t triangles, const char *assets,
                 struct err *err)
{
    *m = (struct meshes){0};
    scenes_init(&m->scenes, SIDE_PX, SIDE_PX);
    bool good = true;
    switch (kind) {
    case MESHES_BUNNY:
        good = make_bunny(m, assets, err);
        break;
    case MESHES_INTERIOR:
        make_interior(m, triangles);
        break;
    case MESHES_TERRAIN:
        make_terrain(m, triangles);
        break;
    case MESHES_SPHERE:
        make_sphere(m, triangles);
        break;
    case MESHES_SOUP:
        make_soup(m, triangles);
        break;
    case MESHES_CORNELL:
        make_cornell(m);
        break;
    case MESHES_KINDS:
        __builtin_unreachable();
    }
    m->triangles = count_triangles(&m->scenes.scene);
    if (!good)
        meshes_release(m);
    return good;
}

void meshes_release(struct meshes *m)
{
    scenes_release(&m->scenes);
}
