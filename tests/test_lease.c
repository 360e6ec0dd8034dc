/* lease.c: an hour of grants, renewals and expiries in a blink; farm.c: names of workers.
 * SPDX-License-Identifier: MIT */
#include "server/lease.h"

#include <stdlib.h>

#include "server/farm.h"
#include "tests/tap.h"

enum { MANY = 5000 };

static uint32_t random_next(uint32_t *state) /* xorshift32: G. Marsaglia, JSS 8(14), 2003 */
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return *state;
}

static void ids(void)
{
    struct lease_table *a = lease_table_new(0x1234abcd), *b = lease_table_new(0x1234abce);
    const uint64_t first = lease_grant(a, NULL, 1, 2, NULL, 10)->id;
    const uint64_t second = lease_grant(a, NULL, 1, 3, NULL, 10)->id;
    const uint64_t other = lease_grant(b, NULL, 1, 2, NULL, 10)->id;
    ok(first >> 32 == 0x1234abcd && first != second, "ids begin with the nonce and differ");
    ok(!lease_find(b, first) && lease_find(b, other), "an id of another run names nothing");
    const struct lease *l = lease_find(a, second);
    ok(l && l->tile == 1 && l->pass == 3, "an id leads to its lease");
    lease_table_free(a);
    lease_table_free(b);
}

static void deadlines(void)
{
    struct lease_table *t = lease_table_new(7);
    struct lease *a = lease_grant(t, NULL, 0, 0, NULL, 100);
    struct lease *b = lease_grant(t, NULL, 1, 0, NULL, 200);
    ok(lease_next_deadline(t) == 100, "the next deadline is the nearest");
    ok(!lease_first_due(t, 99) && lease_first_due(t, 100) == a, "a lease lapses at its deadline");
    lease_renew(t, a, 300);
    ok(!lease_first_due(t, 199) && lease_first_due(t, 200) == b, "renewal moves it back");
    lease_drop(t, b);
    lease_drop(t, a);
    ok(lease_count(t) == 0 && lease_next_deadline(t) == INT64_MAX && !lease_first_due(t, 1 << 30),
       "an empty table has nothing due");
    lease_table_free(t);
}

/* The table against a plain array: grants, renewals, drops and expiries in random order. */
static void against_array(void)
{
    static struct {
        uint64_t id;
        int64_t deadline_ms;
    } all[MANY];
    struct lease_table *t = lease_table_new(99);
    uint32_t random = 1, held = 0;
    int64_t now = 0;
    bool same = true, found = true;
    for (int step = 0; step < 40000; step++) {
        const uint32_t dice = random_next(&random) % 8;
        const uint32_t at = held ? random_next(&random) % held : 0;
        if (dice < 4 && held < MANY) {
            all[held].deadline_ms = now + random_next(&random) % 1000;
            all[held].id = lease_grant(t, NULL, 0, 0, NULL, all[held].deadline_ms)->id;
            held++;
        } else if (dice < 6 && held) {
            all[at].deadline_ms = now + random_next(&random) % 1000;
            lease_renew(t, lease_find(t, all[at].id), all[at].deadline_ms);
        } else if (dice == 6 && held) {
            lease_drop(t, lease_find(t, all[at].id));
            found &= !lease_find(t, all[at].id);
            all[at] = all[--held];
        } else {
            now += random_next(&random) % 20;
            for (struct lease *l; (l = lease_first_due(t, now)); lease_drop(t, l)) {
                uint32_t i = 0;
                while (i < held && all[i].id != l->id)
                    i++;
                same &= i < held && all[i].deadline_ms == l->deadline_ms && l->deadline_ms <= now;
                all[i] = all[--held];
            }
            for (uint32_t i = 0; i < held; i++)
                same &= all[i].deadline_ms > now;
        }
        same &= lease_count(t) == held;
    }
    for (uint32_t i = 0; i < held; i++)
        found &= lease_find(t, all[i].id) && lease_find(t, all[i].id)->id == all[i].id;
    ok(same, "40000 random steps: what lapses, and when, is what an array says");
    ok(found, "every held lease is found by its id, and no dropped one");
    ok(held > 100, "leases were held at the end (%u)", held);
    lease_table_free(t);
}

static void workers(void)
{
    struct farm f;
    farm_init(&f, 1000);
    ok(farm_name_is_sane("vm-1_a.B") && !farm_name_is_sane("") && !farm_name_is_sane("a b") &&
           !farm_name_is_sane("a/b") && !farm_name_is_sane("\xc3\xa4"),
       "a worker's name is letters, digits, dots, dashes");
    struct worker *b = farm_call(&f, "b", 0), *a = farm_call(&f, "a", 5);
    ok(farm_call(&f, "b", 10) == b && a->number != b->number && b->seen_ms == 10,
       "a name is one worker");
    ok(farm_find(&f, "a") == a && !farm_find(&f, "c"), "found by name");
    ok(!farm_is_lost(&f, b, 30000) && farm_is_lost(&f, b, 60000), "silence makes a worker lost");
    b->parked = 1;
    ok(!farm_is_lost(&f, b, 60000), "a worker whose call waits is not lost");
    farm_forget(&f, (int64_t)25 * 3600 * 1000);
    ok(farm_find(&f, "b") && !farm_find(&f, "a"), "forgotten after a day, but not while it waits");
    farm_release(&f);
}

int main(void)
{
    ids();
    deadlines();
    against_array();
    workers();
    return tap_done();
}
