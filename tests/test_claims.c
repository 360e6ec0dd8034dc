/* stagefile.c between processes: of several one prepares, the others wait for it; whoever is killed
 * or frozen meanwhile harms nobody.
 * SPDX-License-Identifier: MIT */
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/clock.h"
#include "common/log.h"
#include "tests/shelf.h"
#include "tests/tap.h"

enum { PROCESSES = 4 };

static struct shelf shelf;

/* What parent and children tell each other. */
struct shared {
    atomic_int step, prepared, good;
};

static struct shared *shared;

static void share_memory(void)
{
    const int zero = open("/dev/zero", O_RDWR);
    shared = mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED, zero, 0);
    if (shared == MAP_FAILED)
        exit(1);
    close(zero);
}

static pid_t fork_to(void (*body)(const struct cache *))
{
    const pid_t pid = fork();
    if (pid == 0) {
        struct cache c = shelf_cache(&shelf, 1 << 20);
        body(&c);
        _exit(0);
    }
    return pid;
}

static pid_t start(void (*body)(const struct cache *))
{
    atomic_store(&shared->step, 0);
    return fork_to(body);
}

static void wait_for_step(int step)
{
    for (int64_t until = clock_ms() + SHELF_LONG_MS; atomic_load(&shared->step) < step;) {
        if (clock_ms() > until)
            abort();
        clock_sleep_ms(1);
    }
}

static void end(pid_t pid, int signal_number)
{
    if (signal_number)
        kill(pid, signal_number);
    waitpid(pid, NULL, 0);
}

/* As worker processes do that start together. */
static void race(const struct cache *c)
{
    struct stagefile f;
    struct stagefile_claim claim;
    struct err err;
    atomic_fetch_add(&shared->step, 1);
    wait_for_step(PROCESSES);
    const enum stagefile_answer answer = shelf_get(c, 1, SHELF_LONG_MS, &f, &claim);
    if (answer == STAGEFILE_CLAIMED) {
        atomic_fetch_add(&shared->prepared, 1);
        clock_sleep_ms(200);
        if (!stagefile_publish(&claim, shelf.stage, &f, &err))
            return;
    }
    atomic_fetch_add(&shared->good, shelf_same(&shelf, &f));
}

static void one_prepares(void)
{
    pid_t pids[PROCESSES];
    atomic_store(&shared->step, 0);
    for (int i = 0; i < PROCESSES; i++)
        pids[i] = fork_to(race);
    for (int i = 0; i < PROCESSES; i++)
        end(pids[i], 0);
    ok(atomic_load(&shared->prepared) == 1, "of %d processes at once one prepares", PROCESSES);
    ok(atomic_load(&shared->good) == PROCESSES, "all get it");
    ok(shelf_count(&shelf, ".") == 1, "nothing else is left behind");
    unlink(shelf_path(&shelf, 1));
}

static void claim_and_stay(const struct cache *c)
{
    struct stagefile f;
    struct stagefile_claim claim;
    shelf_get(c, 1, SHELF_LONG_MS, &f, &claim);
    atomic_store(&shared->step, 1);
    clock_sleep_ms(SHELF_LONG_MS);
}

/* What stagefile_publish does, up to the step that the parent asks for. */
static int last_step;

static void write_and_stay(const struct cache *c)
{
    struct cache_draft d;
    struct err err;
    char name[CACHE_NAME];
    stagefile_name(name, shelf_document(1));
    struct buf file = shelf_file(shelf.stage, name);
    bool good = cache_begin(c, name, &d) == CACHE_BEGUN;
    if (good && last_step > 0)
        good = cache_reserve(c, &d, file.size, &err);
    if (good && last_step > 1)
        good = cache_write(&d, file.data, file.size / 2, &err);
    if (good && last_step > 2)
        good = cache_write(&d, file.data + file.size / 2, file.size - file.size / 2, &err);
    if (good && last_step > 3)
        good = cache_finish(&d, &err);
    atomic_store(&shared->step, good);
    clock_sleep_ms(SHELF_LONG_MS);
}

