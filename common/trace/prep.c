/* SPDX-License-Identifier: MIT */
#include "common/trace/prep.h"

#include <assert.h>
#include <string.h>

#include "common/trace/bvh.h"
#include "common/trace/cylinder.h"
#include "common/trace/fmath.h"
#include "common/trace/sphere.h"
#include "common/trace/tri.h"

enum { ALIGN = 64 };

#define PI 3.14159265358979323846

/* Everything before it is copied into the block. Memory of the scratch arena. */
struct plan {
    const struct scene *scene;
    struct stage head;
    struct stage_prim *prims;
    struct stage_triangle *triangles;
    struct stage_sphere *spheres;
    struct stage_disc *discs;
    struct stage_cylinder *cylinders;
    struct emitter *emitters;
    double *power; /* of each emitter */
    float *pick_cdf;
    struct bvh_box *boxes;
    unsigned char *kinds;
    struct bvh_tree tree;
};

/* Upper bounds of what each shape adds. */
static uint64_t count_prims(const struct scene *scene)
{
    uint64_t n = 0;
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const struct shape *s = &scene->shapes[i];
        n += s->kind == SHAPE_MESH ? scene->meshes[s->mesh.mesh].triangle_count
             : s->kind == SHAPE_QUAD ? 2 : 1;
    }
    return n;
}

static struct plan plan_make(const struct scene *scene, uint64_t prims, struct arena *scratch)
{
    const uint64_t emitters = prims + scene->light_count;
    return (struct plan){
        .scene = scene,
        .prims = arena_new(scratch, struct stage_prim, prims),
        .triangles = arena_new(scratch, struct stage_triangle, prims),
        .spheres = arena_new(scratch, struct stage_sphere, prims),
        .discs = arena_new(scratch, struct stage_disc, prims),
        .cylinders = arena_new(scratch, struct stage_cylinder, prims),
        .emitters = arena_new(scratch, struct emitter, emitters),
        .power = arena_new(scratch, double, emitters),
        .pick_cdf = arena_new(scratch, float, emitters + 1),
        .boxes = arena_new(scratch, struct bvh_box, prims),
        .kinds = arena_new(scratch, unsigned char, prims),
    };
}

/* --- primitives --- */

/* `area` in m^2. Radiance L from a Lambertian emitter of area A is a power of pi A L. */
static void add_prim(struct plan *p, uint32_t shape, enum stage_prim_kind kind, uint32_t index,
                     struct bvh_box box, double area)
{
    const struct shape *from = &p->scene->shapes[shape];
    const uint64_t prim = p->head.prims.count++;
    p->boxes[prim] = box;
    p->kinds[prim] = (unsigned char)kind;
    p->prims[prim] = (struct stage_prim){
        .shape = shape,
        .material = from->material,
        .kind = (uint32_t)kind & 3,
        .index = index & 0x3fffffff,
        .emitter = STAGE_NONE,
    };
    if (rgb_is_black(from->emission))
        return;
    const uint64_t at = p->head.emitters.count++;
    p->prims[prim].emitter = (uint32_t)at;
    p->power[at] = PI * area * (double)rgb_luminance(from->emission);
    struct emitter *e = &p->emitters[at];
    *e = (struct emitter){.kind = EMITTER_PRIM, .prim = (uint32_t)prim, .area = (float)area};
    vec3_store(e->radiance, from->emission);
}

static bool is_finite3(const float v[3])
{
    return v[0] - v[0] == 0 && v[1] - v[1] == 0 && v[2] - v[2] == 0;
}

/* Twice the area, in double: exact enough to be 0 just for collinear vertices. */
static double double_area(const struct stage_triangle *t)
{
    double a[3], b[3], sum = 0;
    for (int k = 0; k < 3; k++) {
        a[k] = (double)t->v[1][k] - (double)t->v[0][k];
        b[k] = (double)t->v[2][k] - (double)t->v[0][k];
    }
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double n = a[i] * b[j] - a[j] * b[i];
        sum += n * n;
    }
    return __builtin_sqrt(sum);
}

