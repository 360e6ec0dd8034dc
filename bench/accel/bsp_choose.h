/* bsp_choose.h - which plane to cut a cell of a BSP tree with.
 *
 * Planes come from the triangles ("autopartition"): a triangle's own, and the three through its
 * edges at right angles to it, without which a convex surface could not be cut at all (T. Ize, I.
 * Wald, S. Parker, "Ray Tracing with the BSP Tree", RT 2008). The best of a few random ones is
 * taken.
 *
 * Which one is good depends on how many rays meet either side. The cells are polyhedra of many
 * sides, whose surface is laborious; so sample lines are cut up along with the scene and counted
 * (J. Bittner, V. Havran, "RDH: Ray Distribution Heuristics for Construction of Spatial Data
 * Structures", SCCG 2009). Where no plane pays by itself, one that halves many triangles does later
 * on. SPDX-License-Identifier: MIT */
#ifndef BENCH_ACCEL_BSP_CHOOSE_H
#define BENCH_ACCEL_BSP_CHOOSE_H

#include "bench/accel/accel.h"
#include "tests/dice.h"

struct bsp_plane {
    float normal[3], offset; /* dot(normal, p) == offset; the normal is unit */
};

struct bsp_line { /* what is of a sample line in a cell */
    float end[2][3];
};

struct bsp_chooser {
    struct accel_mesh mesh;
    struct dice dice;
    double touching;        /* vertices so near are in the plane: normals are rounded to float */
    struct bsp_line *lines; /* of the cells from the root to the one at hand; owned */
    size_t line_count, line_room;
};

struct bsp_cell {
    const uint32_t *prims; /* borrowed */
    size_t count;
    size_t lines_begin, lines_end;
};

struct bsp_sides { /* what only touches the plane is behind */
    bool behind, before;
};

/* The root's lines are then [0, line_count). */
void bsp_chooser_init(struct bsp_chooser *, const struct bsp *);
void bsp_chooser_release(struct bsp_chooser *);

/* False: no plane is worth it. */
bool bsp_choose(struct bsp_chooser *, const struct bsp_cell *, struct bsp_plane *);

struct bsp_sides bsp_sides_of(const struct bsp_chooser *, uint32_t prim, const struct bsp_plane *);

/* Adds what is of the cell's lines on one side. */
void bsp_cut_lines(struct bsp_chooser *, const struct bsp_cell *, const struct bsp_plane *,
                   bool before);

#endif
