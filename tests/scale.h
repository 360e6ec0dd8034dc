/* scale.h - the same scene in other units. Of its shapes, lights and materials, which the scene
 * must have for itself; meshes and images stay. SPDX-License-Identifier: MIT */
#ifndef TESTS_SCALE_H
#define TESTS_SCALE_H

#include "common/scene.h"

/* All lengths, and what hangs on them, so that the image stays: the film's pixels are in no unit.
 */
void scale_lengths(struct scene *, float k);
/* All light. */
void scale_radiance(struct scene *, float k);

#endif
