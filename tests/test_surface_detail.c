/* surface_detail.h: uv and tangents where the header says, carried by transforms, the same for an
 * instance and a copy; and F-25's degenerate ones. SPDX-License-Identifier: MIT */
#include "common/trace/surface_detail.h"

#include <math.h>
#include <string.h>

#include "common/trace/bvh.h"
#include "tests/soup.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

struct met { /* by a ray */
    bool hit;
    struct ray_hit at;
    struct surface surface;
    struct surface_detail detail;
};

static struct met meet(const struct stage *s, vec3 origin, vec3 dir)
{
    const struct ray ray = {origin, dir, INFINITY, 0, 0};
    struct met m = {0};
    m.hit = bvh_hit_closest(s, &ray, &m.at);
    if (!m.hit)
        return m;
    m.surface = surface_at(s, &ray, &m.at);
    const struct stage_detail *d = surface_detail_of(s, m.at.prim, m.at.instance);
    if (!d) {
        m.hit = ok(false, "the shape has a detail");
        return m;
    }
    m.detail = surface_detail_at(s, d, &m.at, &m.surface);
    return m;
}

static uint32_t curious(struct scenes *s) /* a material that asks for everything */
{
    const uint32_t m = scenes_diffuse(s, rgb_gray(0.5f));
    s->scene.materials[m].needs = MATERIAL_NEEDS_UV | MATERIAL_NEEDS_TANGENT | MATERIAL_NEEDS_COLOR;
    return m;
}

static double apart(vec3 a, vec3 b) /* relative to b */
{
    return (double)(vec3_length(a - b) / vec3_length(b));
}

/* --- the parametrisations, where they are known --- */

enum kind { SPHERE, CYLINDER, CYLINDER_Z, DISC, DISC_UP, QUAD, MESH, KINDS };

static const char *const kind_names[] = {
    "sphere", "cylinder", "cylinder along z", "disc", "disc facing y", "quad", "mesh"};