static void add_triangle(struct plan *p, uint32_t shape, vec3 a, vec3 b, vec3 c)
{
    struct stage_triangle t;
    vec3_store(t.v[0], a);
    vec3_store(t.v[1], b);
    vec3_store(t.v[2], c);
    if (!is_finite3(t.v[0]) || !is_finite3(t.v[1]) || !is_finite3(t.v[2])) {
        p->head.dropped_nonfinite++;
        return;
    }
    const double area = double_area(&t) / 2;
    if (!(area > 0)) {
        p->head.dropped_degenerate++;
        return;
    }
    const uint64_t index = p->head.triangles.count++;
    p->triangles[index] = t;
    const struct stage_triangle *kept = &p->triangles[index];
    struct bvh_box box;
    tri_bounds(kept->v, box.lo, box.hi);
    add_prim(p, shape, STAGE_TRIANGLE, (uint32_t)index, box, area);
}

static float determinant(const struct xform *x)
{
    const vec3 a = vec3_make(x->m[0][0], x->m[1][0], x->m[2][0]);
    const vec3 b = vec3_make(x->m[0][1], x->m[1][1], x->m[2][1]);
    const vec3 c = vec3_make(x->m[0][2], x->m[1][2], x->m[2][2]);
    return vec3_dot(vec3_cross(a, b), c);
}

/* The front stays where the author put it: a mirroring transform turns the winding, so it is turned
 * back. */
static void add_mesh(struct plan *p, uint32_t shape, const struct shape *s)
{
    const struct mesh *mesh = &p->scene->meshes[s->mesh.mesh];
    const bool mirrored = determinant(&s->to_world) < 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        vec3 v[3];
        for (size_t k = 0; k < 3; k++) {
            const size_t at = mesh->indices[3 * (size_t)i + k];
            v[k] = xform_point(&s->to_world, vec3_load(mesh->vertices + 3 * at));
        }
        add_triangle(p, shape, v[0], v[mirrored ? 2 : 1], v[mirrored ? 1 : 2]);
    }
}

static void add_quad(struct plan *p, uint32_t shape, const struct shape *s)
{
    const bool mirrored = determinant(&s->to_world) < 0;
    vec3 v[4];
    for (int k = 0; k < 4; k++)
        v[mirrored ? 3 - k : k] = xform_point(&s->to_world, vec3_load(s->quad.vertices[k]));
    add_triangle(p, shape, v[0], v[1], v[2]);
    add_triangle(p, shape, v[0], v[2], v[3]);
}

/* The transform is a similarity: any column's length is its scale. */
static float scale_of(const struct xform *x)
{
    return vec3_length(vec3_make(x->m[0][0], x->m[1][0], x->m[2][0]));
}

static void add_sphere(struct plan *p, uint32_t shape, const struct shape *s)
{
    const vec3 center = xform_point(&s->to_world, vec3_load(s->sphere.center));
    const float radius = s->sphere.radius * scale_of(&s->to_world);
    const uint64_t index = p->head.spheres.count++;
    p->spheres[index].radius = radius;
    vec3_store(p->spheres[index].center, center);
    const double rr = (double)radius * (double)radius;
    struct bvh_box box;
    sphere_bounds(p->spheres[index].center, radius, box.lo, box.hi);
    add_prim(p, shape, STAGE_SPHERE, (uint32_t)index, box, 4 * PI * rr);
}

/* n turned by a similarity: its scale drops out in the unit length, a mirror image keeps its front. */
static void add_disc(struct plan *p, uint32_t shape, const struct shape *s)
{
    const vec3 center = xform_point(&s->to_world, vec3_load(s->disc.center));
    const vec3 n = vec3_unit(xform_vector(&s->to_world, vec3_load(s->disc.normal)));
    const float radius = s->disc.radius * scale_of(&s->to_world);
    const uint64_t index = p->head.discs.count++;
    p->discs[index].radius = radius;
    vec3_store(p->discs[index].center, center);
    vec3_store(p->discs[index].normal, n);
    struct bvh_box box;
    sphere_bounds(p->discs[index].center, radius, box.lo, box.hi);
    add_prim(p, shape, STAGE_DISC, (uint32_t)index, box, PI * (double)radius * (double)radius);
}

