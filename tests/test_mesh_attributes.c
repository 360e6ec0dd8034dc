/* What vertices have beside their place: the same whether it stands in a document, a PLY file or an
 * OBJ file; what is refused; and normals made of the triangles'. SPDX-License-Identifier: MIT */
#include "common/mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/buf.h"
#include "common/trace/bvh.h"
#include "common/trace/prep_plan.h"
#include "common/trace/surface_detail.h"
#include "tests/soup.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

static struct arena arena;

static bool read_text(struct mesh *mesh, enum mesh_format format, const char *text)
{
    struct err err;
    *mesh = (struct mesh){.format = format};
    const size_t bytes = strlen(text);
    char *exact = malloc(bytes + 1); /* so that the sanitizer sees a byte too far */
    memcpy(exact, text, bytes + 1);
    const bool good = mesh_read(mesh, exact, bytes, &arena, &err);
    if (!good)
        diag("%s", err.text);
    free(exact);
    return good;
}

static bool parse(struct scene *scene, const char *keys)
{
    struct scene_errors errors = {0};
    const char *json = arena_printf(
        &arena,
        "{\"smalti\": 1, \"film\": {\"width\": 1, \"height\": 1}, \"camera\": {\"type\": "
        "\"panoramic\", \"look_at\": {\"from\": [0, 0, 1], \"to\": [0, 0, 0]}}, \"materials\": "
        "{\"m\": {\"type\": \"mirror\"}}, \"shapes\": [{\"type\": \"mesh\", \"material\": \"m\", "
        "%s}]}",
        keys);
    const bool good = scene_parse(scene, json, strlen(json), SCENE_FROM_DISK, &arena, &errors);
    for (size_t i = 0; i < errors.count; i++)
        diag("%s: %s", errors.list[i].where, errors.list[i].what);
    return good;
}

static bool read_inline(struct mesh *mesh, const char *keys)
{
    struct scene scene;
    if (!parse(&scene, keys))
        return false;
    *mesh = scene.meshes[0];
    return true;
}

/* --- the same from everywhere --- */

static bool same_floats(const float *a, const float *b, size_t count)
{
    return a == b || (a && b && !memcmp(a, b, count * sizeof *a));
}

static bool same_mesh(const struct mesh *a, const struct mesh *b)
{
    const size_t n = a->vertex_count;
    return n == b->vertex_count && a->triangle_count == b->triangle_count &&
           !memcmp(a->indices, b->indices, 12 * (size_t)a->triangle_count) &&
           same_floats(a->vertices, b->vertices, 3 * n) &&
           same_floats(a->normals, b->normals, 3 * n) && same_floats(a->uvs, b->uvs, 2 * n) &&
           same_floats(a->colors, b->colors, 3 * n);
}

#define PLY_HEAD(numbers)                                                                          \
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float " \
    "z\n" numbers "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
#define PLY_NORMAL      "property float nx\nproperty float ny\nproperty float nz\n"
#define PLY_COLOR(type) "property " type " red\nproperty " type " green\nproperty " type " blue\n"

static void test_same(void)
{
    struct mesh document, ply, obj;
    const bool read =
        read_inline(&document,
                    "\"vertices\": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], \"triangles\": [[0, 1, 2]], "
                    "\"normals\": [[0, 0, 5], [0.3, 0, 0.4], [0, 0, 0]], \"uvs\": [[0, 0], [2, "
                    "-0.5], [0.25, 1]]") &&
        read_text(&ply, MESH_PLY,
                  PLY_HEAD(PLY_NORMAL "property float s\nproperty double t\n") "0 0 0 0 0 1 0 0\n"
                                                                               "1 0 0 3 0 4 2 -.5\n"
                                                                               "0 1 0 0 0 0 .25 "
                                                                               "1\n3 0 1 2\n") &&
        read_text(&obj, MESH_OBJ,
                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 2 -.5 9\nvt 0\nvt .25 1\nvn 0 0 7\nvn 3e5 0 "
                  "4e5\nvn 0 0 0\nf 1/2/1 2/1/2 3/-1/-1\n");
    ok(read && same_mesh(&document, &ply) && same_mesh(&document, &obj) && document.normals,
       "normals and uvs are the same from a document, PLY and OBJ");
    ok(read && document.normals[2] == 1 && document.normals[3] == 0.6f &&
           document.normals[5] == 0.8f && document.normals[8] == 0,
       "normals are made unit; 0, 0, 0 stays");
}

