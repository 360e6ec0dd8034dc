/* study_lens.h - the camera as light that arrives sees it: what of a point's radiance is seen.
 *
 * A thin lens counts as the pinhole in its middle. SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_STUDY_LENS_H
#define COMMON_TRACE_STUDY_LENS_H

#include "common/trace/ray.h"
#include "common/trace/surface.h"

struct study_seen {
    vec3 to_eye; /* unit */
    double
        per_watt; /* mean radiance of the crop window's pixels for radiance x area x cosine of 1 */
    struct ray ray; /* a segment from the point: hits nothing, the point is seen */
};

/* False: it is outside the crop window, or behind the camera. */
bool study_lens_sees(const struct stage *, const struct surface *at, struct study_seen *);

#endif
