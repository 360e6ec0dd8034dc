/* wave_pick.h - of many lights one for each path of a wave, chosen side by side (light_tree.h).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_WAVE_PICK_H
#define COMMON_TRACE_WAVE_PICK_H

#include "common/trace/light.h"
#include "common/trace/wave.h"

/* For all that go on, with the numbers of w->lamp. A path that has no use
 * for a light gets none. */
void wave_pick(const struct wave *, struct light_pick picks[WAVE_LANES]);

#endif
