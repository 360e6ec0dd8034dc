/* corpus.h - small scenes of many kinds, to choose methods for.
 *
 * Every third one is held out: no rule of the planner was set for it. But what came of them has
 * been seen since the first planner, so there are fresh ones, made for the second and looked at
 * when it was done, and last ones, made when the third was done and looked at once: no rule has
 * been changed since. SPDX-License-Identifier: MIT */
#ifndef BENCH_CORPUS_H
#define BENCH_CORPUS_H

#include "tests/scenes.h"

enum { CORPUS_WIDTH_PX = 160, CORPUS_HEIGHT_PX = 120 };

enum corpus_part { CORPUS_TUNED, CORPUS_HELD_OUT, CORPUS_FRESH, CORPUS_LAST, CORPUS_PARTS };

uint32_t corpus_count(void);
const char *corpus_name(uint32_t i);
enum corpus_part corpus_part(uint32_t i);

/* False: its files are not here. The scene is in s, as the corpus's own or read from scenes/. */
bool corpus_make(uint32_t i, struct scenes *s);

#endif
