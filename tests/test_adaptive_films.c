/* adaptive.c on films of random samples: whoever goes on to a smaller error ends as one that was
 * asked for it at once, and no target makes an image too dark. SPDX-License-Identifier: MIT */
#include "common/adaptive.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "common/estimate.h"
#include "tests/adapt.h"
#include "tests/dice.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum kind {
    KIND_QUIET,
    KIND_NOISY,
    KIND_RARE,
    KIND_HEAVY,
    KIND_DARK,
    KIND_BLACK,
    KINDS,
    KIND_EVEN, /* sqrt(1/48) of itself */
    KIND_LAMP  /* F-35: one sample in 200, nine in 10 from column 32 on */
};

/* Blocks of random kinds and noise; a sample is a function of pixel and pass. */
struct field {
    uint64_t seed;
    enum kind of; /* KINDS: of all before it */
};

static enum kind kind_of(const struct field *f, uint32_t x, uint32_t y, double *noise)
{
    struct dice d = dice_make(f->seed * 1000003 + (x >> 3) * 1009 + (y >> 3));
    *noise = exp(dice_range(&d, -4, .5));
    if (f->of == KIND_LAMP)
        *noise = x < 32 ? 1 / 200. : .9;
    return f->of == KINDS ? (enum kind)(dice_unit(&d) * KINDS) : f->of;
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
    case KIND_EVEN:
        return 1 + .5 * (u - .5);
    case KIND_LAMP:
        return u < noise ? 1 / noise : 0;
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
    const struct field field = {seed, seed % 4 ? KINDS : KIND_NOISY};
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
    const uint32_t runs = max_u32(stat_tries(120, 2000), 16);
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
    struct film_samples s = film_samples_make(a.film.window, (struct tile_pass){0, 8}, &arena);
    for (size_t i = 0; i < 128 * FILM_CHANNELS; i++)
        s.sums[i] = i % 3 ? FLT_MAX : -FLT_MAX * (float)(i % 2);
    s.blocks[0] = (struct block){.sum = DBL_MAX, .square = DBL_MAX};
    s.blocks[1] = (struct block){.sum = 1e-300, .square = 0, .top = {FLT_MAX}};
    film_merge(&a.film, &s);
    const struct adaptive_look look = adaptive_look(&a.film, 8, &a.adaptive, &arena);
    adaptive_add(&a.adaptive, &look);
    ok(adaptive_check(&a.adaptive, &err), "whatever comes is written down as numbers %s", err.text);
    arena_release(&arena);
    adapt_release(&a);
}

/* ---- what decisions do to the image ---- */

/* A job whose light comes with one sample in 200. */
static struct adapt lamp_job(struct tile_rect window, double target, uint64_t seed)
{
    const struct field field = {seed, KIND_LAMP};
    struct adapt a;
    adapt_init(&a, window, 64);
    adapt_run(&a, target, 1 << 20, fill, &field);
    return a;
}

static void rare_light(struct tile_rect window, double target, uint32_t jobs)
{
    struct stat_mean mean = {0}, spp = {0}, stopped = {0};
    for (uint64_t seed = 1; seed <= jobs; seed++) {
        struct adapt a = lamp_job(window, target, seed);
        double sum = 0;
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

/* Half of the image is lit by one sample in 200: most pixels have seen none of it for long, and
 * those that have do not know how seldom it was. */
static void thin_evidence(double target)
{
    enum { JOBS = 8 };
    const struct tile_rect window = {0, 0, 64, 32};
    struct stat_mean error2 = {0}, spp = {0};
    for (uint64_t seed = 1; seed <= JOBS; seed++) {
        struct adapt a = lamp_job(window, target, seed);
        double sum = 0;
        for (size_t i = 0; i < tile_rect_pixels(window); i++) {
            const double off = a.film.sum[3 * i] / a.film.spp[i] - 1;
            sum += off * off;
        }
        stat_add(&error2, sum / tile_rect_pixels(window));
        stat_add(&spp, adapt_mean_spp(&a));
        adapt_release(&a);
    }
    ok(sqrt(error2.mean) <= 1.2 * target,
       "half lit by one sample in 200, to %g: %.2f true after %.0f spp", target, sqrt(error2.mean),
       spp.mean);
}

/* ---- when a job ends ---- */

static uint32_t spp_to(double target, uint32_t side_px, uint32_t most, struct field field,
                       double *error)
{
    struct adapt a;
    adapt_init(&a, (struct tile_rect){0, 0, side_px, side_px}, 64);
    adapt_run(&a, target, most, fill, &field);
    *error = estimate_error(&a.film);
    adapt_release(&a);
    return a.spp;
}

static void quiet(void)
{
    double error;
    ok(spp_to(.5, 16, 1 << 20, (struct field){5, KIND_EVEN}, &error) == 8,
       "what is quiet ends after the first round");
    const uint32_t spp = spp_to(.005, 16, 1 << 20, (struct field){5, KIND_EVEN}, &error);
    ok(spp >= 768 && spp <= 1280, /* sqrt(1/48 / n) = .005: n = 833 */
       "and a strict target with as many as it takes: %u", spp);
    ok(error <= .005, "the target is met: %g", error);
}

static void darkness(void)
{
    double error;
    ok(spp_to(.1, 8, 1 << 20, (struct field){6, KIND_BLACK}, &error) == ADAPTIVE_DARK_SPP,
       "black may be chance for a while");
    ok(spp_to(.1, 8, 1 << 20, (struct field){6, KIND_DARK}, &error) == 8,
       "but not where there is nothing");
    ok(spp_to(.1, 8, 64, (struct field){6, KIND_BLACK}, &error) == 64, "the cap holds");
}

int main(void)
{
    histories();
    liars();
    quiet();
    darkness();
    rare_light((struct tile_rect){0, 0, 8, 8}, 1, 1024);
    rare_light((struct tile_rect){0, 0, 1, 1}, 1, 1024);
    rare_light((struct tile_rect){0, 1, 64, 33}, .5, max_u32(stat_tries(16, 1024), 16));
    thin_evidence(.5);
    thin_evidence(.25);
    return tap_done();
}
