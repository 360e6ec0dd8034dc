/* SPDX-License-Identifier: MIT */
#include "common/scene_wrap.h"

static const struct scene_range fraction = {0, 1, false};

void scene_wrap_mix(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {
        {"type", true}, {"first", true}, {"second", true}, {"amount", true}};
    scene_params_of(p, "a mix", keys, countof(keys));
    scene_param_number(p, "amount", fraction, &m->mix.amount);
}

void scene_wrap_mask(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true}, {"material", true}, {"opacity", true}};
    scene_params_of(p, "a mask", keys, countof(keys));
    scene_param_number(p, "opacity", fraction, &m->mask.opacity);
}

void scene_wrap_two_sided(const struct scene_params *p, struct material *m)
{
    (void)m; /* all that it has are names */
    static const struct scene_key keys[] = {{"type", true}, {"front", true}, {"back", true}};
    scene_params_of(p, "a two-sided material", keys, countof(keys));
}

/* --- what they name --- */

struct part {
    const char *key;
    uint32_t *material;
};

/* How many parts a material has. */
static int parts_of(struct material *m, struct part parts[2])
{
    switch (m->kind) {
    case MATERIAL_MIX:
        parts[0] = (struct part){"first", &m->mix.first};
        parts[1] = (struct part){"second", &m->mix.second};
        return 2;
    case MATERIAL_MASK:
        parts[0] = (struct part){"material", &m->mask.of};
        return 1;
    case MATERIAL_TWO_SIDED:
        parts[0] = (struct part){"front", &m->two_sided.front};
        parts[1] = (struct part){"back", &m->two_sided.back};
        return 2;
    case MATERIAL_DIFFUSE:
    case MATERIAL_MIRROR:
    case MATERIAL_DIELECTRIC:
    case MATERIAL_CONDUCTOR:
    case MATERIAL_ROUGH_DIFFUSE:
    case MATERIAL_RETROREFLECTOR:
    case MATERIAL_LEAF:
    case MATERIAL_PLASTIC:
    case MATERIAL_PRINCIPLED:
    case MATERIAL_CLOTH:
    case MATERIAL_PANE:
    case MATERIAL_METAL:
        break;
    }
    return 0;
}

/* The normal is there before it is known which part is. */
static bool is_smooth_part(struct scene_doc *doc, const struct scene_at *name,
                           const struct material *part)
{
    return !part->relief ||
           scene_doc_expected(doc, name, ERR_INPUT,
                              "a material without \"normal_map\" and \"bump\": a material that is "
                              "made of it may have them");
}

static bool bind(struct scene_doc *doc, const struct scene_at *at, const struct scene_names *names,
                 const struct scene *scene, struct material *m)
{
    struct part parts[2];
    const int count = parts_of(m, parts);
    bool good = true;
    for (int i = 0; i < count; i++) {
        struct scene_at member;
        good &= scene_at_member(at, parts[i].key, &member) &&
                scene_names_find(doc, &member, names, parts[i].material) &&
                is_smooth_part(doc, &member, &scene->materials[*parts[i].material]);
    }
    return good;
}

/* A property of what a material is made of in the end. */
typedef bool leaf_property(const struct material *);

static bool is_mask(const struct material *m)
{
    return m->kind == MATERIAL_MASK;
}

static bool lets_through(const struct material *m)
{
    return m->kind == MATERIAL_DIELECTRIC || m->kind == MATERIAL_PANE || m->kind == MATERIAL_LEAF ||
           (m->kind == MATERIAL_PRINCIPLED && m->principled.transmission > 0);
}

/* Whether the material or one that it is made of, down to a depth, has it. */
static bool any_part(const struct scene *scene, uint32_t material, int depth, leaf_property *has)
{
    struct part parts[2];
    struct material *m = &scene->materials[material];
    if (has(m))
        return true;
    const int count = depth > 0 ? parts_of(m, parts) : 0;
    for (int i = 0; i < count; i++)
        if (any_part(scene, *parts[i].material, depth - 1, has))
            return true;
    return false;
}

/* Whether nothing is nested deeper; what holds itself is. */
static bool is_shallow(const struct scene *scene, uint32_t material, int depth)
{
    struct part parts[2];
    const int count = parts_of(&scene->materials[material], parts);
    if (count && depth == 0)
        return false;
    for (int i = 0; i < count; i++)
        if (!is_shallow(scene, *parts[i].material, depth - 1))
            return false;
    return true;
}

/* What the surface is asked for, for every part (enum material_needs). */
static uint32_t needs_of(const struct scene *scene, uint32_t material)
{
    struct part parts[2];
    struct material *m = &scene->materials[material];
    const int count = parts_of(m, parts);
    uint32_t needs = m->needs;
    for (int i = 0; i < count; i++)
        needs |= needs_of(scene, *parts[i].material);
    return needs;
}

static void check_sides(struct scene_doc *doc, const struct scene_at *at, const struct scene *scene,
                        struct material *m)
{
    struct part parts[2];
    const int count = parts_of(m, parts);
    for (int i = 0; i < count; i++) {
        struct scene_at member;
        if (scene_at_member(at, parts[i].key, &member) &&
            any_part(scene, *parts[i].material, SCENE_WRAP_DEPTH, lets_through))
            scene_doc_expected(doc, &member, ERR_INPUT,
                               "an opaque material on each side of a two-sided one");
    }
}

void scene_wrap_bind(struct scene_doc *doc, const struct scene_at *materials,
                     const struct scene_names *names, struct scene *scene)
{
    bool good = true;
    struct scene_at member = {0};
    for (uint32_t i = 0; scene_at_next(materials, &member); i++)
        good &= bind(doc, &member, names, scene, &scene->materials[i]);
    if (!good) /* what is made of what is not known */
        return;
    member = (struct scene_at){0};
    for (uint32_t i = 0; scene_at_next(materials, &member); i++)
        if (!is_shallow(scene, i, SCENE_WRAP_DEPTH)) {
            scene_doc_fault(doc, &member, ERR_INPUT,
                            "expected a material that is not made of itself, and of others at most "
                            "%d deep",
                            SCENE_WRAP_DEPTH);
        } else {
            scene->materials[i].needs = needs_of(scene, i);
            if (scene->materials[i].kind == MATERIAL_TWO_SIDED)
                check_sides(doc, &member, scene, &scene->materials[i]);
        }
}

bool scene_wrap_has_mask(const struct scene *scene, uint32_t material)
{
    return any_part(scene, material, SCENE_WRAP_DEPTH, is_mask);
}
