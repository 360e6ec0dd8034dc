/* SPDX-License-Identifier: MIT */
#include "common/trace/prep_plan.h"

#include <float.h>

#include "common/trace/box8.h"
#include "common/trace/cylinder.h"
#include "common/trace/tri.h"

#define PI 3.14159265358979323846

/* A mesh is shared when its copies would be so many triangles: tracing copies is faster by a
 * half, and below this they cost less memory (57 MB) than anyone misses. */
enum { SHARE_FROM = 1 << 20 };

/* Triangles that are stored, all trees together: their lanes are numbered in 29 bits, half of them
 * empty at worst; and nodes and other items in 28. */
enum { MOST_STORED = 1 << 27 };

/* --- which meshes are shared --- */

/* Lights are not: each of their triangles is an emitter, with its place in the world. */
static bool may_share(const struct shape *s)
{
    return s->kind == SHAPE_MESH && rgb_is_black(s->emission);
}

static uint64_t prims_of(const struct scene *scene, const struct shape *s)
{
    return s->kind == SHAPE_MESH   ? scene->meshes[s->mesh.mesh].triangle_count
           : s->kind == SHAPE_QUAD ? 2
                                   : 1;
}

static void choose_shared(struct prep_plan *p, struct arena *scratch)
{
    const struct scene *scene = p->scene;
    uint64_t *uses = arena_new(scratch, uint64_t, scene->mesh_count);
    for (uint32_t i = 0; i < scene->shape_count; i++)
        if (may_share(&scene->shapes[i]))
            uses[scene->shapes[i].mesh.mesh]++;
    p->mesh_tree = arena_new(scratch, uint32_t, scene->mesh_count);
    p->tree_count = 1;
    for (uint32_t i = 0; i < scene->mesh_count; i++)
        if (uses[i] > 1 && uses[i] * scene->meshes[i].triangle_count >= SHARE_FROM)
            p->mesh_tree[i] = p->tree_count++;
}

static uint32_t tree_of(const struct prep_plan *p, const struct shape *s)
{
    return may_share(s) ? p->mesh_tree[s->mesh.mesh] : 0;
}

bool prep_shape_is_shared(const struct prep_plan *p, const struct shape *s)
{
    return tree_of(p, s) != 0;
}

static void tree_open(struct prep_tree *t, uint64_t triangles, uint64_t others,
                      struct arena *scratch)
{
    t->items = arena_alloc(&t->item_arena, triangles + others, sizeof *t->items, 64);
    t->triangles = arena_new(scratch, struct stage_triangle, triangles);
    t->prims = arena_new(scratch, uint32_t, triangles);
}

struct counts {
    uint64_t prims;     /* numbered */
    uint64_t triangles; /* of the world's tree */
    uint64_t stored;    /* triangles of all trees */
    uint64_t others;    /* instances, and other primitives */
};

static struct counts count(const struct prep_plan *p)
{
    struct counts n = {0};
    for (uint32_t i = 0; i < p->scene->shape_count; i++) {
        const struct shape *s = &p->scene->shapes[i];
        const uint64_t prims = prims_of(p->scene, s);
        n.prims += prims;
        if (tree_of(p, s) || (s->kind != SHAPE_QUAD && s->kind != SHAPE_MESH))
            n.others++;
        else
            n.triangles += prims;
    }
    n.stored = n.triangles;
    for (uint32_t i = 0; i < p->scene->mesh_count; i++)
        if (p->mesh_tree[i])
            n.stored += p->scene->meshes[i].triangle_count;
    return n;
}

