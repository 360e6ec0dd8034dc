/* sphere_chi2.h - does a sampler of directions follow its pdf?
 *
 * 51 x 102 cells in (cos theta, phi), the odd number so that the equator lies inside cells.
 * Expected counts by adaptive quadrature of the pdf in each cell. Both sides of the mass are
 * judged: what the pdf says in all, and what the sampler turned away.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_SPHERE_CHI2_H
#define TESTS_SPHERE_CHI2_H

#include "common/trace/sobol.h"
#include "common/vec.h"

struct sphere_chi2 {
    /* False: turned away. *pdf_w: as the sampler itself states it. */
    bool (*sample)(const void *what, struct square, vec3 *w, float *pdf_w);
    float (*pdf_w)(const void *what, vec3 w);
    const void *what;
    int min_depth; /* cells are halved at least so often: more than 0 if the pdf has edges */
    float pdf_most; /* above it pdf_off is not judged: a pdf that is infinite at an outline says
                     * nothing there that rounding leaves standing. 0: judged everywhere */
};

struct sphere_chi2_result {
    double p;        /* of the chi-square test */
    double mass_off; /* integral of pdf_w, less 1, plus the share turned away */
    double mass_sd;  /* its standard error */
    double pdf_off;  /* largest relative difference of pdf_w sampled and asked */
};

struct sphere_chi2_result sphere_chi2_run(const struct sphere_chi2 *, uint32_t samples,
                                          uint64_t seed);

#endif
