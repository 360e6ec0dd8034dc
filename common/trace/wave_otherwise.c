/* What waves do otherwise by other methods than path's with Sobol's points: apart, so that the
 * usual way stays short. SPDX-License-Identifier: MIT */
#include "common/trace/wave.h"

#include "common/trace/material.h"
#include "common/trace/textured.h"

void wave_draw_otherwise(struct wave *w)
{
    const struct scene_settings *how = &w->stage->settings;
    w->draw.first = w->bounce == 0;
    w->draw.may_end = w->bounce >= w->roulette_begin;
    w->draw.direction = sampler_pair(how, &w->rng, rng_dimension(0, RNG_BSDF_DIRECTION));
    w->lamp = sampler_pair_bits(how, &w->rng, rng_dimension(0, RNG_LIGHT));
    w->draw.lobe = sampler_single(how, &w->rng, rng_dimension(0, RNG_BSDF_LOBE));
    w->draw.roulette = sampler_single(how, &w->rng, rng_dimension(0, RNG_ROULETTE));
}

uint32_t wave_smooth_alone(const struct wave *w, uint32_t next)
{
    for (uint32_t left = next; left; left &= left - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(left);
        if ((w->plain >> i & 1 ? w->lanes.pdf_w[i] : w->paths[i].pdf_w) != 0)
            next &= ~(1u << i);
    }
    return next;
}

/* The vertices' materials, where some are made of others; these are never plain. (What a path in a
 * body sees as an interface is made of nothing else.) */
void wave_choose_materials(struct wave *w)
{
    const struct material *materials = stage_at(w->stage, w->stage->materials);
    const f32x8 number = rng8_single(&w->rng, rng_dimension_choice(0));
    for (uint32_t left = w->going & ~w->plain; left; left &= left - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(left);
        struct path_vertex *v = &w->paths[i].vertex;
        if (v->material == &materials[v->at.material]) {
            const struct material_side side = {v->at.material, v->wo[2] < 0, &v->point};
            v->material = material_at(w->stage, &side, number[i]);
        }
    }
}

/* The materials of the vertices that have textures, filled. */
void wave_apply_textures(struct wave *w)
{
    for (uint32_t left = w->going & ~w->plain; left; left &= left - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(left);
        struct path_vertex *v = &w->paths[i].vertex;
        v->material = textured_material(w->stage, v->material, &v->point, &w->textured[i]);
    }
}
