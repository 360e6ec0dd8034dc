/* scene_disk.c: files are found beside their document, and what is wrong with them is said with its
 * place.
 * SPDX-License-Identifier: MIT */
#include "common/scene_disk.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/image_files.h"
#include "tests/tap.h"

static char dir[64];

static const char *write_file(const char *name, const char *text)
{
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", dir, name);
    FILE *f = fopen(path, "wb");
    fputs(text, f);
    fclose(f);
    return path;
}

static const char head[] =
    "{\"smalti\": 1, \"film\": {\"width\": 8, \"height\": 8}, \"camera\": {\"type\": "
    "\"perspective\", \"fov_deg\": 40, \"look_at\": {\"from\": [0, 0, 5], \"to\": [0, "
    "0, 0]}}, \"materials\": {\"m\": {\"type\": \"diffuse\", \"albedo\": [0.5, 0.5, "
    "0.5]}}, \"shapes\": [{\"type\": \"sphere\", \"material\": \"m\", \"center\": [0, "
    "0, 0], \"radius\": 1}, {\"type\": \"mesh\", \"material\": \"m\", ";
static const char triangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

static const char *scene_with(const char *mesh)
{
    char text[1024];
    snprintf(text, sizeof text, "%s%s}]}", head, mesh);
    return write_file("scene.json", text);
}

static void says(bool good, const struct scene_errors *errors, const char *where, const char *what)
{
    const bool said = !good && errors->count == 1 && !strcmp(errors->list[0].where, where) &&
                      strstr(errors->list[0].what, what);
    if (!ok(said, "refused at '%s': %s", where, what))
        diag("good %d, %zu errors, first '%s': '%s'", good, errors->count,
             errors->count ? errors->list[0].where : "", errors->count ? errors->list[0].what : "");
}

static void reads_beside(struct arena *arena)
{
    struct scene_disk d;
    struct scene_errors errors;
    uint32_t unread = 9;
    char hex[HASH_HEX];
    write_file("part.obj", triangle);
    hash_hex(triangle, strlen(triangle), hex);
    const bool good = scene_disk_open(&d, scene_with("\"file\": \"part.obj\""), arena, &errors) &&
                      scene_disk_load(&d, arena, &unread, &errors);
    ok(good && d.scene.meshes[0].triangle_count == 1 && !unread,
       "a mesh is read beside its document");
    ok(good && !strcmp(d.assets[0].hex, hex), "and named by its SHA-256");
    const char *sent = good ? scene_disk_send(&d, arena) : "";
    struct scene scene;
    ok(scene_parse(&scene, sent, strlen(sent), SCENE_FROM_NET, arena, &errors) &&
           !strcmp(scene.meshes[0].asset, hex),
       "what is sent names the asset and is a document for a coordinator");
}

/* One mesh for the shapes that name it, before it is sent and after. */
static void unites_meshes(struct arena *arena)
{
#define NEXT(mesh) "}, {\"type\": \"mesh\", \"material\": \"m\", " mesh
#define PART(name) "\"file\": \"" name "\""
    static const uint32_t want[] = {0, 1, 0, 2, 1, 0};
    struct scene_disk d;
    struct scene sent;
    struct scene_errors errors;
    uint32_t unread = 9;
    write_file("part.obj", triangle);
    write_file("other.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    const char *path = scene_with(PART("part.obj") NEXT(PART("other.obj")) NEXT(PART("part.obj"))
                                      NEXT("\"vertices\": [[0,0,0],[1,0,0],[0,1,0]], "
                                           "\"triangles\": [[0,1,2]]") NEXT(PART("other.obj"))
                                          NEXT(PART("part.obj")));
    bool good = scene_disk_open(&d, path, arena, &errors) &&
                scene_disk_load(&d, arena, &unread, &errors) && d.scene.mesh_count == 3;
    const char *json = good ? scene_disk_send(&d, arena) : "";
    good = good && scene_parse(&sent, json, strlen(json), SCENE_FROM_NET, arena, &errors) &&
           sent.mesh_count == 3;
    for (uint32_t i = 0; good && i < countof(want); i++)
        good =
            d.scene.shapes[i + 1].mesh.mesh == want[i] && sent.shapes[i + 1].mesh.mesh == want[i];
    ok(good && d.scene.meshes[0].triangle_count == 1 && d.scene.meshes[1].triangle_count == 2 &&
           !strcmp(sent.meshes[1].asset, d.assets[1].hex),
       "shapes that name the same file, and then the same asset, have one mesh");
}

