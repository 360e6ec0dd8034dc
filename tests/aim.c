/* SPDX-License-Identifier: MIT */
#include "tests/aim.h"

#include <math.h>

#include "tests/catalog.h"

/* A point of a triangle's outline: a vertex, or a point of an edge. */
static vec3 outline(struct dice *d, const struct stage_triangle *t, bool vertex)
{
    const uint32_t k = dice_bits(d) % 3;
    const vec3 a = vec3_load(t->v[k]), b = vec3_load(t->v[(k + 1) % 3]);
    return vertex ? a : a + (b - a) * dice_float(d);
}

/* Of those that are not an instance's. */
static struct stage_triangle any_triangle(struct dice *d, const struct stage *s)
{
    const struct stage_tree *world = stage_at(s, s->trees);
    const struct stage_block *blocks = stage_at(s, s->blocks);
    for (;;) {
        const uint32_t i = dice_bits(d) % (world->block_end * STAGE_LANES);
        if (blocks[i / STAGE_LANES].prim[i % STAGE_LANES] != STAGE_NONE)
            return stage_triangle_at(s, i, STAGE_NONE);
    }
}

struct ray aim_ray(struct dice *d, const struct stage *s, vec3 origin, bool vertex)
{
    vec3 dir = {0};
    while (!(vec3_dot(dir, dir) > 0)) { /* far from 0, both on one coarse grid, they may agree */
        const struct stage_triangle t = any_triangle(d, s);
        dir = outline(d, &t, vertex) - origin;
    }
    return (struct ray){origin, dir, INFINITY, 0, 0};
}

/* A. van Oosterom, J. Strackee, "The Solid Angle of a Plane Triangle", IEEE Trans. Biomed. Eng.
 * 30(2), 1983. Positive where the triangle's back is seen. */
static double solid_angle(const struct stage_triangle *t, vec3 p)
{
    double v[3][3], length[3];
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++)
            v[i][k] = (double)t->v[i][k] - (double)p[k];
        length[i] = sqrt(v[i][0] * v[i][0] + v[i][1] * v[i][1] + v[i][2] * v[i][2]);
    }
    double volume = 0, dots = length[0] * length[1] * length[2];
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        volume += v[0][k] * (v[1][i] * v[2][j] - v[1][j] * v[2][i]);
        for (int m = 0; m < 3; m++) /* the dot product of the two corners that are not k */
            dots += v[i][m] * v[j][m] * length[k];
    }
    return 2 * atan2(volume, dots);
}

double aim_winding(const struct stage *s, vec3 p)
{
    const double whole = 4 * 3.14159265358979323846;
    double sum = 0;
    struct stage_id id;
    for (uint64_t at = 0; catalog_next(s, &at, &id);) {
        const struct stage_triangle t = stage_triangle_at(s, id.place.index, id.instance);
        sum += solid_angle(&t, p);
    }
    return sum / whole;
}