bool prep_plan_make(struct prep_plan *p, const struct scene *scene, struct arena *scratch,
                    struct err *err)
{
    *p = (struct prep_plan){.scene = scene};
    choose_shared(p, scratch);
    const struct counts n = count(p);
    if (n.prims >= STAGE_NONE)
        return err_set(err, ERR_LIMIT, "scene has %llu primitives, at most %llu are allowed",
                       (unsigned long long)n.prims, (unsigned long long)STAGE_NONE - 1);
    if (n.stored > MOST_STORED)
        return err_set(err, ERR_LIMIT,
                       "scene has %llu triangles to be stored, at most %llu are allowed",
                       (unsigned long long)n.stored, (unsigned long long)MOST_STORED);
    uint64_t emitters = scene->light_count;
    for (uint32_t i = 0; i < scene->shape_count; i++)
        if (!rgb_is_black(scene->shapes[i].emission))
            emitters += prims_of(scene, &scene->shapes[i]);
    p->shapes = arena_new(scratch, struct stage_shape, (size_t)scene->shape_count + 1);
    p->trees = arena_new(scratch, struct prep_tree, p->tree_count);
    p->instances = arena_new(scratch, struct stage_instance, n.others);
    p->spheres = arena_new(scratch, struct stage_sphere, n.others);
    p->discs = arena_new(scratch, struct stage_disc, n.others);
    p->cylinders = arena_new(scratch, struct stage_cylinder, n.others);
    p->emitters = arena_new(scratch, struct emitter, emitters);
    p->power = arena_new(scratch, double, emitters);
    p->pick_cdf = arena_new(scratch, float, emitters + 1);
    p->spots = arena_new(scratch, struct stage_spot, scene->light_count);
    tree_open(&p->trees[0], n.triangles, n.others, scratch);
    for (uint32_t i = 0; i < scene->mesh_count; i++)
        if (p->mesh_tree[i])
            tree_open(&p->trees[p->mesh_tree[i]], scene->meshes[i].triangle_count, 0, scratch);
    return true;
}

/* --- primitives --- */

static void add_item(struct prep_tree *t, enum bvh_ref_kind kind, uint64_t index, vec3 lo, vec3 hi)
{
    t->items[t->item_count++] = bvh_item_make(kind, (uint32_t)index, lo, hi);
}

/* The number of the next primitive; area in m^2. Radiance L from a Lambertian emitter of area A is
 * a power of pi A L. Where triangles are is not known before the tree is (prep.c). */
static uint32_t add_prim(struct prep_plan *p, uint32_t shape, struct stage_place place, double area)
{
    const struct shape *from = &p->scene->shapes[shape];
    const uint32_t prim = p->head.prim_count++;
    if (rgb_is_black(from->emission))
        return prim;
    const uint64_t at = p->head.emitters.count++;
    p->power[at] = PI * area * (double)rgb_luminance(from->emission);
    struct emitter *e = &p->emitters[at];
    *e = (struct emitter){.kind = EMITTER_PRIM,
                          .prim = prim,
                          .place = place,
                          .texture = from->glow ? from->glow - 1 : STAGE_NONE,
                          .area = (float)area};
    p->head.glowing |= from->glow != 0;
    vec3_store(e->radiance, from->emission);
    return prim;
}

/* False: not kept, but counted. Else the triangle is the tree's next one. */
static bool add_triangle(struct prep_plan *p, struct prep_tree *tree, const vec3 v[3], double *area)
{
    struct stage_triangle *t = &tree->triangles[tree->triangle_count];
    const enum prep_fate fate = prep_triangle_make(v, t, area);
    if (fate != PREP_KEPT) {
        p->head.dropped_nonfinite += fate == PREP_NONFINITE;
        p->head.dropped_degenerate += fate == PREP_DEGENERATE;
        return false;
    }
    vec3 lo, hi;
    tri_bounds(t, &lo, &hi);
    add_item(tree, BVH_BLOCK, tree->triangle_count++, lo, hi);
    return true;
}

static void add_world_triangle(struct prep_plan *p, uint32_t shape, const vec3 v[3])
{
    struct prep_tree *world = &p->trees[0];
    const uint32_t index = world->triangle_count;
    double area;
    if (add_triangle(p, world, v, &area))
        world->prims[index] =
            add_prim(p, shape, (struct stage_place){STAGE_TRIANGLE, index & 0x1fffffff}, area);
}

static void add_mesh(struct prep_plan *p, uint32_t shape, const struct shape *s)
{
    const struct mesh *mesh = &p->scene->meshes[s->mesh.mesh];
    const bool mirrored = prep_triangle_mirrored(s);
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        vec3 world[3];
        prep_triangle_world(mesh, s, mirrored, i, world);
        add_world_triangle(p, shape, world);
    }
}

static void add_quad(struct prep_plan *p, uint32_t shape, const struct shape *s)
{
    const bool mirrored = prep_triangle_mirrored(s);
    for (uint32_t i = 0; i < 2; i++) {
        vec3 world[3];
        prep_triangle_world(NULL, s, mirrored, i, world);
        add_world_triangle(p, shape, world);
    }
}