/* Its front is the outside, which a mirror image keeps. */
static void add_cylinder(struct plan *p, uint32_t shape, const struct shape *s)
{
    const uint64_t index = p->head.cylinders.count++;
    struct stage_cylinder *c = &p->cylinders[index];
    vec3_store(c->from, xform_point(&s->to_world, vec3_load(s->cylinder.from)));
    vec3_store(c->axis, xform_vector(&s->to_world, vec3_load(s->cylinder.axis)));
    c->radius = s->cylinder.radius * scale_of(&s->to_world);
    struct bvh_box box;
    cylinder_bounds(c, box.lo, box.hi);
    add_prim(p, shape, STAGE_CYLINDER, (uint32_t)index, box, cylinder_area(c));
}

static void add_shapes(struct plan *p)
{
    for (uint32_t i = 0; i < p->scene->shape_count; i++) {
        const struct shape *s = &p->scene->shapes[i];
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
            add_mesh(p, i, s);
            break;
        }
    }
}

/* --- lights --- */

/* Half the diagonal of everything: what a distant light shines on. */
static double scene_radius(const struct stage *head)
{
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        const double side = (double)head->bounds[1][k] - (double)head->bounds[0][k];
        sum += side * side;
    }
    return __builtin_sqrt(sum) / 2;
}

static void add_lights(struct plan *p)
{
    const double radius = scene_radius(&p->head);
    for (uint32_t i = 0; i < p->scene->light_count; i++) {
        const struct light *l = &p->scene->lights[i];
        struct emitter *e = &p->emitters[p->head.emitters.count];
        double *power = &p->power[p->head.emitters.count];
        switch (l->kind) {
        case LIGHT_SKY:
            p->head.sky += l->sky.radiance;
            continue;
        case LIGHT_POINT:
            *e = (struct emitter){.kind = EMITTER_POINT, .prim = STAGE_NONE};
            vec3_store(e->radiance, l->point.intensity);
            memcpy(e->at, l->point.position, sizeof e->at);
            *power = 4 * PI * (double)rgb_luminance(l->point.intensity);
            break;
        case LIGHT_DISTANT:
            *e = (struct emitter){.kind = EMITTER_DISTANT, .prim = STAGE_NONE};
            vec3_store(e->radiance, l->distant.irradiance);
            memcpy(e->at, l->distant.direction, sizeof e->at);
            *power = PI * radius * radius * (double)rgb_luminance(l->distant.irradiance);
            break;
        }
        p->head.emitters.count++;
    }
}

/* The table of floats has this many steps that are all exact. */
enum { PICK_STEPS = 1 << 24 };

/* Chosen in proportion to power; all alike when none has any. Every emitter gets a step of the table,
 * however weak it is: one that is never chosen would be missing, since nothing else finds a point
 * or a distant light. (More than 2^23 emitters are surfaces, which directions find, too.) */
static void pick_emitters(struct plan *p)
{
    const uint64_t n = p->head.emitters.count;
    double total = 0, sum = 0;
    for (uint64_t i = 0; i < n; i++)
        total += p->power[i];
    const bool usable = total > 0 && total - total == 0;
    const uint64_t reserved = n <= PICK_STEPS / 2 ? 1 : 0;
    for (uint64_t i = 0; i < n; i++) {
        sum += usable ? p->power[i] / total : 1 / (double)n;
        const double share = (double)(PICK_STEPS - reserved * n) * (sum < 1 ? sum : 1);
        const uint64_t steps = i + 1 < n ? (uint64_t)share + reserved * (i + 1) : PICK_STEPS;
        p->pick_cdf[i + 1] = (float)steps / (float)PICK_STEPS;
        p->emitters[i].pick = p->pick_cdf[i + 1] - p->pick_cdf[i];
    }
}

/* --- camera --- */

static void aim_camera(struct plan *p)
{
    const struct scene_film *film = &p->scene->film;
    const struct xform *m = &p->scene->camera.to_world;
    float sine, cosine;
    fmath_sincos(p->scene->camera.fov_y_rad / 2, &sine, &cosine);
    const float half_y = sine / cosine; /* of the image plane one metre ahead */
    const float pixel = 2 * half_y / (float)film->height_px;
    const float half_x = pixel * (float)film->width_px / 2;
    struct stage_camera *c = &p->head.camera;
    vec3_store(c->origin, xform_point(m, vec3_make(0, 0, 0)));
    vec3_store(c->corner, xform_vector(m, vec3_make(-half_x, half_y, -1)));
    vec3_store(c->dx, xform_vector(m, vec3_make(pixel, 0, 0)));
    vec3_store(c->dy, xform_vector(m, vec3_make(0, -pixel, 0)));
}

