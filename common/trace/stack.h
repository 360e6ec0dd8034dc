/* stack.h - what layers take from a lobe below them beyond what its own light loses in them.
 *
 * Of a lobe below layers that let T(z) pass, T(o) times it may come out, if no light is to be lost;
 * reciprocity wants the same both ways. The smaller of T(o) and T(i) is reciprocal and never too
 * much, but where i is lower than o it is too little, by
 *
 *     L(o) = integral over i of lobe(o, i) (T(o) - min(T(o), T(i))).
 *
 * That light is still inside, and goes to a wide lobe, as what several facets reflect does
 * (albedo.h): with R(o) all that is left for it, R(o) R(i) / (pi R), R the mean of R(o) weighted by
 * the cosine. So nothing is lost, whatever the layers are.
 *
 * T rises with z. It is taken as linear in sqrt(z) within each of eight cells, and how much of a
 * cell lies between o and i, on the lobe's average, is tabled (tests/tool_stack.c): L is then a sum
 * over cells, for all layers. Between knots it is off by up to 0.004 for what lets pass as little
 * as a coat of 3. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_STACK_H
#define COMMON_TRACE_STACK_H

#include "common/color.h"

enum { STACK_CELLS = 8, STACK_WIDTHS = 17, STACK_COSINES = 17 };

enum stack_lobe {
    STACK_FACETS,  /* GGX (microfacet.h) that reflects everything; width: alpha */
    STACK_GRAZING, /* the same times (1 - c)^5, c the cosine at the facet (Schlick's F) */
    STACK_FIBRES,  /* sheen.h; width: roughness */
    STACK_LOBES
};

/* T at the cosines (k / 8)^2. */
struct stack {
    rgb passes[STACK_CELLS + 1];
};

/* L. */
rgb stack_loss(const struct stack *, enum stack_lobe, float width, float cos);

/* The mean, weighted by the cosine, of what is given at the cosines (k / 8)^2 (Simpson's rule). */
rgb stack_mean(const rgb at[STACK_CELLS + 1]);

/* In units of 1 / 65535: [lobe][width][sqrt(cos)][cell]. Widths: sqrt(alpha) from 0 to 1; roughness
 * from 0.1 to 1. */
extern const uint16_t stack_table[STACK_LOBES][STACK_WIDTHS][STACK_COSINES][STACK_CELLS];

#endif
