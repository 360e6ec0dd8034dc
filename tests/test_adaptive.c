/* adaptive.c: blocks stop when they may, a job ends when it may. On rounds written down by hand.
 * SPDX-License-Identifier: MIT */
#include "common/adaptive.h"

#include <math.h>
#include <string.h>

#include "tests/tap.h"

/* ---- rules, on rounds written down by hand ---- */

static const uint32_t judged[] = {8, 16, 32, 64, 128, 256, 512, 768, 1024, 1280};

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
    ok(counts[0] == 5 + 16 && counts[1] == 8 * 12 && counts[0] + counts[1] <= ADAPTIVE_MAX_ROUNDS,
       "rounds are judged at 8 to 128, each 256 to 4096, eight in a doubling: %u, %u", counts[0],
       counts[1]);
    ok(ends && !adaptive_judges(4) && !adaptive_judges(0) && !adaptive_judges(48) &&
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

static const struct adaptive_block noisy = {1, 1000}, quiet = {1e-6f, 1000}, rare = {1e-6f, 20},
                                   tail = {1e-6f, -1000}, dark = {0, INFINITY}, black = {0, 0};

/* The first round, which decides nothing, is written down. */
static void start(struct adaptive *a, uint32_t columns, uint32_t rows, double target)
{
    adaptive_init(a, (struct tile_rect){0, 0, 8 * columns, 8 * rows});
    adaptive_aim(a, target);
    write_all(a, noisy, noisy);
}

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
    ok(stopped_at(quiet, quiet, quiet, tail) == 32, "a neighbour's heavy tail is its own matter");
    const struct adaptive_block nearly = {1.1f * .01f / 2, 1000}, good = {.005f, 1000};
    ok(stopped_at((struct adaptive_block){2.1f * nearly.error2, 1000}, good, good, good) == 32 &&
           stopped_at((struct adaptive_block){2.5f * .01f, 1000}, good, good, good) == 64,
       "a tenth more is foretold enough");
}

/* Three quiet blocks, five noisy ones in a row: d = .001 of the first two, 1 of the last four. */
static void allocation(void)
{
    struct adaptive a;
    struct adaptive_block b[8] = {quiet, quiet, quiet, noisy, noisy, noisy, noisy, noisy};
    const double mean = (2e-3 + sqrt((1 + 2e-6) / 3) + sqrt((2 + 1e-6) / 3) + 4) / 8;
    start(&a, 8, 1, .1);
    write_down(&a, b);
    write_down(&a, b);
    near((double)a.share[0], 1e-3 / mean, 1e-6,
         "a quiet block's share goes as the root of its noise");
    near((double)a.share[2], sqrt((1 + 2e-6) / 3) / mean, 1e-6, "with its neighbours'");
    ok(a.share[4] == 1, "and a noisy one's is no more than the target");
    adaptive_aim(&a, 1.001 * sqrt(1e-6 * mean / 1e-3));
    ok(a.content[0] == 2, "within its share it is content");
    adaptive_aim(&a, .999 * sqrt(1e-6 * mean / 1e-3));
    ok(a.content[0] == ADAPTIVE_NEVER, "and beyond it is not");
    adaptive_aim(&a, 0);
    ok(a.content[0] == ADAPTIVE_NEVER, "without a target nothing is");
    adaptive_release(&a);
    start(&a, 2, 1, .1);
    for (int i = 0; i < 2; i++)
        write_all(&a, (struct adaptive_block){0, 1000}, (struct adaptive_block){0, 1000});
    ok(a.content[0] == 2 && adaptive_is_due(&a, 32), "no noise anywhere: all is done");
    adaptive_release(&a);
}

