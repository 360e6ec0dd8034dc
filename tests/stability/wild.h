/* wild.h - scenes that nobody would write: a document as a pure function of a seed.
 *
 * Units from 1e-6 to 1e6, scenes moved away from the origin, intensities over 24 decades, slivers,
 * triangles without area, surfaces that coincide; every kind of shape, light, camera, filter,
 * material and texture that documents know, parameters at the ends of their ranges. The document
 * goes through the reader like any other; the files that it names are made here as well (wild_load;
 * tool_wild writes them).
 *
 * A quarter of the seeds are `plain`: what tests/naive_path.h knows, and nothing else.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_STABILITY_WILD_H
#define TESTS_STABILITY_WILD_H

#include "common/buf.h"
#include "common/scene.h"
#include "tests/dice.h"

enum {
    WILD_PLAIN = 1,  /* within what the naive tracer claims */
    WILD_OPEN = 2,   /* light may enter a clear body by another way than it leaves: what is
                      * refracted need not come out as bright as it went in */
    WILD_SIGNED = 4, /* the filter has a negative part */
    WILD_TINY = 8,   /* there are lamps that nothing meets by chance */
};

struct wild {
    struct arena arena; /* of all below */
    uint64_t seed;
    const char *json; /* ends with a 0 */
    struct scene scene;
    uint32_t traits;
    double unit; /* m, of what is about 1 in the scene */
    double gain; /* of its light */
};

/* False: the reader refused it, *why then says what (in the arena). */
bool wild_make(struct wild *, uint64_t seed, const char **why);
/* A document from a file, of which the caller knows the traits. */
bool wild_read(struct wild *, const char *path, uint32_t traits, const char **why);
void wild_release(struct wild *);

/* A file that a document names, as it is on disk; of ".ply" and ".exr" files. */
void wild_file(const char *name, struct buf *);

/* --- of wild*.c alone --- */

enum { WILD_MATERIALS = 12, WILD_BODIES = 32 };

struct wild_pen {
    struct dice d;
    struct buf out;
    uint32_t traits;
    double unit, at[3]; /* where what is written at 0, 0, 0 stands, in units */
    double gain;        /* of all emission */
    bool extreme;       /* lights differ by decades */
    bool textured, indoors;
    uint32_t materials; /* written so far: m0, m1, ... */
    struct wild_material {
        bool clear, masked, lets_through; /* clear: refracts */
    } material[WILD_MATERIALS];
    double body[WILD_BODIES][4]; /* balls that hold all clear bodies: centre, radius */
    uint32_t bodies, shapes;
};

void wild_say(struct wild_pen *, const char *fmt, ...) PRINTF(2, 3);
bool wild_chance(struct wild_pen *, double p);
uint32_t wild_below(struct wild_pen *, uint32_t n);
double wild_range(struct wild_pen *, double from, double to);
void wild_point(struct wild_pen *, const double p[3]); /* of the scene, as the document has it */
void wild_direction(struct wild_pen *);                /* any */

void wild_textures(struct wild_pen *);
void wild_materials(struct wild_pen *);
void wild_shapes(struct wild_pen *);
void wild_lights(struct wild_pen *);

#endif