static void test_colors(void)
{
    struct mesh linear, bytes, words, obj;
    const bool read =
        read_inline(&linear,
                    "\"vertices\": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], \"triangles\": [[0, 1, 2]], "
                    "\"colors\": [[1, 0, 0.5], [7, 8, 9], [0, 0, 0]]") &&
        read_text(&bytes, MESH_PLY,
                  PLY_HEAD(PLY_COLOR("uchar")) "0 0 0 255 0 188\n1 0 0 1 2 3\n0 1 0 0 0 0\n3 0 1 "
                                               "2\n") &&
        read_text(&words, MESH_PLY,
                  PLY_HEAD(PLY_COLOR("ushort")) "0 0 0 65535 0 48316\n1 0 0 257 514 771\n0 1 0 0 0 "
                                                "0\n3 0 1 2\n") &&
        read_text(&obj, MESH_OBJ,
                  "v 0 0 0\nv 1 0 0 0.00392156862745098 .00784313725490196 "
                  ".0117647058823529\nv 0 1 0 # 1 2 3\nf 1 2 3\n");
    ok(read && linear.colors[2] == 0.5f && linear.colors[5] == 9, "floats are linear");
    /* (188 / 255 + .055) / 1.055 to the power of 2.4 by a calculator: .50289 */
    ok(read && bytes.colors[0] == 1 && bytes.colors[1] == 0 &&
           fabsf(bytes.colors[2] - 0.502886f) < 1e-5f &&
           fabsf(bytes.colors[3] - 1 / (255 * 12.92f)) < 1e-9f,
       "bytes are sRGB");
    ok(read && same_floats(bytes.colors, words.colors, 9), "and so are numbers of 16 bits");
    ok(read && same_floats(bytes.colors + 3, obj.colors + 3, 3) && obj.colors[0] == 1 &&
           obj.colors[8] == 1,
       "and OBJ's; vertices without are white");
}

/* --- corners with numbers of their own --- */

static void test_split(void)
{
    struct mesh mesh, plain;
    /* A square of two triangles, its diagonal 1-3 a seam of uvs, with another normal at one end. */
    const char *seam =
        "v 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nvt 0 0\nvt 1 0\nvt 1 "
        "1\nvt .5 .5\nvn 0 0 1\nvn 0 1 0\nf 1/1/1 2/2/1 3/3/1\nf 1/4/2 3/4/1 4/3/1\n";
    const bool read = read_text(&mesh, MESH_OBJ, seam) &&
                      read_text(&plain, MESH_OBJ,
                                "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nvt 0 "
                                "0\nvn 0 0 1\nf 1 2 3\nf 1 3 4\n");
    static const uint32_t want[] = {0, 1, 2, 5, 6, 3};
    ok(read && mesh.vertex_count == 7 && !memcmp(mesh.indices, want, sizeof want) &&
           same_floats(mesh.vertices, mesh.vertices + 15, 3) &&
           same_floats(mesh.vertices + 6, mesh.vertices + 18, 3) &&
           same_floats(mesh.colors, mesh.colors + 15, 3) && mesh.colors[3] == 1,
       "a vertex of two choices becomes two, the second behind all others, with place and colour");
    ok(read && mesh.uvs[0] == 0 && mesh.uvs[10] == 0.5f && mesh.uvs[12] == 0.5f &&
           mesh.uvs[4] == 1 && mesh.normals[15 + 1] == 1 && mesh.normals[18 + 2] == 1 &&
           mesh.uvs[8] == 0,
       "each has what its corners name; what no corner names is 0");
    ok(read && !plain.uvs && !plain.normals && !plain.colors && plain.vertex_count == 5 &&
           !memcmp(plain.indices, (const uint32_t[]){0, 1, 2, 0, 2, 3}, 24),
       "what no face names is not there");
    const bool mixed = read_text(
        &mesh, MESH_OBJ, "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nf 1 2 3\nf 1//1 2//1 3//1\n");
    ok(mixed && mesh.vertex_count == 6 && mesh.normals && !mesh.uvs &&
           mesh.normals[3 * mesh.indices[3] + 2] == 1 && mesh.normals[3 * mesh.indices[0] + 2] == 0,
       "faces before the first that names one have none");
}

