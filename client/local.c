/* SPDX-License-Identifier: MIT */
#include "client/local.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/buf.h"
#include "common/clock.h"

enum { START_MS = 20000, TAIL_LINES = 20, MAX_ARGS = 16, NESTING = 8 };

uint32_t local_cores(void)
{
    const long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n < 1 ? 1 : n > 1024 ? 1024 : (uint32_t)n;
}

/* ---------------------------------------------------------------- a child */

/* Beside this program, else wherever PATH finds it. */
static void find_program(const char *name, char path[PATH_MAX])
{
    char self[PATH_MAX];
    const ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
    self[n > 0 ? n : 0] = 0;
    char *slash = strrchr(self, '/');
    if (slash) {
        *slash = 0;
        if (snprintf(path, PATH_MAX, "%s/%s", self, name) < PATH_MAX && !access(path, X_OK))
            return;
    }
    snprintf(path, PATH_MAX, "%s", name);
}

/* In the child: does not return. */
static void become(const char *path, char *const *argv, const char *log, pid_t parent)
{
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    signal(SIGPIPE, SIG_DFL);
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent)
        _exit(1); /* it died before that took effect */
    const int null = open("/dev/null", O_RDONLY);
    const int out = open(log, O_WRONLY | O_CREAT | O_APPEND, 0600);
    if (null < 0 || out < 0 || dup2(null, 0) < 0 || dup2(out, 1) < 0 || dup2(out, 2) < 0)
        _exit(1);
    execvp(path, argv);
    dprintf(2, "%s: %s\n", path, strerror(errno));
    _exit(127);
}

static bool start_program(const char *name, const char *const *args, const char *log, pid_t *pid,
                          struct err *err)
{
    char path[PATH_MAX];
    char *argv[MAX_ARGS + 2] = {path};
    find_program(name, path);
    for (size_t i = 0; i < MAX_ARGS && args[i]; i++)
        argv[i + 1] = strdup(args[i]);
    const pid_t self = getpid();
    *pid = fork();
    if (*pid == 0)
        become(path, argv, log, self);
    for (size_t i = 1; argv[i]; i++)
        free(argv[i]);
    if (*pid > 0)
        return true;
    *pid = 0;
    return err_set(err, ERR_IO, "%s: %s", name, strerror(errno));
}

/* True: it has ended; *pid becomes 0. */
static bool has_ended(pid_t *pid)
{
    if (*pid && waitpid(*pid, NULL, WNOHANG) == 0)
        return false;
    *pid = 0;
    return true;
}

static void end_program(pid_t *pid)
{
    if (!*pid)
        return;
    kill(*pid, SIGKILL); /* its state is about to be deleted: nothing to finish */
    while (waitpid(*pid, NULL, 0) < 0 && errno == EINTR)
        ;
    *pid = 0;
}

/* ------------------------------------------------------------------ start */

static bool make_dir(struct local *l, struct err *err)
{
    const char *base = getenv("TMPDIR");
    if (!base || *base != '/' || strlen(base) > 128)
        base = "/tmp";
    snprintf(l->dir, sizeof l->dir, "%s/smalti-XXXXXX", base);
    if (mkdtemp(l->dir))
        return true;
    err_set(err, ERR_IO, "%s: %s", l->dir, strerror(errno));
    l->dir[0] = 0;
    return false;
}

static bool read_address(struct local *l, const char *announce)
{
    struct buf text = {0};
    struct err err;
    const bool good = buf_read_file(&text, announce, sizeof l->url - 1, &err);
    if (good) {
        const char *begin = text.size ? (const char *)text.data : "";
        const void *end = memchr(begin, '\n', text.size);
        const size_t n = end ? (size_t)((const char *)end - begin) : text.size;
        snprintf(l->url, sizeof l->url, "%.*s", (int)n, begin);
    }
    buf_release(&text);
    return good && l->url[0];
}

