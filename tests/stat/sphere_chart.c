/* SPDX-License-Identifier: MIT */
#include "tests/stat/sphere_chart.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross_unit(const double a[3], const double b[3], double out[3])
{
    const double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                         a[0] * b[1] - a[1] * b[0]};
    for (int i = 0; i < 3; i++)
        out[i] = c[i] / sqrt(dot(c, c));
}

struct sphere_chart sphere_chart_make(vec3 axis, double width)
{
    struct sphere_chart c = {.width = width};
    const double a[3] = {(double)axis[0], (double)axis[1], (double)axis[2]};
    for (int i = 0; i < 3; i++)
        c.z[i] = a[i] / sqrt(dot(a, a));
    const double along_x[3] = {1, 0, 0}, along_y[3] = {0, 1, 0};
    cross_unit(c.z, fabs(c.z[0]) < 0.8 ? along_x : along_y, c.y);
    cross_unit(c.y, c.z, c.x);
    return c;
}

static double s_of(const struct sphere_chart *c, double row)
{
    return c->width > 0 ? c->width * row / (1 + c->width - row) : row;
}

/* ds / drow */
static double stretch(const struct sphere_chart *c, double row)
{
    const double rest = 1 + c->width - row;
    return c->width > 0 ? c->width * (1 + c->width) / (rest * rest) : 1;
}

vec3 sphere_chart_direction(const struct sphere_chart *c, struct sphere_place p)
{
    const double s = s_of(c, p.row), r = 2 * sqrt(s * fmax(0, 1 - s));
    const double x = r * cos(2 * pi * p.turn), y = r * sin(2 * pi * p.turn), z = 1 - 2 * s;
    float w[3];
    for (int i = 0; i < 3; i++)
        w[i] = (float)(x * c->x[i] + y * c->y[i] + z * c->z[i]);
    return vec3_make(w[0], w[1], w[2]);
}

/* s = |w - axis|^2 / 4, which keeps its digits near the axis. */
struct sphere_place sphere_chart_place(const struct sphere_chart *c, vec3 w)
{
    const double v[3] = {(double)w[0], (double)w[1], (double)w[2]};
    double near_axis = 0, far_axis = 0;
    for (int i = 0; i < 3; i++) {
        near_axis += (v[i] - c->z[i]) * (v[i] - c->z[i]) / 4;
        far_axis += (v[i] + c->z[i]) * (v[i] + c->z[i]) / 4;
    }
    const double s = fmin(1, near_axis < far_axis ? near_axis : fmax(0, 1 - far_axis));
    const double turn = atan2(dot(v, c->y), dot(v, c->x)) / (2 * pi);
    return (struct sphere_place){
        .row = c->width > 0 ? s * (1 + c->width) / (s + c->width) : s,
        .turn = turn < 0 ? turn + 1 : turn,
    };
}

struct cell {
    double row, turn, height, breadth;
};

/* 3 x 3 Gauss-Legendre points. dw = 4 pi ds dturn. */
static double gauss(const struct sphere_chart *c, const struct sphere_integrand *f,
                    struct cell cell)
{
    static const double x[3] = {0.1127016653792583, 0.5, 0.8872983346207417};
    static const double w[3] = {5. / 18, 8. / 18, 5. / 18};
    double sum = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const struct sphere_place p = {cell.row + x[i] * cell.height,
                                           cell.turn + x[j] * cell.breadth};
            const double value = f->f(f->what, sphere_chart_direction(c, p));
            sum += w[i] * w[j] * value * stretch(c, p.row);
        }
    return sum * 4 * pi * cell.height * cell.breadth;
}

/* By the corners, more or less: what bulges over the horizon between them is small. */
static bool meets_horizon(const struct sphere_chart *c, const struct cell *cell)
{
    bool above = false, below = false;
    for (int i = 0; i < 4; i++) {
        const struct sphere_place p = {cell->row + (i & 1 ? cell->height : 0),
                                       cell->turn + (i & 2 ? cell->breadth : 0)};
        const float z = sphere_chart_direction(c, p)[2];
        above |= z > 1e-6f;
        below |= z < -1e-6f;
    }
    return above && below;
}

static double refined(const struct sphere_chart *c, const struct sphere_integrand *f,
                      struct cell cell, double whole, int depth)
{
    struct cell part[4];
    double value[4], sum = 0;
    for (int i = 0; i < 4; i++) {
        part[i] = (struct cell){cell.row, cell.turn, cell.height / 2, cell.breadth / 2};
        part[i].row += i & 1 ? part[i].height : 0;
        part[i].turn += i & 2 ? part[i].breadth : 0;
        sum += value[i] = gauss(c, f, part[i]);
    }
    if (depth == f->max_depth)
        return sum;
    const bool settled = fabs(sum - whole) < 1e-8 + f->tolerance * sum;
    if (settled && depth >= f->min_depth && !(f->horizon && meets_horizon(c, &cell)))
        return sum;
    sum = 0;
    for (int i = 0; i < 4; i++)
        sum += refined(c, f, part[i], value[i], depth + 1);
    return sum;
}

double sphere_chart_integral(const struct sphere_chart *c, const struct sphere_integrand *f,
                             struct sphere_place begin, struct sphere_place end)
{
    const struct cell cell = {begin.row, begin.turn, end.row - begin.row, end.turn - begin.turn};
    const double whole = gauss(c, f, cell);
    return whole == 0 && f->trust_zero ? 0 : refined(c, f, cell, whole, 0);
}
