/* work.h - what counted work has cost, as one number that is the same on every machine.
 *
 * Work is counted, not timed (struct film_work). Each ray and each vertex has a price that is a
 * pure function of the scene and its settings: of what a ray costs in it (bvh_cost.h), of whether
 * its lights are sampled in lanes, of the sampler. Prices are whole numbers of units, so that the
 * sum is exact in whatever order it is made. A unit is about a nanosecond of one core of one
 * machine, but that is not promised anywhere: what work is compared with is more work.
 *
 * The prices are held against the clock by bench_work. Whoever changes them raises WORK_VERSION:
 * units of two versions have nothing to do with each other. Building trees and tables has no price.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_WORK_H
#define COMMON_TRACE_WORK_H

#include "common/film.h"
#include "common/trace/stage.h"

enum { WORK_VERSION = 2 };

/* Of a stage that is whole but for them. */
struct stage_prices work_prices(const struct stage *);

/* Of what is counted; what w->units says is not looked at. */
uint64_t work_units(const struct stage *, const struct film_work *w);

#endif
