/* scene_param.h - the parameters of a material, as its document gives them.
 *
 * Private to the scene reader. One function for each type of parameter, so that what every
 * parameter may be is said in one place: its value, or {"texture": NAME} with a scale and, for a
 * number, a channel, which becomes a slot of the material. The output is a member of that material,
 * and where a texture drives it, it takes what the texture's value 1 would make of it. Absent: the output keeps its default; that a required key
 * is absent has been said by scene_params_of. SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_PARAM_H
#define COMMON_SCENE_PARAM_H

#include "common/scene_doc.h"
#include "common/scene_names.h"

struct scene_params { /* of one material */
    struct scene_doc *doc;
    const struct scene_at *at; /* the object that holds them */
    struct scene *scene;       /* whose slots grow: those of a material after those of the last */
    const struct scene_names *textures;
    struct material *material;
};

/* These keys, those that every material may have, and no others; `what` names the material in
 * messages: "a mirror material". */
void scene_params_of(const struct scene_params *, const char *what, const struct scene_key *keys,
                     size_t count);

void scene_param_rgb(const struct scene_params *, const char *key, struct scene_range, rgb *);
void scene_param_number(const struct scene_params *, const char *key, struct scene_range, float *);
/* The key "channel" of an object that names a texture; absent: true. */
bool scene_param_channel(const struct scene_params *, const struct scene_at *value,
                         enum material_channel *);
/* One number for two members. */
void scene_param_both(const struct scene_params *, const char *key, struct scene_range, float *,
                      float *);

#endif