static struct shape *mesh_add(struct scenes *s, uint32_t material)
{
    static const float points[4][3] = {{-1, -1, 0}, {1, -1, 0.25f}, {1, 1, 0}, {-1, 1, 0.25f}};
    static const float uvs[4][2] = {{0.5f, 0}, {1, 0.5f}, {0.5f, 1.25f}, {-0.25f, 0.5f}};
    static const float normals[4][3] = {
        {-0.6f, 0, 0.8f}, {0, 0, 1}, {0.6f, 0, 0.8f}, {0, 0.6f, 0.8f}};
    static const float colors[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    static const uint32_t triangles[2][3] = {{0, 1, 2}, {0, 2, 3}};
    const struct scenes_mesh m = scenes_mesh(s, material, 4, 2);
    memcpy(m.vertices, points, sizeof points);
    memcpy(m.triangles, triangles, sizeof triangles);
    struct mesh *mesh = &s->scene.meshes[m.shape->mesh.mesh];
    mesh->uvs = uvs[0];
    mesh->normals = normals[0];
    mesh->colors = colors[0];
    return m.shape;
}

static struct shape *add(struct scenes *s, uint32_t m, enum kind kind)
{
    const vec3 o = vec3_make(0, 0, 0);
    switch (kind) {
    case SPHERE:
        return scenes_sphere(s, m, o, 1);
    case CYLINDER:
        return scenes_cylinder(s, m, vec3_make(0, -1, 0), vec3_make(0, 1, 0), 1);
    case CYLINDER_Z:
        return scenes_cylinder(s, m, vec3_make(0, 0, -1), vec3_make(0, 0, 1), 1);
    case DISC:
        return scenes_disc(s, m, o, vec3_make(0, 0, 1), 1);
    case DISC_UP:
        return scenes_disc(s, m, o, vec3_make(0, 1, 0), 1);
    case QUAD:
        return scenes_quad(s, m, vec3_make(-1, -1, 0), vec3_make(2, 0, 0), vec3_make(0, 2, 0));
    case MESH:
        return mesh_add(s, m);
    case KINDS:
        break;
    }
    __builtin_unreachable();
}

static void test_known(void)
{
    static const struct {
        enum kind kind;
        float from[3]; /* the ray goes to the origin's side of it */
        float u, v, du[3], dv[3];
    } rows[] = {
        {SPHERE, {0, 0, 2}, .5f, .5f, {6.2831853f, 0, 0}, {0, 3.1415927f, 0}},
        {SPHERE, {2, 0, 0}, .75f, .5f, {0, 0, -6.2831853f}, {0, 3.1415927f, 0}},
        {SPHERE, {0, 2, 2}, .5f, .75f, {4.4428829f, 0, 0}, {0, 2.2214415f, -2.2214415f}},
        {CYLINDER, {0, 0, 2}, .5f, .5f, {6.2831853f, 0, 0}, {0, 2, 0}},
        {CYLINDER, {2, 1, 0}, .75f, .75f, {0, 0, -6.2831853f}, {0, 2, 0}},
        {CYLINDER_Z, {0, 2, 0}, .5f, .5f, {-6.2831853f, 0, 0}, {0, 0, 2}},
        {DISC, {.5f, .25f, 2}, .75f, .625f, {2, 0, 0}, {0, 2, 0}},
        {DISC_UP, {.5f, 2, .25f}, .75f, .375f, {2, 0, 0}, {0, 0, -2}},
        {QUAD, {-.5f, .5f, 2}, .25f, .75f, {2, 0, 0}, {0, 2, 0}},
    };
    for (size_t i = 0; i < countof(rows); i++) {
        struct scenes s;
        scenes_init(&s, 1, 1);
        add(&s, curious(&s), rows[i].kind);
        const vec3 from = vec3_load(rows[i].from);
        const bool flat = rows[i].kind >= DISC;
        const vec3 down = rows[i].kind == DISC_UP ? vec3_make(0, -1, 0) : vec3_make(0, 0, -1);
        const struct met m = meet(scenes_stage(&s), from, flat ? down : -from);
        ok(m.hit && fabsf(m.detail.u - rows[i].u) < 1e-6f &&
               fabsf(m.detail.v - rows[i].v) < 1e-6f &&
               vec3_length(m.detail.dp_du - vec3_load(rows[i].du)) < 3e-6f &&
               vec3_length(m.detail.dp_dv - vec3_load(rows[i].dv)) < 3e-6f,
           "%s seen from (%g, %g, %g): uv (%g, %g)", kind_names[rows[i].kind], (double)from[0],
           (double)from[1], (double)from[2], (double)rows[i].u, (double)rows[i].v);
        scenes_release(&s);
    }
}

/* --- transforms --- */

/* A turn from three directions at right angles; a scale for each axis, or for all; half of them
 * mirror. */
static struct xform random_transform(struct dice *d, bool similarity)
{
    const vec3 x = soup_direction(d), y = vec3_unit(vec3_cross(x, soup_direction(d)));
    const float all = (float)pow(10, dice_range(d, -1, 1));
    const bool mirror = dice_bits(d) & 1;
    vec3 column[3] = {mirror ? -x : x, y, vec3_cross(x, y)};
    struct xform m;
    for (int j = 0; j < 3; j++) {
        column[j] *= similarity ? all : (float)dice_range(d, 0.5, 2);
        if (!similarity)
            column[j] += 0.1f * soup_direction(d); /* and shears */
    }
    const vec3 offset = soup_point(d, similarity ? (double)all : 1);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            m.m[i][j] = column[j][i];
        m.m[i][3] = offset[i];
    }
    return m;
}

/* cof(M) n / det(M), in double; its length is not kept. */
static vec3 carry_normal(const struct xform *x, vec3 n)
{
    double det = 0, out[3];
    for (int i = 0; i < 3; i++) {
        out[i] = 0;
        for (int j = 0; j < 3; j++) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            const double c = (double)x->m[i1][j1] * (double)x->m[i2][j2] -
                             (double)x->m[i1][j2] * (double)x->m[i2][j1];
            out[i] += c * (double)n[j];
            if (i == 0)
                det += c * (double)x->m[0][j];
        }
    }
    const double length = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
    const double k = det < 0 ? -1 / length : 1 / length;
    return vec3_make((float)(k * out[0]), (float)(k * out[1]), (float)(k * out[2]));
}

