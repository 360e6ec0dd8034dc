/* study.h - what a plan has to know about a stage (common/plan.h): what the scene is like, which
 * way its light travels, and what methods make of it.
 *
 *     features   camera rays, rays from where they arrive, and the stage's lists
 *     eye        paths from the eye, their light by class
 *     light      paths from lights that have no size, which paths from the eye cannot meet behind
 *                smooth surfaces: their light by class
 *     pilots     pixels here and there with the candidates' own samples
 *
 * All of it is small beside the job, and the same for the same stage: a pure function. The caller's
 * arena holds a copy of the stage for the pilots, as other methods have it, so that of stages above
 * STUDY_MOST_BYTES there are none. One thread.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_STUDY_H
#define COMMON_TRACE_STUDY_H

#include "common/plan.h"
#include "common/trace/stage.h"

#define STUDY_MOST_BYTES ((uint64_t)1 << 30)

/* The stage: of a document with "auto". halt: NULL, or looked at now and then; once it says so the
 * study ends, and false is returned, the plan unfinished. */
struct study_halt {
    bool (*is_wanted)(const void *user);
    const void *user;
};

bool study_make(const struct stage *, const struct study_halt *, struct arena *scratch,
                struct plan *);

/* A copy, and the copy as prep_stage would have made it of a document with that method. `of` is the
 * stage that study_make takes, or, the first time, the copy itself. */
struct stage *study_stage(const struct stage *, struct arena *);
void study_set_method(struct stage *copy, const struct stage *of, struct plan_method);

#endif
