/* adaptive.c: blocks stop when they may, a job ends when it may, and one that goes on to a smaller
 * error ends as one that was asked for it at once.
 * SPDX-License-Identifier: MIT */
#include "common/adaptive.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/estimate.h"
#include "common/stop.h"
#include "tests/adapt.h"
#include "tests/dice.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

/* ---- rules, on rounds written down by hand ---- */

static const uint32_t judged[] = {16, 32, 64, 128, 256, 512, 768, 1024, 1280};

static void which_rounds(void)
{
    uint32_t counts[2] = {0, 0};
    bool ends = true;
    for (uint32_t p = 0; p < tile_pass_count(1 << 24); p++) {
        const uint32_t end = tile_pass_of(p, 1 << 24).s_end;
        counts[end > 4096] += adaptive_judges(end);
    }
    for (uint32_t spp = 1; spp < 10000; spp++) { /* what is judged ends a pass */
        const uint32_t last = tile_pass_count(spp) - 1;
        const bool whole = tile_pass_of(last, spp).s_end == tile_pass_of(last, 1 << 24).s_end;
        ends = ends && (!adaptive_judges(spp) || whole);
    }
    ok(counts[0] == 4 + 16 && counts[1] == 8 * 12 && counts[0] + counts[1] <= ADAPTIVE_MAX_ROUNDS,
       "rounds are judged at 16 to 128, each 256 to 4096, eight in a doubling: %u, %u", counts[0],
       counts[1]);
    ok(ends && !adaptive_judges(8) && !adaptive_judges(0) && !adaptive_judges(48) &&
           !adaptive_judges(4352) && adaptive_judges(4608),
       "all of them at ends of passes");
}

/* Blocks side by side; the round after the last one: error2 and neff of each. */
static void write_down(struct adaptive *a, const struct adaptive_block *blocks)
{
    struct arena arena = {0};
    struct adaptive_look l = {judged[a->rounds], .01,
                              arena_new(&arena, struct adaptive_block, a->count)};
    memcpy(l.blocks, blocks, a->count * sizeof *blocks);
    adaptive_add(a, &l);
    arena_release(&arena);
}

/* The same error2 and neff in each block but the first. */
static void write_all(struct adaptive *a, struct adaptive_block first, struct adaptive_block others)
{
    struct adaptive_block b[64];
    for (size_t i = 0; i < a->count; i++)
        b[i] = i ? others : first;
    write_down(a, b);
}

static void start(struct adaptive *a, uint32_t columns, uint32_t rows, double target)
{
    adaptive_init(a, (struct tile_rect){0, 0, 8 * columns, 8 * rows});
    adaptive_aim(a, target);
}

static const struct adaptive_block noisy = {1, 1000}, quiet = {1e-6f, 1000}, rare = {1e-6f, 20},
                                   tail = {1e-6f, -1000}, dark = {0, INFINITY}, black = {0, 0};

/* Rounds at 16 and 32 as given, then one more as `later`: since when the first block has stopped.
 */
static uint32_t stopped_at(struct adaptive_block at_16, struct adaptive_block at_32,
                           struct adaptive_block later, struct adaptive_block neighbour)
{
    struct adaptive a;
    start(&a, 2, 1, .1);
    write_all(&a, at_16, neighbour);
    write_all(&a, at_32, neighbour);
    write_all(&a, later, neighbour);
    const uint32_t spp = a.stop[0] == ADAPTIVE_NEVER ? 0 : a.spp[a.stop[0]];
    adaptive_release(&a);
    return spp;
}