/* Random faces: each corner finds what it has named. */
static void test_any_corners(void)
{
    enum { VERTICES = 50, FACES = 400 };
    struct dice d = dice_make(1);
    struct buf text = {0};
    char line[128];
    uint32_t number[FACES][3][3];
    for (int i = 0; i < VERTICES; i++) {
        const int n = snprintf(line, sizeof line, "v %d 0 0\nvt %d\nvn 1 %d 0\n", i, i, i);
        buf_append(&text, line, (size_t)n);
    }
    for (int i = 0; i < FACES; i++) {
        buf_append(&text, "f", 1);
        for (int k = 0; k < 3; k++) {
            for (int j = 0; j < 3; j++)
                number[i][k][j] = dice_bits(&d) % (j ? 3 : VERTICES) + 1;
            const int n = snprintf(line, sizeof line, " %u/%u/%u", number[i][k][0], number[i][k][1],
                                   number[i][k][2]);
            buf_append(&text, line, (size_t)n);
        }
        buf_append(&text, "\n", 1);
    }
    buf_append(&text, "", 1);
    struct mesh mesh;
    bool good = read_text(&mesh, MESH_OBJ, (const char *)text.data);
    for (size_t i = 0; good && i < FACES; i++)
        for (size_t k = 0; k < 3; k++) {
            const uint32_t v = mesh.indices[3 * i + k];
            const float y = (float)number[i][k][2] - 1, length = sqrtf(1 + y * y);
            good &= mesh.vertices[3 * v] == (float)number[i][k][0] - 1 &&
                    mesh.uvs[2 * v] == (float)number[i][k][1] - 1 &&
                    fabsf(mesh.normals[3 * v + 1] - y / length) < 1e-6f;
        }
    ok(good && mesh.vertex_count > VERTICES && mesh.vertex_count <= 9 * VERTICES,
       "every corner has what it names, from %u vertices", good ? mesh.vertex_count : 0);
    buf_release(&text);
}

/* --- what is refused --- */

static void refuses(enum mesh_format format, const char *text, const char *want)
{
    struct err err;
    struct mesh mesh = {.format = format};
    const bool good = mesh_read(&mesh, text, strlen(text), &arena, &err);
    if (!ok(!good && err.code == ERR_INPUT && !strcmp(err.text, want), "refused: %s", want))
        diag("got: %s", good ? "a mesh" : err.text);
}

#define V3 "v 0 0 0\nv 1 0 0\nv 0 1 0\n"

static void test_refused(void)
{
    refuses(MESH_OBJ, V3 "vn 0 0\n", "line 4: normal 1: expected 3 coordinates, got 2");
    refuses(MESH_OBJ, V3 "vn 0 0 nan\n", "line 4: normal 1: expected a number, got \"nan\"");
    refuses(MESH_OBJ, V3 "vn 0 0 1e999\n",
            "line 4: normal 1: expected a normal within [-1e18, 1e18], got inf");
    refuses(MESH_OBJ, V3 "vt # 1\n",
            "line 4: texture coordinate 1: expected 1 texture coordinates, got 0");
    refuses(MESH_OBJ, V3 "vt 0 1e7\n",
            "line 4: texture coordinate 1: expected texture coordinates in [-1e6, 1e6], got 1e+07");
    refuses(MESH_OBJ, V3 "v 0 0 0 .1 .2 255\n",
            "line 4: vertex 4: expected colors in [0, 1], got 255");
    refuses(MESH_OBJ, V3 "v 0 0 0 .1 .2 red\n", "line 4: vertex 4: expected a number, got \"red\"");
    refuses(MESH_OBJ, V3 "vt 0 0\nf 1/1 2/1 3/2\n",
            "line 5: expected a texture coordinate from 1 to 1 or -1 to -1, got 2");
    refuses(MESH_OBJ, V3 "vn 0 0 1\nf 1//1 2//1 3//-2\n",
            "line 5: expected a normal from 1 to 1 or -1 to -1, got -2");
    refuses(MESH_OBJ, V3 "vn 0 0 1\nf 1//1 2//1 3//0\n",
            "line 5: expected a normal from 1 to 1 or -1 to -1, got 0");
    refuses(MESH_OBJ, V3 "f 1/1 2/1 3/1\n",
            "line 4: expected a texture coordinate from 1 to 0 or -0 to -1, got 1");
    refuses(MESH_PLY, PLY_HEAD("property float nx\nproperty float ny\n") "0",
            "line 11: expected nx, ny and nz once each, or none of them");
    refuses(MESH_PLY, PLY_HEAD("property float s\nproperty float t\nproperty float u\n") "0",
            "line 12: expected one pair of texture coordinates (s and t, u and v, texture_u and "
            "texture_v, texture_s and texture_t), or none");
    refuses(MESH_PLY, PLY_HEAD("property uchar red\n") "0",
            "line 10: expected red, green and blue once each, or none of them");
    refuses(MESH_PLY, PLY_HEAD(PLY_COLOR("int")) "0",
            "line 12: expected red, green and blue of one type: uchar, ushort, float or double");
    refuses(MESH_PLY,
            PLY_HEAD("property uchar red\nproperty uchar green\nproperty float blue\n") "0",
            "line 12: expected red, green and blue of one type: uchar, ushort, float or double");
    refuses(MESH_PLY, PLY_HEAD(PLY_COLOR("uchar")) "0 0 0 0 0 256\n1 0 0 0 0 0\n0 1 0 0 0 0\n",
            "line 13: vertex 0: expected colors in [0, 255], got 256");
    refuses(MESH_PLY, PLY_HEAD(PLY_COLOR("float")) "0 0 0 0 0 -1\n1 0 0 0 0 0\n0 1 0 0 0 0\n",
            "line 13: vertex 0: expected colors in [0, 1e+18], got -1");
}

