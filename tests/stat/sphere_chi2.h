/* sphere_chi2.h - does a sampler of directions follow its pdf?
 *
 * 51 x 102 cells of a chart of the sphere, by default in (cos theta, phi), the odd number so that
 * the equator lies inside cells. Expected counts by adaptive quadrature of the pdf in each cell.
 * Both sides of the mass are judged: what the pdf says in all, and what the sampler turned away.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_STAT_SPHERE_CHI2_H
#define TESTS_STAT_SPHERE_CHI2_H

#include "common/trace/sobol.h"
#include "common/vec.h"
#include "tests/stat/chi2.h"
#include "tests/stat/sphere_chart.h"

struct sphere_chi2 {
    /* False: turned away. *pdf_w: as the sampler itself states it. */
    bool (*sample)(const void *what, struct square, vec3 *w, float *pdf_w);
    float (*pdf_w)(const void *what, vec3 w);
    const void *what;
    int min_depth;  /* cells are halved at least so often: more than 0 if the pdf has edges */
    float pdf_most; /* above it pdf_off is not judged: a pdf that is infinite at an outline says
                     * nothing there that rounding leaves standing. 0: judged everywhere */
    const struct sphere_chart *chart; /* NULL: around z, rows of equal area */
    double tolerance;                 /* of the quadrature (sphere_chart.h); 0: 1e-6 */
    bool horizon;                     /* the pdf may have an edge where z = 0 */
    int more_depth;                   /* than usual */
};

struct sphere_chi2_result {
    struct chi2 chi2;
    double mass_off;  /* integral of pdf_w, less 1, plus the share turned away */
    double mass_sd;   /* its standard error */
    double pdf_off;   /* largest relative difference of pdf_w sampled and asked */
    uint32_t invalid; /* samples with a direction or pdf that is negative or no finite number */
};

struct sphere_chi2_result sphere_chi2_run(const struct sphere_chi2 *, uint32_t samples,
                                          uint64_t seed);

#endif