static void single_blocks(void)
{
    ok(stopped_at(quiet, quiet, quiet, noisy) == 32, "a quiet block stops at the pilot");
    ok(stopped_at(noisy, quiet, quiet, noisy) == 64, "unless the round before did not foretell it");
    ok(stopped_at(noisy, noisy, quiet, noisy) == 0, "so never after one look");
    ok(stopped_at(quiet, rare, rare, noisy) == 0, "too few effective samples are no evidence");
    ok(stopped_at(rare, quiet, quiet, noisy) == 64, "nor were they in the round before");
    ok(stopped_at(tail, tail, tail, noisy) == 0, "nor is a heavy tail");
    ok(stopped_at(tail, quiet, quiet, noisy) == 64, "that can be outgrown");
    ok(stopped_at(dark, dark, dark, noisy) == 32, "where nothing is nothing more is to be seen");
    ok(stopped_at(black, black, black, noisy) == 0, "black by chance is no evidence");
    ok(stopped_at(quiet, quiet, quiet, rare) == 0,
       "a block waits for what its neighbour has not seen");
    ok(stopped_at(quiet, quiet, quiet, black) == 0, "which may be anything where that is black");
    const struct adaptive_block nearly = {1.1f * .01f / 2, 1000}, good = {.005f, 1000};
    ok(stopped_at((struct adaptive_block){2.1f * nearly.error2, 1000}, good, good, good) == 32 &&
           stopped_at((struct adaptive_block){2.5f * .01f, 1000}, good, good, good) == 64,
       "a tenth more is foretold enough");
}

/* d = .001 and 1 in one of eight each: t is target^2 times .001 / mean. */
static void allocation(void)
{
    struct adaptive a, fine;
    start(&a, 2, 1, .1);
    const double mean = (1e-3 + 1) / 2;
    const float t = (float)(.01 * 1e-3 / mean);
    write_all(&a, (struct adaptive_block){2 * t, 1000}, noisy);
    write_all(&a, (struct adaptive_block){1e-6f, 1000}, noisy);
    ok(a.content[0] == 1, "within what a quiet block is allowed");
    adaptive_aim(&a, .1 * sqrt(1e-6 / (double)t) * .999);
    ok(a.content[0] == ADAPTIVE_NEVER, "and beyond: it goes as the root of the pilot's error");
    adaptive_aim(&a, 0);
    ok(a.content[0] == ADAPTIVE_NEVER, "without a target nothing stops");
    start(&fine, 2, 1, .1);
    for (int i = 0; i < 2; i++)
        write_all(&fine, (struct adaptive_block){0, 1000}, (struct adaptive_block){0, 1000});
    ok(fine.content[0] == 1 && adaptive_is_due(&fine, 32), "no noise anywhere: all is done");
    adaptive_release(&fine);
    adaptive_release(&a);
}

static void latches(void)
{
    struct adaptive a;
    start(&a, 2, 1, .1);
    for (int i = 0; i < 2; i++)
        write_all(&a, quiet, rare);
    write_all(&a, noisy, noisy);
    ok(a.content[0] == 1 && a.stop[0] == 2, "what is content stays so, and goes when it may");
    ok(adaptive_stopped(&a, 32) == 0 && adaptive_stopped(&a, 64) == .5, "half of the pixels");
    struct adaptive copy;
    adaptive_copy(&copy, &a);
    adaptive_aim(&copy, .1);
    ok(copy.content[0] == 1 && copy.stop[0] == 2 && copy.content[1] == a.content[1],
       "the same from what is written down");
    adaptive_release(&copy);
    adaptive_release(&a);
}

/* Half of the blocks at the given error, the others content. */
static bool is_due(double error2, double target, float neff)
{
    struct adaptive a;
    start(&a, 4, 4, target);
    struct adaptive_block b[16];
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < 16; i++)
            b[i] = (struct adaptive_block){i < 8 ? (float)error2 : 0, neff};
        write_down(&a, b);
    }
    const bool due = adaptive_is_due(&a, 32);
    adaptive_release(&a);
    return due;
}

