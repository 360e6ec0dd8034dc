/* SPDX-License-Identifier: MIT */
#include "server/disk.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

static const char temporary_mark[] = ".tmp-";

static bool failed(struct err *err, const char *path)
{
    return err_set(err, ERR_IO, "%s: %s", path, strerror(errno));
}

bool disk_directory(const char *path, struct err *err)
{
    char part[DISK_PATH];
    if (strlen(path) >= sizeof part)
        return err_set(err, ERR_INPUT, "path of %zu characters: expected at most %zu", strlen(path),
                       sizeof part - 1);
    for (size_t i = 0; i <= strlen(path); i++) {
        part[i] = path[i];
        if (i == 0 || (path[i] != '/' && path[i] != '\0'))
            continue;
        part[i] = '\0';
        if (mkdir(part, 0777) != 0 && errno != EEXIST)
            return failed(err, part);
        part[i] = path[i];
    }
    struct stat st;
    if (stat(path, &st) != 0)
        return failed(err, path);
    return S_ISDIR(st.st_mode) || err_set(err, ERR_IO, "%s: not a directory", path);
}

void disk_clean(const char *directory)
{
    DIR *d = opendir(directory);
    if (!d)
        return;
    for (struct dirent *e; (e = readdir(d));)
        if (!strncmp(e->d_name, temporary_mark, sizeof temporary_mark - 1))
            unlinkat(dirfd(d), e->d_name, 0);
    closedir(d);
}

static size_t directory_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

bool disk_create(struct disk_file *f, const char *path, struct err *err)
{
    const size_t dir = directory_length(path);
    const int n = snprintf(f->path, sizeof f->path, "%s", path);
    const int m = snprintf(f->temporary, sizeof f->temporary, "%.*s%sXXXXXX", (int)dir, path,
                           temporary_mark);
    if (n < 0 || m < 0 || (size_t)n >= sizeof f->path || (size_t)m >= sizeof f->temporary)
        return err_set(err, ERR_IO, "path of %zu characters is too long", strlen(path));
    f->fd = mkstemp(f->temporary);
    if (f->fd < 0)
        return failed(err, f->temporary);
    if (fchmod(f->fd, 0644) != 0) {
        failed(err, f->temporary);
        disk_abort(f);
        return false;
    }
    return true;
}

bool disk_write(struct disk_file *f, const void *data, size_t bytes, struct err *err)
{
    const char *at = data;
    while (bytes) {
        const ssize_t n = write(f->fd, at, bytes);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return failed(err, f->path);
        at += n;
        bytes -= (size_t)n;
    }
    return true;
}

bool disk_write_at(struct disk_file *f, const void *data, size_t bytes, uint64_t offset,
                   struct err *err)
{
    const char *at = data;
    while (bytes) {
        const ssize_t n = pwrite(f->fd, at, bytes, (off_t)offset);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return failed(err, f->path);
        at += n;
        bytes -= (size_t)n;
        offset += (uint64_t)n;
    }
    return true;
}

bool disk_flush(struct disk_file *f, struct err *err)
{
    return fsync(f->fd) == 0 || failed(err, f->path);
}

static bool directory_flush(const char *path, struct err *err)
{
    char dir[DISK_PATH];
    snprintf(dir, sizeof dir, "%.*s.", (int)directory_length(path), path);
    const int fd = open(dir, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0)
        return failed(err, dir);
    const bool ok = fsync(fd) == 0 || failed(err, dir);
    close(fd);
    return ok;
}

bool disk_commit(struct disk_file *f, struct err *err)
{
    if (!disk_flush(f, err)) {
        disk_abort(f);
        return false;
    }
    if (close(f->fd) != 0 || rename(f->temporary, f->path) != 0) {
        failed(err, f->path);
        unlink(f->temporary);
        f->fd = -1;
        return false;
    }
    f->fd = -1;
    return directory_flush(f->path, err);
}

void disk_abort(struct disk_file *f)
{
    if (f->fd >= 0)
        close(f->fd);
    unlink(f->temporary);
    f->fd = -1;
}

bool disk_lock(const char *path, struct err *err)
{
    const int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (fd < 0)
        return failed(err, path);
    if (flock(fd, LOCK_EX | LOCK_NB) == 0)
        return true; /* the descriptor stays open on purpose: the lock lives as long as we do */
    const bool taken = errno == EWOULDBLOCK;
    if (!taken)
        failed(err, path);
    close(fd);
    return taken ? err_set(err, ERR_CONFLICT, "%s: another coordinator uses this state directory",
                           path)
                 : false;
}
