/* bsdf.h - how a surface scatters: eval, sample, pdf.
 *
 * Directions are local and unit: z is the shading normal of the front side, x the tangent where the
 * material needs it (metal with two widths), wo and wi point away from the surface, and either may
 * lie below it. Whether the geometric normal agrees is the caller's business (path_shade.h).
 * Opaque materials look the same from both sides. Only radiance is transported, towards
 * the camera.
 *
 * A delta material scatters into single directions, which eval and pdf cannot see (both 0): only
 * sampling finds them.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BSDF_H
#define COMMON_TRACE_BSDF_H

#include "common/scene.h"
#include "common/trace/sobol.h"

/* Below this GGX width a surface is perfectly smooth. The lobe is then narrower than a tenth of a
 * degree and the change cannot be seen (albedos move by less than 1e-3); and rounding moves a half
 * vector by 2^-23, a ten-thousandth of the lobe: further down, the density at which float
 * directions are sampled would visibly part from pdf. */
#define BSDF_LEAST_ALPHA 0x1p-10f

struct bsdf_sample {
    vec3 wi;
    rgb weight;  /* f |wi.z| / pdf */
    float pdf_w; /* what bsdf_pdf_w says; 0: a delta direction */
    float scale; /* the part of weight that is only the change of radiance on entering another
                  * index of refraction: (near / far)^2; 1 for reflection. It is undone when
                  * the path leaves again, so roulette divides it out */
};

static inline bool bsdf_is_delta(const struct material *m)
{
    if (m->kind == MATERIAL_DIFFUSE) /* most are: said before the choice */
        return false;
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
        return false;
    case MATERIAL_MIRROR:
    case MATERIAL_PANE:
        return true;
    case MATERIAL_DIELECTRIC: /* refraction turns light by less than (ior - 1) alpha */
        return m->dielectric.alpha < BSDF_LEAST_ALPHA ||
               m->dielectric.alpha * (m->dielectric.ior - 1) < BSDF_LEAST_ALPHA;
    case MATERIAL_CONDUCTOR:
        return m->conductor.alpha < BSDF_LEAST_ALPHA;
    case MATERIAL_RETROREFLECTOR:
        return m->retro.alpha < BSDF_LEAST_ALPHA;
    case MATERIAL_ROUGH_DIFFUSE:
    case MATERIAL_LEAF:
    case MATERIAL_PLASTIC:
    case MATERIAL_PRINCIPLED:
    case MATERIAL_CLOTH:
        return false;
    case MATERIAL_MIX: /* looked through before (material.h) */
    case MATERIAL_MASK:
    case MATERIAL_TWO_SIDED:
        break;
    case MATERIAL_METAL:
        return m->metal.alpha_x < BSDF_LEAST_ALPHA && m->metal.alpha_y < BSDF_LEAST_ALPHA;
    }
    __builtin_unreachable();
}

/* Whether the viewer's direction changes little but the side that is seen. */
static inline bool bsdf_is_matte(const struct material *m)
{
    const uint32_t matte =
        1u << MATERIAL_DIFFUSE | 1u << MATERIAL_ROUGH_DIFFUSE | 1u << MATERIAL_LEAF;
    return matte >> m->kind & 1;
}

/* Whether light surely stays on the side from which it came. */
static inline bool bsdf_is_opaque(const struct material *m)
{
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
    case MATERIAL_ROUGH_DIFFUSE:
    case MATERIAL_MIRROR:
    case MATERIAL_CONDUCTOR:
    case MATERIAL_METAL:
    case MATERIAL_RETROREFLECTOR:
    case MATERIAL_PLASTIC:
    case MATERIAL_CLOTH:
        return true;
    case MATERIAL_PRINCIPLED:
        return m->principled.transmission == 0;
    case MATERIAL_DIELECTRIC:
    case MATERIAL_LEAF:
    case MATERIAL_PANE:
    case MATERIAL_MIX: /* of anything */
    case MATERIAL_MASK:
    case MATERIAL_TWO_SIDED:
        return false;
    }
    __builtin_unreachable();
}

/* Whether sampling chooses among kinds of scattering: else bsdf_sample does not look at `lobe`. */
static inline bool bsdf_has_lobes(const struct material *m)
{
    const uint32_t lobed = 1u << MATERIAL_DIELECTRIC | 1u << MATERIAL_ROUGH_DIFFUSE |
                           1u << MATERIAL_LEAF | 1u << MATERIAL_PLASTIC |
                           1u << MATERIAL_PRINCIPLED | 1u << MATERIAL_CLOTH | 1u << MATERIAL_PANE |
                           1u << MATERIAL_METAL;
    return lobed >> m->kind & 1;
}

/* f |wi.z|. */
rgb bsdf_eval(const struct material *, vec3 wo, vec3 wi);

float bsdf_pdf_w(const struct material *, vec3 wo, vec3 wi);

/* False: this sample carries nothing, the path ends. The chances of that belong to the
 * distribution: pdf_w integrates to 1 less them. */
bool bsdf_sample(const struct material *, vec3 wo, float lobe, struct square direction,
                 struct bsdf_sample *);

#endif
