/* scene_relief.h - the keys "normal_map" and "bump" of a material.
 *
 * Private to the scene reader.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_RELIEF_H
#define COMMON_SCENE_RELIEF_H

#include "common/scene_param.h"

/* Makes the material's relief, if it has one. */
void scene_relief_read(const struct scene_params *, struct material *);

#endif
