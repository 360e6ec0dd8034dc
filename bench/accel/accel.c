/* SPDX-License-Identifier: MIT */
#include "bench/accel/accel.h"

const char *accel_name(enum accel_kind kind)
{
    static const char *const names[] = {"smalti",   "binary BVH", "k-d tree",
                                        "BSP tree", "octree",     "grid"};
    _Static_assert(countof(names) == ACCEL_KINDS, "a name for each kind");
    return names[kind];
}

bool accel_build(struct accel *a, enum accel_kind kind, struct accel_mesh mesh,
                 const struct accel_limits *limits, struct err *err)
{
    *a = (struct accel){.kind = kind};
    switch (kind) {
    case ACCEL_OURS:
        ours_build(&a->ours, mesh);
        return true;
    case ACCEL_GRID:
        return grid_build(&a->grid, mesh, limits, err);
    case ACCEL_KDTREE:
        return kdtree_build(&a->kdtree, mesh, limits, err);
    case ACCEL_OCTREE:
        return octree_build(&a->octree, mesh, limits, err);
    case ACCEL_BSP:
        return bsp_build(&a->bsp, mesh, limits, err);
    case ACCEL_BVH2:
        return bvh2_build(&a->bvh2, mesh, limits, err);
    }
    __builtin_unreachable();
}

bool accel_hit(const struct accel *a, const struct ray *ray, struct ray_hit *hit)
{
    switch (a->kind) {
    case ACCEL_OURS:
        return ours_hit(&a->ours, ray, hit);
    case ACCEL_GRID:
        return grid_hit(&a->grid, ray, hit);
    case ACCEL_KDTREE:
        return kdtree_hit(&a->kdtree, ray, hit);
    case ACCEL_OCTREE:
        return octree_hit(&a->octree, ray, hit);
    case ACCEL_BSP:
        return bsp_hit(&a->bsp, ray, hit);
    case ACCEL_BVH2:
        return bvh2_hit(&a->bvh2, ray, hit);
    }
    __builtin_unreachable();
}

static uint64_t mesh_bytes(struct accel_mesh mesh)
{
    return mesh.count * sizeof *mesh.v;
}

uint64_t accel_bytes(const struct accel *a)
{
    switch (a->kind) {
    case ACCEL_OURS:
        return ours_bytes(&a->ours);
    case ACCEL_GRID:
        return grid_bytes(&a->grid) + mesh_bytes(a->grid.mesh);
    case ACCEL_KDTREE:
        return kdtree_bytes(&a->kdtree) + mesh_bytes(a->kdtree.mesh);
    case ACCEL_OCTREE:
        return octree_bytes(&a->octree) + mesh_bytes(a->octree.mesh);
    case ACCEL_BSP:
        return bsp_bytes(&a->bsp) + mesh_bytes(a->bsp.mesh);
    case ACCEL_BVH2:
        return bvh2_bytes(&a->bvh2) + mesh_bytes(a->bvh2.mesh);
    }
    __builtin_unreachable();
}

void accel_release(struct accel *a)
{
    switch (a->kind) {
    case ACCEL_OURS:
        ours_release(&a->ours);
        break;
    case ACCEL_GRID:
        grid_release(&a->grid);
        break;
    case ACCEL_KDTREE:
        kdtree_release(&a->kdtree);
        break;
    case ACCEL_OCTREE:
        octree_release(&a->octree);
        break;
    case ACCEL_BSP:
        bsp_release(&a->bsp);
        break;
    case ACCEL_BVH2:
        bvh2_release(&a->bvh2);
        break;
    }
    *a = (struct accel){0};
}
