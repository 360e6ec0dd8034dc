/* meshes.h - the scenes of the benchmarks, made by program: from 36 triangles to 5 million.
 *
 *   bunny     the Stanford bunny on a ground; without its file, a bumpy ball of as many triangles
 *   interior  a Cornell box with three bumpy balls: most triangles small, the walls large
 *   terrain   a height field: everything alike, rays that graze
 *   sphere    one bumpy ball of 5 million triangles on a ground
 *   soup      a million small triangles at random places: no surface, much overlap
 *   cornell   a Cornell box with its lamp and two blocks: next to nothing
 *
 * Each is a whole scene, meshes and quads only, with camera, diffuse materials and a light (a sky;
 * in cornell the lamp), so that it can be rendered, too. The same arguments give the same triangles
 * on one machine (libm's sine is used).
 * SPDX-License-Identifier: MIT */
#ifndef BENCH_MESHES_H
#define BENCH_MESHES_H

#include "tests/scenes.h"

enum meshes_kind {
    MESHES_BUNNY,
    MESHES_INTERIOR,
    MESHES_TERRAIN,
    MESHES_SPHERE,
    MESHES_SOUP,
    MESHES_CORNELL,
    MESHES_KINDS
};

struct meshes {
    struct scenes scenes; /* owns everything; .scene is the scene, 768 x 768 pixels */
    const char *what;     /* for reports; says so when the bunny is not the bunny */
    uint32_t triangles;
    /* Where shadow rays are aimed: the parallelogram corner, a, b of scenes_quad. Part of the
     * geometry in cornell only; elsewhere scenes_quad and an emission would make it a lamp. */
    vec3 lamp[3];
};

const char *meshes_name(enum meshes_kind);

/* triangles: about how many, for charts over sizes; 0: as above. bunny and cornell are what they
 * are. assets: the directory to look for stanford-bunny.obj in. False: that file is there and bad.
 */
bool meshes_init(struct meshes *, enum meshes_kind, uint32_t triangles, const char *assets,
                 struct err *) MUST_CHECK;
void meshes_release(struct meshes *);

/* --- the parts --- */

struct meshes_ball {
    vec3 center;
    float radius, bump;      /* bump: depth of the noise, in parts of the radius */
    uint32_t rings, columns; /* 2 columns (rings - 1) triangles, closed, none degenerate */
};

struct shape *meshes_add_ball(struct scenes *, uint32_t material, const struct meshes_ball *);
/* side x side metres about the origin, 2 n^2 triangles. */
struct shape *meshes_add_terrain(struct scenes *, uint32_t material, uint32_t n, float side);
/* Triangles of about `size` in the cube [-1, 1]^3. */
struct shape *meshes_add_soup(struct scenes *, uint32_t material, uint32_t triangles, float size);
/* An OBJ or PLY file. NULL: unreadable. */
struct shape *meshes_add_file(struct scenes *, uint32_t material, const char *path, struct err *);
/* The bunny or what stands in for it; `what` says which. NULL: its file is there and bad. */
struct shape *meshes_add_bunny(struct scenes *, uint32_t material, const char *assets,
                               const char **what, struct err *);

#endif
