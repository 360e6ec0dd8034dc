/* SPDX-License-Identifier: MIT */
#include "server/status_report.h"

#include <jansson.h>

static json_t *known_or_null(double v)
{
    return v >= 0 ? json_real(v) : json_null();
}

/* Which part of the error bars means what it says: of all but a hundredth of the pixels, of half of
 * them, of less. */
static const char *coverage(const struct store_report *r)
{
    const double untrusted = r->unknown + r->heavy;
    return untrusted < 0      ? "unknown"
           : untrusted <= .01 ? "trusted"
           : untrusted <= .5  ? "partly"
                              : "untrusted";
}

static json_t *error_json(const struct store_job *row)
{
    const struct store_report *r = &row->report;
    json_t *interval =
        r->error_low >= 0 ? json_pack("[f,f]", r->error_low, r->error_high) : json_null();
    return json_pack("{s:o, s:o, s:s}", "estimate", known_or_null(row->error), "interval", interval,
                     "coverage", coverage(r));
}

static json_t *pixels_json(const struct store_report *r)
{
    const bool known = r->unknown >= 0;
    return json_pack("{s:o, s:o, s:o}", "trusted",
                     known_or_null(known ? 1 - r->unknown - r->heavy : -1), "unknown",
                     known_or_null(r->unknown), "heavy_tail", known_or_null(r->heavy));
}

/* Of the light there would be without the limit. */
static json_t *share_json(double removed, double energy)
{
    const double all = removed + energy;
    return json_pack("{s:f, s:f}", "luminance", removed, "share", all > 0 ? removed / all : 0.0);
}

static json_t *work_json(const struct film_work *w)
{
    return json_pack("{s:I, s:I, s:I, s:I, s:I, s:I}", "camera_rays", (json_int_t)w->camera_rays,
                     "bounce_rays", (json_int_t)w->bounce_rays, "shadow_rays",
                     (json_int_t)w->shadow_rays, "plain_vertices", (json_int_t)w->plain_vertices,
                     "other_vertices", (json_int_t)w->other_vertices, "units",
                     (json_int_t)w->units);
}

json_t *status_report_invalid(const struct store_job *row)
{
    json_t *keys = json_array();
    for (uint32_t i = 0; i < row->key_count; i++)
        json_array_append_new(keys, json_pack("[I,I,I]", (json_int_t)row->keys[i].x_px,
                                              (json_int_t)row->keys[i].y_px,
                                              (json_int_t)row->keys[i].sample));
    return json_pack("{s:I, s:o}", "count", (json_int_t)row->invalid_count, "keys", keys);
}

json_t *status_report(const struct store_job *row)
{
    const struct store_report *r = &row->report;
    return json_pack(
        "{s:o, s:o, s:{s:I, s:f, s:I}, s:f, s:f, s:{s:o, s:o}, s:o, s:{s:I, s:I}, s:o}", "error",
        error_json(row), "pixels", pixels_json(r), "spp", "least", (json_int_t)r->spp_least, "mean",
        r->spp_mean, "most", (json_int_t)r->spp_most, "stopped", r->stopped, "mean_luminance",
        r->energy, "removed", "max_bounces", share_json(r->cut, r->energy), "clamp",
        share_json(r->clamped, r->energy), "invalid_samples", status_report_invalid(row),
        "triangles_dropped", "degenerate", (json_int_t)r->dropped.degenerate, "not_finite",
        (json_int_t)r->dropped.nonfinite, "work", work_json(&r->work));
}

char *status_report_text(const struct store_job *row)
{
    json_t *root = status_report(row);
    char *text = json_dumps(root, JSON_COMPACT);
    json_decref(root);
    return text;
}
