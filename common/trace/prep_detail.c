/* Which shapes have a detail, and its parts. What many shapes share, a mesh's corners and vertices,
 * is kept once.
 * SPDX-License-Identifier: MIT */
#include "common/trace/prep_plan.h"

#include <string.h>

/* Nearer than this to its first choice, a shape's direction is counted from the second: 8 degrees.
 */
#define ALONG 0.99f

static const struct stage_uv quad_uvs[4] = {{{0, 0}}, {{1, 0}}, {{1, 1}}, {{0, 1}}};

static const struct mesh *mesh_of(const struct prep_plan *p, const struct shape *s)
{
    return s->kind == SHAPE_MESH ? &p->scene->meshes[s->mesh.mesh] : NULL;
}

static bool is_smooth(const struct shape *s)
{
    return s->kind == SHAPE_MESH && s->mesh.normals == MESH_NORMALS_SMOOTH;
}

static bool has_normals(const struct shape *s, const struct mesh *mesh)
{
    return is_smooth(s) || (mesh && mesh->normals && s->mesh.normals != MESH_NORMALS_FLAT);
}

static struct prep_mesh *detail_mesh_of(const struct prep_plan *p, const struct shape *s)
{
    return &p->detail_meshes[2 * (size_t)s->mesh.mesh + is_smooth(s)];
}

static uint32_t needs_of(const struct prep_plan *p, const struct shape *s)
{
    uint32_t needs = p->scene->materials[s->material].needs;
    if (s->glow)
        needs |= p->scene->textures[s->glow - 1].kind == TEXTURE_VERTEX_COLOR ? MATERIAL_NEEDS_COLOR
                                                                              : MATERIAL_NEEDS_UV;
    return needs;
}

static bool wants_uv(uint32_t needs)
{
    return needs & (MATERIAL_NEEDS_UV | MATERIAL_NEEDS_TANGENT);
}

/* --- axes --- */

static void store_axis(const struct xform *x, vec3 axis, float out[3])
{
    vec3_store(out, vec3_unit(xform_vector(x, axis)));
}

/* The part of `first` across n, or of `second` when n is nearly along `first`. */
static vec3 across(vec3 n, vec3 first, vec3 second)
{
    const float along = vec3_dot(n, first);
    const vec3 from = along > ALONG || along < -ALONG ? second : first;
    return vec3_unit(from - vec3_dot(n, from) * n);
}

static void turn_sphere(const struct shape *s, struct stage_detail *d)
{
    store_axis(&s->to_world, vec3_make(1, 0, 0), d->axes[0]);
    store_axis(&s->to_world, vec3_make(0, 1, 0), d->axes[1]);
    store_axis(&s->to_world, vec3_make(0, 0, 1), d->axes[2]);
}

static void turn_cylinder(const struct shape *s, struct stage_detail *d)
{
    const vec3 y = vec3_unit(vec3_load(s->cylinder.axis));
    const vec3 z = across(y, vec3_make(0, 0, 1), vec3_make(0, 1, 0));
    store_axis(&s->to_world, vec3_cross(y, z), d->axes[0]);
    store_axis(&s->to_world, y, d->axes[1]);
    store_axis(&s->to_world, z, d->axes[2]);
}

static void turn_disc(const struct shape *s, struct stage_detail *d)
{
    const vec3 z = vec3_load(s->disc.normal);
    const vec3 y = across(z, vec3_make(0, 1, 0), vec3_make(0, 0, -1));
    store_axis(&s->to_world, vec3_cross(y, z), d->axes[0]);
    store_axis(&s->to_world, y, d->axes[1]);
    store_axis(&s->to_world, z, d->axes[2]);
}

/* The inverse transpose is the matrix of cofactors over the determinant, of which the sign is
 * needed: a normal stays on its side in a mirror. In double, scaled to 1. */
static void turn_normals(const struct xform *x, struct stage_detail *d)
{
    double c[3][3], det = 0, greatest = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            c[i][j] = (double)x->m[i1][j1] * (double)x->m[i2][j2] -
                      (double)x->m[i1][j2] * (double)x->m[i2][j1];
            const double size = c[i][j] < 0 ? -c[i][j] : c[i][j];
            greatest = size > greatest ? size : greatest;
        }
    for (int j = 0; j < 3; j++)
        det += (double)x->m[0][j] * c[0][j];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            d->axes[i][j] = (float)(c[i][j] / (det < 0 ? -greatest : greatest));
    d->mirrored = det < 0;
}

/* --- what lies where --- */

static uint32_t take(struct stage_span *span, uint64_t count)
{
    const uint64_t begin = span->count;
    span->count += count;
    return (uint32_t)begin;
}

static void take_once(uint32_t *at, struct stage_span *span, uint64_t count)
{
    if (*at == STAGE_NONE)
        *at = take(span, count);
}

