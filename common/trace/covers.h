/* covers.h - what lies over the base of the principled material: fibres, and a coat over those.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_COVERS_H
#define COMMON_TRACE_COVERS_H

#include "common/scene.h"
#include "common/trace/coat.h"
#include "common/trace/sheen.h"

struct covers {
    float share; /* of the coat */
    struct coat coat;
    rgb sheen;
    float sheen_roughness;
};

static inline struct covers covers_of(const struct material *m)
{
    const float rough = m->principled.clearcoat_roughness;
    return (struct covers){m->principled.clearcoat,
                           {1.5f, rough * rough},
                           m->principled.sheen_color,
                           m->principled.sheen_roughness};
}

static inline bool covers_any(const struct covers *c)
{
    return c->share > 0 || !rgb_is_black(c->sheen);
}

/* The share of light along the cosine that each lets pass. */
static inline float covers_coat_passes(const struct covers *c, float cos)
{
    return c->share > 0 ? 1 - c->share * (1 - coat_passes(&c->coat, cos)) : 1;
}

static inline rgb covers_sheen_passes(const struct covers *c, float cos)
{
    if (rgb_is_black(c->sheen))
        return rgb_gray(1);
    return 1 - c->sheen * sheen_albedo(c->sheen_roughness, cos);
}

static inline rgb covers_pass(const struct covers *c, float cos)
{
    return covers_sheen_passes(c, cos) * covers_coat_passes(c, cos);
}

#endif
