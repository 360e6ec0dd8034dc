/* albedo_table.h - the numbers behind albedo.h: tests/tool_albedo.c makes albedo_table.c.
 *
 * Knots lie evenly in the coordinates of albedo.c, from 0 to 1. The shares of light are in units of
 * 1 / 65535. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_ALBEDO_TABLE_H
#define COMMON_TRACE_ALBEDO_TABLE_H

#include "common/trace/facet.h"

enum {
    ALBEDO_WIDTHS = 33, /* of one width */
    ALBEDO_HEIGHTS = 33,
    ALBEDO_WIDER = 9, /* of two */
    ALBEDO_RATIOS = 6,
    ALBEDO_TURNS = 5,
    ALBEDO_FEWER_HEIGHTS = 9,
    ALBEDO_MEAN_WIDTHS = 65, /* of the means */
    ALBEDO_MEAN_WIDER = 17,
    ALBEDO_MEAN_RATIOS = 11,
};

struct albedo_table {
    uint16_t one[ALBEDO_WIDTHS * ALBEDO_HEIGHTS]; /* by rows: [width][height] */
    /* [width][ratio][turn][height] */
    uint16_t two[ALBEDO_WIDER * ALBEDO_RATIOS * ALBEDO_TURNS * ALBEDO_FEWER_HEIGHTS];
    float mean_one[ALBEDO_MEAN_WIDTHS];
    float mean_two[ALBEDO_MEAN_WIDER * ALBEDO_MEAN_RATIOS]; /* [width][ratio] */
};

extern const struct albedo_table albedo_table;

/* albedo_missing by another table: for who makes one. */
float albedo_missing_by(const struct albedo_table *, vec3 w, struct facet);

#endif
