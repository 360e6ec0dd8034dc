/* shelf.h - a cache directory and a small prepared scene to put into it under many names, for the
 * tests of stagefile.c.
 * SPDX-License-Identifier: MIT */
#ifndef TESTS_SHELF_H
#define TESTS_SHELF_H

#include "tests/scenes.h"
#include "worker/stagefile.h"

enum { SHELF_LONG_MS = 60000 }; /* nothing takes that long unless something is wrong */

struct shelf {
    char dir[64];
    struct scenes scenes;
    const struct stage *stage;
};

void shelf_init(struct shelf *); /* exits when there is no directory */
void shelf_release(struct shelf *);

struct cache shelf_cache(const struct shelf *, uint64_t most_bytes);

/* Documents and their files are numbered. The texts are good until the next call. */
const char *shelf_document(int n);
const char *shelf_path(const struct shelf *, int n);
bool shelf_has(const struct shelf *, int n);
int shelf_count(const struct shelf *, const char *pattern); /* of files, by grep */

/* stagefile_get, not to be broken off. */
enum stagefile_answer shelf_get(const struct cache *, int n, int64_t patience_ms,
                                struct stagefile *, struct stagefile_claim *);
/* As a worker does it: maps, or prepares, writes and maps. */
bool shelf_fill(const struct shelf *, const struct cache *, int n, struct stagefile *);
/* Whether it is the scene, to the last byte, where rays can be traced against it. */
bool shelf_same(const struct shelf *, const struct stagefile *);

struct buf shelf_file(const struct stage *, const char *name); /* the bytes of one */

#endif
