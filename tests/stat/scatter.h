/* scatter.h - the laws that every BSDF obeys, as procedures over its three functions.
 *
 * What is sampled follows the pdf, and pdf and rejections add up to 1 (scatter_follows). A weight
 * is eval / pdf, and nothing that eval has is out of the sampler's reach (scatter_draw). No more
 * light leaves than came (scatter_draw, scatter_albedo). Light goes back the way it came
 * (scatter_reciprocal). Together they mean that sampling is unbiased. Materials that scatter into
 * single directions have only scatter_choices, which says their law exactly; those that also do so
 * are judged by the rest, and the single directions count as turned away.
 *
 * Directions are local, z the normal, as in common/trace/bsdf.h.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_STAT_SCATTER_H
#define TESTS_STAT_SCATTER_H

#include "common/trace/bsdf.h"
#include "tests/stat/sphere_chi2.h"
#include "tests/stat/stat.h"

/* What of it is looked at: a material that also lets light through has two lobes, and a chart of
 * the sphere fits one. What goes elsewhere counts as turned away. */
enum scatter_side { SCATTER_ALL, SCATTER_BACK, SCATTER_THROUGH };

struct scatter {
    rgb (*eval)(const void *what, vec3 wo, vec3 wi); /* f |wi.z| */
    float (*pdf_w)(const void *what, vec3 wo, vec3 wi);
    bool (*sample)(const void *what, vec3 wo, float lobe, struct square, struct bsdf_sample *);
    const void *what;
    double ior;  /* index of refraction below, over that above; 1: none, or nothing passes */
    float alpha; /* width of the lobe around the mirrored or refracted direction, 1 for none: where
                  * to look */
    bool retro;  /* the lobe is around wo itself */
    double most; /* a weight is below it */
    bool slow;   /* eval takes ten times as long as others': the long tier asks less often */
    enum scatter_side side;
};

struct scatter scatter_of(const struct material *); /* borrowed: bsdf.h's functions */

struct sphere_chi2_result scatter_follows(const struct scatter *, vec3 wo, uint32_t samples,
                                          uint64_t seed);

struct scatter_draw {
    struct stat_mean albedo[3]; /* of weight / scale, 0 where the sample was turned away */
    struct stat_mean delta[3];  /* the same of single directions alone */
    double most;                /* largest weight / scale of all channels */
    double off;                 /* largest relative difference of weight pdf_w and eval */
    uint32_t beyond;            /* of as many even directions: eval is not 0 where pdf_w is 0 */
    uint32_t invalid;           /* values that are negative or no finite numbers */
};

struct scatter_draw scatter_draw(const struct scatter *, vec3 wo, uint32_t samples, uint64_t seed);

/* The integral of eval / scale, of which the channel is 0 to 2, by quadrature: it knows nothing of
 * sampling. */
double scatter_albedo(const struct scatter *, vec3 wo, int channel);

struct scatter_reciprocal {
    double worst;     /* |f(o, i) - f(i, o)| over what is allowed: see below */
    uint32_t alive;   /* pairs with an f that is not 0 */
    uint32_t invalid; /* values that are negative or no finite numbers */
};

/* Half of the pairs are even over the sphere, in half i is sampled from o, so that narrow lobes are
 * met. With an index, f n_i^2 (radiance) is what is equal both ways. Allowed are 1e-6 and, of the
 * larger of the two, 1e-5 + 2^-20 / |o + i|: directions that are unit to 2^-24 leave the cosine
 * between facet and light in doubt by 2^-22 / |o + i|, felt where both graze, and a metal's Fresnel
 * term is up to 4 times as steep. Of a retroreflector i is turned half round for it. */
struct scatter_reciprocal scatter_reciprocal(const struct scatter *, uint32_t pairs, uint64_t seed);

/* A single direction with its probability, in steps of 2^-24. */
struct scatter_choice {
    double chance;
    struct bsdf_sample sample;
};

/* The directions that a delta material chooses from by `lobe`, in order, two at most; how many. */
int scatter_choices(const struct scatter *, vec3 wo, struct scatter_choice[2]);

#endif
