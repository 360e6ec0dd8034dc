/* The images that textures and lights name: one for each name, read once.
 * SPDX-License-Identifier: MIT */
#include "common/image_asset.h"
#include "common/scene_read.h"

#include <string.h>

static bool read_file(struct scene_doc *doc, const struct scene_at *at, struct image_asset *image)
{
    if (doc->source == SCENE_FROM_NET)
        return scene_doc_fault(doc, at, ERR_INPUT,
                               "a document that is sent names images by \"asset\" and \"format\", "
                               "a \"file\" can be named by a document on disk only");
    return scene_doc_text(doc, at, 1, 4096, &image->file) &&
           (image_asset_format_of(image->file, &image->format) ||
            scene_doc_expected(doc, at, ERR_INPUT,
                               "a file name that ends in .png, .jpg, .jpeg or .exr"));
}

static bool read_asset(struct scene_doc *doc, const struct scene_at *asset,
                       const struct scene_at *format, struct image_asset *image)
{
    size_t chosen = 0;
    bool good = scene_doc_choice(doc, format, image_asset_formats, IMAGE_ASSET_FORMATS, &chosen);
    image->format = (enum image_format)chosen;
    if (scene_at_type(asset) != SCENE_STRING || !hash_is_hex(scene_at_string(asset)))
        good = scene_doc_expected(doc, asset, ERR_INPUT,
                                  "the SHA-256 of a file as 64 digits 0-9, a-f");
    else
        memcpy(image->asset, scene_at_string(asset), HASH_HEX);
    return good;
}

static const char *name_of(const struct image_asset *image)
{
    return image->file ? image->file : image->asset;
}

/* (No asset is named like a file, which has an ending.) */
static bool add(struct scene_doc *doc, const struct scene_at *at, struct scene *scene,
                const struct image_asset *image, uint32_t *index)
{
    for (uint32_t i = 0; i < scene->image_count; i++)
        if (!strcmp(name_of(&scene->images[i]), name_of(image)) &&
            scene->images[i].format == image->format) {
            *index = i;
            return true;
        }
    const uint32_t count = scene->image_count;
    if (count == SCENE_MAX_IMAGES)
        return scene_doc_fault(doc, at, ERR_LIMIT, "expected at most %d images", SCENE_MAX_IMAGES);
    scene->images = arena_grow(doc->arena, scene->images, count, sizeof *scene->images);
    scene->images[count] = *image;
    scene->images[count].where = scene_doc_pointer(doc, at);
    *index = scene->image_count++;
    return true;
}

bool scene_read_image(struct scene_doc *doc, const struct scene_at *at, const char *what,
                      struct scene *scene, uint32_t *index)
{
    struct scene_at file, asset, format;
    const bool has_file = scene_at_member(at, "file", &file);
    const bool has_asset = scene_at_member(at, "asset", &asset);
    const bool has_format = scene_at_member(at, "format", &format);
    if (has_file == (has_asset || has_format) || has_asset != has_format)
        return scene_doc_fault(doc, at, ERR_INPUT,
                               "%s needs either \"file\", or \"asset\" and \"format\"", what);
    struct image_asset image = {0};
    return (has_file ? read_file(doc, &file, &image) : read_asset(doc, &asset, &format, &image)) &&
           add(doc, at, scene, &image, index);
}
