/* scene_specular.h - materials that mirror and refract: glass, what it
 * absorbs and where it counts; metals by name or by their constants.
 *
 * Private to the scene reader (scene_material.c). Each sets the kind, too: a material that asks for
 * less than it could has a kind of its own, which costs less.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_SPECULAR_H
#define COMMON_SCENE_SPECULAR_H

#include "common/scene_param.h"

void scene_specular_dielectric(const struct scene_params *, struct material *);

void scene_specular_pane(const struct scene_params *, struct material *);

void scene_specular_conductor(const struct scene_params *, struct material *);

#endif
