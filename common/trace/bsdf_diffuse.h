/* bsdf_diffuse.h - what scatters far and wide: rough diffuse surfaces, and leaves.
 *
 * Rough diffuse: J. Portsmouth, P. Kutz, S. Hill, "EON: A practical energy-preserving rough diffuse
 * BRDF", 2024. Oren and Nayar's facets in Fujii's form, and what they scatter a second time and
 * more, so that white reflects everything whatever its roughness r. With s = wo.wi - o.z i.z:
 *
 *     single  albedo A / pi (1 + r s / t),   t = max(o.z, i.z) where s > 0, else 1
 *     more    albedo' (1 - E(o)) (1 - E(i)) / (pi (1 - E_avg)),   E = A (1 + r g(z))
 *
 * A leaf is Lambertian on both of its sides: of what comes to one it reflects a part, and lets a
 * part through, which leaves the other side evenly.
 *
 * Directions as in bsdf.h: rough diffuse from the front side, a leaf from either.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_BSDF_DIFFUSE_H
#define COMMON_TRACE_BSDF_DIFFUSE_H

#include "common/trace/bsdf.h"

rgb bsdf_rough_eval(const struct material *, vec3 wo, vec3 wi);

float bsdf_rough_pdf_w(const struct material *, vec3 wo, vec3 wi);

bool bsdf_rough_sample(const struct material *, vec3 wo, float lobe, struct square direction,
                       struct bsdf_sample *);

rgb bsdf_leaf_eval(const struct material *, vec3 wo, vec3 wi);

float bsdf_leaf_pdf_w(const struct material *, vec3 wo, vec3 wi);

bool bsdf_leaf_sample(const struct material *, vec3 wo, float lobe, struct square direction,
                      struct bsdf_sample *);

#endif