/* --- the block --- */

struct piece {
    struct stage_span *span; /* in the head; its count is set */
    const void *data;
    size_t size; /* of an element */
};

static void bound_scene(struct plan *p)
{
    for (uint64_t i = 0; i < p->head.prims.count; i++)
        for (int k = 0; k < 3; k++) {
            const float lo = p->boxes[i].lo[k], hi = p->boxes[i].hi[k];
            if (!i || lo < p->head.bounds[0][k])
                p->head.bounds[0][k] = lo;
            if (!i || hi > p->head.bounds[1][k])
                p->head.bounds[1][k] = hi;
        }
}

static const struct stage *lay_out(struct plan *p, struct arena *arena)
{
    struct stage *head = &p->head;
    head->pick_cdf.count = head->emitters.count + 1;
    head->materials.count = p->scene->material_count;
    head->nodes.count = p->tree.node_count;
    head->leaf_prims.count = head->prims.count;
    const struct piece pieces[] = {
        {&head->prims, p->prims, sizeof *p->prims},
        {&head->triangles, p->triangles, sizeof *p->triangles},
        {&head->spheres, p->spheres, sizeof *p->spheres},
        {&head->discs, p->discs, sizeof *p->discs},
        {&head->cylinders, p->cylinders, sizeof *p->cylinders},
        {&head->materials, p->scene->materials, sizeof *p->scene->materials},
        {&head->emitters, p->emitters, sizeof *p->emitters},
        {&head->pick_cdf, p->pick_cdf, sizeof *p->pick_cdf},
        {&head->nodes, p->tree.nodes, sizeof *p->tree.nodes},
        {&head->leaf_prims, p->tree.leaf_prims, sizeof *p->tree.leaf_prims},
    };
    uint64_t bytes = (sizeof *head + ALIGN - 1) / ALIGN * ALIGN;
    for (size_t i = 0; i < countof(pieces); i++) {
        pieces[i].span->offset = bytes;
        bytes += (pieces[i].span->count * pieces[i].size + ALIGN - 1) / ALIGN * ALIGN;
    }
    head->bytes = bytes;
    unsigned char *block = arena_alloc(arena, bytes, 1, ALIGN);
    memcpy(block, head, sizeof *head);
    for (size_t i = 0; i < countof(pieces); i++)
        if (pieces[i].span->count)
            memcpy(block + pieces[i].span->offset, pieces[i].data,
                   pieces[i].span->count * pieces[i].size);
    struct material *materials = (struct material *)(void *)(block + head->materials.offset);
    for (uint64_t i = 0; i < head->materials.count; i++)
        materials[i].name = NULL; /* a pointer means nothing elsewhere */
    return (const struct stage *)(const void *)block;
}

bool prep_stage(const struct scene *scene, struct arena *arena, struct arena *scratch,
                const struct stage **stage, struct err *err)
{
    const uint64_t prims = count_prims(scene), most = 1u << 29;
    if (prims > most)
        return err_set(err, ERR_LIMIT, "scene has %llu primitives, at most %llu are allowed",
                       (unsigned long long)prims, (unsigned long long)most);
    struct plan p = plan_make(scene, prims, scratch);
    memcpy(p.head.magic, "SMSTAGE", sizeof p.head.magic);
    p.head.version = STAGE_VERSION;
    p.head.struct_bytes = sizeof p.head;
    p.head.film = scene->film;
    p.head.settings = scene->settings;
    add_shapes(&p);
    bound_scene(&p);
    add_lights(&p);
    pick_emitters(&p);
    aim_camera(&p);
    p.tree = bvh_build(p.boxes, p.kinds, (uint32_t)p.head.prims.count, scratch);
    p.head.bvh_depth = p.tree.depth;
    *stage = lay_out(&p, arena);
    return true;
}
