/* SPDX-License-Identifier: MIT */
#include "common/trace/prep_plan.h"

static bool is_finite3(const float v[3])
{
    return v[0] - v[0] == 0 && v[1] - v[1] == 0 && v[2] - v[2] == 0;
}

/* Twice the area, in double: exact enough to be 0 just for collinear vertices. */
static double double_area(const struct stage_triangle *t)
{
    double a[3], b[3], sum = 0;
    for (int k = 0; k < 3; k++) {
        a[k] = (double)t->v[1][k] - (double)t->v[0][k];
        b[k] = (double)t->v[2][k] - (double)t->v[0][k];
    }
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double n = a[i] * b[j] - a[j] * b[i];
        sum += n * n;
    }
    return __builtin_sqrt(sum);
}

enum prep_fate prep_triangle_make(const vec3 v[3], struct stage_triangle *t, double *area)
{
    for (int i = 0; i < 3; i++)
        vec3_store(t->v[i], v[i]);
    if (!is_finite3(t->v[0]) || !is_finite3(t->v[1]) || !is_finite3(t->v[2]))
        return PREP_NONFINITE;
    *area = double_area(t) / 2;
    return *area > 0 ? PREP_KEPT : PREP_DEGENERATE;
}

bool prep_triangle_mirrored(const struct shape *s)
{
    const struct xform *x = &s->to_world;
    const vec3 a = vec3_make(x->m[0][0], x->m[1][0], x->m[2][0]);
    const vec3 b = vec3_make(x->m[0][1], x->m[1][1], x->m[2][1]);
    const vec3 c = vec3_make(x->m[0][2], x->m[1][2], x->m[2][2]);
    return vec3_dot(vec3_cross(a, b), c) < 0;
}

void prep_triangle_quad(bool mirrored, uint32_t i, uint32_t v[3])
{
    static const uint8_t of[2][2][3] = {{{0, 1, 2}, {0, 2, 3}}, {{3, 2, 1}, {3, 1, 0}}};
    for (int k = 0; k < 3; k++)
        v[k] = of[mirrored][i][k];
}

void prep_triangle_object(const struct mesh *mesh, uint32_t i, vec3 v[3])
{
    for (size_t k = 0; k < 3; k++)
        v[k] = vec3_load(mesh->vertices + 3 * (size_t)mesh->indices[3 * (size_t)i + k]);
}

static void quad_world(const struct shape *s, bool mirrored, uint32_t i, vec3 world[3])
{
    uint32_t v[3];
    prep_triangle_quad(mirrored, i, v);
    for (int k = 0; k < 3; k++)
        world[k] = xform_point(&s->to_world, vec3_load(s->quad.vertices[v[k]]));
}

void prep_triangle_world(const struct mesh *mesh, const struct shape *s, bool mirrored, uint32_t i,
                         vec3 world[3])
{
    vec3 v[3];
    if (!mesh) {
        quad_world(s, mirrored, i, world);
        return;
    }
    prep_triangle_object(mesh, i, v);
    for (int k = 0; k < 3; k++)
        world[mirrored ? (3 - k) % 3 : k] = xform_point(&s->to_world, v[k]);
}
