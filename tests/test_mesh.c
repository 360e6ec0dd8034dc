/* mesh*.c: PLY in its three encodings and OBJ, what they may contain, and what is refused.
 * SPDX-License-Identifier: MIT */
#include "common/mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/buf.h"
#include "common/mesh_build.h"
#include "tests/tap.h"

static struct arena arena;
static struct mesh mesh;
static struct err err;

static bool read_as(enum mesh_format format, const void *data, size_t bytes)
{
    mesh = (struct mesh){.format = format};
    void *exact = malloc(bytes ? bytes : 1); /* so that the sanitizer sees a byte too far */
    memcpy(exact, data, bytes);
    const bool good = mesh_read(&mesh, exact, bytes, &arena, &err);
    free(exact);
    return good;
}

static bool obj(const char *text)
{
    const bool good = read_as(MESH_OBJ, text, strlen(text));
    if (!good)
        diag("%s", err.text);
    return good;
}

static bool ply(const char *text)
{
    const bool good = read_as(MESH_PLY, text, strlen(text));
    if (!good)
        diag("%s", err.text);
    return good;
}

static bool triangles(const char *want)
{
    char got[512] = "";
    size_t n = 0;
    for (uint32_t i = 0; i < mesh.triangle_count && n < sizeof got - 40; i++)
        n +=
            (size_t)snprintf(got + n, sizeof got - n, "%s%u %u %u", i ? ", " : "",
                             mesh.indices[3 * i], mesh.indices[3 * i + 1], mesh.indices[3 * i + 2]);
    if (strcmp(got, want))
        diag("got %s", got);
    return !strcmp(got, want);
}

static bool vertex(uint32_t i, double x, double y, double z)
{
    const float *v = mesh.vertices + (size_t)3 * i;
    return i < mesh.vertex_count && v[0] == (float)x && v[1] == (float)y && v[2] == (float)z;
}

static void refuses(enum mesh_format format, const char *text, const char *want)
{
    const bool good = read_as(format, text, strlen(text));
    if (!ok(!good && err.code == ERR_INPUT && !strcmp(err.text, want), "refused: %s", want))
        diag("got: %s", good ? "a mesh" : err.text);
}

#define V3 "v 0 0 0\nv 1 0 0\nv 0 1 0\n"

static void obj_reads(void)
{
    ok(obj(V3 "f 1 2 3\n") && triangles("0 1 2") && vertex(1, 1, 0, 0), "a triangle");
    ok(obj(V3 "v 1 1 0\nv 2 2 2\nf 1 2 3 4 5\n") && triangles("0 1 2, 0 2 3, 0 3 4"),
       "a polygon becomes a fan");
    ok(obj(V3 "f -3 -2 -1\nv 5 5 5\nf -4 -1 2\n") && triangles("0 1 2, 0 3 1"),
       "negative indices count back from the last vertex so far");
    ok(obj(V3 "vt 0 0\nvn 0 0 1\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf 1/1/1 2/1/-1 3/-1/1\n") &&
           triangles("3 5 7, 4 6 8, 0 1 2") && mesh.vertex_count == 9,
       "corners may name texture coordinates and normals, or not");
    ok(obj("# a comment \\\n\r\nmtllib a b.mtl\r\no thing\r\nv 0 0 0\r\nv 1 0 0 # x\r\nv 0 1 0 1.0 "
           "0.5 0.5 0.5\r\ng\r\ns off\r\nusemtl red\r\n\tf  1   2 3 # first\r\nl 1 2\r\np 1\r\n") &&
           triangles("0 1 2"),
       "comments, groups, lines' ends of either kind, no group, colors, tabs");
    ok(obj(V3 "f 1 \\\n2 \\\r\n3\nf 3\\\n 2 1") && triangles("0 1 2, 2 1 0"),
       "lines continue behind a backslash; the last needs no end");
    ok(obj("\xef\xbb\xbfv -.5 +2. 3e0\nv 1E-3 1e+3 1e-45\nv 0.1 123456789012345678901234567890e-20 "
           "00012\nfo 1 2 3\n") &&
           vertex(0, -.5, 2, 3) && vertex(1, 1e-3, 1e3, 0x1p-149) &&
           vertex(2, .1, 1234567890.123456789, 12),
       "numbers in all their spellings");
}