struct errors {
    double uv, dp, ns, color;
    int hits;
};

static void compare(const struct met *a, const struct met *b, const struct xform *x,
                    struct errors *e)
{
    e->hits++;
    e->uv = fmax(e->uv, fmax(fabs((double)(a->detail.u - b->detail.u)),
                             fabs((double)(a->detail.v - b->detail.v))));
    e->dp = fmax(e->dp, apart(b->detail.dp_du, xform_vector(x, a->detail.dp_du)));
    e->dp = fmax(e->dp, apart(b->detail.dp_dv, xform_vector(x, a->detail.dp_dv)));
    const vec3 ns = carry_normal(x, a->detail.ns);
    if (vec3_dot(ns, b->surface.ng) > 0.01f) /* else it is raised */
        e->ns = fmax(e->ns, apart(b->detail.ns, ns));
    e->color = fmax(e->color, apart(b->detail.color, a->detail.color));
}

/* The same ray in both spaces. */
static void test_carried(enum kind kind)
{
    struct dice d = dice_make(kind);
    struct errors e = {0};
    for (int i = 0; i < 300; i++) {
        const struct xform x = random_transform(&d, kind < QUAD);
        struct scenes s[2];
        const struct stage *stage[2];
        for (int k = 0; k < 2; k++) {
            scenes_init(&s[k], 1, 1);
            struct shape *shape = add(&s[k], curious(&s[k]), kind);
            shape->to_world = k ? x : xform_identity();
            stage[k] = scenes_stage(&s[k]);
        }
        for (int k = 0; k < 20; k++) {
            const vec3 from = soup_direction(&d) * 3, aim = soup_point(&d, 0.8) - from;
            const struct met a = meet(stage[0], from, aim);
            const struct met b = meet(stage[1], xform_point(&x, from), xform_vector(&x, aim));
            /* Near a seam, a pole or an edge rounding decides on which side the hit is. */
            const bool clear = a.hit && b.hit && fabsf(a.detail.u - b.detail.u) < 0.5f &&
                               vec3_length(a.detail.dp_du) > 0.5f && a.at.prim == b.at.prim;
            if (clear)
                compare(&a, &b, &x, &e);
        }
        scenes_release(&s[0]);
        scenes_release(&s[1]);
    }
    ok(e.hits > 1000 && e.uv < 2e-5 && e.dp < 3e-5 && e.ns < 1e-5 && e.color < 2e-5,
       "%s: uv, tangents, normals and colours go with a transform "
       "(%d hits, off by %.1g, %.1g, %.1g, %.1g)",
       kind_names[kind], e.hits, e.uv, e.dp, e.ns, e.color);
}

/* uv a small step along the tangents are those of the step. */
static void test_gradients(enum kind kind)
{
    const float step = 1e-3f;
    struct dice d = dice_make(kind);
    struct scenes s;
    scenes_init(&s, 1, 1);
    add(&s, curious(&s), kind);
    const struct stage *stage = scenes_stage(&s);
    double worst = 0;
    int steps = 0;
    for (int i = 0; i < 3000; i++) {
        const vec3 from = soup_direction(&d) * 3;
        const struct met a = meet(stage, from, soup_point(&d, 0.8) - from);
        if (!a.hit || vec3_length(a.detail.dp_du) < 2)
            continue;
        const float du = step * (2 * dice_float(&d) - 1), dv = step * (2 * dice_float(&d) - 1);
        const vec3 to = a.surface.p + du * a.detail.dp_du + dv * a.detail.dp_dv;
        const struct met b = meet(stage, to + a.surface.ng, -a.surface.ng);
        if (!b.hit || a.at.prim != b.at.prim || fabsf(b.detail.u - a.detail.u) > 0.5f)
            continue; /* another triangle, or over the seam */
        steps++;
        worst = fmax(worst, fabs((double)(b.detail.u - a.detail.u - du)));
        worst = fmax(worst, fabs((double)(b.detail.v - a.detail.v - dv)));
    }
    ok(steps > 500 && worst < 0.02 * (double)step,
       "%s: uv at p + dp_du du + dp_dv dv are u + du, v + dv (%d steps of %g, off by %.1g)",
       kind_names[kind], steps, (double)step, worst);
    scenes_release(&s);
}

