/* relief.c: the normals of maps and bumps are what they should be, on every shape, however textures
 * are laid on it. That no light passes walls by them: test_shading.c.
 * SPDX-License-Identifier: MIT */
#include "common/trace/relief.h"

#include <math.h>
#include <string.h>

#include "common/trace/bvh.h"
#include "common/trace/path.h"
#include "tests/soup.h"
#include "tests/tap.h"
#include "tests/textures.h"

#define PI 3.14159265358979323846

enum kind { QUAD, DISC, CYLINDER, SPHERE, MESH, KINDS };

static const char *const names[] = {"quad", "disc", "cylinder", "sphere", "mesh"};

static void add_mesh(struct scenes *s, uint32_t m)
{
    static const float points[4][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    static const float uvs[4][2] = {{0.9f, 0.1f}, {0.1f, 0.2f}, {0.2f, 0.8f}, {0.8f, 0.9f}};
    static const uint32_t triangles[2][3] = {{0, 1, 2}, {0, 2, 3}};
    const struct scenes_mesh mesh = scenes_mesh(s, m, 4, 2);
    memcpy(mesh.vertices, points, sizeof points);
    memcpy(mesh.triangles, triangles, sizeof triangles);
    s->scene.meshes[mesh.shape->mesh.mesh].uvs = uvs[0];
}

/* All about 1 m large, around the origin. */
static void add(struct scenes *s, uint32_t m, enum kind kind)
{
    const vec3 o = vec3_make(0, 0, 0);
    switch (kind) {
    case QUAD:
        scenes_quad(s, m, vec3_make(-1, -1, 0), vec3_make(2, 0, 0), vec3_make(1, 1.5f, 1));
        return;
    case DISC:
        scenes_disc(s, m, o, vec3_unit(vec3_make(1, 2, 3)), 1);
        return;
    case CYLINDER:
        scenes_cylinder(s, m, vec3_make(0.2f, -1, 0), vec3_make(-0.2f, 1, 0.1f), 1);
        return;
    case SPHERE:
        scenes_sphere(s, m, o, 1);
        return;
    case MESH: /* its uv are mirrored */
        add_mesh(s, m);
        return;
    case KINDS:
        break;
    }
    __builtin_unreachable();
}

struct met {
    bool hit;
    struct path_vertex v;
    struct surface_detail detail;
};

static struct met meet(const struct stage *s, vec3 from, vec3 aim, float width)
{
    const struct ray ray = {from, vec3_unit(aim - from), INFINITY, 0, 0};
    struct film_work work = {0};
    struct ray_hit hit;
    struct met m = {.hit = bvh_hit_closest(s, &ray, &hit)};
    if (!m.hit)
        return m;
    m.v = path_vertex_make(s, &ray, &hit, width, &work);
    m.detail = surface_detail_at(s, surface_detail_of(s, hit.prim, hit.instance), &hit, &m.v.at);
    return m;
}

static vec3 above_ground(struct dice *d, float least) /* a map's normal */
{
    for (;;) {
        const vec3 n = vec3_unit(soup_direction(d));
        if (n[2] > least)
            return n;
    }
}

/* --- maps --- */

/* The part of b across a. */
static vec3 across(vec3 a, vec3 b)
{
    return vec3_unit(b - vec3_dot(a, b) * a);
}

/* Steps along growing u and v of the texture, whatever its scale, say what a map's x and y are. */
static void test_map(enum kind kind)
{
    struct dice d = dice_make(kind);
    double worst = 0;
    int hits = 0;
    for (int i = 0; i < 200; i++) {
        struct scenes s;
        scenes_init(&s, 1, 1);
        const uint32_t m = scenes_diffuse(&s, rgb_gray(1));
        const vec3 n = above_ground(&d, 0.2f);
        struct texture *t = textures_normal(&s, n);
        t->uv_scale[0] = i & 1 ? -2 : 1;
        t->uv_scale[1] = i & 2 ? -0.5f : 3;
        struct material_relief *relief = textures_relief(&s, m);
        relief->normal_map = textures_index(&s, t);
        relief->strength = i & 4 ? 0.5f : 1;
        add(&s, m, kind);
        const struct met a = meet(scenes_stage(&s), 3 * soup_direction(&d), soup_point(&d, 0.5), 0);
        if (a.hit && vec3_length(a.detail.dp_du) > 0.1f) {
            const vec3 u = across(a.v.at.ng, a.detail.dp_du * t->uv_scale[0]);
            vec3 v = a.detail.dp_dv * t->uv_scale[1];
            v = across(a.v.at.ng, v - vec3_dot(u, v) * u);
            const vec3 want =
                vec3_unit(relief->strength * (n[0] * u + n[1] * v) + n[2] * a.v.at.ng);
            worst = fmax(worst, (double)vec3_length(a.v.frame.z - want));
            hits++;
        }
        scenes_release(&s);
    }
    ok(hits > 30 && worst < 3e-6, "%s: a map's normals lie along u and v (%d hits, off by %.1g)",
       names[kind], hits, worst);
}

/* Light of 1 W/m^2 from the side on a diffuse quad: cos / pi. */
static void test_light(void)
{
    double worst = 0;
    for (int i = 0; i < 36; i++) {
        const double turn = i * PI / 18, tilt = 0.02 * i;
        struct scenes s;
        scenes_init(&s, 4, 4);
        scenes_look(&s, vec3_make(0, 0, 3), vec3_make(0, 0, 0), 0.2);
        const uint32_t m = scenes_diffuse(&s, rgb_gray(1));
        const vec3 n = vec3_make((float)(sin(tilt) * cos(turn)), (float)(sin(tilt) * sin(turn)),
                                 (float)cos(tilt));
        textures_relief(&s, m)->normal_map = textures_index(&s, textures_normal(&s, n));
        scenes_quad(&s, m, vec3_make(-1, -1, 0), vec3_make(2, 0, 0), vec3_make(0, 2, 0));
        struct light *light = scenes_light(&s, LIGHT_DISTANT);
        const vec3 to_light = vec3_unit(vec3_make(1, 0.5f, 1));
        vec3_store(light->distant.direction, -to_light);
        light->distant.irradiance = rgb_gray(1);
        struct film film;
        scenes_render(scenes_stage(&s), 1, &film);
        worst = fmax(worst, fabs(film.sum[0] * PI / (double)vec3_dot(n, to_light) - 1));
        film_release(&film);
        scenes_release(&s);
    }
    ok(worst < 1e-5, "a diffuse surface under a map is as bright as its normal says (off by %.1g)",
       worst);
}

/* --- bumps --- */

enum { SIDE = 256 };

/* A height that grows evenly, or in waves. */
static struct texture *heights(struct scenes *s, float (*height)(float u, float v))
{
    float *pixels = arena_new(&s->arena, float, SIDE *SIDE);
    for (size_t y = 0; y < SIDE; y++)
        for (size_t x = 0; x < SIDE; x++)
            pixels[y * SIDE + x] = height(((float)x + 0.5f) / SIDE, 1 - ((float)y + 0.5f) / SIDE);
    return textures_image(s, IMAGE_DEPTH_FLOAT, SIDE, SIDE, 1, pixels);
}

static float ramp(float u, float v)
{
    return 0.5f * u - 0.25f * v;
}

static float waves(float u, float v)
{
    return (float)(0.02 * sin(2 * PI * 3 * (double)u) * cos(2 * PI * 2 * (double)v));
}

/* The slopes of waves, in u and v. */
static void waves_slope(double u, double v, double out[2])
{
    out[0] = 0.02 * 2 * PI * 3 * cos(2 * PI * 3 * u) * cos(2 * PI * 2 * v);
    out[1] = -0.02 * 2 * PI * 2 * sin(2 * PI * 3 * u) * sin(2 * PI * 2 * v);
}

/* (p_u + h_u n) x (p_v + h_v n), on n's side, in double. */
static vec3 raised_normal(const struct met *m, const double slope[2])
{
    double a[3], b[3], c[3], side = 0, square = 0;
    for (int k = 0; k < 3; k++) {
        a[k] = (double)m->detail.dp_du[k] + slope[0] * (double)m->v.at.ng[k];
        b[k] = (double)m->detail.dp_dv[k] + slope[1] * (double)m->v.at.ng[k];
    }
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        c[k] = a[i] * b[j] - a[j] * b[i];
        side += c[k] * (double)m->v.at.ng[k];
        square += c[k] * c[k];
    }
    const double f = (side < 0 ? -1 : 1) / sqrt(square);
    return vec3_make((float)(f * c[0]), (float)(f * c[1]), (float)(f * c[2]));
}

