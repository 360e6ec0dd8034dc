/* scene_fill.h - the meshes and images of a document that names its assets by their hashes.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_FILL_H
#define COMMON_SCENE_FILL_H

#include "common/buf.h"
#include "common/scene.h"

/* Where the bytes come from: `out` is empty and becomes the asset, of at most so many bytes. */
struct scene_fill {
    bool (*get)(void *context, const char *hex, size_t max_bytes, struct buf *out, struct err *);
    void *context;
};

enum scene_fill_result {
    SCENE_FILL_DONE,
    SCENE_FILL_NOT_GOT, /* `get` has failed */
    SCENE_FILL_FAULTY,  /* an asset is not what the document takes it for */
};

/* Memory of the arena. An error begins with "asset HEX". */
enum scene_fill_result scene_fill(struct scene *, const struct scene_fill *, struct arena *,
                                  struct err *);

#endif
