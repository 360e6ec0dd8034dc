/* scene_coat.h - diffuse surfaces, leaves and coats, as their document gives them.
 *
 * Private to the scene reader (scene_material.c). SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_COAT_H
#define COMMON_SCENE_COAT_H

#include "common/scene_param.h"

void scene_coat_rough_diffuse(const struct scene_params *, struct material *);
void scene_coat_retroreflector(const struct scene_params *, struct material *);
void scene_coat_leaf(const struct scene_params *, struct material *);
void scene_coat_plastic(const struct scene_params *, struct material *);
void scene_coat_cloth(const struct scene_params *, struct material *);
void scene_coat_principled(const struct scene_params *, struct material *);

#endif
