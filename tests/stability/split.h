/* split.h - lamps of flat pieces cut into so many that they are picked from a tree (light_tree.h):
 * the same image, by another way. SPDX-License-Identifier: MIT */
#ifndef TESTS_STABILITY_SPLIT_H
#define TESTS_STABILITY_SPLIT_H

#include "common/scene.h"

bool split_can(const struct scene *); /* there is one: a quad, or a mesh in the document */

/* The scene's shapes and meshes become others, in the arena. */
void split_lamps(struct scene *, struct arena *);

#endif