static void ends(void)
{
    ok(is_due(.0199, .1, 1000) && !is_due(.0201, .1, 1000),
       "a job is due when the mean of the squared errors is the target's square");
    ok(is_due(.0199, .1, 17) && !is_due(.0199, .1, 15), "and 256 samples have told");
    struct adaptive a;
    start(&a, 1, 1, 1);
    write_all(&a, (struct adaptive_block){0, 255}, noisy);
    write_all(&a, (struct adaptive_block){0, 255}, noisy);
    ok(!adaptive_is_due(&a, 32) && a.content[0] == ADAPTIVE_NEVER,
       "one block alone needs them all");
    write_all(&a, (struct adaptive_block){0, 256}, noisy);
    write_all(&a, (struct adaptive_block){0, 256}, noisy);
    ok(adaptive_is_due(&a, 64) && a.content[0] == 3 && !adaptive_is_due(&a, 256),
       "to be due once, to be content twice");
    adaptive_release(&a);
    start(&a, 2, 2, .1);
    write_all(&a, dark, dark);
    ok(!adaptive_is_due(&a, 16), "before the pilot nothing is");
    write_all(&a, dark, dark);
    ok(adaptive_is_due(&a, 32), "nothing at all is soon done");
    adaptive_release(&a);
    start(&a, 2, 2, .1);
    for (int i = 0; i < 3; i++)
        write_all(&a, black, dark);
    ok(!adaptive_is_due(&a, 64) && adaptive_stopped(&a, 64) == 0,
       "a black wall in the dark is not, for fear of its neighbourhood");
    write_all(&a, dark, dark);
    ok(adaptive_is_due(&a, 128) && adaptive_stopped(&a, 128) == .75, "until it was black for long");
    adaptive_release(&a);
}

/* ---- hostile checkpoints ---- */

static bool refuses(struct adaptive *a, const char *what)
{
    struct err err = {.text = ""};
    const bool refused = !adaptive_check(a, &err);
    diag("%s", err.text);
    return refused && strstr(err.text, what);
}

static void checkpoints(void)
{
    struct adaptive a;
    struct err err;
    start(&a, 2, 1, .1);
    for (int i = 0; i < 3; i++)
        write_all(&a, quiet, i < 2 ? dark : (struct adaptive_block){-1, 0});
    ok(adaptive_check(&a, &err), "what is written down is believed");
    const struct adaptive_block bad[] = {{NAN, 1},      {-2, 0},  {-1, 1},
                                         {INFINITY, 1}, {1, NAN}, {1, -INFINITY}};
    uint32_t found = 0;
    for (size_t i = 0; i < countof(bad); i++) {
        a.blocks[4] = bad[i];
        found += refuses(&a, "round 2, block 0: ");
    }
    a.blocks[4] = quiet;
    ok(found == countof(bad), "each number is looked at");
    a.blocks[2] = (struct adaptive_block){-1, 0};
    ok(refuses(&a, "round 1, block 0: not sampled"), "all take part in the pilot");
    a.blocks[2] = quiet;
    a.spp[2] = 128;
    ok(refuses(&a, "round 2 ends at 128"), "no round is left out");
    a.spp[2] = 64;
    a.least = -1;
    ok(refuses(&a, "least"), "the floor of dark pixels is one");
    a.least = 0;
    adaptive_resize(&a, 4);
    a.spp[3] = 128;
    a.blocks[6] = a.blocks[7] = quiet;
    ok(refuses(&a, "round 3, block 1: sampled"), "what has stopped does not begin again");
    adaptive_release(&a);
}

/* ---- synthetic films ---- */

enum kind {
    KIND_QUIET,
    KIND_NOISY,
    KIND_RARE,
    KIND_HEAVY,
    KIND_DARK,
    KIND_BLACK,
    KINDS,
    KIND_LAMP
};

/* Blocks of random kinds and noise; a sample is a function of pixel and pass. */
struct field {
    uint64_t seed;
    enum {
        FIELD_MIXED,
        FIELD_EVEN,
        FIELD_LAMP
    } of; /* all kinds; quiet and noisy ones; KIND_LAMP */
};

static enum kind kind_of(const struct field *f, uint32_t x, uint32_t y, double *noise)
{
    struct dice d = dice_make(f->seed * 1000003 + (x >> 3) * 1009 + (y >> 3));
    *noise = exp(dice_range(&d, -4, .5));
    if (f->of == FIELD_LAMP)
        return KIND_LAMP;
    return (enum kind)(dice_unit(&d) * (f->of == FIELD_EVEN ? KIND_RARE : KINDS));
}

