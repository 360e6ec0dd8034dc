/* SPDX-License-Identifier: MIT */
#include "common/scene_xform.h"

#include <math.h>

double scene_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void scene_cross(const double a[3], const double b[3], double out[3])
{
    const double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                         a[0] * b[1] - a[1] * b[0]};
    for (int i = 0; i < 3; i++)
        out[i] = c[i];
}

double scene_length(const double v[3])
{
    return sqrt(scene_dot(v, v)); /* correctly rounded everywhere (IEEE 754), unlike sin */
}

struct scene_xform scene_xform_identity(void)
{
    return (struct scene_xform){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

struct scene_xform scene_xform_translate(const double o[3])
{
    return (struct scene_xform){{{1, 0, 0, o[0]}, {0, 1, 0, o[1]}, {0, 0, 1, o[2]}}};
}

struct scene_xform scene_xform_scale(const double f[3])
{
    return (struct scene_xform){{{f[0], 0, 0, 0}, {0, f[1], 0, 0}, {0, 0, f[2], 0}}};
}

/* Taylor series of sin x / x and cos x in x^2: below 1e-17 from the limit for |x| <= pi/4. */
static double series(double x2, int first)
{
    double sum = 1;
    for (int n = first + 16; n > first; n -= 2)
        sum = 1 - sum * x2 / ((n - 1) * n);
    return sum;
}

static void sin_cos_deg(double deg, double *s, double *c)
{
    const double turn = fmod(deg, 360); /* exact */
    const double quarters = floor(turn / 90 + .5);
    const double x = (turn - 90 * quarters) * (3.14159265358979323846 / 180); /* the difference
                                                                               * is exact */
    const double sx = x * series(x * x, 1), cx = series(x * x, 0);
    switch ((int)quarters & 3) {
    case 0:
        *s = sx, *c = cx;
        return;
    case 1:
        *s = cx, *c = -sx;
        return;
    case 2:
        *s = -sx, *c = -cx;
        return;
    case 3:
        *s = -cx, *c = sx;
        return;
    }
    __builtin_unreachable();
}

/* O. Rodrigues' formula: R = cos I + sin [k]x + (1 - cos) k k^T, k the unit axis. */
struct scene_xform scene_xform_rotate(const double axis[3], double angle_deg)
{
    double s, c, k[3];
    sin_cos_deg(angle_deg, &s, &c);
    const double length = scene_length(axis);
    for (int i = 0; i < 3; i++)
        k[i] = axis[i] / length;
    struct scene_xform r;
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, l = (i + 2) % 3;
        r.m[i][i] = c + (1 - c) * k[i] * k[i];
        r.m[i][j] = (1 - c) * k[i] * k[j] - s * k[l];
        r.m[i][l] = (1 - c) * k[i] * k[l] + s * k[j];
        r.m[i][3] = 0;
    }
    return r;
}

struct scene_xform scene_xform_join(const struct scene_xform *then, const struct scene_xform *first)
{
    struct scene_xform r;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            double sum = j == 3 ? then->m[i][3] : 0;
            for (int k = 0; k < 3; k++)
                sum += then->m[i][k] * first->m[k][j];
            r.m[i][j] = sum;
        }
    return r;
}

bool scene_xform_look_at(struct scene_xform *out, const double from[3], const double to[3],
                         const double up[3])
{
    double back[3], right[3], upright[3];
    for (int i = 0; i < 3; i++)
        back[i] = from[i] - to[i];
    const double distance = scene_length(back), up_length = scene_length(up);
    if (!(distance > 0) || !(up_length > 0))
        return false;
    for (int i = 0; i < 3; i++)
        back[i] /= distance;
    scene_cross(up, back, right);
    const double sine = scene_length(right) / up_length;
    if (!(sine > 1e-6)) /* nearer than this, rounding alone chooses what is upright */
        return false;
    for (int i = 0; i < 3; i++)
        right[i] /= sine * up_length;
    scene_cross(back, right, upright);
    for (int i = 0; i < 3; i++) {
        out->m[i][0] = right[i];
        out->m[i][1] = upright[i];
        out->m[i][2] = back[i];
        out->m[i][3] = from[i];
    }
    return true;
}

void scene_xform_point(const struct scene_xform *x, const double p[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = scene_dot(x->m[i], p) + x->m[i][3];
}

double scene_xform_determinant(const struct scene_xform *x)
{
    double c[3];
    scene_cross(x->m[1], x->m[2], c);
    return scene_dot(x->m[0], c);
}

struct xform scene_xform_round(const struct scene_xform *x)
{
    struct xform r;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            r.m[i][j] = (float)x->m[i][j];
    return r;
}
