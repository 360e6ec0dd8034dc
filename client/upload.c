/* jansson: trees are owned here and released before the function returns.
 * SPDX-License-Identifier: MIT */
#include "client/upload.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#define FILE_MAX_BYTES ((size_t)2 << 30)

static bool upload_one(struct remote *r, const struct scene_disk_asset *asset, struct err *err)
{
    bool here = false;
    if (!remote_has_asset(r, asset->hex, &here, err))
        return false;
    if (here)
        return true;
    struct buf bytes = {0};
    char hex[HASH_HEX];
    bool good = buf_read_file(&bytes, asset->path, FILE_MAX_BYTES, err);
    if (good) {
        hash_hex(bytes.data, bytes.size, hex);
        good = !strcmp(hex, asset->hex) ||
               err_set(err, ERR_INPUT, "%s: changed while it was being sent", asset->path);
    }
    good = good && remote_put_asset(r, asset->hex, &bytes, err);
    buf_release(&bytes);
    return good;
}

bool upload_assets(struct remote *r, const struct scene_disk *scene, struct err *err)
{
    for (uint32_t i = 0; i < scene->asset_count; i++)
        if (scene->assets[i].path && !upload_one(r, &scene->assets[i], err))
            return false;
    return true;
}

const char *upload_retarget(const char *json, const struct scene_target *target,
                            struct arena *arena)
{
    json_t *root = json_loads(json, 0, NULL); /* it has been parsed before: it is an object */
    json_t *settings = json_object_get(root, "settings");
    if (!settings) {
        settings = json_object();
        json_object_set_new(root, "settings", settings);
    }
    json_t *object = json_object();
    if (target->error > 0)
        json_object_set_new(object, "error", json_real(target->error));
    if (target->spp)
        json_object_set_new(object, "spp", json_integer(target->spp));
    if (target->seconds > 0)
        json_object_set_new(object, "seconds", json_real(target->seconds));
    json_object_set_new(settings, "target", object);
    char *text = json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(17));
    const char *copy = arena_strdup(arena, text);
    free(text);
    json_decref(root);
    return copy;
}
