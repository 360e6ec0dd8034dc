/* adaptive.h - where a job with an error target still needs samples, and when it has enough.
 *
 * The unit of decision is the block (block.h), of whose pixels all have equally many samples. Some
 * rounds are *judged* (adaptive_judges): in each, what its own samples say is written down of every
 * block that was sampled in it, and never changes. Everything else is a function of what is
 * written down and of the target:
 *
 * - A block is *content* from the first judged round on, the pilot's or later, in which it has
 *   evidence (below) and its squared error g is at most t, and the judged round before foretold
 *   it: evidence then, too, and g' n' / n at most 1.21 t (g' and n' of that round, n samples now).
 * - It *stops*, and gets no more samples, in the first judged round in which it is content and
 *   each of its up to eight neighbours is content or has `need` effective samples: what a
 *   neighbour has not seen yet may reach over here. (Waiting until neighbours are content keeps a
 *   ring going around all that is noisy: it cost a fifth of the work and found nothing.)
 * - The job is *due* in the first judged round in which the mean of g over pixels, of a block that
 *   is content the g that made it so, is at most target^2, the image has 256 effective samples, and
 *   the same is true of each larger target, with what would be content for that. Before the pilot
 *   also each block must have evidence.
 *
 * g = max(e^2, high^2 / 1.1), of the block; e^2 is the mean over its pixels and channels of s^2 /
 * (y^2 + least^2), as in estimate.h, so that the mean of all blocks is the square of the job's
 * error, and high the upper end of its 95 % interval. `least` is the pilot's film's. Where a block
 * has less than two effective samples a pixel, many of its pixels have seen nothing, and do not
 * know it: there g is at least the variance of its samples, less that between its pixels, over n
 * (y^2 + least^2), y the mean of all of them.
 *
 * t = target^2 min(2, max(.05, c d)), d the root of g in the pilot's round, in which t is at most
 * target^2 (where a lamp's edge has not been seen yet, more could end with that). The least work
 * for a given sum of squared errors takes samples in proportion to d (J. Neyman, "On the Two
 * Different Aspects of the Representative Method", J. Royal Statistical Society 97(4), 1934), which
 * leaves squared errors in proportion to d: quiet blocks go on below the target, since they become
 * better at little cost, and so noisy ones need not reach it. But nothing stops at more than twice
 * what was asked for; c is as large as the mean of t allows, which is target^2, and at most 1.5 /
 * mean of d. When all are content the job is due; mostly it is before, and those that have not
 * stopped are the noisiest.
 *
 * Where the mean of d^2 is not 1.05 times the square of d's mean, that is, where the best
 * allocation would save less than a twentieth, the image is *even*, and nothing stops: rounds that
 * double would leave some blocks with twice the samples of their like, which costs up to an eighth.
 *
 * Evidence: `need` effective samples (block.h), and no heavy tail: up to the pilot's round by all
 * of evidence.h, later by what it says of the block alone. Tails take many blocks to be seen, and
 * these then have samples as the target wants; but those that were flagged in every round since the
 * pilot's have not stopped for any target: they are asked again in each, among themselves, and so
 * can outgrow it (where a sun is met by chance, 40 % of the blocks have and do). need = 32, or 256
 * shared by the blocks that have light in the pilot where those are few. Black is fine if no camera
 * ray has met anything, or after ADAPTIVE_DARK_SPP samples. That decisions are made by many samples
 * together and not by single pixels is what keeps them from making the image darker (D. Kirk, J.
 * Arvo, "Unbiased Sampling Techniques for Image Synthesis", SIGGRAPH 1991).
 *
 * Same pixels (P1), and monotone in the target. With target' < target: t' <= t, so what is content
 * for target' is for target, and what stops for target' has stopped for target, so that in each
 * round the blocks sampled for target' include those for target, with the same samples, and the
 * same is written down. If target' is due, so is each that is larger, and target among them. Hence
 * a job that goes on from target to target' has nothing too many, and with what it lacks becomes
 * the very job that was asked for target' at once.
 *
 * Not for: what takes the samples. A struct adaptive is one thread's at a time; adaptive_look is
 * anyone's. SPDX-License-Identifier: MIT */
