/* bsdf_principled.h - one material for most things, by the parameters of glTF 2.0.
 *
 *     clear coat       a share of it: facets of a dielectric of 1.5 (coat.h)
 *       sheen          fibres (sheen.h)
 *         base         metallic: facets with Schlick's F from the base colour, and what they would
 *                      reflect again (albedo.h)
 *                      else: facets of a dielectric, and below them a diffuse base as a plastic's
 *                      (bsdf_plastic.h), or for the share `transmission` the way through
 *                      (bsdf_glass.h), tinted by the base colour
 *
 * Alphas are squares of roughnesses. What lies below another layer gets what that lets pass, T: the
 * lobes the smaller of T(o) and T(i), so that no more passes than either allows; and what that
 * leaves over goes to the diffuse base, or to what metal reflects again (stack.h). All is
 * reciprocal, makes no light, and white loses none. From inside: bsdf_inside.h.
 *
 * Lobes are chosen by how much they reflect; eval and pdf are of all but those that are single
 * directions (bsdf.h). Directions as there, from either side if transmission is not 0.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BSDF_PRINCIPLED_H
#define COMMON_TRACE_BSDF_PRINCIPLED_H

#include "common/trace/bsdf.h"

/* The glass of what is clear. */
struct material bsdf_principled_glass(const struct material *);

rgb bsdf_principled_eval(const struct material *, vec3 wo, vec3 wi);

float bsdf_principled_pdf_w(const struct material *, vec3 wo, vec3 wi);

bool bsdf_principled_sample(const struct material *, vec3 wo, float lobe, struct square direction,
                            struct bsdf_sample *);

#endif
