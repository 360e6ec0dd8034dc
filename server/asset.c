/* SPDX-License-Identifier: MIT */
#include "server/asset.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/arena.h"

enum { DIR_BYTES = DISK_PATH - HASH_HEX - 16 };

static char assets_dir[DIR_BYTES]; /* set once before any thread starts */

bool asset_open_store(const char *state_dir, struct err *err)
{
    const int n = snprintf(assets_dir, sizeof assets_dir, "%s/assets", state_dir);
    if (n < 0 || (size_t)n >= sizeof assets_dir)
        return err_set(err, ERR_INPUT, "%s: path is too long", state_dir);
    if (!disk_directory(assets_dir, err))
        return false;
    disk_clean(assets_dir);
    return true;
}

static void path_of(const char *hex, char path[DISK_PATH])
{
    snprintf(path, DISK_PATH, "%s/%s", assets_dir, hex);
}

struct asset_spool *asset_spool_new(struct err *err)
{
    char path[DISK_PATH];
    path_of("unnamed", path);
    struct asset_spool *s = arena_malloc(1, sizeof *s);
    if (!disk_create(&s->file, path, err)) {
        free(s);
        return NULL;
    }
    s->hash = hash_new();
    return s;
}

bool asset_spool_add(struct asset_spool *s, const void *data, size_t bytes, struct err *err)
{
    hash_add(s->hash, data, bytes);
    s->bytes += bytes;
    return disk_write(&s->file, data, bytes, err);
}

bool asset_spool_finish(struct asset_spool *s, struct err *err)
{
    hash_finish(s->hash, s->hex);
    s->hash = NULL;
    return disk_flush(&s->file, err);
}

void asset_spool_free(struct asset_spool *s)
{
    if (!s)
        return;
    char unused[HASH_HEX];
    if (s->hash)
        hash_finish(s->hash, unused);
    if (s->file.fd >= 0)
        disk_abort(&s->file);
    free(s);
}

bool asset_exists(const char hex[HASH_HEX])
{
    char path[DISK_PATH];
    struct stat st;
    path_of(hex, path);
    return stat(path, &st) == 0 && S_ISREG(st.st_mode);
}

bool asset_adopt(struct asset_spool *s, struct err *err)
{
    path_of(s->hex, s->file.path);
    return disk_commit(&s->file, err);
}

bool asset_put(const void *data, size_t bytes, char hex[HASH_HEX], struct err *err)
{
    hash_hex(data, bytes, hex);
    if (asset_exists(hex))
        return true;
    struct disk_file f;
    char path[DISK_PATH];
    path_of(hex, path);
    if (!disk_create(&f, path, err))
        return false;
    if (!disk_write(&f, data, bytes, err)) {
        disk_abort(&f);
        return false;
    }
    return disk_commit(&f, err);
}

int asset_fd(const char hex[HASH_HEX], uint64_t *bytes)
{
    char path[DISK_PATH];
    path_of(hex, path);
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    struct stat st;
    if (fd >= 0 && fstat(fd, &st) == 0) {
        *bytes = (uint64_t)st.st_size;
        return fd;
    }
    if (fd >= 0)
        close(fd);
    return -1;
}
