/* Any bytes as the file of a prepared scene: an answer, never a crash, and when the answer is yes
 * every array lies inside the block. Checksums would keep all but the dullest inputs out, so the
 * first byte says whether the rest is a file as it is, or a block to be put into a right file; and
 * whether its arrays are brought near the block's end, where the mistakes would be.
 *
 *     build/fuzz-clang/bin/fuzz_stagefile -max_len=3000 CORPUS
 * SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>

#include "worker/stagefile.h"

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t bytes);

/* What any block of this build begins with; else the input would have to guess it. */
static void make_head(unsigned char *block, size_t bytes)
{
    struct stage head;
    memcpy(&head, block, sizeof head);
    memcpy(head.magic, STAGE_MAGIC, sizeof head.magic);
    head.version = STAGE_VERSION;
    head.struct_bytes = sizeof head;
    head.bytes = bytes;
    memcpy(block, &head, sizeof head);
}

static void bring_near(unsigned char *block, size_t bytes)
{
    unsigned char *at = block + offsetof(struct stage, shapes), *end = block + sizeof(struct stage);
    for (struct stage_span span; at + sizeof span <= end; at += sizeof span) {
        memcpy(&span, at, sizeof span);
        span.offset = span.offset % (bytes + 128) / 64 * 64;
        span.count %= (bytes + 128 - span.offset) / 4 + 2;
        memcpy(at, &span, sizeof span);
    }
}

static void *aligned_copy(const void *data, size_t bytes)
{
    void *copy = NULL;
    if (posix_memalign(&copy, 64, bytes ? bytes : 1))
        abort();
    memcpy(copy, data, bytes);
    return copy;
}

static struct buf file_of(const unsigned char *data, size_t bytes, bool near, const char *name)
{
    struct buf file = {0};
    if (bytes < sizeof(struct stage)) {
        buf_append(&file, data, bytes);
        return file;
    }
    unsigned char *block = aligned_copy(data, bytes);
    make_head(block, bytes);
    if (near)
        bring_near(block, bytes);
    stagefile_head(&file, name, (const struct stage *)(const void *)block);
    buf_append(&file, block, bytes);
    free(block);
    return file;
}

/* Each array where it begins, and as many bytes on as it has elements, for the sanitizer to see. */
static void touch(const struct stage *stage)
{
    const unsigned char *at = (const unsigned char *)stage + offsetof(struct stage, shapes);
    const unsigned char *end = (const unsigned char *)stage + sizeof *stage;
    for (struct stage_span span; at + sizeof span <= end; at += sizeof span) {
        memcpy(&span, at, sizeof span);
        const volatile unsigned char *array = stage_at(stage, span);
        if (span.count) {
            (void)array[0];
            (void)array[span.count - 1];
        }
    }
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t bytes)
{
    if (bytes == 0)
        return 0;
    char name[CACHE_NAME];
    const struct stage *stage;
    struct err err = {0};
    stagefile_name(name, "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef");
    struct buf file = {0};
    if (data[0] % 4 == 0)
        buf_append(&file, data + 1, bytes - 1);
    else
        file = file_of(data + 1, bytes - 1, data[0] % 2, name);
    void *copy = aligned_copy(file.data ? file.data : data, file.size);
    if (stagefile_check(copy, file.size, name, &stage, &err))
        touch(stage);
    else if (!*err.text || err.code != ERR_INPUT)
        abort();
    free(copy);
    buf_release(&file);
    return 0;
}
