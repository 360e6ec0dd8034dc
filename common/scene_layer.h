/* scene_layer.h - diffuse surfaces, leaves and layers, as their document gives them.
 *
 * Private to the scene reader (scene_material.c). SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_LAYER_H
#define COMMON_SCENE_LAYER_H

#include "common/scene_param.h"

void scene_layer_rough_diffuse(const struct scene_params *, struct material *);
void scene_layer_retroreflector(const struct scene_params *, struct material *);
void scene_layer_leaf(const struct scene_params *, struct material *);

#endif