static void obj_refuses(void)
{
    refuses(MESH_OBJ, "", "expected a mesh with at least 1 face, got 0 vertices and no face");
    refuses(MESH_OBJ, V3, "expected a mesh with at least 1 face, got 3 vertices and no face");
    refuses(MESH_OBJ, V3 "f 1 2 4\n", "line 4: expected a vertex from 1 to 3 or -3 to -1, got 4");
    refuses(MESH_OBJ, V3 "f 1 2 0\n", "line 4: expected a vertex from 1 to 3 or -3 to -1, got 0");
    refuses(MESH_OBJ, V3 "f 1 2 -4\n", "line 4: expected a vertex from 1 to 3 or -3 to -1, got -4");
    refuses(MESH_OBJ, V3 "f 1 2 99999999999999999999\n",
            "line 4: expected a corner like 7, 7/1, 7//3 or 7/1/3, got \"99999999999999999999\"");
    refuses(MESH_OBJ, V3 "f 1 2 3/1/1/1\n",
            "line 4: expected a corner like 7, 7/1, 7//3 or 7/1/3, got \"3/1/1/1\"");
    refuses(MESH_OBJ, V3 "f 1 2 1.5\n",
            "line 4: expected a corner like 7, 7/1, 7//3 or 7/1/3, got \"1.5\"");
    refuses(MESH_OBJ, V3 "f 1 2\n", "line 4: expected a face of at least 3 corners, got 2");
    refuses(MESH_OBJ, "v 0 0\n", "line 1: expected 3 coordinates, got 2");
    refuses(MESH_OBJ, "\n\nv 0 nan 0\n", "line 3: expected a number, got \"nan\"");
    refuses(MESH_OBJ, "v 0 0 inf\n", "line 1: expected a number, got \"inf\"");
    refuses(MESH_OBJ, "v 0 0 0x1p3\n", "line 1: expected a number, got \"0x1p3\"");
    refuses(MESH_OBJ, "v 0 0 1e\n", "line 1: expected a number, got \"1e\"");
    refuses(MESH_OBJ, "v 0 0 .\n", "line 1: expected a number, got \".\"");
    refuses(MESH_OBJ, V3 "v 0 1e999 0\n",
            "line 4: vertex 4: expected coordinates in [-1e18, 1e18], got inf");
    refuses(MESH_OBJ, V3 "v 0 -1e19 0\n",
            "line 4: vertex 4: expected coordinates in [-1e18, 1e18], got -1e+19");
    refuses(MESH_OBJ, V3 "f 1 \\\n2 \\\n3\nsurf 0 1 0 1\n",
            "line 7: expected an OBJ statement for polygons (v, f, vt, vn, g, o, s, usemtl, mtllib "
            "...), got \"surf\"");
    refuses(MESH_OBJ,
            "\x7f"
            "ELF\x02\x01 a",
            "line 1: expected an OBJ statement for polygons (v, f, vt, vn, g, o, s, usemtl, mtllib "
            "...), got \"?ELF??\"");
}

#define XYZ     "property float x\nproperty float y\nproperty float z\n"
#define HEAD3   "ply\nformat ascii 1.0\nelement vertex 3\n" XYZ
#define FACE(n) "element face " #n "\nproperty list uchar int vertex_indices\nend_header\n"
#define ROWS3   "0 0 0\n1 0 0\n0 1 0\n"

static void ply_reads(void)
{
    ok(ply(HEAD3 FACE(1) ROWS3 "3 0 1 2\n") && triangles("0 1 2") && vertex(2, 0, 1, 0),
       "a triangle");
    ok(ply("ply\r\nformat ascii 1.0\r\ncomment made by \r\nobj_info x\r\nelement vertex 4\r\n"
           "property uchar confidence\r\nproperty double z\r\nproperty list uchar float "
           "uv\r\nproperty "
           "float32 x\r\nproperty int y\r\nelement edge 1\r\nproperty int a\r\nelement face "
           "2\r\nproperty list uint8 uint32 vertex_index\r\nproperty int flags\r\nend_header\r\n"
           "255 3 2 .5 .5 1 2\r\n0 0 0 0 0\r\n0 0 1 .1 1 0\r\n0 0 0 0 1\r\n\r\n7\r\n4 0 1 2 3 9\r\n"
           "3 3 2 1 9") &&
           triangles("0 1 2, 0 2 3, 3 2 1") && vertex(0, 1, 2, 3),
       "other properties and elements are stepped over; either kind of line's end");
    ok(ply(HEAD3 "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" ROWS3
                 "11 0 1 2 0 -1 2 1 0 0 -1 1\n") &&
           triangles("0 1 2, 2 1 0, 2 1 0"),
       "strips turn every other triangle and drop those that join");
}

static void put(struct buf *b, const void *p, size_t size, bool big)
{
    const unsigned char *bytes = p;
    for (size_t i = 0; i < size; i++)
        buf_append(b, bytes + (big ? size - 1 - i : i), 1); /* this machine is little-endian */
}

