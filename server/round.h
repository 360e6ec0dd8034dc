/* round.h - the rounds of a job: of which blocks a pass of a tile is, and when a round is over.
 *
 * A round is the same pass of every tile. In a job with an error target rounds are judged when they
 * are complete (common/adaptive.h), and blocks stop; so a pass may lack some blocks of its tile
 * only, or none: then it counts as merged without a lease.
 *
 * What a pass lacks follows from the film, the target and what is written down of the rounds: the
 * blocks that have no samples of it yet and have not stopped before it. The same rule finds
 * out, when a job is opened, which passes its tiles have; also for a job that was done and got
 * another target: its rounds begin again at the first that any block lacks.
 *
 * As long as the round below a pass is not judged, the pass may come to lack less. Pure; owner
 * thread only. SPDX-License-Identifier: MIT */
#ifndef SERVER_ROUND_H
#define SERVER_ROUND_H

#include "server/job.h"

/* Blocks of the tile. The job is open, and its film not with the writer. */
struct block_set round_blocks(const struct job *, uint32_t tile, uint32_t pass);
bool round_lacks(const struct job *, uint32_t tile, uint32_t pass); /* any */

uint64_t round_pixels(const struct job *, uint32_t pass); /* of the blocks that lack it */
uint64_t round_owed(const struct job *, uint32_t pass); /* samples that the rounds before it lack */

/* Passes that the tile's blocks have, or will never need, of the first `most`. */
uint32_t round_passes_of(const struct job *, uint32_t tile, uint32_t most);

/* May the pass be merged? Not before the round below it is judged: so the film at a judgement is a
 * function of document and target. */
bool round_is_open(const struct job *, uint32_t pass);

void round_count(struct job *, uint32_t merged); /* a tile has so many passes now */
bool round_is_last(const struct job *);          /* every pass up to the spp target is in */

/* The last complete round is to be judged, by adaptive.h; of round_spp samples. */
bool round_wants_judge(const struct job *);
uint32_t round_spp(const struct job *);
/* It is complete, is not open to judgement, and lets the next one in. */
bool round_goes_on(const struct job *);

#endif
