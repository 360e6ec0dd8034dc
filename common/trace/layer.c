/* SPDX-License-Identifier: MIT */
#include "common/trace/layer.h"

#include "common/trace/bsdf.h"
#include "common/trace/material.h"
#include "common/trace/textured.h"

static void add(double to[], vec3 v)
{
    for (int i = 0; i < 3; i++)
        to[i] += (double)v[i];
}

static rgb albedo(const struct stage *s, const struct path_vertex *v, const struct rng *rng)
{
    const struct material *m = v->material;
    if (s->wrapped)
        m = material_at(s, &(struct material_side){v->at.material, v->wo[2] < 0, &v->point},
                        rng_single(rng, rng_dimension_choice(0)));
    struct material textured;
    m = textured_material(s, m, &v->point, &textured);
    const struct square direction = rng_pair(rng, rng_dimension(0, RNG_BSDF_DIRECTION));
    const float lobe = rng_single(rng, rng_dimension(0, RNG_BSDF_LOBE));
    struct bsdf_sample next;
    if (!bsdf_sample(m, v->wo, lobe, direction, &next))
        return (rgb){0, 0, 0, 0};
    return next.weight / next.scale;
}

static double depth(const struct stage_view *view, vec3 p)
{
    const vec3 way = p - vec3_load(view->position), along = vec3_load(view->direction);
    const bool none = along[0] == 0 && along[1] == 0 && along[2] == 0;
    return (double)(none ? vec3_length(way) : vec3_dot(way, along));
}

void layer_surface(const struct stage *s, uint32_t layers, const struct wave_starts *starts,
                   const struct rng *rng, uint32_t sample, double channels[])
{
    const uint32_t replicate = sample % WAVE_LANES;
    if (!(layers & LAYER_SURFACE) || !(starts->met >> replicate & 1))
        return;
    const struct path_vertex first = wave_first(s, starts, replicate), *v = &first;
    channels[0] += 1;
    if (layers & LAYER_ALBEDO)
        add(channels + layers_at(layers, LAYER_ALBEDO), albedo(s, v, rng));
    if (layers & LAYER_NORMAL)
        add(channels + layers_at(layers, LAYER_NORMAL), v->wo[2] < 0 ? -v->frame.z : v->frame.z);
    if (layers & LAYER_DEPTH)
        channels[layers_at(layers, LAYER_DEPTH)] += depth(&s->view, v->at.p);
    if (layers & LAYER_POSITION)
        add(channels + layers_at(layers, LAYER_POSITION), v->at.p);
    if (layers & LAYER_MATERIAL && sample == 0)
        channels[layers_at(layers, LAYER_MATERIAL)] = 1 + (double)v->at.material;
}

void layer_bounces(uint32_t layers, const struct wave_terms *terms, uint32_t i, rgb radiance,
                   double channels[])
{
    double *to = channels + layers_bounces_at(layers);
    rgb before = {0, 0, 0, 0};
    for (uint32_t k = 0; k <= terms->count; k++) {
        const rgb after = k < terms->count ? terms->light[k][i] : radiance;
        for (int c = 0; c < 3; c++)
            to[3 * k + (uint32_t)c] += (double)after[c] - (double)before[c];
        before = after;
    }
}