static void write_png(const char *name)
{
    static const unsigned char rows[] = {1, 2, 3, 4, 5, 6};
    struct buf bytes = {0};
    image_files_png(&bytes,
                    &(struct image_files_png){2, 1, 8, 3, false, rows, NULL, NULL, 0, NULL});
    char path[128];
    snprintf(path, sizeof path, "%s/%s", dir, name);
    FILE *f = fopen(path, "wb");
    fwrite(bytes.data, 1, bytes.size, f);
    fclose(f);
    buf_release(&bytes);
}

static const char *scene_with_textures(const char *textures)
{
    char text[2048];
    snprintf(text, sizeof text, "%s\"file\": \"part.obj\"}], \"textures\": {%s}}", head, textures);
    return write_file("scene.json", text);
}

#define IMAGE(name, rest) "\"" name "\": {\"type\": \"image\", \"file\": " rest "}"

/* One image for the textures that name it, before it is sent and after. */
static void reads_images(struct arena *arena)
{
    struct scene_disk d;
    struct scene sent;
    struct scene_errors errors;
    uint32_t unread = 9;
    write_file("part.obj", triangle);
    write_png("a.png");
    const char *path = scene_with_textures(IMAGE("wood", "\"a.png\"") ", " IMAGE(
        "bark", "\"a.png\", \"color_space\": \"linear\", \"wrap\": \"mirror\""));
    const bool good = scene_disk_open(&d, path, arena, &errors) &&
                      scene_disk_load(&d, arena, &unread, &errors) && d.scene.image_count == 1 &&
                      d.asset_count == 2 && !unread;
    ok(good && d.scene.images[0].width_px == 2 && d.scene.images[0].channels == 3 &&
           !strcmp(d.scene.images[0].where, "/textures/wood"),
       "an image is read beside its document, once");
    const char *json = good ? scene_disk_send(&d, arena) : "";
    ok(good && scene_parse(&sent, json, strlen(json), SCENE_FROM_NET, arena, &errors) &&
           sent.image_count == 1 && !strcmp(sent.images[0].asset, d.assets[1].hex) &&
           sent.textures[1].image.image == 0 && sent.textures[1].image.wrap == TEXTURE_MIRROR,
       "what is sent names the asset");
}

static void says_what_is_wrong(struct arena *arena)
{
    struct scene_disk d;
    struct scene_errors errors;
    uint32_t unread;
    bool good = scene_disk_open(&d, "/nonexistent/scene.json", arena, &errors);
    says(good, &errors, "", "No such file");
    good = scene_disk_open(&d, write_file("scene.json", "{\n  \"smalti\": 1,,"), arena, &errors);
    says(good, &errors, "line 2, column 15", "");
    good = scene_disk_open(&d, scene_with("\"file\": \"absent.ply\""), arena, &errors) &&
           scene_disk_load(&d, arena, &unread, &errors);
    says(good, &errors, "/shapes/1", "absent.ply: No such file");
    write_file("bad.obj", "v 0 0 0\nf 1 2 3\n");
    good = scene_disk_open(&d, scene_with("\"file\": \"bad.obj\""), arena, &errors) &&
           scene_disk_load(&d, arena, &unread, &errors);
    says(good, &errors, "/shapes/1", "bad.obj: line 2");
    good =
        scene_disk_open(&d, scene_with_textures(IMAGE("wood", "\"none.png\"")), arena, &errors) &&
        scene_disk_load(&d, arena, &unread, &errors);
    says(good, &errors, "/textures/wood", "none.png: No such file");
    write_file("text.exr", "this is not an image");
    good = scene_disk_open(&d, scene_with_textures(IMAGE("a/b", "\"text.exr\"")), arena, &errors) &&
           scene_disk_load(&d, arena, &unread, &errors);
    says(good, &errors, "/textures/a~1b", "text.exr: expected an OpenEXR file, got 20 bytes");
}

int main(void)
{
    struct arena arena = {0};
    strcpy(dir, "/tmp/smalti-disk-XXXXXX");
    if (!mkdtemp(dir))
        return 1;
    reads_beside(&arena);
    unites_meshes(&arena);
    reads_images(&arena);
    says_what_is_wrong(&arena);
    arena_release(&arena);
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", dir);
    return system(command) | tap_done();
}
