/* accel.h - the textbooks' structures for finding what a ray hits first, beside smalti's own.
 *
 * Good for: seeing why the core has the structure it has (docs/accel.md, `make bench-accel`). Not
 * used by any program. Each structure is one file, plain on purpose: what its paper says, one
 * thread, no vector instructions, no tricks of later years.
 *
 * The hit is the same for all, to the last bit: the smallest t of the core's triangle test (tri.h),
 * and among equal t the smallest triangle number. tests/test_accel.c holds every structure against
 * a loop over all triangles.
 *
 * Coordinates must be finite, and a ray's origin no farther from 0 than ACCEL_REACH times the
 * mesh's largest coordinate (grid.c needs to know beforehand how large rounding errors get).
 * Building takes no more memory and CPU time than it is given and then fails with ERR_LIMIT: some
 * of these structures explode on some scenes, which is part of what they teach.
 * SPDX-License-Identifier: MIT */
#ifndef BENCH_ACCEL_ACCEL_H
#define BENCH_ACCEL_ACCEL_H

#include "common/err.h"
#include "common/trace/ray.h"
#include "common/trace/stage.h"

struct accel_mesh {
    const float (*v)[3][3]; /* borrowed: outlives the structure */
    uint32_t count;
};

struct accel_limits {
    uint64_t bytes;   /* of the structure, and of what it needs on the way */
    int64_t until_us; /* as clock_thread_cpu_us tells the time */
};

struct accel_box {
    float lo[3], hi[3];
};

enum { ACCEL_REACH = 4 };

/* A list of numbers, mostly of triangles, that grows. */
struct accel_list {
    uint32_t *at;
    size_t count, room;
};

/* --- grid.c: equal cells, each with the triangles that touch it --- */

struct grid {
    struct accel_mesh mesh;
    struct accel_box bounds;
    float side[3];    /* of a cell */
    int32_t cells[3]; /* along each axis */
    uint32_t *starts; /* of a cell's triangles in refs; one more than cells, x fastest */
    uint32_t *refs;
};

bool grid_build(struct grid *, struct accel_mesh, const struct accel_limits *,
                struct err *) MUST_CHECK;
bool grid_hit(const struct grid *, const struct ray *, struct ray_hit *);
uint64_t grid_bytes(const struct grid *); /* without the mesh */
void grid_release(struct grid *);

/* --- kdtree.c: a plane across one axis at a time, chosen by the surface area heuristic --- */

struct kdtree_node { /* 8 bytes; children are neighbours: below the plane, above it */
    union {
        float split;
        uint32_t count; /* leaf: triangles */
    };
    uint32_t axis : 2;   /* 3: leaf */
    uint32_t first : 30; /* child below; leaf: into refs */
};

struct kdtree {
    struct accel_mesh mesh;
    struct accel_box bounds;
    struct kdtree_node *nodes;
    size_t node_count, node_room;
    struct accel_list refs;
};

bool kdtree_build(struct kdtree *, struct accel_mesh, const struct accel_limits *,
                  struct err *) MUST_CHECK;
bool kdtree_hit(const struct kdtree *, const struct ray *, struct ray_hit *);
uint64_t kdtree_bytes(const struct kdtree *);
void kdtree_release(struct kdtree *);

/* --- octree.c: a cube, cut in eight as long as it pays --- */

struct octree_node { /* 8 bytes */
    uint32_t first; /* of eight children, bit k set: the upper half along axis k; leaf: into refs */
    uint32_t count; /* UINT32_MAX: inner, or triangles of a leaf */
};

struct octree {
    struct accel_mesh mesh;
    struct accel_box bounds;
    float lo[3], side; /* of the cube */
    struct octree_node *nodes;
    size_t node_count, node_room;
    struct accel_list refs;
};

bool octree_build(struct octree *, struct accel_mesh, const struct accel_limits *,
                  struct err *) MUST_CHECK;
bool octree_hit(const struct octree *, const struct ray *, struct ray_hit *);
uint64_t octree_bytes(const struct octree *);
void octree_release(struct octree *);

/* --- bsp.c: planes of any direction, taken from the triangles themselves --- */

struct bsp_node {            /* 24 bytes; children are neighbours: behind the plane, in front */
    float normal[3], offset; /* dot(normal, p) == offset; the normal is unit */
    uint32_t first;          /* child behind; leaf: into refs */
    uint32_t count;          /* UINT32_MAX: inner, or triangles of a leaf */
};

struct bsp {
    struct accel_mesh mesh;
    struct accel_box bounds;
    struct bsp_node *nodes;
    size_t node_count, node_room;
    struct accel_list refs;
};

bool bsp_build(struct bsp *, struct accel_mesh, const struct accel_limits *,
               struct err *) MUST_CHECK;
bool bsp_hit(const struct bsp *, const struct ray *, struct ray_hit *);
uint64_t bsp_bytes(const struct bsp *);
void bsp_release(struct bsp *);

/* --- bvh2.c: boxes in boxes, two by two --- */

struct bvh2_node { /* 32 bytes; children are neighbours: first, first + 1 */
    float lo[3];
    uint32_t first; /* child; leaf: into refs */
    float hi[3];
    uint32_t count; /* 0: inner; else triangles of the leaf */
};

struct bvh2 {
    struct accel_mesh mesh;
    struct accel_box bounds;
    struct bvh2_node *nodes;
    size_t node_count;
    uint32_t *refs;
};

bool bvh2_build(struct bvh2 *, struct accel_mesh, const struct accel_limits *,
                struct err *) MUST_CHECK;
bool bvh2_hit(const struct bvh2 *, const struct ray *, struct ray_hit *);
uint64_t bvh2_bytes(const struct bvh2 *);
void bvh2_release(struct bvh2 *);

/* --- ours.c: smalti's, as the programs use it (common/trace) --- */

struct scenes;

struct ours {
    struct scenes *scenes; /* owned; the stage is in it */
    const struct stage *stage;
};

/* No triangle may be degenerate: prep.c would drop it and number the others anew. */
void ours_build(struct ours *, struct accel_mesh);
bool ours_hit(const struct ours *, const struct ray *, struct ray_hit *);
uint64_t ours_bytes(const struct ours *); /* of the whole stage, shading data and all */
void ours_release(struct ours *);

/* --- any of them --- */

enum accel_kind { ACCEL_OURS, ACCEL_BVH2, ACCEL_KDTREE, ACCEL_BSP, ACCEL_OCTREE, ACCEL_GRID };

enum { ACCEL_KINDS = ACCEL_GRID + 1 };

struct accel {
    enum accel_kind kind;
    union {
        struct grid grid;
        struct kdtree kdtree;
        struct octree octree;
        struct bsp bsp;
        struct bvh2 bvh2;
        struct ours ours;
    };
};

const char *accel_name(enum accel_kind);

/* False: ERR_LIMIT, and there is nothing to release. */
bool accel_build(struct accel *, enum accel_kind, struct accel_mesh, const struct accel_limits *,
                 struct err *) MUST_CHECK;
bool accel_hit(const struct accel *, const struct ray *, struct ray_hit *);
uint64_t accel_bytes(const struct accel *); /* of all that rays look at: the mesh, too */
void accel_release(struct accel *);

#endif
