/* bench_naive: the path tracer against one that samples materials only (tests/naive_path.h), on the
 * Cornell box: relMSE x CPU seconds of each at equal CPU time, in one run, in alternating slices.
 * Last line: "bench-naive: N times better".
 * SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "client/diff.h"
#include "common/clock.h"
#include "common/trace/render.h"
#include "tests/local.h"
#include "tests/naive_path.h"

enum {
    STRIDE = 8, /* every eighth pixel of every eighth row stands for the image */
    SIDE = 64,
    PIXELS = SIDE * SIDE,
    REFERENCE_SPP = 4096,
    SPP = 64,
    SLICE = 8, /* samples per pixel between looks at the clock */
};

struct run {
    double sum[PIXELS][3];
    uint32_t spp;
    int64_t cpu_us;
};

static void add_ours(struct run *run, const struct stage *s)
{
    const int64_t begin = clock_thread_cpu_us();
    for (uint32_t i = 0; i < PIXELS; i++)
        for (uint32_t k = run->spp; k < run->spp + SLICE; k++) {
            const rgb c = render_sample(s, i % SIDE * STRIDE, i / SIDE * STRIDE, k);
            for (int ch = 0; ch < 3; ch++)
                run->sum[i][ch] += (double)c[ch];
        }
    run->spp += SLICE;
    run->cpu_us += clock_thread_cpu_us() - begin;
}

static void add_naive(struct run *run, const struct stage *s, struct dice *dice)
{
    const int64_t begin = clock_thread_cpu_us();
    for (uint32_t i = 0; i < PIXELS; i++)
        for (uint32_t k = 0; k < SLICE; k++)
            naive_path_sample(s, i % SIDE * STRIDE, i / SIDE * STRIDE, dice, run->sum[i]);
    run->spp += SLICE;
    run->cpu_us += clock_thread_cpu_us() - begin;
}

static struct image image_of(const struct run *run, struct arena *arena)
{
    static const char *const names[] = {"B", "G", "R"};
    struct image image = {.window = {0, 0, SIDE, SIDE},
                          .width_px = SIDE,
                          .height_px = SIDE,
                          .channels = arena_new(arena, struct image_channel, 3),
                          .channel_count = 3};
    for (size_t c = 0; c < 3; c++) {
        float *plane = arena_new(arena, float, PIXELS);
        for (size_t i = 0; i < PIXELS; i++)
            plane[i] = (float)(run->sum[i][2 - c] / run->spp);
        image.channels[c] = (struct image_channel){names[c], IMAGE_FLOAT32, plane};
    }
    return image;
}

/* The same scene with other random numbers. A stage is one block that may lie anywhere. */
static const struct stage *reseeded(const struct stage *s, struct arena *arena)
{
    struct stage *copy = arena_alloc(arena, s->bytes, 1, 64);
    memcpy(copy, s, s->bytes);
    copy->settings.seed = s->settings.seed + 1;
    return copy;
}

static double report(const char *name, const struct run *run, const struct image *reference,
                     struct arena *arena)
{
    const struct image image = image_of(run, arena);
    struct diff diff;
    struct err err;
    if (!diff_images(&image, reference, arena, &diff, &err)) {
        fprintf(stderr, "bench-naive: %s\n", err.text);
        exit(1);
    }
    const double seconds = (double)run->cpu_us * 1e-6;
    printf("%-6s %5u spp %7.2f CPU s   relMSE %.5f   relMSE x s %.5f\n", name, run->spp, seconds,
           diff.relmse, diff.relmse * seconds);
    return diff.relmse * seconds;
}

int main(void)
{
    struct local l;
    local_open(&l, "scenes/cornell-box.json");
    struct run *ours = arena_new(&l.arena, struct run, 3), *naive = ours + 1, *reference = ours + 2;
    struct dice dice = dice_make(1);
    while (ours->spp < SPP || naive->cpu_us < ours->cpu_us)
        if (ours->cpu_us <= naive->cpu_us && ours->spp < SPP)
            add_ours(ours, l.stage);
        else
            add_naive(naive, l.stage, &dice);
    const struct stage *other = reseeded(l.stage, &l.arena);
    while (reference->spp < REFERENCE_SPP)
        add_ours(reference, other);
    const struct image truth = image_of(reference, &l.arena);
    const double a = report("smalti", ours, &truth, &l.arena);
    const double b = report("naive", naive, &truth, &l.arena);
    printf("bench-naive: %.1f times better\n", b / a);
    local_release(&l);
    return 0;
}
