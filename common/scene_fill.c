/* SPDX-License-Identifier: MIT */
#include "common/scene_fill.h"

#include "common/image_asset.h"
#include "common/mesh.h"

#define ASSET_MAX_BYTES ((size_t)2 << 30)

enum scene_fill_result scene_fill(struct scene *scene, const struct scene_fill *from,
                                  struct arena *arena, struct err *err)
{
    enum scene_fill_result result = SCENE_FILL_DONE;
    struct buf bytes = {0};
    const uint32_t all = scene->mesh_count + scene->image_count;
    for (uint32_t i = 0; i < all && result == SCENE_FILL_DONE; i++) {
        struct mesh *mesh = i < scene->mesh_count ? &scene->meshes[i] : NULL;
        struct image_asset *image = mesh ? NULL : &scene->images[i - scene->mesh_count];
        const char *hex = mesh ? mesh->asset : image->asset;
        if (mesh && mesh->format == MESH_INLINE)
            continue;
        buf_release(&bytes);
        if (!from->get(from->context, hex, ASSET_MAX_BYTES, &bytes, err))
            result = SCENE_FILL_NOT_GOT;
        else if (!(mesh ? mesh_read(mesh, bytes.data, bytes.size, arena, err)
                        : image_asset_read(image, bytes.data, bytes.size, arena, err)))
            result = SCENE_FILL_FAULTY;
        if (result != SCENE_FILL_DONE)
            err_at(err, "asset %s", hex);
    }
    buf_release(&bytes);
    return result;
}
