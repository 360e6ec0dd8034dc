/* disk.h - files that are whole or absent.
 *
 * A file is written beside its place, flushed, renamed into it, and the directory flushed: a
 * reader never sees half of it, and after disk_commit a power cut does not lose it.
 * Errors are ERR_IO (a full disk among them) and name the path.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_DISK_H
#define SERVER_DISK_H

#include "common/err.h"

enum { DISK_PATH = 1024 };

struct disk_file {
    int fd;
    char path[DISK_PATH];      /* where it shall appear */
    char temporary[DISK_PATH]; /* where it is until then, in the same directory */
};

bool disk_directory(const char *path, struct err *) MUST_CHECK; /* makes it, and its parents */
void disk_clean(const char *directory);                         /* removes forgotten temporaries */

bool disk_create(struct disk_file *, const char *path, struct err *) MUST_CHECK;
bool disk_write(struct disk_file *, const void *data, size_t bytes, struct err *) MUST_CHECK;
bool disk_write_at(struct disk_file *, const void *data, size_t bytes, uint64_t offset,
                   struct err *) MUST_CHECK;
bool disk_flush(struct disk_file *, struct err *) MUST_CHECK; /* the slow half of disk_commit */
bool disk_commit(struct disk_file *, struct err *) MUST_CHECK; /* closes it in either case */
void disk_abort(struct disk_file *);                           /* closes and forgets it */

/* Keeps a file locked until the process ends; ERR_CONFLICT when another process has it. */
bool disk_lock(const char *path, struct err *) MUST_CHECK;

#endif