static void test_bump(enum kind kind, bool even)
{
    struct dice d = dice_make(10 + kind);
    struct scenes s;
    scenes_init(&s, 1, 1);
    const uint32_t m = scenes_diffuse(&s, rgb_gray(1));
    struct material_relief *relief = textures_relief(&s, m);
    struct texture *t = heights(&s, even ? ramp : waves);
    t->uv_scale[0] = even ? 1 : -1;
    relief->bump = textures_index(&s, t);
    relief->height = even ? -0.5f : 2;
    add(&s, m, kind);
    const struct stage *stage = scenes_stage(&s);
    double worst = 0;
    int hits = 0;
    for (int i = 0; i < 2000; i++) {
        const struct met a = meet(stage, 3 * soup_direction(&d), soup_point(&d, 0.9), 0);
        if (!a.hit || !(vec3_length(a.detail.dp_du) > 0.5f) || a.detail.u < 0.02f ||
            a.detail.u > 0.98f || a.detail.v < 0.02f || a.detail.v > 0.98f)
            continue; /* a ramp has a jump where it begins again */
        double slope[2] = {-0.25, 0.125};
        if (!even) {
            waves_slope(-(double)a.detail.u, (double)a.detail.v, slope);
            slope[0] *= -2;
            slope[1] *= 2;
        }
        hits++;
        worst = fmax(worst, (double)vec3_length(a.v.frame.z - raised_normal(&a, slope)));
    }
    ok(hits > 300 && worst < (even ? 1e-4 : 3e-3),
       "%s: %s has the normals of the surface that it raises (%d hits, off by %.1g)", names[kind],
       even ? "a ramp" : "waves", hits, worst);
    scenes_release(&s);
}

