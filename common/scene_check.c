/* SPDX-License-Identifier: MIT */
#include "common/scene_check.h"

#include <math.h>

/* Comparisons in this file are written to be false for a NaN. */

static bool in_range(double v)
{
    return v >= -SCENE_MAX_ABS && v <= SCENE_MAX_ABS;
}

static void column_of(const struct scene_xform *x, int j, double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = x->m[i][j];
}

bool scene_check_affine(const struct scene_xform *x, struct err *err)
{
    double volume = 1;
    for (int j = 0; j < 4; j++) {
        double column[3];
        column_of(x, j, column);
        for (int i = 0; i < 3; i++)
            if (!in_range(column[i]))
                return err_set(err, ERR_INPUT,
                               "expected a transform with elements in [-1e18, 1e18], got %g in "
                               "row %d, column %d",
                               column[i], i, j);
        if (j < 3)
            volume *= scene_length(column);
    }
    const double det = fabs(scene_xform_determinant(x));
    if (!(det > 1e-6 * volume))
        return err_set(err, ERR_INPUT,
                       "expected an invertible transform, got one that flattens space "
                       "(determinant %g)",
                       det);
    return true;
}

bool scene_check_similarity(const struct scene_xform *x, const char *what, struct err *err)
{
    double column[3][3];
    for (int j = 0; j < 3; j++)
        column_of(x, j, column[j]);
    const double size = scene_length(column[0]);
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++) {
            const double want = i == j ? size * size : 0;
            if (!(fabs(scene_dot(column[i], column[j]) - want) <= 1e-4 * size * size))
                return err_set(err, ERR_INPUT,
                               "expected rotations, translations and one scale for all axes for "
                               "%s, got axes of length %g, %g, %g%s",
                               what, size, scene_length(column[1]), scene_length(column[2]),
                               i == j ? "" : " that are not perpendicular");
        }
    return true;
}

bool scene_check_rigid(struct scene_xform *x, struct err *err)
{
    double right[3], up[3], back[3];
    column_of(x, 0, right);
    column_of(x, 1, up);
    column_of(x, 2, back);
    const double *const axes[3] = {right, up, back};
    static const char *const names[3] = {"right", "up", "back"};
    for (int i = 0; i < 3; i++) {
        if (!(fabs(scene_length(axes[i]) - 1) <= 1e-3))
            return err_set(err, ERR_INPUT,
                           "expected a rotation and a translation, got column %d (%s) of length %g",
                           i, names[i], scene_length(axes[i]));
        const int j = (i + 1) % 3;
        if (!(fabs(scene_dot(axes[i], axes[j])) <= 1e-3))
            return err_set(err, ERR_INPUT,
                           "expected a rotation and a translation, got columns %d and %d that are "
                           "not perpendicular (dot product %g)",
                           i, j, scene_dot(axes[i], axes[j]));
    }
    if (!(scene_xform_determinant(x) > 0))
        return err_set(err, ERR_INPUT,
                       "expected a rotation and a translation, got a mirror "
                       "(determinant -1)");
    /* Keep where it looks; make the others fit. The three are independent, as just seen. */
    const double position[3] = {x->m[0][3], x->m[1][3], x->m[2][3]};
    double to[3];
    for (int i = 0; i < 3; i++)
        to[i] = -back[i];
    const double origin[3] = {0};
    if (!scene_xform_look_at(x, origin, to, up))
        return err_set(err, ERR_INPUT, "expected a rotation and a translation");
    for (int i = 0; i < 3; i++)
        x->m[i][3] = position[i];
    return true;
}

bool scene_check_world(const struct scene_xform *x, const double p[3], struct err *err)
{
    double world[3];
    scene_xform_point(x, p, world);
    for (int i = 0; i < 3; i++)
        if (!in_range(world[i]))
            return err_set(err, ERR_INPUT,
                           "expected coordinates in [-1e18, 1e18] after the transform, got %g",
                           world[i]);
    return true;
}

bool scene_check_length(const struct scene_xform *x, const char *what, double length,
                        struct err *err)
{
    double column[3];
    column_of(x, 0, column);
    const double size = length * scene_length(column);
    if (!(size >= SCENE_MIN_LENGTH && size <= SCENE_MAX_ABS))
        return err_set(err, ERR_INPUT, "expected %s in [1e-18, 1e18] after the transform, got %g",
                       what, size);
    return true;
}

/* Newell's normal of the outline: its length is twice the area. I. E. Sutherland, R. F. Sproull,
 * R. A. Schumacker, "A characterization of ten hidden-surface algorithms", 1974. For four
 * points it is the cross product of the diagonals. */
bool scene_check_quad(double v[4][3], struct err *err)
{
    double edge[4][3], diagonal[2][3], normal[3];
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 4; i++)
            edge[i][k] = v[(i + 1) % 4][k] - v[i][k];
        for (int i = 0; i < 2; i++)
            diagonal[i][k] = v[i + 2][k] - v[i][k];
    }
    scene_cross(diagonal[0], diagonal[1], normal);
    const double size = scene_length(normal);
    const double across = fmax(scene_length(diagonal[0]), scene_length(diagonal[1]));
    for (int i = 0; i < 4; i++)
        if (!(scene_length(edge[i]) > 0))
            return err_set(err, ERR_INPUT,
                           "expected four different corners, corners %d and %d coincide", i,
                           (i + 1) % 4);
    if (!(size > 1e-9 * across * across))
        return err_set(err, ERR_INPUT,
                       "expected a quad with an area, got corners in a line or "
                       "crossing edges");
    const double height = fabs(scene_dot(edge[0], normal)) / size; /* between the diagonals */
    if (!(height <= 1e-3 * across))
        return err_set(err, ERR_INPUT,
                       "expected four corners in one plane, they are off by %g: use a mesh of two "
                       "triangles",
                       height);
    for (int i = 0; i < 4; i++) {
        const int next = (i + 1) % 4;
        double turn[3];
        scene_cross(edge[i], edge[next], turn);
        if (!(scene_dot(turn, normal) >
              1e-6 * size * scene_length(edge[i]) * scene_length(edge[next])))
            return err_set(err, ERR_INPUT,
                           "expected a convex quad with its corners in order, it does not turn "
                           "the same way at corner %d",
                           next);
    }
    return true;
}

bool scene_check_crop(const struct scene_film *f, struct err *err)
{
    if (f->crop_x_begin >= f->crop_x_end || f->crop_y_begin >= f->crop_y_end)
        return err_set(err, ERR_INPUT,
                       "expected [x_begin, y_begin, x_end, y_end] with begin < end, got "
                       "[%u, %u, %u, %u]",
                       f->crop_x_begin, f->crop_y_begin, f->crop_x_end, f->crop_y_end);
    if (f->crop_x_end > f->width_px || f->crop_y_end > f->height_px)
        return err_set(err, ERR_INPUT,
                       "expected a window inside the film of %u x %u, got [%u, %u, %u, %u]",
                       f->width_px, f->height_px, f->crop_x_begin, f->crop_y_begin, f->crop_x_end,
                       f->crop_y_end);
    return true;
}

bool scene_check_pixels(const struct scene_film *f, struct err *err)
{
    const uint64_t pixels =
        (uint64_t)(f->crop_x_end - f->crop_x_begin) * (f->crop_y_end - f->crop_y_begin);
    if (pixels > SCENE_MAX_PIXELS)
        return err_set(err, ERR_LIMIT, "expected at most %d pixels to render, got %llu",
                       SCENE_MAX_PIXELS, (unsigned long long)pixels);
    return true;
}