static bool start_coordinator(struct local *l, uint32_t tile_px, struct err *err)
{
    char state[320], announce[320], log[320], tile[16];
    snprintf(state, sizeof state, "%s/state", l->dir);
    snprintf(announce, sizeof announce, "%s/address", l->dir);
    snprintf(log, sizeof log, "%s/smaltid.log", l->dir);
    snprintf(tile, sizeof tile, "%u", tile_px);
    const char *const args[] = {
        "--port", "0", "--state", state, "--announce", announce, tile_px ? "--tile" : NULL,
        tile,     NULL};
    if (!start_program("smaltid", args, log, &l->coordinator, err))
        return false;
    for (const int64_t until = clock_ms() + START_MS; !read_address(l, announce);) {
        if (has_ended(&l->coordinator))
            return err_set(err, ERR_IO, "smaltid has ended instead of listening");
        if (clock_ms() > until)
            return err_set(err, ERR_IO, "smaltid does not listen after %d s", START_MS / 1000);
        clock_sleep_ms(5);
    }
    return true;
}

static bool start_worker(struct local *l, uint32_t i, const struct local_plan *plan,
                         struct err *err)
{
    char private[320], log[320], count[16], name[32];
    snprintf(private, sizeof private, "%s/cache", l->dir);
    snprintf(log, sizeof log, "%s/worker-%u.log", l->dir, i + 1);
    snprintf(count, sizeof count, "%u", plan->threads);
    snprintf(name, sizeof name, "worker-%u", i + 1);
    const char *cache = plan->cache ? plan->cache : private;
    const char *const args[] = {"--server", l->url,   "--threads", count, "--cache",
                                cache,      "--name", name,        NULL};
    return start_program("smalti-worker", args, log, &l->workers[i], err);
}

bool local_start(struct local *l, const struct local_plan *plan, struct err *err)
{
    *l = (struct local){0};
    if (!make_dir(l, err) || !start_coordinator(l, plan->tile_px, err))
        return false;
    l->worker_count = min_u32(plan->workers, LOCAL_MAX_WORKERS);
    for (uint32_t i = 0; i < l->worker_count; i++)
        if (!start_worker(l, i, plan, err))
            return false;
    return true;
}

bool local_check(struct local *l, struct err *err)
{
    if (has_ended(&l->coordinator))
        return err_set(err, ERR_IO, "smaltid has died");
    uint32_t alive = 0;
    for (uint32_t i = 0; i < l->worker_count; i++)
        alive += !has_ended(&l->workers[i]);
    return alive || err_set(err, ERR_IO, "all workers have died");
}

/* -------------------------------------------------------------------- end */

static void show_tail(const char *path, const char *name, FILE *out)
{
    struct buf text = {0};
    struct err err;
    if (buf_read_file(&text, path, (size_t)64 << 20, &err) && text.size) {
        size_t begin = text.size;
        for (int lines = 0; begin > 0; begin--)
            if (text.data[begin - 1] == '\n' && begin < text.size && ++lines == TAIL_LINES)
                break;
        fprintf(out, "--- %s\n%.*s", name, (int)(text.size - begin),
                (const char *)text.data + begin);
    }
    buf_release(&text);
}

void local_show_logs(const struct local *l, FILE *out)
{
    DIR *dir = *l->dir ? opendir(l->dir) : NULL;
    for (struct dirent *d; dir && (d = readdir(dir));) {
        char path[600];
        const size_t n = strlen(d->d_name);
        snprintf(path, sizeof path, "%s/%s", l->dir, d->d_name);
        if (n > 4 && !strcmp(d->d_name + n - 4, ".log"))
            show_tail(path, d->d_name, out);
    }
    if (dir)
        closedir(dir);
}

/* Empties the directory behind `fd`, which it closes. Symbolic links are removed, not followed. */
static void remove_inside(int fd, int nesting)
{
    DIR *dir = fd < 0 ? NULL : fdopendir(fd);
    for (struct dirent *d; dir && (d = readdir(dir));) {
        if (!strcmp(d->d_name, ".") || !strcmp(d->d_name, ".."))
            continue;
        if (!unlinkat(dirfd(dir), d->d_name, 0) || nesting == 0)
            continue;
        remove_inside(
            openat(dirfd(dir), d->d_name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC),
            nesting - 1);
        unlinkat(dirfd(dir), d->d_name, AT_REMOVEDIR);
    }
    if (dir)
        closedir(dir);
}

void local_stop(struct local *l)
{
    for (uint32_t i = 0; i < l->worker_count; i++)
        end_program(&l->workers[i]);
    end_program(&l->coordinator);
    if (*l->dir) {
        remove_inside(open(l->dir, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC), NESTING);
        rmdir(l->dir);
    }
    l->dir[0] = 0;
}
