/* trial.h - what must hold for every scene, whoever has written it.
 *
 *     valid    no sample is invalid, no channel of an image is negative or no finite number
 *     alone    a sample, a row and a crop have the bits that they have in the whole
 *     lanes    a path has the bits of the definition (path.h), followed one by itself
 *     scaled   all lengths times a power of two: the same bits
 *     bright   all light times a power of two: the same bits, times that
 *     layers   change no bit of the image; the terms of light add up to it
 *     furnace  in an even light of 1 nothing is brighter than 1; also with surfaces that give what
 *              they absorb
 *     means    strategies, samplers, roulette or none, lamps cut into so many that they are a tree,
 *              the naive tracer: the same mean
 *
 * A verdict of means and furnace comes from samples. It is judged in three rounds with 16 times as
 * many samples each and other random numbers, and only who is off in all of them by as much has
 * failed: what a heavy tail hides comes nearer with the samples, a bias stays. Whose
 * error a few samples make up (less than 8 effective parts of 512) is not judged.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_STABILITY_TRIAL_H
#define TESTS_STABILITY_TRIAL_H

#include "common/trace/stage.h"
#include "tests/stability/wild.h"

enum trial {
    TRIAL_VALID,
    TRIAL_ALONE,
    TRIAL_LANES,
    TRIAL_SCALED,
    TRIAL_BRIGHT,
    TRIAL_LAYERS,
    TRIAL_FURNACE,
    TRIAL_MEANS,
    TRIALS
};

extern const char *const trial_names[TRIALS];

enum trial_verdict { TRIAL_HOLDS, TRIAL_FAILS, TRIAL_UNJUDGED };

enum { TRIAL_MOST_ROUNDS = 3 };

/* rounds: of what is judged from samples, after the first; at most TRIAL_MOST_ROUNDS. */
enum trial_verdict trial_run(enum trial, const struct wild *, uint32_t rounds, char why[240]);

/* How many comparisons of means have been made, and how many could not be judged. */
struct trial_counts {
    uint32_t made, unjudged, repeated;
};

extern struct trial_counts trial_counts;

/* --- of trial*.c alone --- */

/* Memory of the arena. NULL: prep has refused it. */
const struct stage *trial_stage(const struct scene *, struct arena *);

/* One path by itself, and what its sample weighs. */
rgb trial_path(const struct stage *, uint32_t x_px, uint32_t y_px, uint32_t sample,
               uint32_t roulette_begin);

enum trial_verdict trial_furnace(const struct wild *, uint32_t rounds, char why[240]);
enum trial_verdict trial_means(const struct wild *, uint32_t rounds, char why[240]);

#endif
