/* SPDX-License-Identifier: MIT */
#include "common/trace/prep.h"

#include <assert.h>
#include <string.h>

#include "common/trace/bvh.h"
#include "common/trace/fmath.h"
#include "common/trace/round.h"

enum { ALIGN = 64, PICK_PARTS = 1 << 24, MAX_EMITTERS = 1 << 23 };

#define PI 3.14159265358979323846

/* Everything before it is copied into the block. Memory of the scratch arena. */
struct plan {
    const struct scene *scene;
    struct stage head;
    struct stage_prim *prims;
    struct stage_triangle *triangles;
    struct stage_sphere *spheres;
    struct stage_disc *discs;
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
        .emitters = arena_new(scratch, struct emitter, emitters),
        .power = arena_new(scratch, double, emitters),
        .pick_cdf = arena_new(scratch, float, emitters + 1),
        .boxes = arena_new(scratch, struct bvh_box, prims),
        .kinds = arena_new(scratch, unsigned char, prims),
    };
}

/* --- primitives --- */

/* The box of lo, hi and 2^-48 of its extent more, rounded outwards: primitive tests err by less (box.h),
 * and what is inside stays inside. */
static struct bvh_box box_make(const double lo[3], const double hi[3])
{
    const double slack = 0x1p-48 * (hi[0] - lo[0] + hi[1] - lo[1] + hi[2] - lo[2]);
    struct bvh_box box;
    for (int k = 0; k < 3; k++) {
        box.lo[k] = round_floor(lo[k] - slack);
        box.hi[k] = round_ceil(hi[k] + slack);
    }
    return box;
}

static bool is_finite_box(const struct bvh_box *box)
{
    bool finite = true;
    for (int k = 0; k < 3; k++)
        finite &= box->lo[k] - box->lo[k] == 0 && box->hi[k] - box->hi[k] == 0;
    return finite;
}

/* False, and counted: the primitive is left out. A box that is not finite has a vertex, centre or
 * radius that is not. An area that is 0 as a float (below 1e-45 m^2) counts as none. */
static bool is_kept(struct plan *p, const struct bvh_box *box, double area)
{
    if (!is_finite_box(box)) {
        p->head.dropped_nonfinite++;
        return false;
    }
    if (!((float)area > 0)) {
        p->head.dropped_degenerate++;
        return false;
    }
    return true;
}

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

/* In double; 0 when the vertices are collinear as far as double can tell. */
static double triangle_area(const struct stage_triangle *t)
{
    double a[3], b[3], sum = 0;
    for (int k = 0; k < 3; k++) {
        a[k] = (double)t->v[1][k] - (double)t->v[0][k];
        b[k] = (double)t->v[2][k] - (double)t->v[0][k];
    }
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double n = a[i] * b[j] - a[j] * b[i];
        const double error = 0x1p-51 * (__builtin_fabs(a[i] * b[j]) + __builtin_fabs(a[j] * b[i]));
        sum += __builtin_fabs(n) > error ? n * n : 0;
    }
    return __builtin_sqrt(sum) / 2;
}

static void add_triangle(struct plan *p, uint32_t shape, vec3 a, vec3 b, vec3 c)
{
    struct stage_triangle *t = &p->triangles[p->head.triangles.count];
    vec3_store(t->v[0], a);
    vec3_store(t->v[1], b);
    vec3_store(t->v[2], c);
    double lo[3], hi[3];
    for (int k = 0; k < 3; k++) {
        /* A NaN anywhere must get into the box: min and max would lose it. */
        const double nan = (double)(a[k] - a[k] + b[k] - b[k] + c[k] - c[k]);
        const float ab_lo = a[k] < b[k] ? a[k] : b[k], ab_hi = a[k] > b[k] ? a[k] : b[k];
        lo[k] = (double)(ab_lo < c[k] ? ab_lo : c[k]) + nan;
        hi[k] = (double)(ab_hi > c[k] ? ab_hi : c[k]) + nan;
    }
    const struct bvh_box box = box_make(lo, hi);
    const double area = triangle_area(t);
    if (is_kept(p, &box, area))
        add_prim(p, shape, STAGE_TRIANGLE, (uint32_t)p->head.triangles.count++, box, area);
}

