/* plan.h - the cheapest sufficient method for a scene, as data with its reasons.
 *
 *     facts     what the scene is like, what light travels which way, what a pilot has measured:
 *               common/trace/study.h fills them in
 *     plan_consider   which methods are worth a pilot, and how large it may be
 *     plan_choose     the method
 *     plan_forecast   what its work will be
 *     plan_print      all of it as JSON (docs/plan.md)
 *
 * Classes of light are named in Heckbert's notation, from the light to the eye: D a scattering into
 * many directions, S into a single one. A method that leaves out light that others find is
 * insufficient. What no method finds is said.
 *
 * A plan is a pure function of document and assets: it is made of counted work, not of time. The
 * method does not depend on the target, so that a job that goes on to another one ends as if it had
 * been asked for that at once; the forecast does. What planning may cost follows from that: for the
 * method a fifth of a sample of each pixel, whatever the job, for the forecast a share of it, the
 * less the more of it the method has had.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_PLAN_H
#define COMMON_PLAN_H

#include "common/buf.h"
#include "common/scene.h"

enum {
    PLAN_VERSION = 3,
    PLAN_WHY = 160,         /* bytes of a reason */
    PLAN_LEAST_PIXELS = 32, /* of a pilot */
    PLAN_PILOT_SPP = 16,
    PLAN_MAX_BYTES = 16384, /* of a printed plan */
};

#define PLAN_ERROR         0.01   /* what is planned for when a document asks for no error */
#define PLAN_SAMPLES       0.2    /* of each pixel, that it may cost to find the method */
#define PLAN_SHARE         0.018  /* of the work forecast, that all may cost; if the method has: */
#define PLAN_OUTLOOK_SHARE 0.009  /* of it, to forecast it */
#define PLAN_SLOPE         (-1.2) /* of the squared error over samples, log by log, mostly, .. */
#define PLAN_SLOPE_ERROR   0.13
#define PLAN_FAR_SLOPE     (-1.05) /* .. and where pixels' edges no longer count */

/* --- what the scene is like --- */

enum plan_lobe { /* of materials by GGX width */
                 PLAN_DELTA,
                 PLAN_NARROW, /* below .05 */
                 PLAN_GLOSSY, /* below .2 */
                 PLAN_ROUGH,
                 PLAN_MATTE,
                 PLAN_LOBES,
};

enum plan_emitter { /* as enum emitter_kind (stage.h) */
                    PLAN_SURFACE,
                    PLAN_POINT,
                    PLAN_SPOT,
                    PLAN_DISTANT,
                    PLAN_SUN,
                    PLAN_MAP,
                    PLAN_EMITTERS,
};

struct plan_features {
    uint32_t lobes[PLAN_LOBES];       /* materials that have some of that width */
    uint32_t emitters[PLAN_EMITTERS]; /* a quad is two */
    bool sky;
    double map_peak;    /* brightest pixel over the mean of an environment map; 0: there is none */
    double map_top;     /* share of its light in its brightest thousandth */
    double hit;         /* share of camera rays that meet a surface */
    double solid_angle; /* sr, of the largest shape that shines as seen from where they do */
    double open;        /* share of rays from there that leave the scene */
    double albedo;      /* mean share of light that is scattered there */
    double behind;      /* share of the ways to lights on which a smooth surface stands first */
    bool textures, masks, media, light_tree, detail;
};

/* --- what light travels which way --- */

/* By what happens next to the light (nothing, or S+), how often light is scattered by D (never,
 * once, more often), and what happens next to the eye (nothing, or S+). */
enum plan_class {
    PLAN_LE,
    PLAN_LSE,
    PLAN_LDE,
    PLAN_LDSE,
    PLAN_LSDE,
    PLAN_LSDSE,
    PLAN_LDDE,
    PLAN_LDDSE,
    PLAN_LSDDE,
    PLAN_LSDDSE,
    PLAN_CLASSES,
};

const char *plan_class_name(enum plan_class);

struct plan_light { /* shares of all light of the image, that which no path finds included */
    double found[PLAN_CLASSES];  /* by paths from the eye */
    double missed[PLAN_CLASSES]; /* traced from lights, since no path from the eye can meet them */
    double beyond_direct, beyond_direct_error;   /* of what is found: after a second scattering; */
    double beyond_whitted, beyond_whitted_error; /* what "whitted" would leave out */
    uint64_t direct_paths, whitted_paths; /* that went on so, whether they met light or not */
    uint64_t eye_paths, light_paths;
};

