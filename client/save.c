/* SPDX-License-Identifier: MIT */
#include "client/save.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { PATH_ROOM = PATH_MAX };

static bool fail(struct err *err, const char *path)
{
    return err_set(err, ERR_IO, "%s: %s", path, strerror(errno));
}

static bool write_all(int fd, const struct buf *bytes)
{
    for (size_t at = 0; at < bytes->size;) {
        const ssize_t n = write(fd, bytes->data + at, bytes->size - at);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        at += (size_t)n;
    }
    return true;
}

/* The directory a path is in. */
static bool directory_of(const char *path, char dir[PATH_ROOM], struct err *err)
{
    const char *slash = strrchr(path, '/');
    if (strlen(path) >= PATH_ROOM - 32) {
        errno = ENAMETOOLONG;
        return fail(err, path);
    }
    snprintf(dir, PATH_ROOM, "%.*s", slash ? (int)(slash - path + 1) : 1, slash ? path : ".");
    return true;
}

static void sync_directory(const char *dir)
{
    const int fd = open(dir, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0)
        return; /* the file is there; only its durability is not certain */
    fsync(fd);
    close(fd);
}

bool save_file(const char *path, const struct buf *bytes, struct err *err)
{
    char dir[PATH_ROOM], temp[PATH_ROOM + 32];
    if (!directory_of(path, dir, err))
        return false;
    snprintf(temp, sizeof temp, "%s.tmp-%ld", path, (long)getpid());
    const int fd = open(temp, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (fd < 0)
        return fail(err, path);
    bool good = (write_all(fd, bytes) && !fsync(fd)) || fail(err, path);
    if (close(fd) && good)
        good = fail(err, path);
    if (good && rename(temp, path))
        good = fail(err, path);
    if (!good)
        unlink(temp);
    else
        sync_directory(dir);
    return good;
}

bool save_possible(const char *path, struct err *err)
{
    char dir[PATH_ROOM];
    struct stat st;
    if (!directory_of(path, dir, err))
        return false;
    if (!stat(path, &st) && S_ISDIR(st.st_mode))
        errno = EISDIR;
    else if (!access(dir, W_OK | X_OK))
        return true;
    return fail(err, path);
}
