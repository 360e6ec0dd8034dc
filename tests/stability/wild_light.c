/* SPDX-License-Identifier: MIT */
#include "tests/stability/wild.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/image_files.h"

/* --- lights --- */

static void strength(struct wild_pen *p, const char *key, double least, double most)
{
    const double decades = p->extreme ? wild_range(p, -4, 4) : 0;
    const double s = fmin(1e18, p->gain * wild_range(p, least, most) * pow(10, decades));
    wild_say(p, ", \"%s\": [%.6g, %.6g, %.6g]", key, s, s * wild_range(p, .1, 1), s);
}

static void place(struct wild_pen *p)
{
    double at[3];
    for (int k = 0; k < 3; k++)
        at[k] = wild_range(p, -.9, .9);
    wild_say(p, ", \"position\": ");
    wild_point(p, at);
}

static void direction(struct wild_pen *p)
{
    wild_say(p, ", \"direction\": ");
    wild_direction(p);
}

/* Intensities go with the square of lengths. */
static void from_a_point(struct wild_pen *p, bool spot)
{
    const double gain = p->gain, outer = wild_range(p, 1, 180);
    wild_say(p, spot ? "\"spot\"" : "\"point\"");
    place(p);
    p->gain *= p->unit * p->unit;
    strength(p, "intensity", .05, .5);
    p->gain = gain;
    if (!spot)
        return;
    direction(p);
    wild_say(p, ", \"outer_deg\": %.9g, \"inner_deg\": %.9g", outer,
             outer * (wild_chance(p, .3) ? 1 : wild_range(p, 0, 1)));
}

/* The first two the naive tracer meets. */
static void light(struct wild_pen *p, uint32_t kind)
{
    wild_say(p, "{\"type\": ");
    switch (kind) {
    case 0:
        wild_say(p, "\"sky\"");
        strength(p, "radiance", .1, 1);
        break;
    case 1:
        p->traits |= wild_chance(p, .5) ? WILD_TINY : 0;
        wild_say(p, "\"sun\", \"diameter_deg\": %.6g", p->traits & WILD_TINY ? .53 : 40.);
        direction(p);
        strength(p, "irradiance", .1, 1);
        break;
    case 2:
        from_a_point(p, false);
        break;
    case 3:
        from_a_point(p, true);
        break;
    case 4:
        wild_say(p, "\"distant\"");
        direction(p);
        strength(p, "irradiance", .1, 1);
        break;
    default:
        wild_say(p,
                 "\"environment\", \"file\": \"map.exr\", \"transform\": [{\"rotate_deg\": "
                 "{\"axis\": [1, 2, 3], \"angle\": %.6g}}]",
                 wild_range(p, -180, 180));
        strength(p, "scale", .1, 1);
    }
    wild_say(p, "}");
}

void wild_lights(struct wild_pen *p)
{
    const uint32_t count = wild_below(p, 4), kinds = p->traits & WILD_PLAIN ? 2 : 5;
    wild_say(p, "\"lights\": [\n");
    light(p, p->indoors && kinds > 2 ? 2 : wild_below(p, kinds)); /* indoors: one that is there */
    for (uint32_t i = 1; i < count; i++) {
        wild_say(p, ",\n");
        light(p, wild_below(p, kinds));
    }
    if (wild_chance(p, .2)) {
        wild_say(p, ",\n");
        light(p, 5);
    }
    wild_say(p, "\n],\n");
}

/* --- files --- */

/* A ball of 2 rows x rows quadrangles, its poles without area on one side. */
static void ball(uint32_t rows, struct buf *out)
{
    const double pi = 3.14159265358979323846;
    const uint32_t columns = 2 * rows;
    char text[256];
    buf_append(out, text,
               (size_t)snprintf(text, sizeof text,
                                "ply\nformat ascii 1.0\nelement vertex %u\nproperty float x\n"
                                "property float y\nproperty float z\nelement face %u\n"
                                "property list uchar int vertex_indices\nend_header\n",
                                (rows + 1) * columns, rows * columns));
    for (uint32_t r = 0; r <= rows; r++)
        for (uint32_t c = 0; c < columns; c++) {
            const double t = pi * r / rows, f = 2 * pi * c / columns;
            const double s = r == 0 || r == rows ? 0 : sin(t);
            buf_append(out, text,
                       (size_t)snprintf(text, sizeof text, "%.9g %.9g %.9g\n", s * sin(f), cos(t),
                                        s * cos(f)));
        }
    for (uint32_t r = 0; r < rows; r++)
        for (uint32_t c = 0; c < columns; c++) {
            const uint32_t a = r * columns + c, b = r * columns + (c + 1) % columns;
            buf_append(out, text,
                       (size_t)snprintf(text, sizeof text, "4 %u %u %u %u\n", a, a + columns,
                                        b + columns, b));
        }
}

/* Noise; the map has a pixel that outshines all others. */
static void image(const char *name, struct buf *out)
{
    enum { W = 16, H = 9 };
    static const char *const names[] = {"R", "G", "B"};
    float pixels[H * W][3];
    struct dice d = dice_make(name[7]);
    for (int i = 0; i < H * W; i++)
        for (int k = 0; k < 3; k++)
            pixels[i][k] = (float)dice_unit(&d);
    if (!strcmp(name, "map.exr"))
        pixels[20][0] = pixels[20][1] = 100;
    const struct image_files_exr file = {.width_px = W,
                                         .height_px = H,
                                         .names = names,
                                         .channels = 3,
                                         .type = IMAGE_FILES_FLOAT,
                                         .packing = IMAGE_FILES_NONE,
                                         .pixels = pixels[0]};
    if (!image_files_exr(out, &file))
        abort();
}

void wild_file(const char *name, struct buf *out)
{
    uint32_t rows;
    if (sscanf(name, "ball%u.ply", &rows) == 1 || sscanf(name, "smooth%u.ply", &rows) == 1)
        ball(rows, out);
    else
        image(name, out);
}
