/* scene_assets.c: a document for sending differs from the one on disk in the names of files alone.
 * SPDX-License-Identifier: MIT */
#include "common/scene.h"

#include <string.h>

#include "tests/tap.h"

static struct arena arena;

#define A "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
#define B "bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb"
#define C "cccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccc"

#define D "dddddddddddddddddddddddddddddddddddddddddddddddddddddddddddddddd"

static const char hex[][HASH_HEX] = {A, B, C, B, A};
static const char textures[][HASH_HEX] = {D, C, B};
static const char lights[][HASH_HEX] = {A, B};

#define HEAD                                                                                       \
    "{\"smalti\": 1, \"film\" : {\"width\": 64.0, \"height\": 4.8E1},\n \"camera\": {\"type\": "   \
    "\"perspective\", \"fov_deg\": 40.10, \"look_at\": {\"from\": [0.1, -0, 3], \"to\": [0,0,0]}}" \
    ",\t\"materials\": {\"file\": {\"type\": \"diffuse\", \"albedo\": 0.30000000000000004}}, "     \
    "\"title\": \"\\\"shapes\\\": [{\\\\\", \"shapes\""

static bool named(const char *json, const char *want)
{
    struct scene s;
    struct scene_errors e;
    if (!scene_parse(&s, json, strlen(json), SCENE_FROM_DISK, &arena, &e)) {
        diag("%s: %s", e.list[0].where, e.list[0].what);
        return false;
    }
    const struct scene_hashes hashes = {.textures = textures, .shapes = hex, .lights = lights};
    const char *got = scene_name_assets(json, strlen(json), &hashes, &arena);
    if (strcmp(got, want))
        diag("got %s", got);
    return !strcmp(got, want) && scene_parse(&s, got, strlen(got), SCENE_FROM_NET, &arena, &e);
}

int main(void)
{
    ok(named(HEAD ": []}", HEAD ": []}"), "without files the text stays as it is");
    ok(named(HEAD ": [{\"type\": \"mesh\", \"file\": \"m.ply\", \"material\": \"file\"}]}\n",
             HEAD ": [{\"type\": \"mesh\", \"asset\": \"" A "\", \"format\": \"ply\", "
                  "\"material\": \"file\"}]}\n"),
       "a file gives way to its asset");
    ok(named(HEAD ":[{\"material\":\"file\",\"file\":\"x \\\"}],.ObJ\",\"type\":\"mesh\"}]}",
             HEAD ":[{\"material\":\"file\",\"asset\": \"" A "\", \"format\": \"obj\","
                  "\"type\":\"mesh\"}]}"),
       "whatever its name looks like");
    ok(named(
           HEAD ": [{\"t\\u0079pe\": \"m\\u0065sh\", \"material\": \"f\\u0069le\", \"f\\u0069le\" "
                ": \"\\u00e9\\\\\\ud83d\\ude00.\\u0050ly\"}]}",
           HEAD ": [{\"t\\u0079pe\": \"m\\u0065sh\", \"material\": \"f\\u0069le\", \"asset\": \"" A
                "\", \"format\": \"ply\"}]}"),
       "and however it is escaped");
#define INLINE                                                                                     \
    "{\"type\": \"mesh\", \"material\": \"file\", \"vertices\": [[0,0,0],[1,0,0],[0,1,0.0]], "     \
    "\"triangles\": [[0,1,2]]}"
#define SPHERE                                                                                     \
    "{\"type\": \"sphere\", \"material\": \"file\", \"center\": [0,0,0], \"radius\": 1e-1}"
    ok(named(HEAD ": [" SPHERE ", " INLINE ", {\"type\": \"mesh\", \"material\": \"file\", "
                  "\"file\": \"1.obj\"}, " SPHERE ", {\"type\": \"mesh\", \"file\": \"2.ply\", "
                  "\"material\": \"file\"}], \"lights\": []}",
             HEAD ": [" SPHERE ", " INLINE ", {\"type\": \"mesh\", \"material\": \"file\", "
                  "\"asset\": \"" C "\", \"format\": \"obj\"}, " SPHERE ", {\"type\": \"mesh\", "
                  "\"asset\": \"" A "\", \"format\": \"ply\", \"material\": \"file\"}], "
                  "\"lights\": []}"),
       "each mesh gets its own, those without a file none");
    ok(named(HEAD ": [{\"type\": \"mesh\", \"file\": \"m.ply\", \"material\": \"file\"}], "
                  "\"textures\": {\"shapes\": {\"type\": \"image\", \"file\": \"a.PNG\"}, "
                  "\"file\": {\"file\" : \"b.jpg\", \"wrap\": \"clamp\", \"type\": \"image\"},"
                  "\"t\": {\"type\": \"image\", \"file\": \"c.jpeg.exr\"}}}",
             HEAD ": [{\"type\": \"mesh\", \"asset\": \"" A "\", \"format\": \"ply\", "
                  "\"material\": \"file\"}], "
                  "\"textures\": {\"shapes\": {\"type\": \"image\", \"asset\": \"" D "\", "
                  "\"format\": \"png\"}, "
                  "\"file\": {\"asset\": \"" C "\", \"format\": \"jpeg\", \"wrap\": \"clamp\", "
                  "\"type\": \"image\"},"
                  "\"t\": {\"type\": \"image\", \"asset\": \"" B "\", \"format\": \"exr\"}}}"),
       "images of textures, too, whatever the textures are called");
    ok(named(HEAD ": [], \"lights\": [{\"type\": \"sky\", \"radiance\": 1}, {\"type\": "
                  "\"environment\", \"file\": \"s.exr\", \"scale\": 2}]}",
             HEAD ": [], \"lights\": [{\"type\": \"sky\", \"radiance\": 1}, {\"type\": "
                  "\"environment\", \"asset\": \"" B "\", \"format\": \"exr\", \"scale\": 2}]}"),
       "and of lights");
    arena_release(&arena);
    return tap_done();
}
