/* SPDX-License-Identifier: MIT */
#include "tests/judge.h"

#include <math.h>

#include "tests/stat/stat.h"
#include "tests/tap.h"

uint32_t judge_samples(uint32_t quick)
{
    return stat_tries(quick, 25 * quick / 4);
}

/* The smallest bias that must be found. */
static double gate(void)
{
    if (STAT_SLOW > 1)
        return 0.25;
    return stat_is_long() ? 0.002 : 0.005;
}

void judge_mean(struct scenes_mean m, double truth, const char *name)
{
    const double z_accept = 3.9, z_detect = 3.9 + 2.33;
    const double off = fabs(m.mean - truth), rounding = 1e-5 * truth;
    ok(off <= z_accept * m.error + rounding && z_detect * m.error <= gate() * truth,
       "%s: %.6f is %.6f (%.1f standard errors; detects %.2f %%)", name, truth, m.mean,
       off / (m.error + rounding), 100 * z_detect * m.error / truth);
}

void judge_scene(struct scenes *s, uint32_t spp, double truth, const char *name)
{
    struct film film;
    const uint32_t samples = judge_samples(spp);
    const struct stage *stage = scenes_stage(s);
    scenes_render(stage, samples < 8 ? 8 : samples, &film);
    judge_mean(scenes_mean(&film, 1), truth, name);
    if (film.invalid_count)
        ok(false, "%s: %lu invalid samples", name, (unsigned long)film.invalid_count);
    film_release(&film);
    scenes_release(s);
}
