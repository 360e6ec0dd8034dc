/* Random scenes (tests/stability/wild.h), each put through all trials (tests/stability/trial.h).
 *
 *     test_stability                the quick tier, or with TEST_LONG=1 the long one
 *     test_stability FROM [END]     the seeds of [FROM, END), in every detail
 *
 * SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/stability/trial.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

struct sums {
    uint32_t scenes, refused, held[TRIALS], failed[TRIALS], unjudged[TRIALS];
};

static void try_all(const struct wild *w, const char *name, uint32_t rounds, struct sums *sums)
{
    for (enum trial t = 0; t < TRIALS; t++) {
        char why[240] = "";
        const enum trial_verdict v = trial_run(t, w, rounds, why);
        sums->held[t] += v == TRIAL_HOLDS;
        sums->unjudged[t] += v == TRIAL_UNJUDGED;
        if (v != TRIAL_FAILS)
            continue;
        sums->failed[t]++;
        diag("%s: %s: %s", name, trial_names[t], why);
    }
}

static void try_seed(uint64_t seed, uint32_t rounds, struct sums *sums)
{
    struct wild w;
    const char *refused;
    char name[40];
    snprintf(name, sizeof name, "seed %llu", (unsigned long long)seed);
    sums->scenes++;
    if (wild_make(&w, seed, &refused))
        try_all(&w, name, rounds, sums);
    else {
        sums->refused++;
        diag("%s: refused: %s", name, refused);
    }
    wild_release(&w);
}

/* Scenes that have shown a fault, cut down to it; their titles tell the story. */
static const struct found {
    const char *name;
    uint32_t traits;
} found[] = {
    {"map-last-row", 0},
    {"mask-behind-hidden-surface", WILD_PLAIN},
};

static void found_ones_hold(void)
{
    for (size_t i = 0; i < countof(found); i++) {
        struct wild w;
        struct sums sums = {0};
        uint32_t failed = 0;
        const char *refused = "";
        char name[128];
        snprintf(name, sizeof name, "tests/stability/found/%s.json", found[i].name);
        const bool made = wild_read(&w, name, found[i].traits, &refused);
        if (made)
            try_all(&w, found[i].name, TRIAL_MOST_ROUNDS, &sums);
        for (enum trial t = 0; t < TRIALS; t++)
            failed += sums.failed[t];
        ok(made && failed == 0 && sums.held[TRIAL_MEANS], "%s: %s%s", found[i].name,
           made ? w.scene.title : "refused: ", refused);
        wild_release(&w);
    }
}

static const char *const says[TRIALS] = {
    [TRIAL_VALID] = "F-20: every sample is a number, and none is negative",
    [TRIAL_ALONE] = "samples, rows and crops have the bits that they have in the whole",
    [TRIAL_LANES] = "paths have the bits of one that is followed by itself",
    [TRIAL_SCALED] = "F-13: all lengths times 2^11 or 2^-11: the same bits",
    [TRIAL_BRIGHT] = "all light times 2^20 or 2^-20: the same bits",
    [TRIAL_LAYERS] = "layers change no bit, and the terms of light add up",
    [TRIAL_FURNACE] = "F-29: nothing is brighter than the light around it",
    [TRIAL_MEANS] =
        "F-04: strategies, samplers, no roulette, a tree of lights, the naive tracer: one mean",
};

static void report(const struct sums *s)
{
    ok(s->refused == 0, "%u documents, of which the reader refuses %u", s->scenes, s->refused);
    for (enum trial t = 0; t < TRIALS; t++)
        ok(s->failed[t] == 0 && s->held[t] > 0, "%s: %u scenes hold, %u do not (%u not judged)",
           says[t], s->held[t], s->failed[t], s->unjudged[t]);
    diag("%u means compared, %u again, %u too noisy to judge", trial_counts.made,
         trial_counts.repeated, trial_counts.unjudged);
}

int main(int argc, char **argv)
{
    struct sums sums = {0};
    const uint64_t from = argc > 1 ? strtoull(argv[1], NULL, 10) : 1;
    const uint64_t end = argc > 2   ? strtoull(argv[2], NULL, 10)
                         : argc > 1 ? from + 1
                                    : 1 + max_u32(6, stat_tries(60, 1500));
    for (uint64_t seed = from; seed < end; seed++)
        try_seed(seed, argc > 1 || stat_is_long() ? TRIAL_MOST_ROUNDS : 2, &sums);
    report(&sums);
    if (argc < 2)
        found_ones_hold();
    return tap_done();
}
