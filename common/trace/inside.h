/* inside.h - what coat and sheen over rough glass keep of light that comes from inside it.
 *
 * From outside, what lies over glass takes its share and lets T(z) pass (stack.h). Light that goes
 * the other way meets it too, having passed the glass: of the light from o, below, what goes on to
 * i, above, is 1 - T(i) short, and all of that is sent back, below:
 *
 *     K(o) = integral over i of passing(o, i) (1 - T(i)),
 *
 * passing all that the glass alone lets through (bsdf_glass.h, with `multiscatter`). Two lobes
 * return it. One is narrow, and turns into the mirror that a smooth coat over clear glass is:
 * facets reflect, of what they do not themselves,
 *
 *     q(c) = a + b (1 - min(1, c + alpha))^6,
 *
 * c the cosine of the refracted light at the facet, a what the coat reflects of light straight on,
 * a + b of grazing light. That is less than a coat reflects, and with the facet's light moved up by
 * alpha the lobe never returns more than K. What it leaves, R(o) = K(o) - N(o), comes back even, as
 * R(o) R(i) / (pi R), R the mean of R(o) weighted by the cosine. So the body loses nothing.
 *
 * 1 - T is taken as linear in sqrt(z) within each of eight cells; K is then a sum over its values
 * at their ends, N one over a and b, and their factors are tabled (tests/tool_inside.c) by the
 * direction of the refracted light, so that the knots lie along the critical angle. What several
 * facets of the glass let through is K's part that is a product, and has but one row.
 * Between knots R is short by up to 0.015, as a rule by 0.003, and too much by 0.001 at most, below
 * a cosine of 0.1 by 0.004, where the other lobes are short of more: light may be lost, but is not
 * made. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_INSIDE_H
#define COMMON_TRACE_INSIDE_H

#include "common/color.h"
#include "common/trace/stack.h"

enum {
    INSIDE_IORS = 7,
    INSIDE_WIDTHS = 17,
    INSIDE_BEYOND = 12, /* steps from grazing to the critical angle */
    INSIDE_WITHIN = 16, /* from there to straight on */
    INSIDE_HEIGHTS = INSIDE_BEYOND + INSIDE_WITHIN + 1,
    INSIDE_CELLS = STACK_CELLS + 1,
    INSIDE_PARTS = INSIDE_CELLS + 2 /* then N's of a and of b */
};

/* Evenly spaced: the root of (n - 1) / (n + 1) from that of 1.1, up to 3; sqrt(alpha) from 2^-5 to
 * 1; inside_height. */
struct inside_table {
    uint16_t part[INSIDE_IORS][INSIDE_WIDTHS][INSIDE_HEIGHTS][INSIDE_PARTS]; /* of 65535 */
    float mean[INSIDE_IORS][INSIDE_WIDTHS][INSIDE_PARTS];                    /* as part is read */
    /* Of light that several facets let through, what is kept. */
    float several[INSIDE_IORS][INSIDE_WIDTHS][INSIDE_CELLS];
};

extern const struct inside_table inside_table;

struct inside_glass {
    float ior, alpha;       /* of the glass: below over above; GGX width */
    float straight, steep;  /* a, b */
    rgb kept[INSIDE_CELLS]; /* 1 - T at the cosines (k / 8)^2 */
};

/* q, of a facet whose refracted light has the cosine. */
float inside_mirrors(const struct inside_glass *, float cos);

/* R; missing: what several facets do with light along the cosine (glass_albedo.h). */
rgb inside_left(const struct inside_glass *, float cos, float missing);

/* Its mean, from that of `missing`. */
rgb inside_mean(const struct inside_glass *, float missing_mean);

/* Knots from 0 on, beyond the critical angle and then within it. */
float inside_height(float ior, float alpha, float cos);

/* The factors at a cosine, by a table. */
void inside_parts(const struct inside_table *, const struct inside_glass *, float cos,
                  float parts[INSIDE_PARTS]);

#endif