static void latches(void)
{
    struct adaptive a;
    start(&a, 2, 1, .1);
    for (int i = 0; i < 2; i++)
        write_all(&a, quiet, rare);
    write_all(&a, noisy, noisy);
    ok(a.content[0] == 2 && a.stop[0] == 3, "what is content stays so, and goes when it may");
    ok(adaptive_stopped(&a, 32) == 0 && adaptive_stopped(&a, 64) == .5, "half of the pixels");
    struct adaptive copy;
    adaptive_copy(&copy, &a);
    adaptive_aim(&copy, .1);
    ok(copy.content[0] == 2 && copy.stop[0] == 3 && copy.content[1] == a.content[1],
       "the same from what is written down");
    adaptive_release(&copy);
    adaptive_release(&a);
}

/* Half of the blocks so noisy that the whole is `of` its target's square; the others are content.
 */
static bool is_due(double of, float neff)
{
    const double target = .1;
    double error2 = 1, left = 16;
    struct adaptive a;
    for (int again = 0; again < 2; again++) {
        start(&a, 4, 4, target);
        struct adaptive_block b[16];
        for (int i = 0; i < 16; i++)
            b[i] = (struct adaptive_block){i < 8 ? (float)error2 : 0, neff};
        write_down(&a, b);
        write_down(&a, b);
        for (int i = 8; !again && i < 16; i++)
            left -= (double)a.share[i];
        error2 = left / 8 * target * target * of;
        if (!again)
            adaptive_release(&a);
    }
    const bool due = adaptive_is_due(&a, 32);
    adaptive_release(&a);
    return due;
}

static void ends(void)
{
    ok(is_due(.999, 1000) && !is_due(1.001, 1000),
       "a job is due when the mean of the squared errors is the target's square");
    ok(is_due(.999, 17) && !is_due(.999, 15), "and 256 samples have told");
    struct adaptive a;
    start(&a, 1, 1, 1);
    write_all(&a, (struct adaptive_block){0, 255}, noisy);
    write_all(&a, (struct adaptive_block){0, 255}, noisy);
    ok(!adaptive_is_due(&a, 32) && a.content[0] == ADAPTIVE_NEVER,
       "one block alone needs them all");
    write_all(&a, (struct adaptive_block){0, 256}, noisy);
    write_all(&a, (struct adaptive_block){0, 256}, noisy);
    ok(adaptive_is_due(&a, 64) && a.content[0] == 4 && !adaptive_is_due(&a, 256),
       "to be due once, to be content twice");
    adaptive_release(&a);
    start(&a, 4, 4, .1);
    write_all(&a, quiet, rare);
    ok(!adaptive_is_due(&a, 16), "before the pilot a job is only due with evidence everywhere,");
    write_all(&a, quiet, rare);
    ok(adaptive_is_due(&a, 32), "afterwards with what single blocks lack,");
    adaptive_release(&a);
    start(&a, 2, 2, .1);
    write_all(&a, quiet, quiet);
    ok(adaptive_is_due(&a, 16), "what is quiet is soon done");
    adaptive_aim(&a, 1e-4);
    ok(!adaptive_is_due(&a, 16), "for this target");
    adaptive_release(&a);
    start(&a, 2, 2, .1);
    write_all(&a, dark, dark);
    ok(adaptive_is_due(&a, 16), "and so is nothing at all");
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
        a.blocks[6] = bad[i];
        found += refuses(&a, "round 3, block 0: ");
    }
    a.blocks[6] = quiet;
    ok(found == countof(bad), "each number is looked at");
    a.blocks[4] = (struct adaptive_block){-1, 0};
    ok(refuses(&a, "round 2, block 0: not sampled"), "all take part in the pilot");
    a.blocks[4] = quiet;
    a.spp[3] = 128;
    ok(refuses(&a, "round 3 ends at 128"), "no round is left out");
    a.spp[3] = 64;
    a.least = -1;
    ok(refuses(&a, "least"), "the floor of dark pixels is one");
    a.least = 0;
    adaptive_resize(&a, 5);
    a.spp[4] = 128;
    a.blocks[8] = a.blocks[9] = quiet;
    ok(refuses(&a, "round 4, block 1: sampled"), "what has stopped does not begin again");
    adaptive_release(&a);
}

int main(void)
{
    which_rounds();
    single_blocks();
    allocation();
    latches();
    ends();
    checkpoints();
    return tap_done();
}