static void test_not_a_number(void)
{
    static const char *const kinds[] = {"nx", "s", "red"};
    static const char *const want[] = {"expected a normal within",
                                       "expected texture coordinates in", "expected colors in"};
    for (size_t i = 0; i < countof(kinds); i++) {
        struct buf b = {0};
        const char *head = arena_printf(
            &arena,
            "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty "
            "float y\nproperty float z\nproperty float %s\nproperty float %s\n%s%s"
            "element face 0\nproperty list uchar int vertex_indices\nend_header\n",
            kinds[i],
            i == 0   ? "ny"
            : i == 1 ? "t"
                     : "green",
            i == 1 ? "" : "property float ",
            i == 0   ? "nz\n"
            : i == 1 ? ""
                     : "blue\n");
        const float row[] = {0, 0, 0, 0, NAN, 0};
        buf_append(&b, head, strlen(head));
        buf_append(&b, row, i == 1 ? 20 : 24);
        struct mesh mesh = {.format = MESH_PLY};
        struct err err;
        ok(!mesh_read(&mesh, b.data, b.size, &arena, &err) && strstr(err.text, "vertex 0: ") &&
               strstr(err.text, want[i]),
           "not a number is refused with its vertex: %s", err.text);
        buf_release(&b);
    }
}

/* --- smooth normals --- */

static vec3 smooth_at(const float *normals, uint32_t vertex)
{
    return vec3_load(normals + 3 * (size_t)vertex);
}

/* A cube whose faces are cut along any diagonal, its vertices one for all faces or one for each. */
static void test_cube(bool apart)
{
    struct dice d = dice_make(apart);
    double worst = 0;
    for (int round = 0; round < 64; round++) {
        struct scenes s;
        scenes_init(&s, 1, 1);
        const struct scenes_mesh m = scenes_mesh(&s, scenes_mirror(&s, rgb_gray(1)), 24, 12);
        for (uint32_t face = 0; face < 6; face++) {
            const int k = (int)face / 2;
            const float side = face % 2 ? 1 : -1;
            uint32_t number[4];
            for (uint32_t v = 0; v < 4; v++) {
                float *p = m.vertices[4 * face + v];
                p[k] = side;
                p[(k + 1) % 3] = v == 1 || v == 2 ? 1 : -1;
                p[(k + 2) % 3] = v >= 2 ? side : -side;
                number[v] = 4 * face + v;
                for (uint32_t w = 0; !apart && w < 4 * face; w++)
                    if (!memcmp(m.vertices[w], p, sizeof m.vertices[w]))
                        number[v] = w < number[v] ? w : number[v];
            }
            const uint32_t turn = dice_bits(&d) % 4;
            for (uint32_t t = 0; t < 2; t++)
                for (uint32_t c = 0; c < 3; c++)
                    m.triangles[2 * face + t][c] = number[((c ? t + c : 0) + turn) % 4];
        }
        const struct mesh *mesh = &s.scene.meshes[m.shape->mesh.mesh];
        const float *normals = prep_smooth_make(mesh, &s.arena);
        for (uint32_t i = 0; i < 36; i++) {
            const uint32_t v = mesh->indices[i];
            const vec3 want = vec3_unit(vec3_load(m.vertices[v]));
            worst = fmax(worst, (double)vec3_length(smooth_at(normals, v) - want));
        }
        scenes_release(&s);
    }
    ok(worst < 1e-6,
       "a cube's corners have normals along its diagonals, however it is cut, %s (%.1g)",
       apart ? "each face with vertices of its own" : "its faces sharing their vertices", worst);
}

