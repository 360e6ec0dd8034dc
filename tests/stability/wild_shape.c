/* SPDX-License-Identifier: MIT */
#include "tests/stability/wild.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/image_files.h"

enum { MOST_OBJECTS = 10 };

/* --- a shape's own keys --- */

static void begin(struct wild_pen *p, const char *kind, uint32_t material)
{
    wild_say(p, "%s{\"type\": \"%s\", \"material\": \"m%u\"", p->shapes++ ? ",\n" : "", kind,
             material);
}

/* Lamps have emission, and few others. */
static void end(struct wild_pen *p, double radiance)
{
    if (radiance > 0)
        wild_say(p, ", \"emission\": [%.6g, %.6g, %.6g]", p->gain * radiance,
                 p->gain * radiance * wild_range(p, .1, 1), p->gain * radiance);
    wild_say(p, "}");
}

static void add(double to[3], const double a[3], const double b[3])
{
    for (int k = 0; k < 3; k++)
        to[k] = a[k] + b[k];
}

/* A parallelogram; its front is where a x b is. */
static void quad(struct wild_pen *p, uint32_t material, const double corner[3], const double a[3],
                 const double b[3], double radiance)
{
    double v[3];
    begin(p, "quad", material);
    wild_say(p, ", \"vertices\": [");
    wild_point(p, corner);
    add(v, corner, a);
    wild_say(p, ", ");
    wild_point(p, v);
    add(v, v, b);
    wild_say(p, ", ");
    wild_point(p, v);
    add(v, corner, b);
    wild_say(p, ", ");
    wild_point(p, v);
    wild_say(p, "]");
    end(p, radiance);
}

/* Six walls around the middle, fronts inside. */
static void room(struct wild_pen *p, double half)
{
    const double lo = -half, hi = half, s = 2 * half;
    const double walls[6][3][3] = {
        {{lo, lo, lo}, {s, 0, 0}, {0, s, 0}},  {{hi, lo, hi}, {-s, 0, 0}, {0, s, 0}},
        {{lo, lo, hi}, {0, 0, -s}, {0, s, 0}}, {{hi, lo, lo}, {0, 0, s}, {0, s, 0}},
        {{lo, lo, hi}, {s, 0, 0}, {0, 0, -s}}, {{lo, hi, lo}, {s, 0, 0}, {0, 0, s}}};
    for (int i = 0; i < 6; i++) {
        uint32_t m = wild_chance(p, .5) ? 0 : wild_below(p, p->materials);
        m = p->material[m].lets_through ? 0 : m;
        quad(p, m, walls[i][0], walls[i][1], walls[i][2], 0);
    }
}

/* --- meshes in the document --- */

static void triangles_begin(struct wild_pen *p, uint32_t material)
{
    begin(p, "mesh", material);
    wild_say(p, ", \"vertices\": [");
}

/* Triangles that share no vertices. */
static void triangles_end(struct wild_pen *p, uint32_t count, double radiance)
{
    wild_say(p, "], \"triangles\": [");
    for (uint32_t i = 0; i < count; i++)
        wild_say(p, "%s[%u, %u, %u]", i ? ", " : "", 3 * i, 3 * i + 1, 3 * i + 2);
    wild_say(p, "]");
    end(p, radiance);
}

/* Corners near `at`: ordinary, slivers, without area, one as the one before it. (No lamps: of two
 * that coincide a ray meets one, but both are aimed at.) */
static void soup(struct wild_pen *p, uint32_t material, const double at[3], double size,
                 double radiance)
{
    const uint32_t count = 1 + wild_below(p, 8);
    double v[3][3] = {{0}};
    triangles_begin(p, material);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t kind = wild_below(p, radiance > 0 ? 5 : 6);
        for (int c = 0; c < 3 && (kind != 5 || i == 0); c++)
            for (int k = 0; k < 3; k++)
                v[c][k] = at[k] + size * wild_range(p, -1, 1);
        const double thin = pow(10, wild_range(p, -7, -1));
        for (int k = 0; k < 3; k++) {
            if (kind == 3) /* a sliver */
                v[2][k] = .5 * (v[0][k] + v[1][k]) + thin * (v[2][k] - at[k]);
            if (kind == 4) /* a needle, or nothing */
                v[1][k] = v[0][k] + (i % 2 ? thin * (v[1][k] - at[k]) : 0);
        }
        for (int c = 0; c < 3; c++) {
            wild_say(p, i || c ? ", " : "");
            wild_point(p, v[c]);
        }
    }
    triangles_end(p, count, radiance);
}

