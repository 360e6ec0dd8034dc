/* SPDX-License-Identifier: MIT */
#include "common/trace/prep.h"

#include <assert.h>
#include <string.h>

#include "common/trace/bvh_cost.h"
#include "common/trace/light8.h"
#include "common/trace/medium.h"
#include "common/trace/prep_plan.h"
#include "common/trace/work.h"

/* A panorama looks everywhere: its depth is the distance. */
static void set_view(struct stage_view *view, const struct scene_camera *c)
{
    vec3_store(view->position, xform_point(&c->to_world, vec3_make(0, 0, 0)));
    if (c->kind != CAMERA_PANORAMIC)
        vec3_store(view->direction, vec3_unit(xform_vector(&c->to_world, vec3_make(0, 0, -1))));
}

/* --- materials --- */

/* What only some materials need, and costs every path of a scene that has them. */
static void survey_materials(struct prep_plan *p)
{
    for (uint32_t i = 0; i < p->scene->material_count; i++) {
        const enum material_kind kind = p->scene->materials[i].kind;
        if (kind == MATERIAL_MIX || kind == MATERIAL_MASK || kind == MATERIAL_TWO_SIDED)
            p->head.wrapped = 1;
        if (kind == MATERIAL_MASK)
            p->head.masked = 1;
    }
}

/* --- the block --- */

enum { GUIDE_MOST = 1024 }; /* entries but for two: it is to stay in the nearest cache */

struct piece {
    struct stage_span *span; /* in the head; its count is set */
    const void *data;        /* NULL: written later */
    size_t size;             /* of an element */
};

static void count_pieces(struct prep_plan *p)
{
    struct stage *head = &p->head;
    head->shapes.count = (uint64_t)p->scene->shape_count + 1;
    head->pick_cdf.count = head->emitters.count + 1;
    while (head->prim_count >> head->guide_shift >= GUIDE_MOST)
        head->guide_shift++;
    head->guide.count = (head->prim_count >> head->guide_shift) + 2;
    head->materials.count = p->scene->material_count;
    head->reliefs.count = p->scene->relief_count;
    head->trees.count = p->tree_count;
    for (uint32_t i = 0; i < p->tree_count; i++) {
        const struct bvh_plan *plan = &p->trees[i].plan;
        head->nodes.count += plan->node_count;
        head->blocks.count += plan->leaf_count;
        head->bvh_depth = max_u32(head->bvh_depth, plan->depth);
    }
}

static unsigned char *lay_out(struct prep_plan *p, struct arena *arena)
{
    struct stage *head = &p->head;
    count_pieces(p);
    const struct piece pieces[] = {
        {&head->shapes, p->shapes, sizeof *p->shapes},
        {&head->trees, NULL, sizeof(struct stage_tree)},
        {&head->nodes, NULL, sizeof(struct bvh_node)},
        {&head->blocks, NULL, sizeof(struct stage_block)},
        {&head->instances, p->instances, sizeof *p->instances},
        {&head->spheres, p->spheres, sizeof *p->spheres},
        {&head->discs, p->discs, sizeof *p->discs},
        {&head->cylinders, p->cylinders, sizeof *p->cylinders},
        {&head->materials, p->scene->materials, sizeof *p->scene->materials},
        {&head->emitters, p->emitters, sizeof *p->emitters},
        {&head->pick_cdf, p->pick_cdf, sizeof *p->pick_cdf},
        {&head->knots, p->knots, sizeof *p->knots},
        {&head->lamps, NULL, sizeof(struct stage_lamps)},
        {&head->guide, NULL, sizeof(uint32_t)},
        {&head->details, p->details, sizeof *p->details},
        {&head->corners, NULL, sizeof(struct stage_corners)},
        {&head->normals, NULL, sizeof(struct stage_normal)},
        {&head->uvs, NULL, sizeof(struct stage_uv)},
        {&head->colors, NULL, sizeof(struct stage_color)},
        {&head->slots, p->scene->slots, sizeof *p->scene->slots},
        {&head->reliefs, p->scene->reliefs, sizeof *p->scene->reliefs},
        {&head->textures, p->textures, sizeof *p->textures},
        {&head->pyramids, p->pyramids, sizeof *p->pyramids},
        {&head->bytes8, NULL, sizeof(struct stage_bytes)},
        {&head->texels, NULL, 1},
        {&head->spots, p->spots, sizeof *p->spots},
        {&head->light_nodes, p->light_nodes, sizeof *p->light_nodes},
        {&head->light_parents, p->light_parents, sizeof *p->light_parents},
        {&head->maps, p->maps, sizeof *p->maps},
        {&head->map_rows, p->map_rows, sizeof *p->map_rows},
        {&head->map_pixels, p->map_pixels, sizeof *p->map_pixels},
        {&head->map_columns, p->map_columns, sizeof *p->map_columns},
    };
    uint64_t bytes = (sizeof *head + STAGE_ALIGN - 1) / STAGE_ALIGN * STAGE_ALIGN;
    for (size_t i = 0; i < countof(pieces); i++) {
        pieces[i].span->offset = bytes;
        bytes +=
            (pieces[i].span->count * pieces[i].size + STAGE_ALIGN - 1) / STAGE_ALIGN * STAGE_ALIGN;
    }
    head->bytes = bytes;
    unsigned char *block = arena_alloc(arena, bytes, 1, STAGE_ALIGN);
    memcpy(block, head, sizeof *head);
    for (size_t i = 0; i < countof(pieces); i++)
        if (pieces[i].span->count && pieces[i].data)
            memcpy(block + pieces[i].span->offset, pieces[i].data,
                   pieces[i].span->count * pieces[i].size);
    struct material *materials = (struct material *)(void *)(block + head->materials.offset);
    for (uint64_t i = 0; i < head->materials.count; i++)
        materials[i].name = NULL; /* a pointer means nothing elsewhere */
    return block;
}

