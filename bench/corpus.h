/* corpus.h - small scenes of many kinds, to choose methods for.
 *
 * Every third one is held out: no rule of the planner was set for it.
 * SPDX-License-Identifier: MIT */
#ifndef BENCH_CORPUS_H
#define BENCH_CORPUS_H

#include "tests/scenes.h"

enum { CORPUS_WIDTH_PX = 48, CORPUS_HEIGHT_PX = 36 };

uint32_t corpus_count(void);
const char *corpus_name(uint32_t i);
bool corpus_is_held_out(uint32_t i);

/* False: its files are not here. The scene is in s, as the corpus's own or read from scenes/. */
bool corpus_make(uint32_t i, struct scenes *s);

#endif