/* The transform is a similarity: any column's length is its scale. */
static float scale_of(const struct xform *x)
{
    return vec3_length(vec3_make(x->m[0][0], x->m[1][0], x->m[2][0]));
}

static void add_sphere(struct prep_plan *p, uint32_t shape, const struct shape *s)
{
    const vec3 center = xform_point(&s->to_world, vec3_load(s->sphere.center));
    const float radius = s->sphere.radius * scale_of(&s->to_world);
    const uint64_t index = p->head.spheres.count++;
    struct stage_sphere *to = &p->spheres[index];
    to->radius = radius;
    vec3_store(to->center, center);
    const double rr = (double)radius * (double)radius;
    to->prim =
        add_prim(p, shape, (struct stage_place){STAGE_SPHERE, index & 0x1fffffff}, 4 * PI * rr);
    vec3 lo, hi;
    sphere_bounds(to->center, radius, &lo, &hi);
    add_item(&p->trees[0], BVH_SPHERE, index, lo, hi);
}

/* n turned by a similarity: its scale drops out in the unit length, a mirror image keeps its front.
 */
static void add_disc(struct prep_plan *p, uint32_t shape, const struct shape *s)
{
    const vec3 center = xform_point(&s->to_world, vec3_load(s->disc.center));
    const vec3 n = vec3_unit(xform_vector(&s->to_world, vec3_load(s->disc.normal)));
    const float radius = s->disc.radius * scale_of(&s->to_world);
    const uint64_t index = p->head.discs.count++;
    struct stage_disc *to = &p->discs[index];
    to->radius = radius;
    vec3_store(to->center, center);
    vec3_store(to->normal, n);
    to->prim = add_prim(p, shape, (struct stage_place){STAGE_DISC, index & 0x1fffffff},
                        PI * (double)radius * (double)radius);
    vec3 lo, hi;
    sphere_bounds(to->center, radius, &lo, &hi);
    add_item(&p->trees[0], BVH_DISC, index, lo, hi);
}

/* Its front is the outside, which a mirror image keeps. */
static void add_cylinder(struct prep_plan *p, uint32_t shape, const struct shape *s)
{
    const uint64_t index = p->head.cylinders.count++;
    struct stage_cylinder *to = &p->cylinders[index];
    vec3_store(to->from, xform_point(&s->to_world, vec3_load(s->cylinder.from)));
    vec3_store(to->axis, xform_vector(&s->to_world, vec3_load(s->cylinder.axis)));
    to->radius = s->cylinder.radius * scale_of(&s->to_world);
    to->prim = add_prim(p, shape, (struct stage_place){STAGE_CYLINDER, index & 0x1fffffff},
                        cylinder_area(to));
    vec3 lo, hi;
    cylinder_bounds(to, &lo, &hi);
    add_item(&p->trees[0], BVH_CYLINDER, index, lo, hi);
}

/* --- shared meshes --- */

static void plan_tree(struct prep_tree *tree, const struct crew *crew)
{
    tree->plan = bvh_plan_make(tree->items, tree->item_count, crew);
    tree->items = NULL;
    arena_release(&tree->item_arena);
}

static void plan_mesh(struct prep_plan *p, const struct mesh *mesh, struct prep_tree *tree,
                      const struct crew *crew)
{
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        vec3 v[3];
        double area;
        prep_triangle_object(mesh, i, v);
        const uint32_t index = tree->triangle_count;
        if (add_triangle(p, tree, v, &area))
            tree->prims[index] = index;
    }
    plan_tree(tree, crew);
}

/* By cofactors, in double. */
static void invert(const struct xform *x, double inverse[3][4])
{
    double m[3][4], c[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            m[i][j] = (double)x->m[i][j];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            c[i][j] = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
        }
    const double det = m[0][0] * c[0][0] + m[0][1] * c[0][1] + m[0][2] * c[0][2];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            inverse[i][j] = c[j][i] / det;
        inverse[i][3] =
            -(inverse[i][0] * m[0][3] + inverse[i][1] * m[1][3] + inverse[i][2] * m[2][3]);
    }
}