static uint32_t kept_of(const struct prep_plan *p, uint32_t shape)
{
    return p->shapes[shape + 1].prim_begin - p->shapes[shape].prim_begin;
}

/* Copies that have lost triangles have lists of their own, for each has lost what its transform has
 * made of it. */
static uint32_t take_corners(struct prep_plan *p, uint32_t shape, const struct shape *s,
                             const struct mesh *mesh)
{
    struct prep_mesh *to = detail_mesh_of(p, s);
    const uint32_t kept = kept_of(p, shape);
    if (kept == mesh->triangle_count) {
        take_once(&to->corners, &p->head.corners, kept);
        return to->corners;
    }
    if (!prep_shape_is_shared(p, s))
        return take(&p->head.corners, kept);
    take_once(&to->in_tree, &p->head.corners, kept);
    return to->in_tree;
}

static void detail_mesh(struct prep_plan *p, uint32_t shape, const struct shape *s,
                        struct stage_detail *d)
{
    const struct mesh *mesh = mesh_of(p, s);
    struct prep_mesh *to = detail_mesh_of(p, s);
    const uint32_t needs = needs_of(p, s);
    turn_normals(&s->to_world, d);
    if (has_normals(s, mesh)) {
        take_once(&to->normals, &p->head.normals, mesh->vertex_count);
        d->normals = to->normals;
    }
    if (mesh->uvs && wants_uv(needs)) {
        take_once(&to->uvs, &p->head.uvs, mesh->vertex_count);
        d->uvs = to->uvs;
    }
    if (mesh->colors && needs & MATERIAL_NEEDS_COLOR) {
        take_once(&to->colors, &p->head.colors, mesh->vertex_count);
        d->colors = to->colors;
    }
    if (d->normals != STAGE_NONE || d->uvs != STAGE_NONE || d->colors != STAGE_NONE)
        d->corners = take_corners(p, shape, s, mesh);
}

/* All quads have the same uv. */
static void detail_quad(struct prep_plan *p, uint32_t shape, const struct shape *s,
                        struct stage_detail *d)
{
    if (!wants_uv(needs_of(p, s)))
        return;
    take_once(&p->quad_uvs, &p->head.uvs, countof(quad_uvs));
    d->uvs = p->quad_uvs;
    d->corners = take(&p->head.corners, kept_of(p, shape));
}

static struct stage_detail detail_of(struct prep_plan *p, uint32_t shape, const struct shape *s)
{
    struct stage_detail d = {.prim_begin = p->shapes[shape].prim_begin,
                             .corners = STAGE_NONE,
                             .normals = STAGE_NONE,
                             .uvs = STAGE_NONE,
                             .colors = STAGE_NONE};
    switch (s->kind) {
    case SHAPE_SPHERE:
        turn_sphere(s, &d);
        break;
    case SHAPE_DISC:
        turn_disc(s, &d);
        break;
    case SHAPE_CYLINDER:
        turn_cylinder(s, &d);
        break;
    case SHAPE_QUAD:
        detail_quad(p, shape, s, &d);
        break;
    case SHAPE_MESH:
        detail_mesh(p, shape, s, &d);
        break;
    }
    return d;
}

static bool wants_detail(const struct prep_plan *p, const struct shape *s)
{
    return needs_of(p, s) || has_normals(s, mesh_of(p, s));
}

bool prep_detail_plan(struct prep_plan *p, struct arena *scratch, struct err *err)
{
    const struct scene *scene = p->scene;
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->shape_count; i++)
        p->shapes[i].detail = wants_detail(p, &scene->shapes[i]) ? count++ : STAGE_NONE;
    p->details = arena_new(scratch, struct stage_detail, count);
    p->detail_meshes = arena_new(scratch, struct prep_mesh, 2 * (size_t)scene->mesh_count);
    p->head.details.count = count;
    p->quad_uvs = STAGE_NONE;
    for (size_t i = 0; i < 2 * (size_t)scene->mesh_count; i++)
        p->detail_meshes[i] = (struct prep_mesh){scene->meshes[i / 2].normals,
                                                 STAGE_NONE,
                                                 STAGE_NONE,
                                                 STAGE_NONE,
                                                 STAGE_NONE,
                                                 STAGE_NONE};
    for (uint32_t i = 0; i < scene->shape_count; i++)
        if (p->shapes[i].detail != STAGE_NONE)
            p->details[p->shapes[i].detail] = detail_of(p, i, &scene->shapes[i]);
    for (size_t i = 1; i < 2 * (size_t)scene->mesh_count; i += 2)
        if (p->detail_meshes[i].normals != STAGE_NONE)
            p->detail_meshes[i].given = prep_smooth_make(&scene->meshes[i / 2], scratch);
    const uint64_t most = STAGE_NONE - 1;
    if (p->head.normals.count > most || p->head.uvs.count > most || p->head.colors.count > most ||
        p->head.corners.count > most)
        return err_set(err, ERR_LIMIT,
                       "the meshes have more than %llu vertices with normals, uvs or colors",
                       (unsigned long long)most);
    return true;
}

