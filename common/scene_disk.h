/* scene_disk.h - a scene as it lies on disk: the document, and the mesh and image files it names
 * relative to itself.
 *
 * For the programs people run beside their files (CLI, tools). A coordinator sees documents
 * that name assets only, and a worker gets those from it.
 * All faults come as scene_errors: where is a JSON pointer, "line L, column C", or "" when the file
 * itself cannot be read.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_DISK_H
#define COMMON_SCENE_DISK_H

#include "common/buf.h"
#include "common/scene.h"

struct scene_disk_asset {
    const char *path; /* of the file, as it can be opened; NULL: inline, or an asset's name only */
    char hex[HASH_HEX]; /* SHA-256 of the file; set by scene_disk_load */
    uint64_t bytes;
};

struct scene_disk {
    const char *json; /* the very bytes of the file */
    size_t json_bytes;
    struct scene scene;
    struct scene_disk_asset *assets; /* the meshes', then the images' */
    uint32_t asset_count;            /* of both together */
};

/* Reads and checks the document. Memory of the arena. */
bool scene_disk_open(struct scene_disk *, const char *path, struct arena *,
                     struct scene_errors *) MUST_CHECK;

/* Reads and checks every file: fills scene.meshes, scene.images and assets. Goes on after a bad
 * one. What is an asset's name only stays empty, and `unread` counts it. */
bool scene_disk_load(struct scene_disk *, struct arena *, uint32_t *unread,
                     struct scene_errors *) MUST_CHECK;

/* The document with every file replaced by its asset (after scene_disk_load), in the arena. */
const char *scene_disk_send(const struct scene_disk *, struct arena *);

#endif