/* --- trees --- */

/* Where the lights among the world's triangles have come to lie: their index was their number among
 * the triangles so far. */
static void place_emitters(const struct prep_plan *p, struct emitter *emitters,
                           struct arena *scratch)
{
    const struct prep_tree *world = &p->trees[0];
    if (!p->head.emitters.count || !world->triangle_count)
        return;
    uint32_t *lane_of = arena_new(scratch, uint32_t, world->triangle_count);
    for (uint32_t i = 0; i < world->plan.part_count; i++) {
        const struct bvh_part *part = &world->plan.parts[i];
        for (uint32_t n = 0; n < part->leaf_count; n++)
            for (uint32_t lane = 0; lane < STAGE_LANES; lane++) {
                const uint32_t triangle = bvh_part_leaf(part, n)->triangle[lane];
                if (triangle != STAGE_NONE)
                    lane_of[triangle] = STAGE_LANES * (part->leaf_begin + n) + lane;
            }
    }
    for (uint64_t i = 0; i < p->head.emitters.count; i++)
        if (emitters[i].kind == EMITTER_PRIM && emitters[i].place.kind == STAGE_TRIANGLE)
            emitters[i].place.index = lane_of[emitters[i].place.index] & 0x1fffffff;
}

/* Of the shapes, whose last but one ends the list: where stage_shape_of is to look. */
static void write_guide(const struct stage *s, uint32_t *guide)
{
    const struct stage_shape *shapes = stage_at(s, s->shapes);
    const uint32_t last = s->shapes.count > 1 ? (uint32_t)s->shapes.count - 2 : 0;
    uint32_t shape = 0;
    for (uint64_t i = 0; i < s->guide.count; i++) {
        const uint64_t prim = i << s->guide_shift;
        while (shape < last && shapes[shape + 1].prim_begin <= prim)
            shape++;
        guide[i] = shape;
    }
}

