/* SPDX-License-Identifier: MIT */
#include "common/scene_param.h"

#include <assert.h>
#include <string.h>

enum { MOST_KEYS = 14 };

void scene_params_of(const struct scene_params *p, const char *what, const struct scene_key *keys,
                     size_t count)
{
    static const struct scene_key of_all[] = {{"normal_map", false}, {"bump", false}};
    struct scene_key all[MOST_KEYS];
    assert(count + countof(of_all) <= countof(all));
    memcpy(all, keys, count * sizeof *all);
    memcpy(all + count, of_all, sizeof of_all);
    scene_doc_object(p->doc, p->at, what, all, count + countof(of_all));
}

/* --- textures --- */

static const struct scene_range scale_range = {0, 1e6, false};

static bool is_textured(const struct scene_at *value)
{
    return scene_at_type(value) == SCENE_OBJECT;
}

static void add_slot(const struct scene_params *p, const struct material_slot *slot)
{
    struct scene *scene = p->scene;
    scene->slots = arena_grow(p->doc->arena, scene->slots, scene->slot_count, sizeof *scene->slots);
    scene->slots[scene->slot_count++] = *slot;
}

static bool read_scale(const struct scene_params *p, const struct scene_at *value,
                       struct material_slot *slot)
{
    rgb color = rgb_gray(1);
    double number = 1;
    const bool good = slot->is_rgb ? scene_key_rgb(p->doc, value, "scale", scale_range, &color)
                                   : scene_key_number(p->doc, value, "scale", scale_range, &number);
    if (!slot->is_rgb)
        color = rgb_gray((float)number);
    vec3_store(slot->scale, color);
    return good;
}

bool scene_param_channel(const struct scene_params *p, const struct scene_at *value,
                         enum material_channel *out)
{
    static const char *const names[] = {"r", "g", "b", "a"};
    size_t channel;
    struct scene_at at;
    if (!scene_at_member(value, "channel", &at))
        return true;
    if (!scene_doc_choice(p->doc, &at, names, countof(names), &channel))
        return false;
    *out = (enum material_channel)(MATERIAL_CHANNEL_R + channel);
    return true;
}

static float kept(float v, const struct material_slot *slot)
{
    return v < slot->lo ? slot->lo : v > slot->hi ? slot->hi : v;
}

/* A parameter that a texture drives; rgb: its scale, kept in the range. False: a fault. */
static bool read_textured(const struct scene_params *p, const struct scene_at *value,
                          struct material_slot *slot, rgb *most)
{
    static const struct scene_key keys[] = {
        {"texture", true}, {"scale", false}, {"channel", false}};
    struct scene_at name;
    bool good = scene_doc_object(p->doc, value, "a textured parameter", keys,
                                 countof(keys) - (slot->is_rgb ? 1 : 0));
    good &= read_scale(p, value, slot);
    good &= slot->is_rgb || scene_param_channel(p, value, &slot->channel);
    good &= scene_at_member(value, "texture", &name) &&
            scene_names_find(p->doc, &name, p->textures, &slot->texture);
    if (!good)
        return false;
    p->material->needs |= p->scene->textures[slot->texture].kind == TEXTURE_VERTEX_COLOR
                              ? MATERIAL_NEEDS_COLOR
                              : MATERIAL_NEEDS_UV;
    add_slot(p, slot);
    *most = vec3_make(kept(slot->scale[0], slot), kept(slot->scale[1], slot),
                      kept(slot->scale[2], slot));
    return true;
}

/* Of the member of the material that `out` is. */
static struct material_slot slot_of(const struct scene_params *p, const void *out,
                                    struct scene_range range, bool is_rgb)
{
    const size_t member = (size_t)((const char *)out - (const char *)p->material);
    assert(member < sizeof *p->material);
    return (struct material_slot){
        .member = (uint32_t)member, .is_rgb = is_rgb, .lo = (float)range.lo, .hi = (float)range.hi};
}

/* --- parameters --- */

void scene_param_rgb(const struct scene_params *p, const char *key, struct scene_range range,
                     rgb *out)
{
    struct scene_at value;
    if (!scene_at_member(p->at, key, &value))
        return;
    struct material_slot slot = slot_of(p, out, range, true);
    if (is_textured(&value))
        read_textured(p, &value, &slot, out);
    else
        scene_doc_rgb(p->doc, &value, range, out);
}

/* False: absent, or a fault. */
static bool read_number(const struct scene_params *p, const char *key, struct scene_range range,
                        float *out)
{
    struct scene_at value;
    double number;
    rgb most;
    if (!scene_at_member(p->at, key, &value))
        return false;
    struct material_slot slot = slot_of(p, out, range, false);
    if (is_textured(&value)) {
        if (!read_textured(p, &value, &slot, &most))
            return false;
        *out = most[0];
    } else {
        if (!scene_doc_number(p->doc, &value, range, &number))
            return false;
        *out = (float)number;
    }
    return true;
}

void scene_param_number(const struct scene_params *p, const char *key, struct scene_range range,
                        float *out)
{
    read_number(p, key, range, out);
}

void scene_param_both(const struct scene_params *p, const char *key, struct scene_range range,
                      float *a, float *b)
{
    if (read_number(p, key, range, a))
        read_number(p, key, range, b);
}
