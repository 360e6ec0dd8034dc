/* split.h - lamps of flat pieces cut into so many that they are picked from a tree (light_tree.h):
 * the same image, by another way. SPDX-License-Identifier: MIT */
#ifndef TESTS_STABILITY_SPLIT_H
#define TESTS_STABILITY_SPLIT_H

#include "common/scene.h"

/* There is one: of a quad, or a mesh in the document, a triangle that is large enough where it is.
 */
bool split_can(const struct scene *);

/* The scene's shapes and meshes become others, in the arena. */
void split_lamps(struct scene *, struct arena *);

#endif
