/* study_parts.h - the parts of a study, for study.c alone (study.h).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_STUDY_PARTS_H
#define COMMON_TRACE_STUDY_PARTS_H

#include "common/film.h"
#include "common/trace/path.h"
#include "common/trace/path_media.h"
#include "common/trace/rng.h"
#include "common/trace/study.h"

struct study_shot;

struct study {
    const struct stage *stage;
    const struct study_halt *halt;
    struct plan *plan;
    struct stage *copy;       /* for other methods than the stage's own; NULL until one is tried */
    struct study_shot *shots; /* of the pilots, by candidate; the outlook goes on with one */
    struct film_work work;    /* that the study has taken, but for them */
};

struct study_place {
    uint32_t x_px, y_px; /* pixel of the whole frame */
};

/* Place i of many, spread evenly over the crop window. */
struct study_place study_place(const struct stage *, uint32_t i, uint32_t salt);

/* The numbers of a study, beside those of the image. */
struct rng study_rng(const struct stage *, struct study_place, uint32_t sample, uint32_t salt);

bool study_is_halted(const struct study *);

/* A way of light, told from the eye on or from the light on. */
struct study_chain {
    bool head, tail; /* the last scatterings at either end were smooth */
    uint32_t rough;  /* others than smooth */
    uint32_t count;  /* all of them */
};

void study_chain_add(struct study_chain *, bool smooth);

/* eye, light: what is next to them is smooth. */
enum plan_class study_class(bool eye, bool light, uint32_t rough);

/* A path that stands at a vertex, in the scalar way of path.c: for one alone. */
struct study_path {
    const struct stage *stage;
    struct path path;
    struct path_media media;
    struct material textured;
    struct film_work *work;
    struct rng rng;
    uint32_t bounce;
};

void study_path_init(struct study_path *, const struct stage *, struct rng, struct film_work *);
/* Along the ray to the next vertex; light that is met is added to path.light. False: there is
 * none. first: the ray starts at no vertex. */
bool study_path_go(struct study_path *, struct ray, bool first);
/* The vertex's material, chosen and with its textures; NULL: nothing scatters there. */
const struct material *study_path_material(struct study_path *);
/* The next ray; first, may_end: as in struct path_draw. */
bool study_path_scatter(struct study_path *, bool first, bool may_end, struct ray *);

bool study_features(struct study *);
bool study_eye(struct study *);
bool study_light(struct study *);
bool study_pilots(struct study *, struct arena *scratch);
bool study_outlook(struct study *, struct arena *scratch);

#endif
