/* SPDX-License-Identifier: MIT */
#include "tests/catalog.h"

#include <stdlib.h>

static const struct stage_tree *tree_at(const struct stage *s, uint32_t i)
{
    return (const struct stage_tree *)stage_at(s, s->trees) + i;
}

static uint32_t lane_prim(const struct stage *s, uint64_t lane)
{
    const struct stage_block *blocks = stage_at(s, s->blocks);
    return blocks[lane / STAGE_LANES].prim[lane % STAGE_LANES];
}

static bool at_lane(const struct stage *s, uint64_t lane, uint32_t instance, struct stage_id *id)
{
    *id = (struct stage_id){
        lane_prim(s, lane), {STAGE_TRIANGLE, (uint32_t)lane & 0x1fffffff}, instance};
    if (id->prim == STAGE_NONE)
        return false;
    if (instance != STAGE_NONE)
        id->prim += stage_instance_at(s, instance)->prim_begin;
    return true;
}

static bool at_round(enum stage_kind kind, uint64_t index, uint32_t prim, struct stage_id *id)
{
    *id = (struct stage_id){prim, {(uint32_t)kind & 7, (uint32_t)index & 0x1fffffff}, STAGE_NONE};
    return true;
}

bool catalog_next(const struct stage *s, uint64_t *at, struct stage_id *id)
{
    for (;; ++*at) {
        uint64_t i = *at;
        const uint64_t lanes = (uint64_t)tree_at(s, 0)->block_end * STAGE_LANES;
        bool found = false, inside = i < lanes;
        if (inside)
            found = at_lane(s, i, STAGE_NONE, id);
        i -= inside ? 0 : lanes;
        if (!inside && (inside = i < s->spheres.count))
            found = at_round(STAGE_SPHERE, i,
                             ((const struct stage_sphere *)stage_at(s, s->spheres))[i].prim, id);
        i -= inside ? 0 : s->spheres.count;
        if (!inside && (inside = i < s->discs.count))
            found = at_round(STAGE_DISC, i,
                             ((const struct stage_disc *)stage_at(s, s->discs))[i].prim, id);
        i -= inside ? 0 : s->discs.count;
        if (!inside && (inside = i < s->cylinders.count))
            found =
                at_round(STAGE_CYLINDER, i,
                         ((const struct stage_cylinder *)stage_at(s, s->cylinders))[i].prim, id);
        i -= inside ? 0 : s->cylinders.count;
        for (uint32_t k = 0; !inside && k < s->instances.count; k++) {
            const struct stage_tree *t = tree_at(s, stage_instance_at(s, k)->tree);
            const uint64_t own = (uint64_t)(t->block_end - t->block_begin) * STAGE_LANES;
            if ((inside = i < own))
                found = at_lane(s, (uint64_t)t->block_begin * STAGE_LANES + i, k, id);
            i -= inside ? 0 : own;
        }
        if (!inside)
            return false;
        if (found) {
            ++*at;
            return true;
        }
    }
}

struct stage_id catalog_id(const struct stage *s, uint32_t prim)
{
    struct stage_id id;
    for (uint64_t at = 0; catalog_next(s, &at, &id);)
        if (id.prim == prim)
            return id;
    abort();
}

struct stage_triangle catalog_triangle(const struct stage *s, uint32_t prim)
{
    const struct stage_id id = catalog_id(s, prim);
    return stage_triangle_at(s, id.place.index, id.instance);
}