static double draw(enum kind kind, double noise, struct dice *d)
{
    const double u = dice_unit(d);
    switch (kind) {
    case KIND_QUIET:
        return 1 + noise * (u - .5) * .1;
    case KIND_NOISY:
        return 1 - noise * log(1 - u);
    case KIND_RARE:
        return u < .02 ? 50 * noise : 0;
    case KIND_HEAVY:
        return pow(1 - u, -1 / 1.5);
    case KIND_LAMP: /* F-35 */
        return u < 1 / 200. ? 200 : 0;
    case KIND_DARK:
    case KIND_BLACK:
    case KINDS:
        return 0;
    }
    __builtin_unreachable();
}

static void add_pixel(const struct field *f, struct film_samples *s, uint32_t x, uint32_t y)
{
    const struct tile_rect r = s->rect;
    const size_t pixel = (size_t)(y - r.y_begin) * (r.x_end - r.x_begin) + (x - r.x_begin);
    struct block *b =
        &s->blocks[(y - r.y_begin) / BLOCK_PX * block_columns(r) + (x - r.x_begin) / BLOCK_PX];
    double noise;
    const enum kind kind = kind_of(f, x, y, &noise);
    struct dice d =
        dice_make(f->seed + ((uint64_t)y << 40) + ((uint64_t)x << 24) + s->pass.s_begin);
    b->met += kind == KIND_DARK ? 0 : s->pass.s_end - s->pass.s_begin;
    for (uint32_t i = s->pass.s_begin; i < s->pass.s_end; i++) {
        const float v = (float)draw(kind, noise, &d);
        block_add(b, v);
        for (uint32_t c = 0; c < 3; c++)
            s->sums[pixel * FILM_CHANNELS + i % FILM_REPLICATES * 3 + c] += v;
    }
}

static void fill(const void *field, struct film_samples *s)
{
    for (uint32_t y = s->rect.y_begin; y < s->rect.y_end; y++) {
        uint32_t x = s->rect.x_begin, end;
        for (; film_samples_run(s, y, &x, &end); x = end)
            for (uint32_t i = x; i < end; i++)
                add_pixel(field, s, i, y);
    }
}

static bool same_films(const struct film *a, const struct film *b)
{
    const size_t pixels = tile_rect_pixels(a->window), blocks = block_count(a->window);
    return !memcmp(a->sum, b->sum, pixels * 3 * sizeof *a->sum) &&
           !memcmp(a->replicate, b->replicate, pixels * FILM_CHANNELS * sizeof *a->replicate) &&
           !memcmp(a->spp, b->spp, pixels * sizeof *a->spp) &&
           !memcmp(a->blocks, b->blocks, blocks * sizeof *a->blocks) &&
           !memcmp(a->variance, b->variance, blocks * BLOCK_DOUBLINGS * sizeof *a->variance);
}

static bool same_written(const struct adaptive *a, const struct adaptive *b)
{
    return a->rounds == b->rounds && a->least == b->least &&
           !memcmp(a->blocks, b->blocks, a->rounds * a->count * sizeof *a->blocks) &&
           !memcmp(a->content, b->content, a->count) && !memcmp(a->stop, b->stop, a->count);
}

struct history {
    uint32_t runs, same, due, partly; /* partly: some blocks had stopped before the end */
};

/* Down to a target in steps, beside at once with tiles of another size. */
static void go_on(uint64_t seed, struct history *h)
{
    enum { MOST_SPP = 768 };
    struct dice d = dice_make(seed);
    const struct field field = {seed, seed % 4 ? FIELD_MIXED : FIELD_EVEN};
    const uint32_t width = 1 + (uint32_t)(dice_unit(&d) * 90),
                   height = 1 + (uint32_t)(dice_unit(&d) * 60);
    const struct tile_rect window = {3, 5, 3 + width, 5 + height};
    struct adapt steps, once;
    struct err err;
    adapt_init(&steps, window, 16);
    adapt_init(&once, window, 24 + 8 * (uint32_t)(seed % 3));
    double target = exp(dice_range(&d, -3, 0));
    bool due = true;
    for (uint32_t n = 1 + (uint32_t)(dice_unit(&d) * 3); due && n > 0; n--) {
        due = adapt_run(&steps, target, MOST_SPP, fill, &field);
        if (due && n > 1)
            target *= dice_range(&d, .3, 1);
    }
    h->due += adapt_run(&once, target, MOST_SPP, fill, &field);
    h->runs++;
    h->partly += adaptive_stopped(&once.adaptive, once.spp - 1) > 0;
    h->same += same_films(&steps.film, &once.film) &&
               same_written(&steps.adaptive, &once.adaptive) && steps.spp == once.spp &&
               adaptive_check(&once.adaptive, &err);
    adapt_release(&once);
    adapt_release(&steps);
}