/* Twelve triangles, a closed body; outside is the front. */
static void box(struct wild_pen *p, uint32_t material, const double at[3], double size)
{
    static const uint32_t faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                          {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                          {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    double half[3];
    for (int k = 0; k < 3; k++)
        half[k] = size * (wild_chance(p, .1) ? 1e-3 : wild_range(p, .3, 1));
    triangles_begin(p, material);
    for (uint32_t i = 0; i < 8; i++) {
        double v[3];
        for (int k = 0; k < 3; k++)
            v[k] = at[k] + (i >> k & 1 ? half[k] : -half[k]);
        wild_say(p, i ? ", " : "");
        wild_point(p, v);
    }
    wild_say(p, "], \"triangles\": [");
    for (int i = 0; i < 12; i++)
        wild_say(p, "%s[%u, %u, %u]", i ? ", " : "", faces[i][0], faces[i][1], faces[i][2]);
    wild_say(p, "]");
    end(p, 0);
}

/* A mesh in a file, about the origin and of size 1. Closed meshes may be mirrored; others may be
 * squeezed as well. */
static void from_file(struct wild_pen *p, uint32_t material, const char *file, const double at[3],
                      double size, bool even)
{
    double s[3], where[3];
    for (int k = 0; k < 3; k++) {
        s[k] = p->unit * size * (even ? 1 : wild_range(p, .2, 1));
        where[k] = p->unit * (at[k] + p->at[k]);
    }
    begin(p, "mesh", material);
    wild_say(p,
             ", \"file\": \"%s\", \"transform\": [{\"scale\": [%.9g, %.9g, %.9g]}, "
             "{\"rotate_deg\": {\"axis\": [1, 2, %.3g], \"angle\": %.6g}}, {\"translate\": [%.9g, "
             "%.9g, %.9g]}]",
             file, wild_chance(p, .2) ? -s[0] : s[0], s[1], s[2], wild_range(p, -1, 1),
             wild_range(p, -180, 180), where[0], where[1], where[2]);
    end(p, 0);
}

/* --- objects --- */

static void note_body(struct wild_pen *p, const double at[3], double radius)
{
    if (p->bodies == WILD_BODIES)
        abort();
    for (int k = 0; k < 3; k++)
        p->body[p->bodies][k] = at[k];
    p->body[p->bodies++][3] = radius;
}

static void sphere(struct wild_pen *p, uint32_t material, const double at[3], double radius,
                   double radiance)
{
    begin(p, "sphere", material);
    wild_say(p, ", \"center\": ");
    wild_point(p, at);
    wild_say(p, ", \"radius\": %.9g", p->unit * radius);
    end(p, radiance);
}

static void disc(struct wild_pen *p, uint32_t material, const double at[3], double radius,
                 double radiance)
{
    begin(p, "disc", material);
    wild_say(p, ", \"center\": ");
    wild_point(p, at);
    wild_say(p, ", \"normal\": ");
    wild_direction(p);
    wild_say(p, ", \"radius\": %.9g", p->unit * radius);
    end(p, radiance);
}

static void cylinder(struct wild_pen *p, uint32_t material, const double at[3], double size,
                     double radiance)
{
    double to[3];
    for (int k = 0; k < 3; k++)
        to[k] = at[k] + size * wild_range(p, .2, 1) * (wild_chance(p, .5) ? 1 : -1);
    begin(p, "cylinder", material);
    wild_say(p, ", \"from\": ");
    wild_point(p, at);
    wild_say(p, ", \"to\": ");
    wild_point(p, to);
    wild_say(p, ", \"radius\": %.9g",
             p->unit * size * (wild_chance(p, .2) ? 1e-3 : wild_range(p, .1, .6)));
    end(p, radiance);
}

/* What clear bodies are made of; meshes have twice their size for a radius that holds them. */
static void closed(struct wild_pen *p, uint32_t material, const double at[3], double size)
{
    static const char *const files[] = {"ball4.ply", "ball9.ply", "smooth5.ply", "smooth8.ply"};
    const uint32_t kind = wild_below(p, p->traits & WILD_PLAIN ? 2 : 6);
    if (p->material[material].clear)
        note_body(p, at, 2 * size);
    if (kind == 0)
        sphere(p, material, at, size, 0);
    else if (kind == 1)
        box(p, material, at, size);
    else
        from_file(p, material, files[kind - 2], at, size, wild_chance(p, .5));
}

static void open_one(struct wild_pen *p, uint32_t material, const double at[3], double size,
                     double radiance)
{
    const double a[3] = {size * wild_range(p, .2, 1), size * wild_range(p, -1, 1), 0};
    const double b[3] = {0, size * wild_range(p, -1, 1), size * wild_range(p, .2, 1)};
    p->traits |= radiance > 0 && size < .02 ? WILD_TINY : 0;
    const double steps = fabs(p->at[0]) + fabs(p->at[1]) + fabs(p->at[2]) + 1;
    switch (wild_below(p, size < 1e-3 * steps ? 4 : 5)) { /* else no quad would be flat in float */
    case 0:
        disc(p, material, at, size, radiance);
        break;
    case 1:
        cylinder(p, material, at, size, radiance);
        break;
    case 2:
        soup(p, material, at, size, radiance);
        break;
    case 3:
        sphere(p, material, at, size, radiance);
        break;
    default:
        quad(p, material, at, a, b, radiance);
    }
}

static void place(struct wild_pen *p, double at[3])
{
    for (int k = 0; k < 3; k++)
        at[k] = wild_range(p, -.6, .6);
}

static void object(struct wild_pen *p, double at[3], double size)
{
    const uint32_t m = wild_below(p, p->materials);
    const bool clear = p->material[m].clear;
    if (wild_chance(p, clear ? .9 : .4)) {
        closed(p, m, at, size);
        return;
    }
    p->traits |= clear ? WILD_OPEN : 0;
    const bool shines = !p->material[m].masked && !clear && wild_chance(p, .1);
    open_one(p, m, at, size, shines ? wild_range(p, .1, 2) : 0);
}

/* Of matte material, of a size that is found by chance, too; or of any. */
static void lamp(struct wild_pen *p)
{
    double at[3];
    const double size = p->extreme ? .3 * pow(10, wild_range(p, -6, 0)) : wild_range(p, .1, .4);
    place(p, at);
    open_one(p, 0, at, size, p->extreme ? pow(10, wild_range(p, -6, 6)) : wild_range(p, 1, 10));
}

/* So many small copies of one mesh that they become instances (prep.h). */
static void swarm(struct wild_pen *p)
{
    const uint32_t m = wild_below(p, p->materials);
    if (p->material[m].clear)
        p->traits |= WILD_OPEN;
    for (int i = 0; i < 300; i++) {
        double at[3];
        place(p, at);
        from_file(p, m, wild_chance(p, .999) ? "ball32.ply" : "smooth5.ply", at, .05, false);
    }
}

void wild_shapes(struct wild_pen *p)
{
    const uint32_t objects = 1 + wild_below(p, MOST_OBJECTS);
    uint32_t lamps = wild_below(p, 4);
    double at[3] = {0, 0, 0};
    wild_say(p, "\"shapes\": [\n");
    p->indoors = wild_chance(p, .4);
    if (p->indoors)
        room(p, 1);
    else if (wild_chance(p, .7))
        quad(p, 0, (const double[3]){-3, -.7, 3}, (const double[3]){6, 0, 0},
             (const double[3]){0, 0, -6}, 0);
    for (uint32_t i = 0; i < objects; i++) {
        if (!wild_chance(p, .1)) /* else it is where the last one is */
            place(p, at);
        object(p, at,
               wild_chance(p, .1) ? .3 * pow(10, wild_range(p, -5, 0)) : wild_range(p, .1, .35));
    }
    lamps += p->indoors; /* no other light need come in */
    for (uint32_t i = 0; i < lamps; i++)
        lamp(p);
    if (!(p->traits & WILD_PLAIN) && wild_chance(p, .03))
        swarm(p);
    wild_say(p, "\n],\n");
}
