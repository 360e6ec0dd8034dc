/* oracle.h - what each method would cost on a scene, by having tried it.
 *
 * Each method renders the scene until it is twice as good as the stricter target asks in squared
 * error, has had its share of work or is out of the race; what is missing then is extrapolated by
 * the slope of its last two doublings. The method that the planner has chosen goes on, to four
 * shares, so that forecasts are held against what was seen as far as may be; methods are compared
 * by the same share, since the same method seen twice as long looks like another one. All is
 * counted work. Pure functions of the scene.
 * SPDX-License-Identifier: MIT */
#ifndef BENCH_ORACLE_H
#define BENCH_ORACLE_H

#include "common/plan.h"
#include "tests/scenes.h"

enum { ORACLE_LEVELS = 16, ORACLE_TARGETS = 2 };

extern const double oracle_targets[ORACLE_TARGETS]; /* errors, the stricter one last */

struct oracle_curve { /* after 16, 32 .. samples of a pixel */
    uint32_t count;
    double square[ORACLE_LEVELS], units[ORACLE_LEVELS];
    double own[ORACLE_LEVELS]; /* the squared error relative to its own last pixels */
    double bias, lacks;        /* of one that leaves light out: squared error, share */
    bool is_out;               /* of the race, before it had its share */
};

struct oracle {
    struct oracle_curve of[PLAN_REAL];
    struct oracle_curve chosen; /* the same, but longer */
};

/* share: of work, of a method. */
void oracle_ask(struct scenes *, double share, enum plan_candidate_kind chosen, struct oracle *);

/* Units until the error is e, of eight samples of a pixel at least; infinite when it never will be.
 */
double oracle_units(const struct oracle_curve *, double e);

/* The same over the units that it has had: what is above 1 is extrapolated. */
double oracle_reach(const struct oracle_curve *, double e);

#endif