/* The world's bounds of what is in a box of object space. */
static void bound_corners(const struct xform *x, vec3 lo, vec3 hi, struct bvh_box *box)
{
    for (int corner = 0; corner < 8; corner++) {
        const vec3 p =
            xform_point(x, vec3_make(corner & 1 ? hi[0] : lo[0], corner & 2 ? hi[1] : lo[1],
                                     corner & 4 ? hi[2] : lo[2]));
        bvh_box_grow(box, bvh_box_make(p, p));
    }
}

/* Of the boxes of the top node's children: tighter than the corners of one box. */
static struct bvh_box bound_instance(const struct prep_tree *tree, const struct xform *x)
{
    struct bvh_box box = bvh_box_empty();
    const struct bvh_plan *plan = &tree->plan;
    const struct bvh_node *top = plan->node_count ? bvh_part_node(&plan->parts[0], 0) : NULL;
    for (int i = 0; top && top->used >> i; i++)
        bound_corners(x, vec3_make(top->plane[0][i], top->plane[2][i], top->plane[4][i]),
                      vec3_make(top->plane[1][i], top->plane[3][i], top->plane[5][i]), &box);
    if (!top && plan->part_count)
        bound_corners(x, bvh_box_lo(&plan->box), bvh_box_hi(&plan->box), &box);
    return box;
}

static void add_instance(struct prep_plan *p, uint32_t shape, const struct shape *s)
{
    const uint32_t tree = tree_of(p, s);
    const uint64_t index = p->head.instances.count;
    struct stage_instance *to = &p->instances[index];
    *to = (struct stage_instance){.to_world = s->to_world,
                                  .tree = tree,
                                  .shape = shape,
                                  .prim_begin = p->head.prim_count,
                                  .mirrored = prep_triangle_mirrored(s)};
    if (!p->trees[tree].triangle_count)
        return;
    invert(&s->to_world, to->to_object);
    for (int k = 0; k < 3; k++) {
        double sum = 0;
        for (int j = 0; j < 3; j++)
            sum += to->to_object[k][j] < 0 ? -to->to_object[k][j] : to->to_object[k][j];
        to->spread[k] = round_up((float)sum);
    }
    const struct bvh_box box = bound_instance(&p->trees[tree], &s->to_world);
    const vec3 lo = bvh_box_lo(&box), hi = bvh_box_hi(&box);
    vec3_store(to->lo, lo);
    vec3_store(to->hi, hi);
    p->head.instances.count++;
    p->head.prim_count += p->trees[tree].triangle_count;
    add_item(&p->trees[0], BVH_INSTANCE, index, lo, hi);
}

/* --- all of it --- */

static void add_shape(struct prep_plan *p, uint32_t i)
{
    const struct shape *s = &p->scene->shapes[i];
    p->shapes[i] = (struct stage_shape){
        .prim_begin = p->head.prim_count,
        .material = s->material,
        .emitter_begin = rgb_is_black(s->emission) ? STAGE_NONE : (uint32_t)p->head.emitters.count,
    };
    switch (s->kind) {
    case SHAPE_SPHERE:
        add_sphere(p, i, s);
        break;
    case SHAPE_DISC:
        add_disc(p, i, s);
        break;
    case SHAPE_CYLINDER:
        add_cylinder(p, i, s);
        break;
    case SHAPE_QUAD:
        add_quad(p, i, s);
        break;
    case SHAPE_MESH:
        if (tree_of(p, s))
            add_instance(p, i, s);
        else
            add_mesh(p, i, s);
        break;
    }
}

void prep_shapes(struct prep_plan *p, const struct crew *crew)
{
    for (uint32_t i = 0; i < p->scene->mesh_count; i++)
        if (p->mesh_tree[i])
            plan_mesh(p, &p->scene->meshes[i], &p->trees[p->mesh_tree[i]], crew);
    for (uint32_t i = 0; i < p->scene->shape_count; i++)
        add_shape(p, i);
    p->shapes[p->scene->shape_count].prim_begin = p->head.prim_count;
    struct prep_tree *world = &p->trees[0];
    plan_tree(world, crew);
    if (world->item_count) {
        const struct bvh_box *box = &world->plan.box;
        vec3_store(p->head.bounds[0], bvh_box_lo(box));
        vec3_store(p->head.bounds[1], bvh_box_hi(box));
    }
}
