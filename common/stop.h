/* stop.h - is an image good enough for its error target, and may one believe so?
 *
 * Stopping when an estimate happens to be small makes images too dark where light comes seldom: of
 * a pixel that is 200 with one sample in 200, and else black, "no error at all" is what most see at
 * first, and a rule that believes it after 16 samples ends with a mean of .08 instead of 1. So the
 * estimate alone does not count:
 *
 * - the image has at least STOP_LEAST_NEFF effective samples (block.h: (sum x)^2 / sum x^2, of
 *   all pixels together). Where that many have come, having waited for the last of them shifts the
 *   mean by less than 1 %
 * - the upper end of the error's 95 % interval (estimate.h) is at most STOP_SLACK times the target
 * - an image that is all black is so for sure when no camera ray has met anything; else it has to
 *   be black for STOP_DARK_SPP samples
 *
 * What single blocks lack is said by evidence.h, and does not keep a job from ending: a black wall
 * would. A function of the film alone. SPDX-License-Identifier: MIT */
#ifndef COMMON_STOP_H
#define COMMON_STOP_H

#include "common/film.h"

enum { STOP_LEAST_NEFF = 256, STOP_DARK_SPP = 4096 };

#define STOP_SLACK 1.2

bool stop_is_due(const struct film *, double target); /* target: of estimate_error, > 0 */

#endif
