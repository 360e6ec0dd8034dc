/* SPDX-License-Identifier: MIT */
#include "tests/crowd.h"

#include <math.h>
#include <string.h>

#include "tests/soup.h"

/* A turn, a stretch along each axis of up to 3 times, a turn; one in two mirrored. */
static struct xform transform(struct dice *d, double reach)
{
    vec3 turn[2][3];
    float stretch[3];
    for (int i = 0; i < 2; i++) {
        turn[i][0] = soup_direction(d);
        turn[i][1] = vec3_unit(vec3_cross(turn[i][0], soup_direction(d)));
        turn[i][2] = vec3_cross(turn[i][0], turn[i][1]);
    }
    for (int k = 0; k < 3; k++)
        stretch[k] = (float)pow(3, dice_range(d, -1, 1));
    if (dice_bits(d) & 1)
        stretch[2] = -stretch[2];
    const vec3 at = soup_point(d, dice_bits(d) & 1 ? 10 : reach);
    struct xform x;
    for (int i = 0; i < 3; i++) {
        x.m[i][3] = at[i];
        for (int j = 0; j < 3; j++) {
            x.m[i][j] = 0;
            for (int k = 0; k < 3; k++)
                x.m[i][j] += turn[0][k][i] * stretch[k] * turn[1][k][j];
        }
    }
    return x;
}

void crowd_add(struct scenes *s, uint32_t material, const struct crowd *c)
{
    struct dice d = dice_make(c->seed);
    scenes_ball(s, material, vec3_make(0.1f, -0.2f, 0.3f), 1, c->rings, 0.2f, false);
    struct scene *scene = &s->scene;
    const struct shape ball = scene->shapes[--scene->shape_count];
    const struct mesh mesh = scene->meshes[--scene->mesh_count];
    struct shape *shapes = arena_new(&s->arena, struct shape, scene->shape_count + c->uses);
    struct mesh *meshes = arena_new(&s->arena, struct mesh, scene->mesh_count + c->uses);
    memcpy(shapes, scene->shapes, scene->shape_count * sizeof *shapes);
    memcpy(meshes, scene->meshes, scene->mesh_count * sizeof *meshes);
    scene->shapes = shapes;
    scene->meshes = meshes;
    for (uint32_t i = 0; i < c->uses; i++) {
        struct shape *shape = &shapes[scene->shape_count++];
        *shape = ball;
        shape->to_world = transform(&d, c->reach);
        if (i == c->uses / 2)
            shape->emission = rgb_gray(2);
        if (c->copies || i == 0)
            meshes[scene->mesh_count++] = mesh;
        shape->mesh.mesh = scene->mesh_count - 1;
    }
}

void crowd_add_others(struct scenes *s, uint32_t material, uint64_t seed)
{
    struct dice d = dice_make(seed);
    scenes_quad(s, material, vec3_make(-50, -10, -50), vec3_make(0, 0, 100), vec3_make(100, 0, 0));
    scenes_quad(s, material, vec3_make(-5, 15, -5), vec3_make(10, 0, 0), vec3_make(0, 0, 10))
        ->emission = rgb_gray(5);
    for (int i = 0; i < 10; i++) {
        const float radius = (float)dice_range(&d, 0.2, 2);
        scenes_sphere(s, material, soup_point(&d, 10), radius);
        const vec3 center = soup_point(&d, 10), normal = soup_direction(&d);
        scenes_disc(s, material, center, normal, radius);
        const vec3 from = soup_point(&d, 10);
        scenes_cylinder(s, material, from, from + 3 * soup_direction(&d), radius);
    }
}
