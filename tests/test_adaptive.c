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

/* A row: the first block, its neighbour, and ten with nothing in them. */
static void write_row(struct adaptive *a, struct adaptive_block first,
                      struct adaptive_block neighbour)
{
    struct adaptive_block b[12];
    for (size_t i = 0; i < a->count; i++)
        b[i] = i == 0 ? first : i == 1 ? neighbour : dark;
    write_down(a, b);
}

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
    start(&a, 12, 1, .1);
    write_row(&a, at_16, neighbour);
    write_row(&a, at_32, neighbour);
    write_row(&a, later, neighbour);
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
    const struct adaptive_block above = {.015f, 1000}, more = {.025f, 1000};
    ok(stopped_at(above, above, above, noisy) == 64, "above the target one stops, but not at once");
    ok(stopped_at(more, more, more, noisy) == 0, "and not at more than twice its square");
    ok(stopped_at(quiet, quiet, quiet, rare) == 0,
       "a block waits for what its neighbour has not seen");
    ok(stopped_at(quiet, quiet, quiet, black) == 0, "which may be anything where that is black");
    ok(stopped_at(quiet, quiet, quiet, tail) == 32, "a neighbour's heavy tail is its own matter");
    const struct adaptive_block good = {.005f, 1000}; /* allowed are .01 */
    ok(stopped_at((struct adaptive_block){.024f, 1000}, good, good, good) == 32 &&
           stopped_at((struct adaptive_block){.025f, 1000}, good, good, good) == 64,
       "a tenth more is foretold enough");
}

/* Rounds of eight blocks: two quiet ones, four or five of that error, others noisy. */
static void start_row(struct adaptive *a, int some, float error2)
{
    struct adaptive_block b[8] = {quiet, quiet};
    for (int i = 2; i < 8; i++)
        b[i] = i < 2 + some ? (struct adaptive_block){error2, 1000} : noisy;
    start(a, 8, 1, .1);
    write_down(a, b);
    write_down(a, b);
}

static void allocation(void)
{
    struct adaptive a;
    start_row(&a, 4, .01f);
    const double mean = (2 * 1e-3 + 4 * .1 + 2) / 8;
    near((double)a.share[2], 1.5 * .1 / mean, 1e-6,
         "a block's share goes as the root of its noise");
    near((double)a.share[0], .05, 1e-6, "is never nothing");
    ok(a.share[7] == 2, "and no more than twice the target's square");
    adaptive_aim(&a, 1.001 * sqrt(1e-6 / .05));
    ok(a.content[0] == 2, "within its share it is content");
    adaptive_aim(&a, .999 * sqrt(1e-6 / .05));
    ok(a.content[0] == ADAPTIVE_NEVER, "and beyond it is not");
    adaptive_release(&a);
    start_row(&a, 5, .25f);
    near((double)a.share[2], (8 - 2 - .1) / 5, 1e-6, "all shares together are one for each block");
    adaptive_aim(&a, 0);
    ok(a.content[0] == ADAPTIVE_NEVER, "without a target nothing is");
    adaptive_release(&a);
    start(&a, 2, 1, .1);
    for (int i = 0; i < 2; i++)
        write_all(&a, (struct adaptive_block){0, 1000}, (struct adaptive_block){0, 1000});
    ok(a.content[0] == 2 && adaptive_is_due(&a, 32), "no noise anywhere: all is done");
    adaptive_release(&a);
}

/* Nearly the same noise everywhere, and a little less of it in one of 16 blocks. */
static void even_images(void)
{
    struct adaptive a;
    for (int i = 0; i < 2; i++) {
        start(&a, 16, 1, .1);
        for (int round = 0; round < 2; round++)
            write_all(&a, (struct adaptive_block){i ? .25f : .004f, 1000},
                      (struct adaptive_block){.005f, 1000});
        ok(a.even == !i && (a.stop[15] == ADAPTIVE_NEVER) == !i,
           i ? "where noise differs, blocks stop" : "where it hardly does, none");
        adaptive_release(&a);
    }
}

static void latches(void)
{
    struct adaptive a;
    start(&a, 12, 1, .1);
    for (int i = 0; i < 2; i++)
        write_row(&a, quiet, rare);
    write_row(&a, noisy, noisy);
    ok(a.content[0] == 2 && a.stop[0] == 3, "what is content stays so, and goes when it may");
    ok(adaptive_stopped(&a, 32) == 9 / 12. && adaptive_stopped(&a, 64) == 11 / 12.,
       "all but the neighbour");
    struct adaptive copy;
    adaptive_copy(&copy, &a);
    adaptive_aim(&copy, .1);
    ok(copy.content[0] == 2 && copy.stop[0] == 3 && copy.content[1] == a.content[1],
       "the same from what is written down");
    adaptive_release(&copy);
    adaptive_release(&a);
}

/* Half of the blocks so noisy that the whole is `of` its target's square. */
static bool is_due(double of, float neff)
{
    struct adaptive a;
    struct adaptive_block b[16];
    start(&a, 4, 4, .1);
    for (int i = 0; i < 16; i++)
        b[i] = (struct adaptive_block){i < 8 ? (float)(2 * .01 * of) : 0, neff};
    write_down(&a, b);
    write_down(&a, b);
    const bool due = adaptive_is_due(&a, 32);
    adaptive_release(&a);
    return due;
}

/* A quarter of the blocks are content now, with little error, and would have been before, with so
 * much, for any target from the root of that on; the others never are. */
static bool is_due_after(float before)
{
    struct adaptive a;
    struct adaptive_block b[3][16];
    start(&a, 4, 4, sqrt(.009));
    for (int i = 0; i < 16; i++) {
        b[0][i] = (struct adaptive_block){i < 4 ? 2 * before : 1e-4f, i < 4 ? 1000 : 20};
        b[1][i] = (struct adaptive_block){i < 4 ? before : 1e-4f, b[0][i].neff};
        b[2][i] = (struct adaptive_block){i < 4 ? .005f : .0103f, b[0][i].neff};
    }
    for (int round = 0; round < 3; round++)
        write_down(&a, b[round]);
    const bool due = adaptive_is_due(&a, 64);
    adaptive_release(&a);
    return due;
}

static void ends(void)
{
    ok(is_due(.999, 1000) && !is_due(1.001, 1000),
       "a job is due when the mean of the squared errors is the target's square");
    ok(is_due(.999, 17) && !is_due(.999, 15), "and 256 samples have told");
    ok(is_due_after(.2f) && !is_due_after(.0098f),
       "but not while one with a larger target would go on");
    struct adaptive a;
    start(&a, 1, 1, 1);
    write_all(&a, (struct adaptive_block){0, 255}, noisy);
    write_all(&a, (struct adaptive_block){0, 255}, noisy);
    ok(!adaptive_is_due(&a, 32) && a.content[0] == ADAPTIVE_NEVER,
       "one block alone needs them all");
    write_all(&a, (struct adaptive_block){0, 256}, noisy);
    write_all(&a, (struct adaptive_block){0, 256}, noisy);
    ok(adaptive_is_due(&a, 64) && !adaptive_is_due(&a, 256), "in a round that has come");
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
    even_images();
    latches();
    ends();
    checkpoints();
    return tap_done();
}