/* What is smaller than the ray is wide is not seen. */
static void test_width(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    const uint32_t m = scenes_diffuse(&s, rgb_gray(1));
    textures_relief(&s, m)->bump = textures_index(&s, heights(&s, waves));
    scenes_quad(&s, m, vec3_make(-1, -1, 0), vec3_make(2, 0, 0), vec3_make(0, 2, 0));
    const struct stage *stage = scenes_stage(&s);
    double tilt[3] = {0};
    static const float width[3] = {0, 0.1f, 1};
    struct dice d = dice_make(5);
    for (int i = 0; i < 1000; i++) {
        const vec3 at = vec3_make((float)dice_range(&d, -1, 1), (float)dice_range(&d, -1, 1), 0);
        for (int k = 0; k < 3; k++) {
            const struct met a = meet(stage, at + vec3_make(0, 0, 3), at, width[k]);
            tilt[k] += 1 - (double)a.v.frame.z[2];
        }
    }
    ok(tilt[1] < tilt[0] && tilt[1] > 0.5 * tilt[0] && tilt[2] < 0.1 * tilt[0],
       "waves of 0.67 m are flatter to a ray of 0.1 m, and all but gone to one of 1 m (%.3g, %.3g)",
       tilt[1] / tilt[0], tilt[2] / tilt[0]);
    scenes_release(&s);
}

/* --- anything --- */

static float extreme(struct dice *d)
{
    static const float some[] = {0, 1, -1, 0.5f, 1e30f, -1e30f, 3e38f, 1e-40f};
    return dice_bits(d) & 1 ? dice_float(d) : some[dice_bits(d) % countof(some)];
}

static bool is_fit(const struct path_vertex *v, vec3 dir)
{
    const vec3 n = v->frame.z;
    return fabsf(vec3_length(n) - 1) < 1e-5f && fabsf(vec3_length(v->frame.x) - 1) < 1e-5f &&
           vec3_dot(n, v->at.ng) > 0 && (v->wo[2] == 0 || v->wo[2] * vec3_dot(-dir, v->at.ng) > 0);
}

static void test_anything(void)
{
    struct dice d = dice_make(11);
    int hits = 0, bad = 0;
    for (int i = 0; i < 400; i++) {
        struct scenes s;
        scenes_init(&s, 1, 1);
        const uint32_t m = i & 1 ? scenes_diffuse(&s, rgb_gray(1)) : scenes_mirror(&s, rgb_gray(1));
        struct material_relief *relief = textures_relief(&s, m);
        float *pixels = arena_new(&s.arena, float, 3 * 8 * 8);
        for (size_t k = 0; k < (size_t)3 * 8 * 8; k++)
            pixels[k] = extreme(&d);
        struct texture *t = textures_image(&s, IMAGE_DEPTH_FLOAT, 8, 8, 3, pixels);
        relief->height = i % 3 ? 1 : 1e6f;
        if (i % 5)
            relief->bump = textures_index(&s, t);
        if (i % 7)
            relief->normal_map = textures_index(&s, t);
        add(&s, m, (enum kind)(i % KINDS));
        if (i % KINDS == MESH && i & 2) /* no directions */
            s.scene.meshes[0].uvs = NULL;
        const struct stage *stage = scenes_stage(&s);
        for (int k = 0; k < 50; k++) {
            const vec3 from = 3 * soup_direction(&d), aim = soup_point(&d, 0.9);
            const struct met a = meet(stage, from, aim, k % 2 ? (float)pow(10, k % 10 - 5) : 0);
            hits += a.hit;
            bad += a.hit && !is_fit(&a.v, vec3_unit(aim - from));
        }
        scenes_release(&s);
    }
    ok(hits > 5000 && !bad, "any image gives normals that are fit for use (%d of %d do not)", bad,
       hits);
}

static void test_without_uv(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    const uint32_t m = scenes_diffuse(&s, rgb_gray(1));
    textures_relief(&s, m)->normal_map =
        textures_index(&s, textures_normal(&s, vec3_unit(vec3_make(1, 0, 1))));
    add_mesh(&s, m);
    s.scene.meshes[0].uvs = NULL;
    const struct met a =
        meet(scenes_stage(&s), vec3_make(0.3f, 0.1f, 3), vec3_make(0.3f, 0.1f, 0), 0);
    ok(a.hit && vec3_length(a.v.frame.z - a.v.at.ng) == 0,
       "a mesh without uv is as flat as without a map");
    scenes_release(&s);
}

int main(void)
{
    for (int kind = 0; kind < KINDS; kind++) {
        test_map((enum kind)kind);
        test_bump((enum kind)kind, true);
        test_bump((enum kind)kind, false);
    }
    test_light();
    test_width();
    test_anything();
    test_without_uv();
    return tap_done();
}