/* --- instances --- */

static const float *ball_normals(struct scenes *s, const struct mesh *mesh)
{
    float *n = arena_new(&s->arena, float, 3 * (size_t)mesh->vertex_count);
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        vec3_store(n + 3 * (size_t)i, vec3_unit(vec3_load(mesh->vertices + 3 * (size_t)i)));
    return n;
}

static const float *ball_uvs(struct scenes *s, const struct mesh *mesh)
{
    float *uv = arena_new(&s->arena, float, 2 * (size_t)mesh->vertex_count);
    struct dice d = dice_make(5);
    for (size_t i = 0; i < 2 * (size_t)mesh->vertex_count; i++)
        uv[i] = dice_float(&d);
    return uv;
}

enum { USES = 5, RINGS = 256 };

/* A ball whose poles have triangles without an area, used five times: as instances, or each use
 * with a mesh of its own. */
static const struct stage *make_uses(struct scenes *s, bool copies)
{
    struct dice d = dice_make(6);
    scenes_init(s, 1, 1);
    const uint32_t m = curious(s);
    struct shape first = *scenes_ball(s, m, vec3_make(0, 0, 0), 1, RINGS, 0.1f, false);
    struct mesh *mesh = &s->scene.meshes[0];
    mesh->normals = ball_normals(s, mesh);
    mesh->uvs = mesh->colors = NULL;
    mesh->uvs = ball_uvs(s, mesh);
    for (uint32_t i = 0; i < USES; i++) {
        first.to_world = random_transform(&d, false);
        first.mesh.mesh = copies ? i : 0;
        s->scene.shapes[i] = first;
        s->scene.meshes[copies ? i : 0] = *mesh;
    }
    s->scene.shape_count = USES;
    s->scene.mesh_count = copies ? USES : 1;
    return scenes_stage(s);
}

static void test_instances(void)
{
    struct scenes s[2];
    const struct stage *shared = make_uses(&s[0], false), *copies = make_uses(&s[1], true);
    const uint64_t vertices = s[0].scene.meshes[0].vertex_count;
    ok(shared->instances.count == USES && copies->instances.count == 0 &&
           shared->normals.count == vertices && shared->uvs.count == vertices &&
           shared->colors.count == 0 && shared->corners.count == shared->prim_count / USES &&
           copies->normals.count == USES * vertices,
       "normals and uvs of a shared mesh are kept once, colours it has not take nothing");
    struct dice d = dice_make(7);
    int hits = 0, wrong = 0;
    for (int i = 0; i < 20000; i++) {
        const vec3 from = soup_point(&d, 9), aim = soup_point(&d, 3) - from;
        const struct met a = meet(shared, from, aim), b = meet(copies, from, aim);
        if (!a.hit || !b.hit || a.at.prim != b.at.prim)
            continue;
        hits++;
        wrong += memcmp(&a.detail, &b.detail, sizeof a.detail) != 0;
    }
    ok(hits > 1000 && wrong == 0, "an instance has a copy's detail, bit by bit (%d of %d not)",
       wrong, hits);
    scenes_release(&s[0]);
    scenes_release(&s[1]);
}

/* --- what is missing or degenerate --- */

/* Five triangles in a row, of which every other one has no area: corners go with the triangles that
 * are left. */
static void test_dropped(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    const struct scenes_mesh m = scenes_mesh(&s, curious(&s), 15, 5);
    float(*uvs)[2] = (float(*)[2])arena_new(&s.arena, float, 30);
    for (uint32_t i = 0; i < 15; i++) {
        const uint32_t t = i / 3, k = i % 3;
        m.triangles[t][k] = i;
        vec3_store(m.vertices[i], vec3_make((float)(t + (k == 1 && t % 2 == 0)), k == 2, 0));
        uvs[i][0] = (float)t;
    }
    s.scene.meshes[0].uvs = uvs[0];
    const struct stage *stage = scenes_stage(&s);
    bool good = stage->prim_count == 3 && stage->corners.count == 3;
    for (uint32_t t = 0; t < 5; t += 2) {
        const struct met a =
            meet(stage, vec3_make((float)t + 0.25f, 0.25f, 1), vec3_make(0, 0, -1));
        good = good && a.hit && near((double)a.detail.u, t, 1e-6, "triangle %u keeps its uv", t);
    }
    ok(good, "triangles that are dropped take their corners with them");
    scenes_release(&s);
}