static struct buf binary_mesh(bool big)
{
    struct buf b = {0};
    const char *head = "\nelement vertex 3\nproperty double x\nproperty float y\nproperty short z\n"
                       "property char c\nelement face 2\nproperty list ushort uint vertex_indices\n"
                       "property list char double more\nend_header\n";
    const char *format = big ? "ply\nformat binary_big_endian 1.0"
                             : "ply\nformat "
                               "binary_little_endian 1.0";
    buf_append(&b, format, strlen(format));
    buf_append(&b, head, strlen(head));
    for (int i = 0; i < 3; i++) {
        const double x = i + .25;
        const float y = -(float)i;
        const int16_t z = (int16_t)(-300 * i);
        put(&b, &x, sizeof x, big);
        put(&b, &y, sizeof y, big);
        put(&b, &z, sizeof z, big);
        put(&b, "\n", 1, big);
    }
    for (uint32_t i = 0; i < 2; i++) {
        const uint16_t count = 3;
        const double more = 1e300;
        put(&b, &count, sizeof count, big);
        for (uint32_t k = 0; k < 3; k++)
            put(&b, &(uint32_t){i ? 2 - k : k}, 4, big);
        put(&b, i ? "\1" : "\0", 1, big);
        if (i)
            put(&b, &more, sizeof more, big);
    }
    return b;
}

static void ply_binary(void)
{
    for (int big = 0; big < 2; big++) {
        struct buf b = binary_mesh(big);
        ok(read_as(MESH_PLY, b.data, b.size) && triangles("0 1 2, 2 1 0") && vertex(0, .25, 0, 0) &&
               vertex(2, 2.25, -2, -600),
           "binary, %s-endian", big ? "big" : "little");
        size_t accepted = 0;
        for (size_t n = 0; n < b.size; n++)
            accepted += read_as(MESH_PLY, b.data, n);
        ok(accepted == 0, "cut at any of its bytes it is refused");
        buf_release(&b);
    }
    struct buf b = binary_mesh(false);
    const uint32_t bad = 3;
    memcpy(b.data + b.size - 13, &bad, sizeof bad);
    char want[128]; /* the last row is a count, three indices, a count, a double */
    snprintf(want, sizeof want, "byte %zu: face 1: expected a vertex from 0 to 2, got 3",
             b.size - (2 + 12 + 1 + 8));
    ok(!read_as(MESH_PLY, b.data, b.size) && !strcmp(err.text, want),
       "an index out of range is refused at its row: %s", err.text);
    const double not_finite = (double)NAN;
    const char *rows = strstr((const char *)b.data, "end_header\n") + 11;
    memcpy(b.data + (rows - (const char *)b.data), &not_finite, sizeof not_finite);
    ok(!read_as(MESH_PLY, b.data, b.size) && strstr(err.text, "vertex 0: expected coordinates in "
                                                              "[-1e18, 1e18], got"),
       "so is a coordinate that is none: %s", err.text);
    buf_release(&b);
}

static void ply_refuses(void)
{
    const enum mesh_format f = MESH_PLY;
    refuses(f, "", "line 1: expected the word \"ply\", this is no PLY file");
    refuses(f, "plyx\n", "line 1: expected the word \"ply\", this is no PLY file");
    refuses(f, "ply\nformat ascii 1.0\n", "line 2: expected end_header before the file ends");
    refuses(f, "ply\nend_header\n", "line 2: expected a line \"format ...\" in the header");
    refuses(f, "ply\nformat ascii 2.0\n", "line 2: expected PLY version 1.0, got \"2.0\"");
    refuses(f, "ply\nformat text 1.0\n",
            "line 2: expected the format ascii, binary_little_endian or binary_big_endian, got "
            "\"text\"");
    refuses(f, "ply\nformat ascii 1.0\nproperty int x\n",
            "line 3: expected an element before its properties");
    refuses(f, "ply\nformat ascii 1.0\nelement vertex -1\n",
            "line 3: expected a count, got \"-1\"");
    refuses(f, "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n",
            "line 4: expected a type (char, uchar, short, ushort, int, uint, float, double), got "
            "\"half\"");
    refuses(f, "ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int x\n",
            "line 4: expected a whole type for the count of a list");
    refuses(f,
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float "
            "y\nend_header\n0 0\n0 0\n0 0\n",
            "line 6: expected x, y and z once each among the properties of a vertex");
    refuses(f, "ply\nformat ascii 1.0\n" FACE(0), "line 5: expected the vertices before the faces");
    refuses(f, HEAD3 "element face 1\nproperty int flags\nend_header\n" ROWS3 "1\n",
            "line 9: expected one list \"vertex_indices\" or \"vertex_index\" in a face");
    refuses(f, HEAD3 "element nothing 4000000000\nend_header\n" ROWS3,
            "line 8: expected a property in every element");
    refuses(f, HEAD3 "end_header\n" ROWS3,
            "expected a mesh with at least 1 face, got 3 vertices and no face");
    refuses(f, HEAD3 FACE(1) "0 0 0\n1 0 0 0\n0 1 0\n3 0 1 2\n",
            "line 11: vertex 1: expected the end of the line, got \"0\"");
    refuses(f, HEAD3 FACE(1) "0 0 0\n1 0\n0 1 0\n3 0 1 2\n",
            "line 11: vertex 1: expected more values before the line ends");
    refuses(f, HEAD3 FACE(1) ROWS3 "3 0 1 3\n",
            "line 13: face 0: expected a vertex from 0 to 2, got 3");
    refuses(f, HEAD3 FACE(1) ROWS3 "3 0 1 -1\n",
            "line 13: face 0: expected a vertex from 0 to 2, got -1");
    refuses(f, HEAD3 FACE(1) ROWS3 "3 0 1 .5\n",
            "line 13: face 0: expected a vertex from 0 to 2, got 0.5");
    refuses(f, HEAD3 FACE(1) ROWS3 "2 0 1\n",
            "line 13: face 0: expected a face of at least 3 corners, got 2");
    refuses(f, HEAD3 FACE(1) ROWS3 "9 0 1 2\n",
            "line 13: face 0: expected a list of 0 to 3 values, got a count of 9");
    refuses(f, HEAD3 FACE(2) ROWS3 "3 0 1 2\n", "line 13: face 1: the file ends too early");
    refuses(f, HEAD3 FACE(9000000) ROWS3 "3 0 1 2\n",
            "face: expected at most 4 rows in the 8 bytes left, got 9000000");
    refuses(f, "ply\nformat binary_little_endian 1.0\nelement vertex 999999999999999\n" XYZ FACE(1),
            "vertex: expected at most 0 rows in the 0 bytes left, got 999999999999999");
}

