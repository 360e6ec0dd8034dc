/* scene_wrap.h - materials made of others: mix, mask, two sided.
 *
 * Private to the scene reader. They name materials that may stand behind them in the document, so
 * they are read twice: their keys and numbers with all materials, then what they name.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_WRAP_H
#define COMMON_SCENE_WRAP_H

#include "common/scene_names.h"
#include "common/scene_param.h"

enum { SCENE_WRAP_DEPTH = 8 }; /* how deep they may be nested */

void scene_wrap_mix(const struct scene_params *, struct material *);
void scene_wrap_mask(const struct scene_params *, struct material *);
void scene_wrap_two_sided(const struct scene_params *, struct material *);

/* Once all materials are read: `materials` holds them in the document. */
void scene_wrap_bind(struct scene_doc *, const struct scene_at *materials,
                     const struct scene_names *, struct scene *);

/* Whether rays may go straight on where the material is. */
bool scene_wrap_has_mask(const struct scene *, uint32_t material);

#endif
