/* SPDX-License-Identifier: MIT */
#include "common/scene_disk.h"

#include <string.h>

#include "common/image_asset.h"
#include "common/mesh.h"

enum { MAX_ERRORS = 100 };

#define FILE_MAX_BYTES ((size_t)2 << 30) /* what a coordinator takes as an asset */

static bool fail(struct scene_errors *errors, struct arena *arena, enum err_code code,
                 const char *where, const char *what)
{
    if (!errors->list)
        errors->list = arena_new(arena, struct scene_error, MAX_ERRORS);
    if (errors->count < MAX_ERRORS)
        errors->list[errors->count++] =
            (struct scene_error){code, arena_strdup(arena, where), arena_strdup(arena, what)};
    return false;
}

static const char *beside(const char *document, const char *file, struct arena *arena)
{
    const char *slash = strrchr(document, '/');
    if (*file == '/' || !slash)
        return arena_strdup(arena, file);
    return arena_printf(arena, "%.*s/%s", (int)(slash - document), document, file);
}

bool scene_disk_open(struct scene_disk *d, const char *path, struct arena *arena,
                     struct scene_errors *errors)
{
    struct buf bytes = {0};
    struct err err;
    *d = (struct scene_disk){0};
    *errors = (struct scene_errors){0};
    if (!buf_read_file(&bytes, path, SCENE_MAX_BYTES, &err)) {
        buf_release(&bytes);
        const size_t named =
            strlen(path) + 2; /* "PATH: ": whoever prints it says the file's name */
        return fail(errors, arena, err.code, "", err.text + min_size(named, strlen(err.text)));
    }
    char *json = arena_new(arena, char, bytes.size + 1);
    if (bytes.size)
        memcpy(json, bytes.data, bytes.size);
    d->json = json;
    d->json_bytes = bytes.size;
    buf_release(&bytes);
    if (!scene_parse(&d->scene, d->json, d->json_bytes, SCENE_FROM_DISK, arena, errors))
        return false;
    const uint32_t meshes = d->scene.mesh_count;
    d->asset_count = meshes + d->scene.image_count;
    d->assets = arena_new(arena, struct scene_disk_asset, d->asset_count);
    for (uint32_t i = 0; i < d->asset_count; i++) {
        const char *file = i < meshes ? d->scene.meshes[i].file : d->scene.images[i - meshes].file;
        if (file)
            d->assets[i].path = beside(path, file, arena);
    }
    return true;
}

static const char *pointer_of(const struct scene *scene, uint32_t asset, struct arena *arena)
{
    if (asset >= scene->mesh_count)
        return scene->images[asset - scene->mesh_count].where;
    for (uint32_t i = 0; i < scene->shape_count; i++)
        if (scene->shapes[i].kind == SHAPE_MESH && scene->shapes[i].mesh.mesh == asset)
            return arena_printf(arena, "/shapes/%u", i);
    return "";
}

static bool read_asset(struct scene *scene, uint32_t i, const struct buf *bytes,
                       struct arena *arena, struct err *err)
{
    if (i < scene->mesh_count)
        return mesh_read(&scene->meshes[i], bytes->data, bytes->size, arena, err);
    return image_asset_read(&scene->images[i - scene->mesh_count], bytes->data, bytes->size, arena,
                            err);
}

static bool load_asset(struct scene_disk *d, uint32_t i, struct arena *arena, struct err *err)
{
    struct scene_disk_asset *asset = &d->assets[i];
    struct buf bytes = {0};
    bool good = buf_read_file(&bytes, asset->path, FILE_MAX_BYTES, err);
    if (good) {
        asset->bytes = bytes.size;
        hash_hex(bytes.data, bytes.size, asset->hex);
        good = read_asset(&d->scene, i, &bytes, arena, err) || err_at(err, "%s", asset->path);
    }
    buf_release(&bytes);
    return good;
}

bool scene_disk_load(struct scene_disk *d, struct arena *arena, uint32_t *unread,
                     struct scene_errors *errors)
{
    struct err err;
    *unread = 0;
    *errors = (struct scene_errors){0};
    for (uint32_t i = 0; i < d->asset_count; i++) {
        if (i < d->scene.mesh_count && d->scene.meshes[i].format == MESH_INLINE)
            continue;
        if (!d->assets[i].path)
            ++*unread;
        else if (!load_asset(d, i, arena, &err))
            fail(errors, arena, err.code, pointer_of(&d->scene, i, arena), err.text);
    }
    return !errors->count;
}

typedef char hex_name[HASH_HEX];

static hex_name *hex_names(size_t count, struct arena *arena)
{
    return (hex_name *)arena_alloc(arena, count, HASH_HEX, 1);
}

const char *scene_disk_send(const struct scene_disk *d, struct arena *arena)
{
    const struct scene *scene = &d->scene;
    bool any = false;
    for (uint32_t i = 0; i < d->asset_count; i++)
        any |= d->assets[i].path != NULL;
    if (!any)
        return d->json;
    hex_name *shapes = hex_names(scene->shape_count, arena);
    for (uint32_t i = 0; i < scene->shape_count; i++)
        if (scene->shapes[i].kind == SHAPE_MESH)
            memcpy(shapes[i], d->assets[scene->shapes[i].mesh.mesh].hex, HASH_HEX);
    const struct scene_disk_asset *images = d->assets + scene->mesh_count;
    hex_name *textures = hex_names(scene->texture_count, arena);
    for (uint32_t i = 0; i < scene->texture_count; i++)
        if (scene->textures[i].kind == TEXTURE_IMAGE)
            memcpy(textures[i], images[scene->textures[i].image.image].hex, HASH_HEX);
    hex_name *lights = hex_names(scene->light_count, arena);
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].kind == LIGHT_ENVIRONMENT)
            memcpy(lights[i], images[scene->lights[i].environment.image].hex, HASH_HEX);
    const struct scene_hashes hashes = {.textures = (const hex_name *)textures,
                                        .shapes = (const hex_name *)shapes,
                                        .lights = (const hex_name *)lights};
    return scene_name_assets(d->json, d->json_bytes, &hashes, arena);
}
