/* A chart's numbers as CSV. Every column but seconds is the same on every machine.
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "client/chart.h"

/* An empty cell says that there is no such number. */
static void cell(struct buf *b, double value)
{
    if (isfinite(value))
        buf_text(b, ",%.9g", value);
    else
        buf_text(b, ",");
}

static void interval(struct buf *b, struct curve_value v)
{
    cell(b, v.at);
    cell(b, v.low);
    cell(b, v.high);
}

static void row(struct buf *b, const struct chart *c, const struct chart_line *line, uint32_t point)
{
    const struct chart_point *p = &line->points[point];
    const double work = line->curve.work[point];
    buf_text(b, "\"%s\",%u,%u", line->method->name, p->spp, c->options.runs);
    cell(b, work);
    cell(b, work * line->unit_ns * 1e-9);
    interval(b, p->error);
    cell(b, p->trimmed);
    cell(b, p->untrusted);
    buf_text(b, ",%d,%d,%d", p->tail, p->near_floor, line->missing);
    interval(b, line->slope);
    interval(b, line->gain);
    interval(b, line->bias2);
    interval(b, line->energy);
    for (int t = 0; t < CHART_TARGETS; t++)
        cell(b, line->work_to[t].at);
    buf_text(b, ",%d,%d\n", &c->lines[c->best < 0 ? 0 : c->best] == line && c->best >= 0,
             c->planned >= 0 && &c->lines[c->planned] == line);
}

/* Columns between relmse and energy, and after that. */
enum { BEFORE_ENERGY = 16, AFTER_ENERGY = 4 + CHART_TARGETS };

static const char commas[] = ",,,,,,,,,,,,,,,,,,,,";

void chart_table(const struct chart *c, struct buf *csv)
{
    buf_text(csv, "method,spp,runs,work_units,seconds,relmse,relmse_low,relmse_high,relmse_99_9,"
                  "untrusted_blocks,tail,near_floor,class_missing,slope,slope_low,slope_high,"
                  "efficiency,efficiency_low,efficiency_high,bias2,bias2_low,bias2_high,"
                  "energy,energy_low,energy_high");
    for (int t = 0; t < CHART_TARGETS; t++)
        buf_text(csv, ",work_to_%g_percent", 100 * chart_targets[t]);
    buf_text(csv, ",best,planned\n");
    for (uint32_t i = 0; i < c->line_count; i++)
        for (uint32_t p = 0; p < c->point_count; p++)
            row(csv, c, &c->lines[i], p);
    buf_text(csv, "\"reference: %s and %s\",%u,%u,,", c->reference.methods[0]->name,
             c->reference.methods[1]->name, c->reference.spp, (unsigned)CHART_REFERENCE_RUNS);
    cell(csv, c->reference.noise);
    buf_text(csv, "%.*s", BEFORE_ENERGY, commas);
    cell(csv, c->reference.off);
    buf_text(csv, "%.*s\n", AFTER_ENERGY, commas);
}

void chart_table_price(const struct chart *c, struct buf *csv)
{
    buf_text(csv, "left_out,spp,runs,work_saved,work_saved_low,work_saved_high,relmse_added,"
                  "relmse_added_low,relmse_added_high,energy_added,energy_added_low,"
                  "energy_added_high\n");
    buf_text(csv, "\"nothing: %s\",%u,%u,0,,,%.9g,,,,,\n", c->lines[0].method->name, c->piece_spp,
             c->options.runs, c->piece_error);
    for (uint32_t i = 0; i < c->piece_count; i++) {
        const struct chart_piece *p = &c->pieces[i];
        buf_text(csv, "\"%s\",%u,%u", p->name, c->piece_spp, c->options.runs);
        interval(csv, p->saved);
        interval(csv, p->error);
        interval(csv, p->energy);
        buf_text(csv, "\n");
    }
}
