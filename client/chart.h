/* chart.h - a scene's chart as data: each method's error against work, and what each optional piece
 * costs and buys. Filled by chart_measure.c and chart_price.c, drawn by chart_draw.c, written as a
 * table by chart_table.c.
 *
 *     chart_measure   methods x amounts of samples x runs, against a reference of two methods
 *     chart_price     pieces that the document can switch off, likewise
 *     chart_draw ...  to SVG and CSV
 *
 * Everything but seconds is a pure function of the document and the options.
 * One thread; memory of the arena that is given.
 * SPDX-License-Identifier: MIT */
#ifndef CLIENT_CHART_H
#define CLIENT_CHART_H

#include "client/chart_runs.h"
#include "common/buf.h"
#include "common/curve.h"
#include "common/err.h"
#include "common/scene.h"

enum {
    CHART_MOST_LINES = 8,
    CHART_MOST_PIECES = 12,
    CHART_TARGETS = 4,
    CHART_FIRST_SPP = 8,
    CHART_REFERENCE_RUNS = 8, /* of each of the two methods */
};

/* Errors that people ask for: parts of the value, as relMSE their squares. */
static const double chart_targets[CHART_TARGETS] = {0.1, 0.03, 0.01, 0.003};

struct chart_options {
    uint32_t size_px;       /* of the longer side: the scene's frame is made that small */
    uint32_t spp;           /* the most of a run: 8 2^k */
    uint32_t runs;          /* of each point */
    uint32_t reference_spp; /* of each of the two methods, in all */
};

struct chart_method {
    const char *name;
    enum integrator_kind integrator;
    enum strategy_kind strategy;
    enum sampler_kind sampler;
};

/* What all runs are held against. */
struct chart_reference {
    const struct chart_method *methods[2];
    uint32_t spp;   /* of each */
    double *image;  /* the mean of both, weighed by their noise */
    double noise;   /* its own relMSE */
    double mean[2]; /* of the image, over channels */
    double off, p;  /* relative difference of these; how probable it is when in truth it is... */
    double margin;  /* ...this or more */
};

struct chart_point {
    uint32_t spp;
    struct curve_value error; /* relMSE */
    double trimmed;           /* without one pixel in a thousand */
    double unknown, heavy;    /* shares of a run's pixels, of the runs' mean: few effective
                               * samples, heavy tails (evidence.h) */
    bool tail;                /* one pixel in a thousand, or one run, has most of the error */
    bool near_floor;          /* within three times of the reference's noise */
};

struct chart_line {
    const struct chart_method *method;
    struct curve curve;
    struct chart_point points[CURVE_MOST_POINTS];
    struct curve_value slope; /* of the points that are not near the floor */
    struct curve_value work_to[CHART_TARGETS];
    struct curve_value gain;   /* over the first line: efficiency */
    struct curve_value bias2;  /* at the last point, less the reference's noise */
    struct curve_value energy; /* mean over the reference's, less 1; at the last point */
    bool missing;              /* a class of paths: energy is surely below 0 by more than .001 */
    double unit_ns;            /* seconds per unit of work: median of the runs */
};

struct chart_piece { /* left out */
    const char *name;
    struct curve_value saved;  /* part of the work */
    struct curve_value error;  /* relMSE added */
    struct curve_value energy; /* added, in parts; its sign is kept */
};

struct chart {
    const char *title;
    uint32_t width_px, height_px;
    struct chart_options options;
    struct chart_reference reference;
    uint32_t line_count, point_count;
    struct chart_line lines[CHART_MOST_LINES]; /* the first: path tracing with all that there is */
    int32_t planned;           /* the line that the planner chose; -1: none of these */
    int32_t best, best_target; /* least work to the smallest error that was reached; -1: none */
    double unit_ns[3];         /* of all lines' runs: 5 %, median, 95 % */

    uint32_t piece_spp;
    double piece_error; /* relMSE with all pieces */
    uint32_t piece_count;
    struct chart_piece pieces[CHART_MOST_PIECES];
};

/* How many runs there will be, for the crew's line. */
uint32_t chart_run_count(const struct scene *, const struct chart_options *);

/* The scene is loaded and not changed. False: it cannot be charted, and why. */
bool chart_measure(struct chart *, const struct scene *, const struct chart_options *,
                   struct chart_crew *, struct arena *, struct err *) MUST_CHECK;

/* Fills the pieces, after chart_measure. */
bool chart_price(struct chart *, const struct scene *, struct chart_crew *, struct arena *,
                 struct err *) MUST_CHECK;

/* --- between these files: chart_prepare.c, chart_reference.c, chart_measure.c --- */

/* The frame made small, whatever it is. */
struct scene chart_shrunk(const struct scene *, uint32_t size_px);
bool chart_prepare(const struct scene *, const struct chart_method *, const struct stage **,
                   struct arena *, struct err *) MUST_CHECK;
bool chart_refer(struct chart *, const struct scene *, struct chart_crew *, struct arena *,
                 struct err *) MUST_CHECK;
/* Runs number 0 to n - 1 of `of`, images allocated. */
struct chart_run *chart_make_runs(const struct stage *, uint32_t spp, uint32_t n, uint64_t seed,
                                  uint32_t of, struct arena *);
/* The part of the reference's energy that an image has too much. */
double chart_energy(const struct chart *, const double *image);

/* --- what is written --- */

void chart_draw(const struct chart *, struct buf *svg);
void chart_draw_price(const struct chart *, struct buf *svg);
void chart_table(const struct chart *, struct buf *csv);
void chart_table_price(const struct chart *, struct buf *csv);

#endif