static void killed_writers(void)
{
    static const char *const steps[] = {"it has begun", "it has made room", "half is written",
                                        "all is written", "it is done"};
    struct cache c = shelf_cache(&shelf, 1 << 20);
    struct stagefile f;
    for (last_step = 0; last_step < (int)countof(steps); last_step++) {
        const pid_t pid = start(write_and_stay);
        wait_for_step(1);
        end(pid, SIGKILL);
        const bool whole = last_step == 4;
        ok(shelf_has(&shelf, 1) == whole && shelf_count(&shelf, "^.tmp-") == !whole,
           "a writer is killed when %s: its file is %s", steps[last_step],
           whole ? "there" : "not there");
        ok(shelf_fill(&shelf, &c, 1, &f) && shelf_same(&shelf, &f) && shelf_count(&shelf, ".") == 1,
           "and the next goes on from there");
        stagefile_close(&f);
        unlink(shelf_path(&shelf, 1));
    }
    last_step = 2;
    const pid_t pid = start(write_and_stay);
    wait_for_step(1);
    if (!shelf_fill(&shelf, &c, 2, &f))
        abort();
    ok(shelf_count(&shelf, "^.tmp-") == 1,
       "what is being written is left alone by who writes another");
    stagefile_close(&f);
    end(pid, SIGKILL);
    if (!shelf_fill(&shelf, &c, 3, &f))
        abort();
    ok(shelf_count(&shelf, "^.tmp-") == 0, "what a dead one left is removed");
    stagefile_close(&f);
    unlink(shelf_path(&shelf, 2));
    unlink(shelf_path(&shelf, 3));
}

static void killed_preparer(void)
{
    const atomic_bool stopped = true;
    struct cache c = shelf_cache(&shelf, 1 << 20);
    struct stagefile f;
    struct stagefile_claim claim;
    pid_t pid = start(claim_and_stay);
    wait_for_step(1);
    const struct stagefile_ask ask = {&c, shelf_document(1), &stopped, SHELF_LONG_MS};
    ok(stagefile_get(&ask, &f, &claim) == STAGEFILE_ALONE, "waiting can be broken off");
    const int64_t begin_ms = clock_ms();
    kill(pid, SIGKILL);
    const enum stagefile_answer answer = shelf_get(&c, 1, SHELF_LONG_MS, &f, &claim);
    ok(answer == STAGEFILE_CLAIMED && clock_ms() - begin_ms < SHELF_LONG_MS / 2,
       "when the one that prepares is killed another takes over, without waiting");
    stagefile_unclaim(&claim);
    end(pid, 0);
}

static void slow_preparer(const struct cache *c)
{
    struct stagefile f;
    struct stagefile_claim claim;
    struct err err;
    shelf_get(c, 1, SHELF_LONG_MS, &f, &claim);
    atomic_store(&shared->step, 1);
    clock_sleep_ms(2500);
    if (!stagefile_publish(&claim, shelf.stage, &f, &err))
        atomic_store(&shared->step, 100);
}

static void waits_for_the_living(void)
{
    struct cache c = shelf_cache(&shelf, 1 << 20);
    struct stagefile f;
    struct stagefile_claim claim;
    pid_t pid = start(slow_preparer);
    wait_for_step(1);
    ok(shelf_get(&c, 1, 1700, &f, &claim) == STAGEFILE_MAPPED && shelf_same(&shelf, &f),
       "one that is slow, longer than our patience, but alive is waited for");
    stagefile_close(&f);
    end(pid, 0);
    unlink(shelf_path(&shelf, 1));
    pid = start(slow_preparer);
    wait_for_step(1);
    kill(pid, SIGSTOP);
    ok(shelf_get(&c, 1, 300, &f, &claim) == STAGEFILE_ALONE, "for one that is frozen only so long");
    kill(pid, SIGCONT);
    ok(shelf_get(&c, 1, SHELF_LONG_MS, &f, &claim) == STAGEFILE_MAPPED && shelf_same(&shelf, &f),
       "and when it goes on it does no harm");
    stagefile_close(&f);
    end(pid, 0);
    unlink(shelf_path(&shelf, 1));
}

int main(void)
{
    log_init("test_claims", LOG_ERROR);
    share_memory();
    shelf_init(&shelf);
    one_prepares();
    killed_writers();
    killed_preparer();
    waits_for_the_living();
    shelf_release(&shelf);
    munmap(shared, sizeof *shared);
    return tap_done();
}