/* Random decimals, among them the shortest and longest, read as strtod reads them. */
static void numbers(void)
{
    uint64_t state = 1;
    size_t different = 0;
    for (int i = 0; i < 200000; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        const uint32_t r = (uint32_t)(state >> 33);
        char text[64];
        const int digits = 1 + (int)(r % 20), shift = (int)(r / 20 % 640) - 320;
        snprintf(text, sizeof text, "%s%.*ge%d", r & 1 << 20 ? "-" : "", digits,
                 (double)(state >> 11) * 0x1p-40, i % 2 ? shift : shift / 16);
        char *e = strchr(text, 'e'), *last = strrchr(text, 'e');
        if (e != last) /* %g wrote an exponent of its own */
            *last = '\0';
        double got = 0;
        const bool good = mesh_span_number((struct mesh_span){text, text + strlen(text)}, &got);
        different += !good || got != strtod(text, NULL);
    }
    ok(different == 0, "200000 random decimals read as strtod reads them");
}

/* Files from elsewhere, of Debian's assimp-testmodels; the counts are their own headers' or `grep
 * -c`'s. */
static void models(void)
{
    static const struct {
        const char *path;
        enum mesh_format format;
        uint32_t vertices, triangles;
    } list[] = {{"OBJ/WusonOBJ.obj", MESH_OBJ, 2117, 3732},
                {"OBJ/spider.obj", MESH_OBJ, 974, 1368}, /* different corners of its faces */
                {"PLY/cube_binary.ply", MESH_PLY, 8, 12},
                {"PLY/cube.ply", MESH_PLY, 8, 12}};
    for (size_t i = 0; i < countof(list); i++) {
        char path[256];
        struct buf b = {0};
        snprintf(path, sizeof path, "/usr/share/assimp/models/%s", list[i].path);
        if (!buf_read_file(&b, path, 1 << 26, &err)) {
            skip("%s", err.text);
            continue;
        }
        const bool good = read_as(list[i].format, b.data, b.size);
        if (!ok(good && mesh.vertex_count == list[i].vertices &&
                    mesh.triangle_count == list[i].triangles,
                "%s has its %u vertices and %u triangles", list[i].path, list[i].vertices,
                list[i].triangles))
            diag("%s", good ? "other counts" : err.text);
        buf_release(&b);
    }
}

static void formats(void)
{
    enum mesh_format f;
    ok(mesh_format_of("a/b.ply", &f) && f == MESH_PLY && mesh_format_of(".OBJ", &f) &&
           f == MESH_OBJ && !mesh_format_of("ply", &f) && !mesh_format_of("a.ply.gz", &f),
       "formats go by the ending");
}

int main(void)
{
    formats();
    numbers();
    obj_reads();
    obj_refuses();
    ply_reads();
    ply_binary();
    ply_refuses();
    models();
    arena_release(&arena);
    return tap_done();
}