static void test_absent(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    const uint32_t plain = scenes_diffuse(&s, rgb_gray(0.5f));
    struct shape *shape = mesh_add(&s, plain);
    scenes_sphere(&s, plain, vec3_make(0, 0, -5), 1);
    const struct stage *stage = scenes_stage(&s);
    ok(stage->details.count == 1 && stage->normals.count == 4 && !stage->uvs.count &&
           !stage->colors.count,
       "of what a mesh has, what nobody asks for is left out");
    ok(!surface_detail_of(stage, 2, STAGE_NONE) && surface_detail_of(stage, 1, STAGE_NONE),
       "a shape whose material asks for nothing has no detail");
    shape->mesh.normals = MESH_NORMALS_FLAT;
    stage = scenes_stage(&s);
    ok(!stage->details.count && !stage->corners.count && !stage->normals.count,
       "a flat mesh under a plain material takes no byte");
    scenes_release(&s);
}

/* Unit vectors at right angles, right-handed, z is ns. A NaN fails. */
static bool is_frame(const struct warp_frame *f, vec3 ns)
{
    return fabsf(vec3_length(f->x) - 1) < 1e-6f && fabsf(vec3_length(f->y) - 1) < 1e-6f &&
           fabsf(vec3_dot(f->x, f->y)) < 1e-6f && fabsf(vec3_dot(f->x, ns)) < 1e-6f &&
           vec3_length(vec3_cross(f->x, f->y) - ns) < 1e-6f && vec3_length(f->z - ns) == 0;
}

static void test_frames(void)
{
    struct dice d = dice_make(8);
    int bad = 0, turned = 0, parallel = 0;
    for (int i = 0; i < 100000; i++) {
        const vec3 ns = vec3_unit(soup_direction(&d));
        const float size = (float)pow(10, dice_range(&d, -30, 30));
        const vec3 off = soup_direction(&d) * (float)pow(10, dice_range(&d, -9, 0));
        const vec3 along[] = {soup_direction(&d) * size, (ns + off) * size};
        for (int k = 0; k < 2; k++) {
            const struct warp_frame f = surface_detail_frame(ns, along[k]);
            bad += !is_frame(&f, ns);
            const vec3 t = vec3_unit(along[k] / size);
            const float sine = vec3_length(vec3_cross(t, ns));
            parallel += sine < 0.9e-3f;
            /* x has all of t that is not along ns */
            turned += sine > 2e-3f && !(vec3_dot(f.x, t) > 0.99f * sine);
        }
    }
    ok(!bad && !turned && parallel > 1000,
       "F-25: the frame is right-handed with u along x, T at any angle and of any length "
       "(%d not, %d of another direction, %d T along N)",
       bad, turned, parallel);
    const float odd[] = {0, INFINITY, -INFINITY, NAN, 1e38f, 1e-45f};
    bad = 0;
    for (size_t i = 0; i < countof(odd) * countof(odd); i++) {
        const vec3 ns = vec3_unit(soup_direction(&d));
        const struct warp_frame f =
            surface_detail_frame(ns, vec3_make(odd[i % 6], odd[i / 6], odd[i % 6]));
        bad += !is_frame(&f, ns);
    }
    ok(!bad, "F-25: T of zero, infinite, NaN, denormal: a frame (%d not)", bad);
}

