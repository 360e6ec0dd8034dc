/* scene_share.h - parameters that are shares of light, and what becomes of those above 1.
 *
 * Private to the scene reader. No surface returns more light than it gets: a share above 1 is a
 * fault, unless the document's settings ask for `rescale`. Then a colour is divided by its largest
 * channel, so that its hue stays, and the scene has a warning that says where, and what it was and
 * became. Textures are kept below 1 where they are looked at (textured.h) and are no matter here.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_SHARE_H
#define COMMON_SCENE_SHARE_H

#include "common/scene_param.h"

/* Whether the document asks for it; looked at before any part of it is read. */
bool scene_share_wanted(const struct scene_at *whole);

void scene_share_rgb(const struct scene_params *, const char *key, rgb *out);

/* Two that share the light: at most 1 together. */
struct scene_share {
    const char *key;
    rgb *out;
};
void scene_share_pair(const struct scene_params *, struct scene_share, struct scene_share);

#endif