static void histories(void)
{
    struct history h = {0};
    const uint32_t runs = stat_tries(120, 2000);
    for (uint32_t i = 0; i < runs; i++)
        go_on(i + 1, &h);
    diag("%u histories: %u met their target, in %u some blocks stopped early", h.runs, h.due,
         h.partly);
    ok(h.same == h.runs, "going on to a smaller error gives the bits of asking at once: %u of %u",
       h.same, h.runs);
    ok(h.due >= h.runs / 4 && h.partly >= h.runs / 4, "of many that end and that stop in part");
}

/* What any film says: no worker can make numbers that a checkpoint would not take. */
static void liars(void)
{
    struct adapt a;
    struct arena arena = {0};
    struct err err = {.text = ""};
    adapt_init(&a, (struct tile_rect){0, 0, 16, 8}, 16);
    struct film_samples s = film_samples_make(a.film.window, (struct tile_pass){0, 16}, &arena);
    for (size_t i = 0; i < 128 * FILM_CHANNELS; i++)
        s.sums[i] = i % 3 ? FLT_MAX : -FLT_MAX * (float)(i % 2);
    s.blocks[0] = (struct block){.sum = DBL_MAX, .square = DBL_MAX};
    s.blocks[1] = (struct block){.sum = 1e-300, .square = 0, .top = {FLT_MAX}};
    film_merge(&a.film, &s);
    const struct adaptive_look look = adaptive_look(&a.film, 16, &a.adaptive, &arena);
    adaptive_add(&a.adaptive, &look);
    ok(adaptive_check(&a.adaptive, &err), "whatever comes is written down as numbers %s", err.text);
    arena_release(&arena);
    adapt_release(&a);
}

/* ---- what decisions do to the image ---- */

static void rare_light(struct tile_rect window, double target, uint32_t jobs)
{
    struct stat_mean mean = {0}, spp = {0}, stopped = {0};
    for (uint64_t seed = 1; seed <= jobs; seed++) {
        const struct field field = {seed, FIELD_LAMP};
        struct adapt a;
        double sum = 0;
        adapt_init(&a, window, 64);
        adapt_run(&a, target, 1 << 20, fill, &field);
        for (size_t i = 0; i < tile_rect_pixels(window); i++)
            sum += a.film.sum[3 * i] / a.film.spp[i];
        stat_add(&mean, sum / tile_rect_pixels(window));
        stat_add(&spp, adapt_mean_spp(&a));
        stat_add(&stopped, adaptive_stopped(&a.adaptive, a.spp - 1));
        adapt_release(&a);
    }
    near(mean.mean, 1, .01 + 3 * stat_error(&mean),
         "F-35: light of one sample in 200, %u px to %g: mean of %u jobs of %.0f spp, %.0f %% "
         "stopped early",
         tile_rect_pixels(window), target, jobs, spp.mean, 100 * stopped.mean);
    if (jobs == 1024)
        near(mean.mean, 1, .01, "F-35: within 1 %%");
}

int main(void)
{
    which_rounds();
    single_blocks();
    allocation();
    latches();
    ends();
    checkpoints();
    histories();
    liars();
    rare_light((struct tile_rect){0, 0, 1, 1}, 1, 1024);
    rare_light((struct tile_rect){2, 1, 34, 25}, .5, stat_tries(32, 1024));
    return tap_done();
}
