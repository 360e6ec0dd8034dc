/* SPDX-License-Identifier: MIT */
#include "common/trace/stage.h"

#include <string.h>

#include "common/trace/bvh.h"

/* Each span of struct stage in its order: they are its last members. */
struct row {
    const char *name;
    size_t at;   /* in struct stage */
    size_t size; /* of an element */
};

#define ROW(member, type)                                                                          \
    {                                                                                              \
#member, offsetof(struct stage, member), sizeof(type)                                      \
    }

static const struct row rows[] = {
    ROW(shapes, struct stage_shape),
    ROW(trees, struct stage_tree),
    ROW(nodes, struct bvh_node),
    ROW(blocks, struct stage_block),
    ROW(instances, struct stage_instance),
    ROW(spheres, struct stage_sphere),
    ROW(discs, struct stage_disc),
    ROW(cylinders, struct stage_cylinder),
    ROW(materials, struct material),
    ROW(emitters, struct emitter),
    ROW(pick_cdf, float),
    ROW(knots, struct stage_knot),
    ROW(lamps, struct stage_lamps),
    ROW(guide, uint32_t),
    ROW(details, struct stage_detail),
    ROW(corners, struct stage_corners),
    ROW(normals, struct stage_normal),
    ROW(uvs, struct stage_uv),
    ROW(colors, struct stage_color),
    ROW(slots, struct material_slot),
    ROW(reliefs, struct material_relief),
    ROW(textures, struct stage_texture),
    ROW(pyramids, struct stage_pyramid),
    ROW(bytes8, struct stage_bytes),
    ROW(texels, unsigned char),
    ROW(spots, struct stage_spot),
    ROW(light_nodes, struct stage_light_node),
    ROW(light_parents, uint32_t),
    ROW(maps, struct stage_map),
    ROW(map_rows, struct stage_map_row),
    ROW(map_pixels, struct stage_map_pixel),
    ROW(map_columns, uint32_t),
};

_Static_assert((sizeof(struct stage) - offsetof(struct stage, shapes)) /
                       sizeof(struct stage_span) ==
                   countof(rows),
               "each span has its row");

static bool check_head(const struct stage *s, size_t bytes, struct err *err)
{
    if (bytes < sizeof *s)
        return err_set(err, ERR_INPUT, "%zu bytes, the head alone has %zu", bytes, sizeof *s);
    if (memcmp(s->magic, STAGE_MAGIC, sizeof s->magic) != 0)
        return err_set(err, ERR_INPUT, "no prepared scene");
    if (s->version != STAGE_VERSION || s->struct_bytes != sizeof *s)
        return err_set(err, ERR_INPUT, "version %u with a head of %u bytes, this build has %u, %zu",
                       s->version, s->struct_bytes, (unsigned)STAGE_VERSION, sizeof *s);
    if (s->bytes != bytes)
        return err_set(err, ERR_INPUT, "%zu bytes, the head says %llu", bytes,
                       (unsigned long long)s->bytes);
    return true;
}

bool stage_check(const void *block, size_t bytes, struct err *err)
{
    const struct stage *s = block;
    if (!check_head(s, bytes, err))
        return false;
    for (size_t i = 0; i < countof(rows); i++) {
        struct stage_span span;
        memcpy(&span, (const unsigned char *)block + rows[i].at, sizeof span);
        if (span.offset % STAGE_ALIGN != 0 || span.offset > bytes ||
            span.count > (bytes - span.offset) / rows[i].size)
            return err_set(err, ERR_INPUT, "%s: %llu of %zu bytes at %llu, the block has %zu",
                           rows[i].name, (unsigned long long)span.count, rows[i].size,
                           (unsigned long long)span.offset, bytes);
    }
    return true;
}