/* --- the methods --- */

struct plan_method {
    enum integrator_kind integrator;
    enum strategy_kind strategy;
    enum sampler_kind sampler;
};

enum plan_candidate_kind { /* simplest first; the last three do not exist yet */
                           PLAN_DIRECT,
                           PLAN_WHITTED,
                           PLAN_PATH_BSDF,
                           PLAN_PATH_LIGHT,
                           PLAN_PATH_MIS,
                           PLAN_REAL, /* how many there are */
                           PLAN_BIDIRECTIONAL = PLAN_REAL,
                           PLAN_PHOTON_MAP,
                           PLAN_METROPOLIS,
                           PLAN_CANDIDATES,
};

enum plan_verdict {
    PLAN_CHOSEN,
    PLAN_DEARER,       /* by the pilot, or no cheaper and less simple */
    PLAN_TAILED,       /* its variance may not exist: the pilot cannot say what it costs */
    PLAN_INSUFFICIENT, /* light is missing */
    PLAN_RULED_OUT,    /* not tried: the scene says so */
    PLAN_ABSENT,       /* smalti does not have it */
};

struct plan_pilot {
    uint32_t pixels, spp; /* what it was */
    double variance;      /* of a sample, by so many, relative to the squares of pixels */
    double spread;        /* of that: its standard error, relative */
    double slope;         /* of the squared error over samples, log by log, from here on */
    double work;          /* units of a sample */
    double tail;          /* share of the variance in the worst fiftieth of the pixels */
    double thin;          /* share of pixels whose light is that of very few samples */
};

struct plan_candidate {
    enum plan_verdict verdict;
    char why[PLAN_WHY];
    double lacks; /* share of light that it does not find */
    bool tried;   /* there is a pilot */
    struct plan_pilot pilot;
};

struct plan {
    /* Of the document. */
    double error;    /* what is planned for */
    bool is_asked;   /* the document asks for it: then a method may leave out a half of that */
    uint32_t spp;    /* the target's */
    uint64_t pixels; /* of the crop window */
    uint32_t max_bounces;
    enum sampler_kind sampler;

    struct plan_features features;
    struct plan_light light;

    double studied; /* units of work that the study has taken, with its pilots */

    uint32_t pilot_pixels; /* 0: none, and why_no_pilot says why */
    char why_no_pilot[PLAN_WHY];
    struct plan_candidate candidates[PLAN_CANDIDATES];
    enum plan_candidate_kind chosen;
    struct plan_pilot outlook;                    /* of that method, for the forecast */
    double forecast, forecast_low, forecast_high; /* units of work to the target */
    double forecast_spp;
};

const char *plan_candidate_name(enum plan_candidate_kind);

/* Methods as documents name them. plan_find: PLAN_REAL when there is none of these names. */
struct plan_names {
    const char *integrator, *strategy;
};

struct plan_names plan_names(enum plan_candidate_kind); /* below PLAN_REAL */
enum plan_candidate_kind plan_find(const char *integrator, const char *strategy);
struct plan_method plan_method_of(const struct plan *, enum plan_candidate_kind);

/* --- the steps --- */

/* An empty plan; pixels: of the crop window. */
void plan_init(struct plan *, const struct scene_settings *, uint64_t pixels);

/* How many places of the frame are looked at, and how many paths from lights are followed. */
uint32_t plan_places(const struct plan *);
uint32_t plan_light_paths(const struct plan *);

/* After features and light: settles which candidates are tried (verdict PLAN_DEARER until
 * plan_choose) and pilot_pixels. */
void plan_consider(struct plan *, bool may_pilot);

static inline bool plan_wants(const struct plan *p, enum plan_candidate_kind k)
{
    return p->pilot_pixels > 0 && p->candidates[k].verdict == PLAN_DEARER;
}

/* After the pilots. */
void plan_choose(struct plan *);

/* After the outlook; spp: of a pixel to the target, by that, give or take a factor. */
void plan_forecast(struct plan *, double spp, double factor);

/* What methods are compared by: variance x work. */
double plan_price(const struct plan_pilot *);

/* --- in words --- */

void plan_print(const struct plan *, struct buf *out); /* one JSON object; appends */

#endif
