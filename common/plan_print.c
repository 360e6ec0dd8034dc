/* A plan in JSON: docs/plan.md. SPDX-License-Identifier: MIT */
#include "common/plan.h"

#include <assert.h>
#include <stdarg.h>
#include <stdio.h>

#include "common/base.h"

PRINTF(2, 3)
static void say(struct buf *out, const char *fmt, ...)
{
    char text[512];
    va_list args;
    va_start(args, fmt);
    const int n = vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    assert(n >= 0 && (size_t)n < sizeof text);
    buf_append(out, text, (size_t)n);
}

/* JSON has no infinity. */
static void say_number(struct buf *out, const char *name, double v)
{
    if (v - v == 0)
        say(out, ", \"%s\": %.6g", name, v);
    else
        say(out, ", \"%s\": null", name);
}

static const char *bool_text(bool b)
{
    return b ? "true" : "false";
}

static void say_counts(struct buf *out, const char *name, const char *const names[],
                       const uint32_t counts[], int count)
{
    say(out, ", \"%s\": {", name);
    for (int i = 0; i < count; i++)
        say(out, "%s\"%s\": %u", i ? ", " : "", names[i], counts[i]);
    say(out, "}");
}

static void print_features(const struct plan_features *f, struct buf *out)
{
    static const char *const lobes[] = {[PLAN_DELTA] = "smooth",
                                        [PLAN_NARROW] = "narrow",
                                        [PLAN_GLOSSY] = "glossy",
                                        [PLAN_ROUGH] = "rough",
                                        [PLAN_MATTE] = "matte"};
    static const char *const emitters[] = {
        [PLAN_SURFACE] = "surface", [PLAN_POINT] = "point", [PLAN_SPOT] = "spot",
        [PLAN_DISTANT] = "distant", [PLAN_SUN] = "sun",     [PLAN_MAP] = "environment"};
    say(out, "\"features\": {\"sky\": %s", bool_text(f->sky));
    say_counts(out, "lobes", lobes, f->lobes, PLAN_LOBES);
    say_counts(out, "emitters", emitters, f->emitters, PLAN_EMITTERS);
    say_number(out, "map_peak", f->map_peak);
    say_number(out, "map_top", f->map_top);
    say_number(out, "hit", f->hit);
    say_number(out, "solid_angle", f->solid_angle);
    say_number(out, "open", f->open);
    say_number(out, "albedo", f->albedo);
    say_number(out, "behind_smooth", f->behind);
    say(out,
        ", \"models\": {\"textures\": %s, \"masks\": %s, \"media\": %s, \"light_tree\": %s, "
        "\"shading_normals\": %s}}",
        bool_text(f->textures), bool_text(f->masks), bool_text(f->media), bool_text(f->light_tree),
        bool_text(f->detail));
}

static void print_light(const struct plan_light *l, struct buf *out)
{
    say(out, "\"light\": {\"eye_paths\": %llu, \"light_paths\": %llu, \"classes\": {",
        (unsigned long long)l->eye_paths, (unsigned long long)l->light_paths);
    for (int c = 0; c < PLAN_CLASSES; c++)
        say(out, "%s\"%s\": {\"found\": %.6g, \"missed\": %.6g}", c ? ", " : "",
            plan_class_name((enum plan_class)c), l->found[c], l->missed[c]);
    say(out, "}}");
}

static void print_pilot(const char *name, const struct plan_pilot *p, struct buf *out)
{
    say(out, ", \"%s\": {\"pixels\": %u, \"spp\": %u", name, p->pixels, p->spp);
    say_number(out, "variance", p->variance);
    say_number(out, "spread", p->spread);
    say_number(out, "slope", p->slope);
    say_number(out, "units_per_sample", p->work);
    say_number(out, "tail", p->tail);
    say_number(out, "thin", p->thin);
    say_number(out, "price", plan_price(p));
    say(out, "}");
}

static void print_candidate(const struct plan *p, enum plan_candidate_kind k, struct buf *out)
{
    static const char *const verdicts[] = {
        [PLAN_CHOSEN] = "chosen",       [PLAN_DEARER] = "dearer",
        [PLAN_TAILED] = "heavy tail",   [PLAN_INSUFFICIENT] = "insufficient",
        [PLAN_RULED_OUT] = "ruled out", [PLAN_ABSENT] = "absent"};
    const struct plan_candidate *c = &p->candidates[k];
    say(out, "{\"method\": \"%s\", \"verdict\": \"%s\", \"why\": \"%s\"", plan_candidate_name(k),
        verdicts[c->verdict], c->why);
    say_number(out, "lacks", c->lacks);
    if (c->tried)
        print_pilot("pilot", &c->pilot, out);
    say(out, "}");
}

/* Light that the chosen method cannot find, by class. */
static void print_missing(const struct plan *p, struct buf *out)
{
    bool any = false;
    say(out, "\"missing\": {");
    for (int c = 0; c < PLAN_CLASSES; c++) {
        if (!(p->light.missed[c] > 0))
            continue;
        say(out, "%s\"%s\": %.6g", any ? ", " : "", plan_class_name((enum plan_class)c),
            p->light.missed[c]);
        any = true;
    }
    say(out, "}, \"sufficient\": %s", bool_text(p->candidates[p->chosen].lacks <= p->error / 2));
}

static void print_method(const struct plan *p, struct buf *out)
{
    static const char *const samplers[] = {[SAMPLER_SOBOL] = "sobol",
                                           [SAMPLER_INDEPENDENT] = "independent",
                                           [SAMPLER_STRATIFIED] = "stratified"};
    const struct plan_names n = plan_names(p->chosen);
    say(out, "\"method\": {\"integrator\": \"%s\", \"strategy\": \"%s\", \"sampler\": \"%s\"}",
        n.integrator, n.strategy, samplers[p->sampler]);
}

void plan_print(const struct plan *p, struct buf *out)
{
    say(out, "{\"version\": %d, ", PLAN_VERSION);
    print_method(p, out);
    say(out, ", \"why\": \"%s\", ", p->candidates[p->chosen].why);
    print_missing(p, out);
    say_number(out, "error", p->error);
    say(out, ", \"error_asked\": %s", bool_text(p->is_asked));
    say(out, ", \"forecast\": {\"spp\": %.6g", p->forecast_spp);
    say_number(out, "units", p->forecast);
    say_number(out, "low", p->forecast_low);
    say_number(out, "high", p->forecast_high);
    print_pilot("outlook", &p->outlook, out);
    say(out, "}, \"studied_units\": %.6g, \"pilot_pixels\": %u, \"candidates\": [", p->studied,
        p->pilot_pixels);
    for (int k = 0; k < PLAN_CANDIDATES; k++) {
        say(out, "%s", k ? ", " : "");
        print_candidate(p, (enum plan_candidate_kind)k, out);
    }
    say(out, "], ");
    print_light(&p->light, out);
    say(out, ", ");
    print_features(&p->features, out);
    say(out, "}");
}
