/* judge.h - is a rendered mean its truth?
 *
 * The gate of docs/accuracy.md: the mean lies within 3.9 standard errors of the truth, and the
 * standard error is so small that a bias of 0.5 % fails with probability 0.99; in the long tier,
 * which has more samples (judge_samples), a bias of 0.2 %.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_JUDGE_H
#define TESTS_JUDGE_H

#include "tests/scenes.h"

/* This tier's number for the quick one's: in the long tier 6.25 times as many, which makes the
 * error 2.5 times smaller. */
uint32_t judge_samples(uint32_t quick);

void judge_mean(struct scenes_mean, double truth, const char *name);

/* Renders judge_samples(spp), judges the green channel, and ends the scene. */
void judge_scene(struct scenes *, uint32_t spp, double truth, const char *name);

#endif