#ifndef COMMON_ADAPTIVE_H
#define COMMON_ADAPTIVE_H

#include "common/err.h"
#include "common/film.h"

enum {
    ADAPTIVE_FIRST_SPP = 8,  /* of the first judged round */
    ADAPTIVE_PILOT_SPP = 32, /* from which on blocks stop */
    ADAPTIVE_PILOT_ROUND = 2,
    ADAPTIVE_LEAST_NEFF = 256,
    ADAPTIVE_DARK_SPP = 4096,
    ADAPTIVE_MAX_ROUNDS = 128,
    ADAPTIVE_NEVER = 255, /* a round that has not come */
};

struct adaptive_block { /* what a judged round says of a block */
    float error2;       /* g; -1: it was not sampled in this round, or not yet (made up for when a
                         * smaller target wants it) */
    float neff; /* effective samples; < 0: so many, and a heavy tail; +infinity: black, and fine */
};

struct adaptive {
    struct tile_rect window;
    size_t count; /* of blocks, row by row */

    /* What is written down, and belongs into a checkpoint. */
    double least;                      /* of the pilot's film; 0 before */
    uint32_t rounds;                   /* judged so far */
    uint32_t spp[ADAPTIVE_MAX_ROUNDS]; /* of each, rising */
    struct adaptive_block *blocks;     /* [round][block]; heap */

    /* What follows from it, */
    double need;  /* effective samples; 0 before the pilot */
    bool even;    /* nothing stops */
    float *share; /* [block]: t / target^2; heap */
    /* and for the target. */
    double target;    /* 0: none, nothing ever stops */
    uint8_t *content; /* [block]: index of the round since when it is; or ADAPTIVE_NEVER; heap */
    uint8_t *stop;    /* [block]: the same, of its last samples; heap */
};

void adaptive_init(struct adaptive *, struct tile_rect window);     /* no rounds, no target */
void adaptive_copy(struct adaptive *, const struct adaptive *from); /* inits it */
void adaptive_release(struct adaptive *);
void adaptive_aim(struct adaptive *, double target); /* any time; >= 0 */

/* ---- rounds ---- */

/* Is the round that ends with so many samples per pixel judged? 8, 16, 32, 64, 128; 256 and so on
 * by 256 to 4096; then eight in each doubling. All are ends of passes (tile.h) of a job without a
 * cap: the shortened last pass of a capped job is judged only if it happens to end there. */
bool adaptive_judges(uint32_t spp);

struct adaptive_look {
    uint32_t spp;
    double least;                  /* that it went by */
    struct adaptive_block *blocks; /* [block]; the arena's */
};

/* What the film says in the judged round of so many samples per pixel, of those blocks that have
 * just as many; all judged rounds before it have been written down. The heavy part of a decision:
 * for a snapshot (adaptive_copy), in any thread. */
struct adaptive_look adaptive_look(const struct film *, uint32_t spp, const struct adaptive *,
                                   struct arena *);

/* Writes it down: the judged round after the last one, or an earlier one again, for blocks that
 * were not sampled then. */
void adaptive_add(struct adaptive *, const struct adaptive_look *);

/* ---- decisions, for the target, from the judged rounds so far ---- */

/* Does the job end with this judged round, which has been written down? Never without a target. */
bool adaptive_is_due(const struct adaptive *, uint32_t spp);

/* The blocks of the rectangle (which begins where a block does) that lack this pass of samples: not
 * stopped before it begins, and not merged. */
struct block_set adaptive_blocks(const struct adaptive *, const struct film *, struct tile_rect,
                                 struct tile_pass);

/* The share of the window's pixels that have stopped with so many samples or less. */
double adaptive_stopped(const struct adaptive *, uint32_t spp);

/* ---- checkpoints ---- */

/* Makes room for so many rounds, whose content is then read into least, spp and blocks, checked
 * (before anything else is asked) and aimed. rounds <= ADAPTIVE_MAX_ROUNDS. */
void adaptive_resize(struct adaptive *, uint32_t rounds);

/* Whether what was read can be one's own: each number in its range, the rounds just those that are
 * judged. That it belongs to a film cannot be seen. */
bool adaptive_check(const struct adaptive *, struct err *) MUST_CHECK;

#endif