/* In double: a product of three small scales must not vanish. */
static bool is_mirroring(const struct xform *x)
{
    double m[3][3];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            m[i][k] = (double)x->m[i][k];
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
               m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]) <
           0;
}

/* The front is the side from which the author's vertices run counter-clockwise; it stays where he put
 * it: a mirroring transform turns the winding round, so it is turned back. */
static void add_mesh(struct plan *p, uint32_t shape, const struct shape *s)
{
    const struct mesh *mesh = &p->scene->meshes[s->mesh.mesh];
    const bool mirrored = is_mirroring(&s->to_world);
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
    const bool mirrored = is_mirroring(&s->to_world);
    vec3 v[4];
    for (int k = 0; k < 4; k++)
        v[k] = xform_point(&s->to_world, vec3_load(s->quad.vertices[k]));
    for (int k = 1; k < 3; k++) /* 0 1 2 and 0 2 3 */
        add_triangle(p, shape, v[0], v[mirrored ? k + 1 : k], v[mirrored ? k : k + 1]);
}

/* The transforms of spheres and discs are similarities: any column's length is the scale. */
static float scale_of(const struct xform *x)
{
    return vec3_length(vec3_make(x->m[0][0], x->m[1][0], x->m[2][0]));
}

static void add_sphere(struct plan *p, uint32_t shape, const struct shape *s)
{
    struct stage_sphere *out = &p->spheres[p->head.spheres.count];
    vec3_store(out->center, xform_point(&s->to_world, vec3_load(s->sphere.center)));
    out->radius = s->sphere.radius * scale_of(&s->to_world);
    const double radius = (double)out->radius;
    double lo[3], hi[3];
    for (int k = 0; k < 3; k++) {
        lo[k] = (double)out->center[k] - radius;
        hi[k] = (double)out->center[k] + radius;
    }
    const struct bvh_box box = box_make(lo, hi);
    const double area = 4 * PI * radius * radius;
    if (is_kept(p, &box, area))
        add_prim(p, shape, STAGE_SPHERE, (uint32_t)p->head.spheres.count++, box, area);
}

/* Its normal is turned like a vector: the scale drops out in the unit length, and the image of the front
 * is the front of the image, mirrored or not. */
