/* SPDX-License-Identifier: MIT */
#include "tests/jumble.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/trace/prep.h"

static const double pi = 3.14159265358979323846;

void jumble_init(struct jumble *j, uint32_t max_triangles, uint32_t max_others)
{
    *j = (struct jumble){.max_vertices = 3 * max_triangles,
                         .max_triangles = max_triangles,
                         .max_shapes = max_others + 1};
    struct scene *s = &j->scene;
    j->vertices = arena_new(&j->arena, float, 3 * (size_t)j->max_vertices);
    j->indices = arena_new(&j->arena, uint32_t, 3 * (size_t)max_triangles);
    s->title = "";
    s->film = (struct scene_film){16, 16, 0, 0, 16, 16, FILTER_BOX, 0.5f};
    s->settings = (struct scene_settings){.max_bounces = 64, .target = {.spp = 64}};
    s->camera.to_world = xform_identity();
    s->camera.fov_y_rad = 1;
    s->materials = arena_new(&j->arena, struct material, 1);
    s->materials[0].name = "grey";
    s->material_count = 1;
    s->meshes = arena_new(&j->arena, struct mesh, 1);
    s->meshes[0].vertices = j->vertices;
    s->meshes[0].indices = j->indices;
    s->mesh_count = 1;
    s->shapes = arena_new(&j->arena, struct shape, j->max_shapes);
    s->shapes[0] = (struct shape){.kind = SHAPE_MESH, .to_world = xform_identity()};
    s->shape_count = 1;
}

void jumble_release(struct jumble *j)
{
    arena_release(&j->arena);
}

uint32_t jumble_vertex(struct jumble *j, vec3 p)
{
    struct mesh *m = &j->scene.meshes[0];
    if (m->vertex_count == j->max_vertices)
        abort();
    vec3_store(j->vertices + 3 * (size_t)m->vertex_count, p);
    return m->vertex_count++;
}

void jumble_face(struct jumble *j, uint32_t a, uint32_t b, uint32_t c)
{
    struct mesh *m = &j->scene.meshes[0];
    if (m->triangle_count == j->max_triangles)
        abort();
    uint32_t *at = j->indices + 3 * (size_t)m->triangle_count++;
    at[0] = a;
    at[1] = b;
    at[2] = c;
}

void jumble_triangle(struct jumble *j, vec3 a, vec3 b, vec3 c)
{
    const uint32_t first = jumble_vertex(j, a);
    jumble_vertex(j, b);
    jumble_vertex(j, c);
    jumble_face(j, first, first + 1, first + 2);
}

static struct shape *add(struct jumble *j, enum shape_kind kind)
{
    if (j->scene.shape_count == j->max_shapes)
        abort();
    struct shape *s = &j->scene.shapes[j->scene.shape_count++];
    *s = (struct shape){.kind = kind, .to_world = xform_identity()};
    return s;
}

struct shape *jumble_sphere(struct jumble *j, vec3 center, float radius)
{
    struct shape *s = add(j, SHAPE_SPHERE);
    vec3_store(s->sphere.center, center);
    s->sphere.radius = radius;
    return s;
}

struct shape *jumble_disc(struct jumble *j, vec3 center, vec3 normal_raw, float radius)
{
    struct shape *s = add(j, SHAPE_DISC);
    vec3_store(s->disc.center, center);
    vec3_store(s->disc.normal, vec3_unit(normal_raw));
    s->disc.radius = radius;
    return s;
}

void jumble_bumpy_sphere(struct jumble *j, uint32_t n, vec3 center)
{
    struct dice d = dice_make(n);
    const uint32_t south = jumble_vertex(j, center + vec3_make(0, -1, 0));
    const uint32_t north = jumble_vertex(j, center + vec3_make(0, 1, 0));
    const uint32_t first = north + 1; /* then n - 1 rings of n */
    for (uint32_t y = 1; y < n; y++)
        for (uint32_t x = 0; x < n; x++) {
            const double theta = pi * y / n, phi = 2 * pi * x / n, r = dice_range(&d, 0.9, 1.1);
            const vec3 out = {(float)(r * sin(theta) * cos(phi)), (float)(-r * cos(theta)),
                              (float)(r * sin(theta) * sin(phi)), 0};
            jumble_vertex(j, center + out);
        }
    for (uint32_t x = 0; x < n; x++) {
        const uint32_t next = (x + 1) % n;
        jumble_face(j, south, first + x, first + next);
        for (uint32_t y = 0; y + 2 < n; y++) {
            const uint32_t below = first + y * n, above = below + n;
            jumble_face(j, below + x, above + x, above + next);
            jumble_face(j, below + x, above + next, below + next);
        }
        const uint32_t last = first + (n - 2) * n;
        jumble_face(j, north, last + next, last + x);
    }
}

const struct stage *jumble_stage(struct jumble *j)
{
    const struct stage *stage;
    struct arena scratch = {0};
    struct err err;
    if (!prep_stage(&j->scene, &j->arena, &scratch, &stage, &err)) {
        fprintf(stderr, "prep: %s\n", err.text);
        abort();
    }
    arena_release(&scratch);
    return stage;
}

vec3 jumble_point(struct dice *d, vec3 center, double reach)
{
    vec3 p = center;
    for (int k = 0; k < 3; k++)
        p[k] += (float)dice_range(d, -reach, reach);
    return p;
}

vec3 jumble_direction(struct dice *d)
{
    const double z = dice_range(d, -1, 1), phi = dice_range(d, 0, 2 * pi), r = sqrt(1 - z * z);
    return vec3_make((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z);
}
