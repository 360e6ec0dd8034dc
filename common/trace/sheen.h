/* sheen.h - fibres that stand up from cloth: bright where the surface is seen from the side.
 *
 * Facets whose normals lie near the surface, D = (k + 2) / (2 pi) sin^k (A. Conty Estevez,
 * C. Kulla, "Production Friendly Microfacet Sheen BRDF", 2017, k = 1 / roughness^2), in V-shaped
 * cavities (K. Torrance, E. Sparrow, JOSA 57, 1967), whose masking needs no table and makes no
 * light whatever D is. Visible facets are sampled exactly: E. Heitz, E. d'Eon, "Importance Sampling
 * Microfacet-Based BSDFs using the Distribution of Visible Normals", EGSR 2014, section 5.
 *
 * E(z), how much of all light fibres that reflect everything send back, is tabled
 * (tests/tool_sheen.c) and too large by up to 0.006, so that what stands below gets no more than is
 * left. Directions: local, z > 0. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_SHEEN_H
#define COMMON_TRACE_SHEEN_H

#include "common/trace/sobol.h"
#include "common/vec.h"

enum { SHEEN_WIDTHS = 33, SHEEN_COSINES = 33 };

/* Roughness in [0.1, 1] and sqrt(cos) in [0, 1], both evenly. */
struct sheen_table {
    float albedo[SHEEN_WIDTHS][SHEEN_COSINES];
    float mean[SHEEN_WIDTHS]; /* as sheen_table_albedo has it, weighted by the cosine */
};

extern const struct sheen_table sheen_table;

float sheen_table_albedo(const struct sheen_table *, float roughness, float cos);

float sheen_albedo(float roughness, float cos);
float sheen_mean(float roughness);

/* f i.z of fibres that reflect everything; its density by sheen_sample. */
float sheen_eval(float roughness, vec3 wo, vec3 wi);
float sheen_pdf_w(float roughness, vec3 wo, vec3 wi);

/* side: in [0, 1), of a cavity. False: into the surface. */
bool sheen_sample(float roughness, vec3 wo, float side, struct square, vec3 *wi);

#endif