static void add_disc(struct plan *p, uint32_t shape, const struct shape *s)
{
    struct stage_disc *out = &p->discs[p->head.discs.count];
    const vec3 n = vec3_unit(xform_vector(&s->to_world, vec3_load(s->disc.normal)));
    vec3_store(out->center, xform_point(&s->to_world, vec3_load(s->disc.center)));
    vec3_store(out->normal, n);
    out->radius = s->disc.radius * scale_of(&s->to_world);
    const double radius = (double)out->radius;
    double lo[3], hi[3], squares[3], sum = 0;
    for (int k = 0; k < 3; k++) {
        squares[k] = (double)n[k] * (double)n[k];
        sum += squares[k];
    }
    for (int k = 0; k < 3; k++) {
        const double flat = squares[(k + 1) % 3] + squares[(k + 2) % 3];
        const double reach = radius * __builtin_sqrt(flat / sum);
        lo[k] = (double)out->center[k] - reach;
        hi[k] = (double)out->center[k] + reach;
    }
    const struct bvh_box box = box_make(lo, hi);
    const double area = PI * radius * radius;
    if (is_kept(p, &box, area))
        add_prim(p, shape, STAGE_DISC, (uint32_t)p->head.discs.count++, box, area);
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

/* Emitter i gets 1 + (its share of the rest) of 2^24 parts: in proportion to power but for less than a part
 * in 2^24 / n, and never too weak to be found. Powers that are no use (all 0, or infinite) make
 * all alike. */
static void pick_emitters(struct plan *p)
{
    const uint64_t n = p->head.emitters.count;
    double total = 0, sum = 0;
    for (uint64_t i = 0; i < n; i++)
        total += p->power[i];
    const bool usable = total > 0 && total - total == 0;
    for (uint64_t i = 0; i < n; i++) {
        sum += usable ? p->power[i] / total : 1 / (double)n;
        const double spare = (double)(PICK_PARTS - n);
        const uint64_t parts = (uint64_t)(spare * (sum < 1 ? sum : 1)) + i + 1;
        p->pick_cdf[i + 1] = (float)(i + 1 < n ? parts : PICK_PARTS) / (float)PICK_PARTS;
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
    const void *data;        /* NULL: order_leaves fills it */
    size_t size;             /* of an element */
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

/* Copies each kind's primitives in the order of the leaves, so that a leaf is a range of them. */
static void order_leaves(const struct plan *p, unsigned char *block)
{
    const struct stage *head = &p->head;
    struct bvh_node *nodes = (struct bvh_node *)(void *)(block + head->nodes.offset);
    struct stage_prim *prims = (struct stage_prim *)(void *)(block + head->prims.offset);
    struct stage_triangle *triangles = (struct stage_triangle *)(void *)(block + head->triangles.offset);
    struct stage_sphere *spheres = (struct stage_sphere *)(void *)(block + head->spheres.offset);
    struct stage_disc *discs = (struct stage_disc *)(void *)(block + head->discs.offset);
    uint32_t next[3] = {0}; /* by kind */
    for (uint64_t n = 0; n < head->nodes.count; n++) {
        const uint32_t begin = nodes[n].first, kind = nodes[n].kind;
        if (nodes[n].count)
            nodes[n].first = next[kind];
        for (uint32_t i = begin; i < begin + nodes[n].count; i++) {
            const uint32_t prim = p->tree.leaf_prims[i], from = p->prims[prim].index;
            const uint32_t to = next[kind]++;
            prims[prim].index = to & 0x3fffffff;
            switch ((enum stage_prim_kind)kind) {
            case STAGE_TRIANGLE:
                triangles[to] = p->triangles[from];
                triangles[to].prim = prim;
                break;
            case STAGE_SPHERE:
                spheres[to] = p->spheres[from];
                spheres[to].prim = prim;
                break;
            case STAGE_DISC:
                discs[to] = p->discs[from];
                discs[to].prim = prim;
                break;
            }
        }
    }
}

static const struct stage *lay_out(struct plan *p, struct arena *arena)
{
    struct stage *head = &p->head;
    head->pick_cdf.count = head->emitters.count + 1;
    head->materials.count = p->scene->material_count;
    head->nodes.count = p->tree.node_count;
    const struct piece pieces[] = {
        {&head->prims, p->prims, sizeof *p->prims},
        {&head->triangles, NULL, sizeof *p->triangles},
        {&head->spheres, NULL, sizeof *p->spheres},
        {&head->discs, NULL, sizeof *p->discs},
        {&head->materials, p->scene->materials, sizeof *p->scene->materials},
        {&head->emitters, p->emitters, sizeof *p->emitters},
        {&head->pick_cdf, p->pick_cdf, sizeof *p->pick_cdf},
        {&head->nodes, p->tree.nodes, sizeof *p->tree.nodes},
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
        if (pieces[i].span->count && pieces[i].data)
            memcpy(block + pieces[i].span->offset, pieces[i].data,
                   pieces[i].span->count * pieces[i].size);
    order_leaves(p, block);
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
    if (p.head.emitters.count > MAX_EMITTERS)
        return err_set(err, ERR_LIMIT,
                       "scene has %llu lights and emitting triangles, at most %d are allowed",
                       (unsigned long long)p.head.emitters.count, MAX_EMITTERS);
    pick_emitters(&p);
    aim_camera(&p);
    p.tree = bvh_build(p.boxes, p.kinds, (uint32_t)p.head.prims.count, scratch);
    p.head.bvh_depth = p.tree.depth;
    *stage = lay_out(&p, arena);
    return true;
}