static void test_ball(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    scenes_ball(&s, scenes_mirror(&s, rgb_gray(1)), vec3_make(0, 0, 0), 1, 32, 0, false);
    const struct mesh *mesh = &s.scene.meshes[0];
    const float *normals = prep_smooth_make(mesh, &s.arena);
    double worst = 0, length = 0;
    for (uint32_t i = 0; i < 3 * mesh->triangle_count; i++) {
        const vec3 n = smooth_at(normals, mesh->indices[i]);
        const vec3 p = vec3_load(mesh->vertices + 3 * (size_t)mesh->indices[i]);
        worst = fmax(worst, (double)vec3_length(n - vec3_unit(p)));
        length = fmax(length, fabs((double)vec3_length(n) - 1));
    }
    ok(worst < 0.01 && length < 1e-6, "a ball's smooth normals are the sphere's, within %.2g",
       worst);
    scenes_release(&s);
}

/* A sheet of two triangles back to back, one that has no area, and one alone, from 1e-17 to 1e17.
 */
static void test_cancel(void)
{
    for (int power = -17; power <= 17; power += 17) {
        struct scenes s;
        scenes_init(&s, 1, 1);
        const float size = (float)pow(10, power);
        const struct scenes_mesh m = scenes_mesh(&s, scenes_mirror(&s, rgb_gray(1)), 9, 4);
        static const uint32_t corners[4][3] = {{0, 1, 2}, {0, 2, 1}, {3, 4, 5}, {6, 7, 8}};
        memcpy(m.triangles, corners, sizeof corners);
        for (uint32_t i = 0; i < 9; i++) {
            const float x = i % 3 == 1 ? size : 0, y = i % 3 == 2 && i != 5 ? size : 0;
            vec3_store(m.vertices[i], vec3_make(x + (float)(i / 3) * 4 * size, y, 0));
        }
        const float *n = prep_smooth_make(&s.scene.meshes[0], &s.arena);
        bool none = true, up = true;
        for (uint32_t i = 0; i < 9; i++)
            if (i < 6)
                none &= rgb_is_black(smooth_at(n, i));
            else
                up &= vec3_length(smooth_at(n, i) - vec3_make(0, 0, 1)) == 0;
        ok(none && up, "size 1e%d: where normals cancel, and without an area, there is none",
           power);
        scenes_release(&s);
    }
}

/* --- whose normals a shape has --- */

/* Four uses of one mesh: with its own normals, flat, smooth, smooth and mirrored; as instances or
 * as meshes of their own. */
static const struct stage *make_uses(struct scenes *s, bool copies, uint32_t rings)
{
    scenes_init(s, 1, 1);
    const uint32_t material = scenes_mirror(s, rgb_gray(1));
    const struct shape first = *scenes_ball(s, material, vec3_make(0, 0, 0), 1, rings, 0.1f, false);
    struct mesh *mesh = &s->scene.meshes[0];
    float *given = arena_new(&s->arena, float, 3 * (size_t)mesh->vertex_count);
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        vec3_store(given + 3 * (size_t)i, vec3_unit(vec3_load(mesh->vertices + 3 * (size_t)i)));
    mesh->normals = given;
    static const enum mesh_normals normals[] = {MESH_NORMALS_GIVEN, MESH_NORMALS_FLAT,
                                                MESH_NORMALS_SMOOTH, MESH_NORMALS_SMOOTH};
    for (uint32_t i = 0; i < countof(normals); i++) {
        struct shape *use = &s->scene.shapes[i];
        *use = first;
        use->mesh.mesh = copies ? i : 0;
        use->mesh.normals = normals[i];
        use->to_world.m[0][3] = 3 * (float)i;
        use->to_world.m[2][2] = i == 3 ? -0.5f : 1;
        s->scene.meshes[use->mesh.mesh] = *mesh;
    }
    s->scene.shape_count = countof(normals);
    s->scene.mesh_count = copies ? countof(normals) : 1;
    return scenes_stage(s);
}

