/* SPDX-License-Identifier: MIT */
#include "tests/cylinder_view.h"

#include <math.h>

struct frame { /* across the axis x, y, along it z; `at`: the first end as seen from the origin */
    double x[3], y[3], z[3], at[3];
    double height, foot; /* of the cylinder; of the origin over the first end */
    double distance;     /* of the origin from the axis, along x */
};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static struct frame frame_make(const vec3 ends[2])
{
    struct frame f;
    for (int k = 0; k < 3; k++) {
        f.at[k] = (double)ends[0][k];
        f.z[k] = (double)(ends[1][k] - ends[0][k]); /* in float, as the stage has it */
    }
    f.height = sqrt(dot(f.z, f.z));
    for (int k = 0; k < 3; k++)
        f.z[k] /= f.height;
    f.foot = -dot(f.at, f.z);
    for (int k = 0; k < 3; k++)
        f.x[k] = -f.at[k] - f.foot * f.z[k];
    f.distance = sqrt(dot(f.x, f.x));
    for (int k = 0; k < 3; k++)
        f.x[k] /= f.distance;
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        f.y[k] = f.z[i] * f.x[j] - f.z[j] * f.x[i];
    }
    return f;
}

struct cylinder_view cylinder_view_make(const vec3 ends[2], float radius, vec3 normal, int n)
{
    const struct frame f = frame_make(ends);
    const double r = (double)radius, half = acos(r / f.distance);
    const double up[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
    struct cylinder_view view = {0, 0};
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            const double angle = half * ((2 * i + 1.0) / n - 1), h = f.height * (j + 0.5) / n;
            const double c = cos(angle), s = sin(angle);
            double w[3]; /* from the origin to the point */
            for (int k = 0; k < 3; k++)
                w[k] = f.at[k] + h * f.z[k] + r * (c * f.x[k] + s * f.y[k]);
            /* Written out: with far ends, sums of w would have no digits left. */
            const double facing = f.distance * c - r, along = h - f.foot;
            const double dd =
                f.distance * f.distance + r * r - 2 * r * f.distance * c + along * along;
            const double part = facing / (dd * sqrt(dd));
            view.solid_angle += part;
            view.irradiance += part * fmax(dot(w, up), 0) / sqrt(dd);
        }
    const double area = r * 2 * half / n * f.height / n;
    view.solid_angle *= area;
    view.irradiance *= area;
    return view;
}
