/* scene_names.h - the things of a document that have names, materials and textures: an object from
 * names to them, and who refers to them by name.
 *
 * Private to the scene reader.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_NAMES_H
#define COMMON_SCENE_NAMES_H

#include "common/scene_doc.h"

struct scene_name {
    const char *name;
    uint32_t index;
};

struct scene_names {
    const char *one;           /* "material": what each of them is, for messages */
    struct scene_name *sorted; /* by name, once closed; in the document's arena */
    uint32_t count;
    bool known; /* false: what should hold them is no object, so nobody can say what dangles */
};

/* From the object that holds them, at most so many; `one` is set. False: no names, a fault. */
bool scene_names_open(struct scene_doc *, const struct scene_at *, size_t most,
                      struct scene_names *);
/* The name of the i-th member, checked and copied. */
const char *scene_names_take(struct scene_doc *, const struct scene_at *member,
                             struct scene_names *, uint32_t i);
void scene_names_close(struct scene_names *);

/* The one that a string of the document means; a fault says which there are. */
bool scene_names_find(struct scene_doc *, const struct scene_at *, const struct scene_names *,
                      uint32_t *index);

#endif
