/* buf.h - a growable byte buffer to write into, and a bounded reader.
 *
 * The reader never runs past its end: the first short read sets `failed`, every
 * later read returns zero, and one look at the flag after the last field is enough.
 * All integers are little-endian on the wire, whatever the host.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_BUF_H
#define COMMON_BUF_H

#include "common/base.h"

struct buf {
    unsigned char *data; /* owned; freed by buf_release */
    size_t size;         /* bytes in use */
    size_t capacity;
};

void buf_release(struct buf *);
void *buf_grow(struct buf *, size_t bytes); /* appends uninitialised bytes, returns them */
void buf_append(struct buf *, const void *data, size_t bytes);
void buf_text(struct buf *, const char *fmt, ...) PRINTF(2, 3); /* without the final 0 */
void buf_u32(struct buf *, uint32_t);
void buf_u64(struct buf *, uint64_t);

struct buf_reader {
    const unsigned char *at;
    const unsigned char *end;
    bool failed; /* sticky */
};

struct buf_reader buf_reader_make(const void *data, size_t bytes);
const void *buf_read(struct buf_reader *, size_t bytes); /* NULL when short */
uint32_t buf_read_u32(struct buf_reader *);
uint64_t buf_read_u64(struct buf_reader *);

/* The whole file, at most max_bytes. `out` is appended to. */
struct err;
bool buf_read_file(struct buf *out, const char *path, size_t max_bytes, struct err *) MUST_CHECK;

#endif
