/* tap.h - Test Anything Protocol, what `prove` reads. A failed check is reported and the program
 * goes on; tap_done says how many there were and is main's return value.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_TAP_H
#define TESTS_TAP_H

#include "common/base.h"

/* Both return whether the check held. The text says the property: "expired lease returns to ready". */
bool ok(bool cond, const char *fmt, ...) PRINTF(2, 3);
bool near(double got, double want, double tolerance, const char *fmt, ...) PRINTF(4, 5);
void diag(const char *fmt, ...) PRINTF(1, 2); /* a comment line; failures explain themselves */
void skip(const char *fmt, ...) PRINTF(1, 2); /* counts as one check that was skipped, and says why */
int tap_done(void);

#endif