static void write_trees(const struct prep_plan *p, unsigned char *block, const struct crew *crew)
{
    const struct stage *head = &p->head;
    struct bvh_node *nodes = (struct bvh_node *)(void *)(block + head->nodes.offset);
    struct stage_block *blocks = (struct stage_block *)(void *)(block + head->blocks.offset);
    struct stage_tree *trees = (struct stage_tree *)(void *)(block + head->trees.offset);
    uint32_t node_begin = 0, block_begin = 0;
    for (uint32_t i = 0; i < p->tree_count; i++) {
        const struct bvh_plan *plan = &p->trees[i].plan;
        const struct bvh_site site = {
            .nodes = nodes + node_begin,
            .node_line = BVH_NODE_LINES * node_begin,
            .block_line =
                BVH_NODE_LINES * (uint32_t)head->nodes.count + BVH_BLOCK_LINES * block_begin,
        };
        trees[i].root = bvh_plan_write(plan, &site, crew);
        trees[i].block_begin = block_begin;
        trees[i].block_end = block_begin + plan->leaf_count;
        bvh_plan_fill(plan, p->trees[i].triangles, p->trees[i].prims, blocks + block_begin, crew);
        node_begin += plan->node_count;
        block_begin += plan->leaf_count;
    }
    for (uint32_t i = p->tree_count; i-- > 0;) /* the world's is made of the others */
        trees[i].cost = bvh_cost((const struct stage *)(const void *)block, i);
}

/* Of a stage that is whole but for this. */
static void surround_camera(struct stage *s)
{
    if (s->media)
        s->around = medium_around(s, vec3_load(s->view.position));
}

/* References to nodes and blocks have 28 bits. */
static bool check_lines(const struct prep_plan *p, struct err *err)
{
    uint64_t lines = 0;
    for (uint32_t i = 0; i < p->tree_count; i++)
        lines += (uint64_t)BVH_NODE_LINES * p->trees[i].plan.node_count +
                 (uint64_t)BVH_BLOCK_LINES * p->trees[i].plan.leaf_count;
    return lines <= BVH_MOST_LINES ||
           err_set(err, ERR_LIMIT, "the hierarchy takes %llu MB, at most %llu are allowed",
                   (unsigned long long)(lines * BVH_LINE >> 20),
                   (unsigned long long)BVH_MOST_LINES * BVH_LINE >> 20);
}

/* Direct light is one scattering; Whitted's surfaces look for lights and for nothing else. */
static void settle_method(struct scene_settings *s)
{
    if (s->integrator == INTEGRATOR_AUTO)
        s->integrator = INTEGRATOR_PATH;
    if (s->integrator == INTEGRATOR_DIRECT)
        s->max_bounces = min_u32(s->max_bounces, 1);
    if (s->integrator == INTEGRATOR_WHITTED)
        s->strategy = STRATEGY_LIGHT;
}

bool prep_stage(const struct scene *scene, const struct crew *crew, struct arena *arena,
                struct arena *scratch, const struct stage **stage, struct err *err)
{
    struct prep_plan p;
    if (!prep_plan_make(&p, scene, scratch, err))
        return false;
    memcpy(p.head.magic, STAGE_MAGIC, sizeof p.head.magic);
    p.head.version = STAGE_VERSION;
    p.head.struct_bytes = sizeof p.head;
    p.head.film = scene->film;
    p.head.settings = scene->settings;
    settle_method(&p.head.settings);
    p.head.media = medium_uses(scene);
    prep_shapes(&p, crew);
    prep_lights(&p, scratch);
    survey_materials(&p);
    prep_camera(&p.head.camera, scene);
    prep_filter(&p, scratch);
    set_view(&p.head.view, &scene->camera);
    const bool fits = prep_detail_plan(&p, scratch, err) && prep_texture_plan(&p, scratch, err) &&
                      check_lines(&p, err);
    if (fits) {
        unsigned char *block = lay_out(&p, arena);
        write_guide((const struct stage *)(const void *)block,
                    (uint32_t *)(void *)(block + p.head.guide.offset));
        write_trees(&p, block, crew);
        prep_detail_write(&p, block);
        prep_texture_write(&p, block);
        place_emitters(&p, (struct emitter *)(void *)(block + p.head.emitters.offset), scratch);
        if (p.head.lamps.count)
            light8_lamps((const struct stage *)(const void *)block,
                         (struct stage_lamps *)(void *)(block + p.head.lamps.offset));
        surround_camera((struct stage *)(void *)block);
        ((struct stage *)(void *)block)->prices =
            work_prices((const struct stage *)(const void *)block);
        *stage = (const struct stage *)(const void *)block;
    }
    for (uint32_t i = 0; i < p.tree_count; i++)
        bvh_plan_release(&p.trees[i].plan);
    return fits;
}
