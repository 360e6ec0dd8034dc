/* mailbox.c: nothing is lost or doubled between threads; closing lets readers go.
 * SPDX-License-Identifier: MIT */
#include "worker/mailbox.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "common/clock.h"
#include "tests/tap.h"

enum { WRITERS = 3, READERS = 3, EACH = 5000 };

struct traffic {
    struct mailbox *box;
    unsigned char items[WRITERS][EACH];
    atomic_int seen[WRITERS][EACH];
    atomic_int read;
};

static struct traffic traffic;

static void *write_all(void *user)
{
    unsigned char *mine = user;
    for (int i = 0; i < EACH; i++)
        mailbox_push(traffic.box, &mine[i]);
    return NULL;
}

static void *read_all(void *user)
{
    (void)user;
    for (unsigned char *item; (item = mailbox_pop(traffic.box));) {
        const ptrdiff_t at = item - traffic.items[0];
        atomic_fetch_add(&traffic.seen[at / EACH][at % EACH], 1);
        atomic_fetch_add(&traffic.read, 1);
    }
    return NULL;
}

static void everything_arrives_once(void)
{
    pthread_t writers[WRITERS], readers[READERS];
    traffic.box = mailbox_new(7, -1); /* much smaller than what passes: both sides must wait */
    for (int i = 0; i < READERS; i++)
        pthread_create(&readers[i], NULL, read_all, NULL);
    for (int i = 0; i < WRITERS; i++)
        pthread_create(&writers[i], NULL, write_all, traffic.items[i]);
    for (int i = 0; i < WRITERS; i++)
        pthread_join(writers[i], NULL);
    while (atomic_load(&traffic.read) < WRITERS * EACH)
        clock_sleep_ms(1);
    mailbox_close(traffic.box);
    for (int i = 0; i < READERS; i++)
        pthread_join(readers[i], NULL);
    mailbox_free(traffic.box);
    int wrong = 0;
    for (int w = 0; w < WRITERS; w++)
        for (int i = 0; i < EACH; i++)
            wrong += atomic_load(&traffic.seen[w][i]) != 1;
    ok(wrong == 0, "%d items of %d writers reach %d readers once each", WRITERS * EACH, WRITERS,
       READERS);
}

static void order_and_end(void)
{
    int a, b;
    const int fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    struct mailbox *box = mailbox_new(2, fd);
    ok(!mailbox_try_pop(box), "an empty mailbox gives nothing");
    mailbox_push(box, &a);
    mailbox_push(box, &b);
    eventfd_t pushes = 0;
    ok(!eventfd_read(fd, &pushes) && pushes == 2, "every push is told to the eventfd");
    ok(mailbox_pop(box) == &a, "first in, first out");
    mailbox_close(box);
    ok(!mailbox_pop(box), "a closed mailbox lets its reader go");
    ok(mailbox_try_pop(box) == &b, "what was left can still be taken out");
    mailbox_free(box);
    close(fd);
}

int main(void)
{
    everything_arrives_once();
    order_and_end();
    return tap_done();
}
