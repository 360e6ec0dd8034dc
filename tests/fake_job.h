/* fake_job.h - jobs and payloads for the coordinator's tests, without scenes and tracing. The sums
 * of a payload are a function of pixel and sample range, as a worker's are, so films can be
 * compared. SPDX-License-Identifier: MIT */
#ifndef TESTS_FAKE_JOB_H
#define TESTS_FAKE_JOB_H

#include "common/wire.h"
#include "server/job.h"

/* width x height pixels in tiles of 8; an id that is never 0. */
struct store_job fake_job_row(uint32_t width_px, uint32_t height_px, struct scene_target);
struct job *fake_job_of(const struct store_job *); /* with an empty film */
struct job *fake_job_open(uint32_t width_px, uint32_t height_px, struct scene_target);

/* Of the blocks that the pass lacks by now; of all, if none. noise 0: every sample of a pixel is
 * the same, so the error is 0. Else all but the two blocks on the left have an eighth of their
 * noise, and it falls with the root of the samples. */
struct wire_samples fake_job_payload(const struct job *, uint32_t tile, uint32_t pass, float noise,
                                     struct arena *);
void fake_job_fill(struct film_samples *, float noise); /* rect, pass and blocks are set */

#endif
