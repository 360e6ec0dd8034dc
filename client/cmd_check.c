/* jansson: the tree is owned and released where it is printed.
 * SPDX-License-Identifier: MIT */
#include <jansson.h>
#include <stdio.h>

#include "client/cmd.h"
#include "common/scene_disk.h"

static const char usage[] =
    "Usage: smalti check SCENE [--json]\n"
    "Reads a scene and the files it names and prints everything that is wrong with them, one\n"
    "'FILE: PLACE: TEXT' a line; PLACE is a JSON pointer, or line and column of a syntax\n"
    "error. What reading has changed, since the scene asks for \"rescale\", is said on stderr.\n"
    "\n"
    "  --json   {\"valid\": true or false, \"errors\": [{\"pointer\", \"detail\"}, ...],\n"
    "           \"warnings\": [{\"pointer\", \"detail\", \"was\", \"became\"}, ...]}\n"
    "\n"
    "Exit status: 0 valid, 2 wrong usage, 3 not valid.\n";

static json_t *color_json(const float c[3])
{
    return json_pack("[f,f,f]", (double)c[0], (double)c[1], (double)c[2]);
}

static json_t *warnings_json(const struct scene *scene)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < scene->warning_count; i++) {
        const struct scene_warning *w = &scene->warnings[i];
        json_array_append_new(list, json_pack("{s:s, s:s, s:o, s:o}", "pointer", w->where, "detail",
                                              w->what, "was", color_json(w->was), "became",
                                              color_json(w->became)));
    }
    return list;
}

static void print_json(const struct scene_errors *errors, const struct scene *scene)
{
    json_t *list = json_array();
    for (size_t i = 0; i < errors->count; i++)
        json_array_append_new(list, json_pack("{s:s, s:s}", "pointer", errors->list[i].where,
                                              "detail", errors->list[i].what));
    json_t *root = json_pack("{s:b, s:o, s:o}", "valid", errors->count == 0, "errors", list,
                             "warnings", warnings_json(scene));
    json_dumpf(root, stdout, JSON_COMPACT | JSON_REAL_PRECISION(9));
    putchar('\n');
    json_decref(root);
}

static void print_summary(const struct scene_disk *d, uint32_t unread)
{
    uint64_t triangles = 0; /* of all shapes: a mesh's as often as it is used */
    for (uint32_t i = 0; i < d->scene.shape_count; i++)
        if (d->scene.shapes[i].kind == SHAPE_MESH)
            triangles += d->scene.meshes[d->scene.shapes[i].mesh.mesh].triangle_count;
    printf("valid: %u x %u pixels, %u shapes, %u meshes with %llu triangles, %u materials, %u "
           "lights, %u images\n",
           d->scene.film.width_px, d->scene.film.height_px, d->scene.shape_count,
           d->scene.mesh_count, (unsigned long long)triangles, d->scene.material_count,
           d->scene.light_count, d->scene.image_count);
    if (unread)
        printf("not read: %u files that are named by their hash only\n", unread);
}

int cmd_check(int argc, char *const *args)
{
    bool json = false;
    const struct flags_entry flags[] = {{.name = "json", .kind = FLAGS_SWITCH, .value = &json}};
    const struct cmd_spec spec = {"check", usage, flags, countof(flags), 1, 1};
    const char *file;
    size_t operands;
    int status;
    if (!cmd_parse(&spec, argc, args, &file, &operands, &status))
        return status;

    struct arena arena = {0};
    struct scene_disk scene = {0};
    struct scene_errors errors;
    uint32_t unread = 0;
    const bool valid = scene_disk_open(&scene, file, &arena, &errors) &&
                       scene_disk_load(&scene, &arena, &unread, &errors);
    if (valid && !json)
        cmd_warn_scene(file, &scene.scene);
    if (json)
        print_json(&errors, &scene.scene);
    else if (valid)
        print_summary(&scene, unread);
    else
        cmd_fail_scene(file, &errors);
    arena_release(&arena);
    return valid ? CMD_OK : CMD_INPUT;
}
