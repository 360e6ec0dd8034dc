/* medium.h - the bodies that a ray is in: what they absorb, and which of their surfaces are there.
 *
 * The body of a dielectric is what lies behind its surface. One that is a part of another material
 * (material.h) has none: it refracts as written. A path carries the bodies around it
 * (struct stage_bodies) in the order in which it has entered them.
 *
 * Absorption: radiance falls by exp(-absorption distance) in the innermost body, per channel.
 *
 * Order: as soon as one material of the scene has a priority, bodies may overlap (C. Schmidt,
 * B. Budge, "Simple Nested Dielectrics in Ray Traced Images", JGT 7(2), 2002). What fills a place
 * is the body of the highest priority that is there; of equal ones, which must be nested or apart,
 * the one entered last. A surface inside a body of higher priority is not there. ior is against
 * vacuum, and what bends light is the quotient of both sides.
 *
 * Bodies are closed. Who leaves a body that it never entered was in it from the start; from the
 * camera's position this is found out beforehand (medium_around). A body entered with STAGE_BODIES
 * around is passed over, with its surface.
 *
 * A scene without either has media 0, and none of this is on its path.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_MEDIUM_H
#define COMMON_TRACE_MEDIUM_H

#include "common/trace/ray.h"
#include "common/trace/stage.h"

enum { MEDIUM_ABSORBS = 1, MEDIUM_ORDERED = 2 };

enum { MEDIUM_MOST_HIDDEN = 1000 }; /* surfaces passed over in a row: then the path ends */

uint32_t medium_uses(const struct scene *); /* stage.media */

/* What is left of light after the distance, in m, which may be infinite. */
rgb medium_passed(const struct stage *, const struct stage_bodies *, float distance);

/* Whether this material bounds a body. */
bool medium_is_body(const struct material *);

/* A surface of the body of stage's material `material`, about to be entered or left. False: it is
 * not there. Else *ratio: the index of refraction behind the surface over that before it. */
bool medium_meets(const struct stage *, const struct stage_bodies *, uint32_t material,
                  bool entering, float *ratio);

void medium_cross(struct stage_bodies *, uint32_t material, bool entering);

/* The bodies around a point, by the surfaces that a ray from it leaves. */
struct stage_bodies medium_around(const struct stage *, vec3 point);

#endif