/* --- the parts --- */

/* Which side of a triangle its normals as a whole point to is judged in object space, once for all
 * that share it: a strong stretch may take a slanting normal to the other side. */
static void write_corner(const struct mesh *mesh, const float *normals, uint32_t i,
                         struct stage_corners *to)
{
    memcpy(to, mesh->indices + 3 * (size_t)i, sizeof *to);
    if (!normals)
        return;
    vec3 v[3], sum = {0};
    prep_triangle_object(mesh, i, v);
    for (int k = 0; k < 3; k++)
        sum += vec3_load(normals + 3 * (size_t)to->v[k]);
    if (vec3_dot(sum, vec3_cross(v[1] - v[0], v[2] - v[0])) < 0)
        to->v[0] |= STAGE_CORNERS_BACK;
}

/* Of the triangles that a copy has kept, as its transform makes them. */
static void write_own_corners(const struct prep_plan *p, const struct shape *s,
                              struct stage_corners *to)
{
    const struct mesh *mesh = mesh_of(p, s);
    const bool mirrored = prep_triangle_mirrored(s);
    const float *normals = has_normals(s, mesh) ? detail_mesh_of(p, s)->given : NULL;
    const uint32_t all = mesh ? mesh->triangle_count : 2;
    for (uint32_t i = 0; i < all; i++) {
        struct stage_triangle t;
        double area;
        vec3 v[3];
        prep_triangle_world(mesh, s, mirrored, i, v);
        if (prep_triangle_make(v, &t, &area) != PREP_KEPT)
            continue;
        if (mesh)
            write_corner(mesh, normals, i, to++);
        else
            prep_triangle_quad(mirrored, i, (to++)->v);
    }
}

static void write_mesh_corners(const struct mesh *mesh, const struct prep_mesh *at,
                               struct stage_corners *corners)
{
    uint32_t all = at->corners, in_tree = at->in_tree;
    const float *normals = at->normals != STAGE_NONE ? at->given : NULL;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        struct stage_triangle t;
        double area;
        vec3 v[3];
        if (all != STAGE_NONE)
            write_corner(mesh, normals, i, &corners[all++]);
        if (in_tree == STAGE_NONE)
            continue;
        prep_triangle_object(mesh, i, v);
        if (prep_triangle_make(v, &t, &area) == PREP_KEPT)
            write_corner(mesh, normals, i, &corners[in_tree++]);
    }
}

static void write_corners(const struct prep_plan *p, struct stage_corners *to)
{
    for (size_t i = 0; i < 2 * (size_t)p->scene->mesh_count; i++)
        if (p->detail_meshes[i].corners != STAGE_NONE || p->detail_meshes[i].in_tree != STAGE_NONE)
            write_mesh_corners(&p->scene->meshes[i / 2], &p->detail_meshes[i], to);
    for (uint32_t i = 0; i < p->scene->shape_count; i++) {
        const struct shape *s = &p->scene->shapes[i];
        const uint32_t detail = p->shapes[i].detail;
        const uint32_t own = detail == STAGE_NONE ? STAGE_NONE : p->details[detail].corners;
        const struct prep_mesh *of = s->kind == SHAPE_MESH ? detail_mesh_of(p, s) : NULL;
        if (own != STAGE_NONE && !(of && (own == of->corners || own == of->in_tree)))
            write_own_corners(p, s, to + own);
    }
}

static void write_vertices(const struct prep_plan *p, unsigned char *block)
{
    struct stage_normal *normals = (struct stage_normal *)(void *)(block + p->head.normals.offset);
    struct stage_uv *uvs = (struct stage_uv *)(void *)(block + p->head.uvs.offset);
    struct stage_color *colors = (struct stage_color *)(void *)(block + p->head.colors.offset);
    for (size_t i = 0; i < 2 * (size_t)p->scene->mesh_count; i++) {
        const struct mesh *mesh = &p->scene->meshes[i / 2];
        const struct prep_mesh *at = &p->detail_meshes[i];
        if (at->normals != STAGE_NONE)
            memcpy(normals + at->normals, at->given, mesh->vertex_count * sizeof *normals);
        if (at->uvs != STAGE_NONE)
            memcpy(uvs + at->uvs, mesh->uvs, mesh->vertex_count * sizeof *uvs);
        if (at->colors != STAGE_NONE)
            memcpy(colors + at->colors, mesh->colors, mesh->vertex_count * sizeof *colors);
    }
    if (p->quad_uvs != STAGE_NONE)
        memcpy(uvs + p->quad_uvs, quad_uvs, sizeof quad_uvs);
}

void prep_detail_write(const struct prep_plan *p, unsigned char *block)
{
    write_corners(p, (struct stage_corners *)(void *)(block + p->head.corners.offset));
    write_vertices(p, block);
}