static bool shading_normal(const struct stage *s, vec3 from, vec3 dir, vec3 *ns, bool *has_detail)
{
    const struct ray ray = {from, dir, INFINITY, 0, 0};
    struct ray_hit hit;
    if (!bvh_hit_closest(s, &ray, &hit))
        return false;
    const struct surface at = surface_at(s, &ray, &hit);
    const struct stage_detail *d = surface_detail_of(s, hit.prim, hit.instance);
    *has_detail = d != NULL;
    *ns = d ? surface_detail_at(s, d, &hit, &at).ns : at.ng;
    return true;
}

static void test_words(void)
{
#define INLINE "\"vertices\": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], \"triangles\": [[0, 1, 2]]"
    static const struct {
        const char *keys;
        enum mesh_normals normals;
        bool given;
    } rows[] = {
        {INLINE, MESH_NORMALS_GIVEN, false},
        {INLINE ", \"normals\": [[0, 0, 1], [0, 0, 1], [1, 0, 0]]", MESH_NORMALS_GIVEN, true},
        {INLINE ", \"normals\": \"flat\"", MESH_NORMALS_FLAT, false},
        {INLINE ", \"normals\": \"smooth\"", MESH_NORMALS_SMOOTH, false},
        {"\"file\": \"a.ply\"", MESH_NORMALS_GIVEN, false},
        {"\"file\": \"a.ply\", \"normals\": \"file\"", MESH_NORMALS_GIVEN, false},
        {"\"file\": \"a.ply\", \"normals\": \"flat\"", MESH_NORMALS_FLAT, false},
        {"\"file\": \"a.obj\", \"normals\": \"smooth\"", MESH_NORMALS_SMOOTH, false},
    };
    int wrong = 0;
    for (size_t i = 0; i < countof(rows); i++) {
        struct scene scene;
        wrong += !parse(&scene, rows[i].keys) || scene.shapes[0].mesh.normals != rows[i].normals ||
                 !scene.meshes[0].normals == rows[i].given;
    }
    ok(wrong == 0, "documents say whose normals a mesh has");
}

static void test_uses(void)
{
    struct scenes s[2];
    const struct stage *shared = make_uses(&s[0], false, 256),
                       *copies = make_uses(&s[1], true, 256);
    struct dice d = dice_make(3);
    int hits[4] = {0}, wrong = 0, flat = 0;
    for (int i = 0; i < 20000; i++) {
        const uint32_t use = dice_bits(&d) % 4;
        const vec3 center = vec3_make(3 * (float)use, 0, 0);
        const vec3 from = center + 1.3f * vec3_unit(soup_direction(&d));
        vec3 a = {0}, b = {0};
        bool has[2] = {false, false};
        if (!shading_normal(shared, from, center - from, &a, &has[0]) ||
            !shading_normal(copies, from, center - from, &b, &has[1]))
            continue;
        hits[use]++;
        wrong += vec3_length(a - b) != 0 || has[0] != has[1];
        flat += !has[0] != (use == 1);
    }
    ok(shared->instances.count == 4 && copies->instances.count == 0 && wrong == 0 &&
           hits[0] > 4000 && hits[3] > 2000,
       "one mesh with its own normals, flat and smooth: instances are shaded like copies (%d not)",
       wrong);
    ok(flat == 0, "and only the flat one has no normals of its own");
    scenes_release(&s[0]);
    scenes_release(&s[1]);
}

int main(void)
{
    test_same();
    test_colors();
    test_split();
    test_any_corners();
    test_refused();
    test_not_a_number();
    test_cube(false);
    test_cube(true);
    test_ball();
    test_cancel();
    test_words();
    test_uses();
    arena_release(&arena);
    return tap_done();
}
