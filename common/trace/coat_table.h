/* coat_table.h - how much light rough coats let pass; made by tests/tool_coat.c.
 *
 * Coordinates, all evenly spaced from 0 to 1:
 *
 *     ior     r = (n - 1) / (n + 1), between those of 1.1 and 3
 *     width   sqrt(alpha), but no less than 2^-5
 *     slope   sqrt(y), y = alpha sin / (z + S(z)): 0 from above, 1 along the surface
 *
 * A facet that is seen lies at the cosine m = (z + S(z)) / 2 on average. With E1 the albedo of
 * facets that reflect everything, T = 1 - E1 (1 - ratio (1 - F(m))), and ratio hardly changes.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_COAT_TABLE_H
#define COMMON_TRACE_COAT_TABLE_H

#include "common/base.h"

enum { COAT_IORS = 9, COAT_WIDTHS = 33, COAT_SLOPES = 33 };

#define COAT_RATIO_ONE 2048 /* a ratio of 1 */

struct coat_table {
    uint16_t ratio[COAT_IORS][COAT_WIDTHS][COAT_SLOPES];
    float mean[COAT_IORS][COAT_WIDTHS]; /* of T, as coat_table_passes has it */
};

extern const struct coat_table coat_table;

/* T by a table; alpha at least 2^-10. */
float coat_table_passes(const struct coat_table *, float ior, float alpha, float cos);

#endif
