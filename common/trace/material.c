/* SPDX-License-Identifier: MIT */
#include "common/trace/material.h"

#include "common/trace/textured.h"

static const struct material *material_of(const struct stage *s, uint32_t material)
{
    return (const struct material *)stage_at(s, s->materials) + material;
}

/* Another one at the same place. */
static struct material_side other(const struct material_side *side, uint32_t material)
{
    return (struct material_side){material, side->back, side->point};
}

static float opacity_of(const struct stage *s, const struct material_side *side, uint32_t material)
{
    const struct material_side part = other(side, material);
    return material_opacity(s, &part);
}

float material_opacity(const struct stage *s, const struct material_side *side)
{
    struct material filled;
    if (!s->masked)
        return 1;
    const struct material *m = material_of(s, side->material);
    switch (m->kind) {
    case MATERIAL_MIX:
        m = textured_material(s, m, side->point, &filled);
        return (1 - m->mix.amount) * opacity_of(s, side, m->mix.first) +
               m->mix.amount * opacity_of(s, side, m->mix.second);
    case MATERIAL_MASK:
        m = textured_material(s, m, side->point, &filled);
        return m->mask.opacity * opacity_of(s, side, m->mask.of);
    case MATERIAL_TWO_SIDED:
        return opacity_of(s, side, side->back ? m->two_sided.back : m->two_sided.front);
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
    return 1;
}

/* The chance of the second among the rays that are stopped. */
static float second_chance(const struct stage *s, const struct material *m,
                           const struct material_side *side)
{
    struct material filled;
    const float amount = textured_material(s, m, side->point, &filled)->mix.amount;
    const float first = (1 - amount) * opacity_of(s, side, m->mix.first);
    const float second = amount * opacity_of(s, side, m->mix.second);
    return first > 0 ? second / (first + second) : 1;
}

/* Where it lies in the part of [0, 1) that begins there: in [0, 1) again. */
static float spread(float number, float begin, float length)
{
    const float most = 1 - 0x1p-24f, v = (number - begin) / length;
    return v < most ? v : most;
}

const struct material *material_at(const struct stage *s, const struct material_side *where,
                                   float number)
{
    struct material_side side = *where;
    for (;;) {
        const struct material *m = material_of(s, side.material);
        if (m->kind == MATERIAL_MIX) {
            const float chance = second_chance(s, m, &side);
            const bool second = number < chance;
            number = second ? spread(number, 0, chance) : spread(number, chance, 1 - chance);
            side.material = second ? m->mix.second : m->mix.first;
        } else if (m->kind == MATERIAL_MASK) {
            side.material = m->mask.of;
        } else if (m->kind == MATERIAL_TWO_SIDED) {
            side.material = side.back ? m->two_sided.back : m->two_sided.front;
        } else {
            return m;
        }
    }
}
