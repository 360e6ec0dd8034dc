/* SPDX-License-Identifier: MIT */
#include "common/trace/material.h"

static const struct material *material_of(const struct stage *s, uint32_t material)
{
    return (const struct material *)stage_at(s, s->materials) + material;
}

float material_opacity(const struct stage *s, uint32_t material, bool back)
{
    if (!s->masked)
        return 1;
    const struct material *m = material_of(s, material);
    switch (m->kind) {
    case MATERIAL_MIX:
        return (1 - m->mix.amount) * material_opacity(s, m->mix.first, back) +
               m->mix.amount * material_opacity(s, m->mix.second, back);
    case MATERIAL_MASK:
        return m->mask.opacity * material_opacity(s, m->mask.of, back);
    case MATERIAL_TWO_SIDED:
        return material_opacity(s, back ? m->two_sided.back : m->two_sided.front, back);
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
static float second_chance(const struct stage *s, const struct material *m, bool back)
{
    const float first = (1 - m->mix.amount) * material_opacity(s, m->mix.first, back);
    const float second = m->mix.amount * material_opacity(s, m->mix.second, back);
    return first > 0 ? second / (first + second) : 1;
}

/* Where it lies in the part of [0, 1) that begins there: in [0, 1) again. */
static float spread(float number, float begin, float length)
{
    const float most = 1 - 0x1p-24f, v = (number - begin) / length;
    return v < most ? v : most;
}

const struct material *material_at(const struct stage *s, uint32_t material, bool back,
                                   float number)
{
    for (;;) {
        const struct material *m = material_of(s, material);
        if (m->kind == MATERIAL_MIX) {
            const float chance = second_chance(s, m, back);
            const bool second = number < chance;
            number = second ? spread(number, 0, chance) : spread(number, chance, 1 - chance);
            material = second ? m->mix.second : m->mix.first;
        } else if (m->kind == MATERIAL_MASK) {
            material = m->mask.of;
        } else if (m->kind == MATERIAL_TWO_SIDED) {
            material = back ? m->two_sided.back : m->two_sided.front;
        } else {
            return m;
        }
    }
}
