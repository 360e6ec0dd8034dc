/* Any bytes as a scene document: an answer, never a crash, and a scene that keeps its promises.
 *
 *     build/fuzz-clang/bin/fuzz_scene -max_len=20000 CORPUS tests/invalid scenes
 * SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>

#include "common/scene.h"

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t bytes);

static void require(bool cond)
{
    if (!cond)
        abort();
}

static void check_errors(const struct scene_errors *e)
{
    require(e->count >= 1 && e->count <= 100);
    for (size_t i = 0; i < e->count; i++) {
        require(e->list[i].code == ERR_INPUT || e->list[i].code == ERR_LIMIT);
        require(e->list[i].where && e->list[i].what && *e->list[i].what);
        for (const char *c = e->list[i].what; *c; c++)
            require((unsigned char)*c >= 0x20);
    }
}

static void check_textures(const struct scene *s)
{
    for (uint32_t i = 0; i < s->texture_count; i++) {
        const struct texture *t = &s->textures[i];
        require(t->kind != TEXTURE_IMAGE || t->image.image < s->image_count);
        require(t->uv_scale[0] != 0 && t->uv_scale[1] != 0);
    }
    for (uint32_t i = 0; i < s->image_count; i++)
        require(!s->images[i].file != !*s->images[i].asset && *s->images[i].where == '/');
    uint32_t slots = 0;
    for (uint32_t i = 0; i < s->material_count; i++) {
        require(s->materials[i].slot_begin == slots && s->materials[i].slot_end >= slots);
        slots = s->materials[i].slot_end;
    }
    require(slots == s->slot_count);
    for (uint32_t i = 0; i < slots; i++)
        require(s->slots[i].texture < s->texture_count &&
                s->slots[i].member + sizeof(float) <= sizeof(struct material) &&
                s->slots[i].lo <= s->slots[i].hi);
}

static void check_camera(const struct scene_camera *c)
{
    switch (c->kind) {
    case CAMERA_THIN_LENS:
        require(c->lens_radius >= 0 && c->focus > 0 && c->lens_radius <= c->focus);
        require(!c->blades || (c->blades >= 3 && c->blades <= SCENE_MAX_BLADES));
        require(c->blades_turn >= 0 && c->blades_turn <= 1);
        require(c->fov_y_rad > 0 && c->fov_y_rad < 3.15f);
        return;
    case CAMERA_PERSPECTIVE:
        require(c->fov_y_rad > 0 && c->fov_y_rad < 3.15f);
        return;
    case CAMERA_ORTHOGRAPHIC:
        require((c->width > 0) != (c->height > 0));
        return;
    case CAMERA_PANORAMIC:
        return;
    }
    require(false);
}

static void check_scene(const struct scene *s)
{
    const struct scene_film *f = &s->film;
    require(f->crop_x_begin < f->crop_x_end && f->crop_x_end <= f->width_px);
    require(f->crop_y_begin < f->crop_y_end && f->crop_y_end <= f->height_px);
    require(f->filter_radius_px >= .1f && f->filter_radius_px <= 16);
    require(f->filter != FILTER_GAUSSIAN || f->filter_sigma_px >= .05f);
    check_camera(&s->camera);
    require(s->settings.target.spp >= 1 && s->settings.target.spp <= SCENE_MAX_SPP);
    for (uint32_t i = 0; i < s->shape_count; i++) {
        require(s->shapes[i].material < s->material_count);
        require(s->shapes[i].kind != SHAPE_MESH || s->shapes[i].mesh.mesh < s->mesh_count);
        require(s->shapes[i].kind != SHAPE_SPHERE || s->shapes[i].sphere.radius > 0);
        require(s->shapes[i].kind != SHAPE_CYLINDER ||
                (s->shapes[i].cylinder.radius > 0 &&
                 vec3_length(vec3_load(s->shapes[i].cylinder.axis)) > 0));
    }
    for (uint32_t i = 0; i < s->mesh_count; i++)
        for (size_t k = 0; k < (size_t)3 * s->meshes[i].triangle_count; k++)
            require(s->meshes[i].indices[k] < s->meshes[i].vertex_count);
    check_textures(s);
}

static void check_assets(const struct scene *scene, const char *json, size_t bytes,
                         struct arena *arena)
{
    const uint32_t most = max_u32(scene->shape_count, scene->texture_count);
    char(*hex)[HASH_HEX] = arena_alloc(arena, most, HASH_HEX, 1);
    for (uint32_t i = 0; i < most; i++)
        memset(hex[i], '0' + (int)(i % 10), HASH_HEX - 1);
    const struct scene_hashes hashes = {.textures = (const char(*)[HASH_HEX])hex,
                                        .shapes = (const char(*)[HASH_HEX])hex};
    const char *text = scene_name_assets(json, bytes, &hashes, arena);
    struct scene sent;
    struct scene_errors errors;
    if (strlen(text) > SCENE_MAX_BYTES)
        return;
    require(scene_parse(&sent, text, strlen(text), SCENE_FROM_NET, arena, &errors));
    require(sent.shape_count == scene->shape_count);
    for (uint32_t i = 0; i < sent.shape_count; i++) {
        const struct shape *shape = &scene->shapes[i];
        if (shape->kind == SHAPE_MESH && scene->meshes[shape->mesh.mesh].file)
            require(!strcmp(sent.meshes[sent.shapes[i].mesh.mesh].asset, hex[i]));
    }
    for (uint32_t i = 0; i < sent.texture_count; i++) {
        const struct texture *t = &scene->textures[i];
        if (t->kind == TEXTURE_IMAGE && scene->images[t->image.image].file)
            require(!strcmp(sent.images[sent.textures[i].image.image].asset, hex[i]));
    }
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t bytes)
{
    struct arena arena = {0};
    struct scene scene;
    struct scene_errors errors;
    const char *json = (const char *)data;
    if (scene_parse(&scene, json, bytes, SCENE_FROM_NET, &arena, &errors))
        check_scene(&scene);
    else
        check_errors(&errors);
    if (scene_parse(&scene, json, bytes, SCENE_FROM_DISK, &arena, &errors)) {
        check_scene(&scene);
        check_assets(&scene, json, bytes, &arena);
    }
    arena_release(&arena);
    return 0;
}