/* uv of a point, of a line, next to a line, huge and tiny; a pole of a sphere. */
static void test_degenerate_uv(void)
{
    static const float cases[][3][2] = {
        {{.5f, .5f}, {.5f, .5f}, {.5f, .5f}},
        {{0, 0}, {.5f, .5f}, {1, 1}},
        {{0, 0}, {1, 0}, {1, 1e-45f}},
        {{1e30f, 0}, {0, 1e30f}, {-1e30f, 0}},
        {{0, 0}, {1e-30f, 0}, {0, 1e-30f}},
        {{0, 0}, {1e-45f, 0}, {0, 1e-45f}},
        {{1, 1}, {1.0000001f, 1}, {1, 1.0000001f}},
    };
    struct scenes s;
    int bad = 0;
    for (size_t i = 0; i < countof(cases); i++) {
        scenes_init(&s, 1, 1);
        scenes_triangle(&s, curious(&s), vec3_make(-1, -1, 0), vec3_make(1, -1, 0),
                        vec3_make(0, 1, 0));
        s.scene.meshes[0].uvs = cases[i][0];
        const struct met m = meet(scenes_stage(&s), vec3_make(0, 0, 1), vec3_make(0, 0, -1));
        const struct warp_frame f = surface_detail_frame(m.detail.ns, m.detail.dp_du);
        const vec3 sum = m.detail.dp_du + m.detail.dp_dv + vec3_make(m.detail.u, m.detail.v, 0);
        bad += !m.hit || !is_frame(&f, m.detail.ns) || !(vec3_length(sum * 1e-30f) >= 0);
        scenes_release(&s);
    }
    ok(!bad, "F-25: degenerate uv give a frame and no NaN (%d of %zu not)", bad, countof(cases));
    scenes_init(&s, 1, 1);
    scenes_sphere(&s, curious(&s), vec3_make(0, 0, 0), 1);
    const struct met pole = meet(scenes_stage(&s), vec3_make(0, 2, 0), vec3_make(0, -1, 0));
    const struct warp_frame f = surface_detail_frame(pole.detail.ns, pole.detail.dp_du);
    ok(pole.hit && is_frame(&f, pole.detail.ns) && pole.detail.v == 1 &&
           vec3_length(pole.detail.dp_du) == 0 && vec3_length(pole.detail.dp_dv) == 0,
       "F-25: the pole of a sphere has v 1, no tangent, and a frame");
    scenes_release(&s);
}

/* Corners without a normal, normals that cancel, that point inwards, that lie flat. */
static void test_odd_normals(void)
{
    static const struct {
        const char *what;
        float n[3][3];
        float want[3]; /* at the middle */
    } cases[] = {
        {"one of them 0", {{0, 0, 0}, {.6f, 0, .8f}, {.6f, 0, .8f}}, {0, 0, 1}},
        {"all of them 0", {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {0, 0, 1}},
        {"all turned inwards", {{-.6f, 0, -.8f}, {-.6f, 0, -.8f}, {-.6f, 0, -.8f}}, {.6f, 0, .8f}},
        {"below the surface", {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}}, {1, 0, 0x1p-10f}},
    };
    for (size_t i = 0; i < countof(cases); i++) {
        struct scenes s;
        scenes_init(&s, 1, 1);
        scenes_triangle(&s, scenes_diffuse(&s, rgb_gray(0.5f)), vec3_make(-1, -1, 0),
                        vec3_make(1, -1, 0), vec3_make(0, 1, 0));
        s.scene.meshes[0].normals = cases[i].n[0];
        const struct met m = meet(scenes_stage(&s), vec3_make(0, -0.25f, 1), vec3_make(0, 0, -1));
        ok(m.hit && vec3_length(m.detail.ns - vec3_unit(vec3_load(cases[i].want))) < 1e-5f &&
               fabsf(vec3_length(m.detail.ns) - 1) < 1e-6f,
           "vertex normals, %s: ns is (%.3f, %.3f, %.3f)", cases[i].what, (double)m.detail.ns[0],
           (double)m.detail.ns[1], (double)m.detail.ns[2]);
        scenes_release(&s);
    }
}

int main(void)
{
    test_known();
    for (int kind = 0; kind < KINDS; kind++) {
        test_carried((enum kind)kind);
        test_gradients((enum kind)kind);
    }
    test_instances();
    test_dropped();
    test_absent();
    test_frames();
    test_degenerate_uv();
    test_odd_normals();
    return tap_done();
}
