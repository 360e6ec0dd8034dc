/* SPDX-License-Identifier: MIT */
#include "common/trace/stack.h"

#include "common/trace/knot.h"

static float blend_rows(const uint16_t *row, float f)
{
    return knot_blend((float)row[0], (float)row[STACK_CELLS], f);
}

/* Of facets narrower than the first knot everything grows like alpha, from 0. */
static struct knot knot_of_width(enum stack_lobe lobe, float width)
{
    struct knot k = knot_of(lobe == STACK_FIBRES ? (width - 0.1f) / 0.9f : __builtin_sqrtf(width),
                            STACK_WIDTHS);
    if (lobe != STACK_FIBRES && k.i == 0)
        k.f *= k.f;
    return k;
}

rgb stack_loss(const struct stack *s, enum stack_lobe lobe, float width, float cos)
{
    const struct knot kw = knot_of_width(lobe, width);
    const struct knot kz = knot_of(__builtin_sqrtf(cos), STACK_COSINES);
    const uint16_t *a = stack_table[lobe][kw.i][kz.i], *b = stack_table[lobe][kw.i + 1][kz.i];
    rgb sum = {0, 0, 0, 0};
    for (int j = 0; j < STACK_CELLS; j++) {
        const float share = knot_blend(blend_rows(a + j, kz.f), blend_rows(b + j, kz.f), kw.f);
        sum += (s->passes[j + 1] - s->passes[j]) * share;
    }
    return sum * (1.0f / 65535);
}

/* The integral over z = s^2 of 2 z dz = 4 s^3 ds. */
rgb stack_mean(const rgb at[STACK_CELLS + 1])
{
    const float h = 1.0f / STACK_CELLS;
    rgb sum = at[STACK_CELLS];
    for (int k = 1; k < STACK_CELLS; k++) {
        const float s = h * (float)k;
        sum += at[k] * (s * s * s * (k % 2 ? 4 : 2));
    }
    return sum * (4 * h / 3);
}
