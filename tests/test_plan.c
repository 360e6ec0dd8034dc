/* Plans from facts: what is ruled out and why, what is chosen, what is printed.
 * SPDX-License-Identifier: MIT */
#include "common/plan.h"

#include <jansson.h>
#include <math.h>
#include <string.h>

#include "tests/tap.h"

/* Matte walls, a lamp of so many sr, a target of 1 %, 10^5 pixels. */
static struct plan facts(double solid_angle)
{
    struct plan p;
    const struct scene_settings s = {.max_bounces = 64,
                                     .target = {.error = .01, .spp = SCENE_MAX_SPP}};
    plan_init(&p, &s, 100000);
    p.features.lobes[PLAN_MATTE] = 3;
    p.features.emitters[PLAN_SURFACE] = 2;
    p.features.solid_angle = solid_angle;
    p.light.found[PLAN_LDE] = .6;
    p.light.found[PLAN_LDDE] = .4;
    p.light.beyond_direct = p.light.beyond_whitted = .4;
    p.light.direct_paths = p.light.whitted_paths = 900;
    return p;
}

static void pilot(struct plan *p, enum plan_candidate_kind k, double variance, double work)
{
    p->candidates[k].tried = true;
    p->candidates[k].pilot = (struct plan_pilot){
        .pixels = 256, .spp = 16, .variance = variance, .slope = -1, .work = work, .tail = .1};
}

static enum plan_verdict verdict(const struct plan *p, enum plan_candidate_kind k)
{
    return p->candidates[k].verdict;
}

static void rules(void)
{
    struct plan p = facts(.01);
    plan_consider(&p, true);
    ok(verdict(&p, PLAN_DIRECT) == PLAN_INSUFFICIENT, "direct: %s", p.candidates[PLAN_DIRECT].why);
    ok(verdict(&p, PLAN_WHITTED) == PLAN_INSUFFICIENT, "whitted: %s",
       p.candidates[PLAN_WHITTED].why);
    ok(verdict(&p, PLAN_PATH_BSDF) == PLAN_RULED_OUT, "bsdf: %s", p.candidates[PLAN_PATH_BSDF].why);
    ok(plan_wants(&p, PLAN_PATH_LIGHT) && plan_wants(&p, PLAN_PATH_MIS),
       "a small light: light and mis are tried");
    ok(verdict(&p, PLAN_METROPOLIS) == PLAN_ABSENT && !plan_wants(&p, PLAN_PHOTON_MAP),
       "what is not there yet is not tried");
    p = facts(1);
    plan_consider(&p, true);
    ok(plan_wants(&p, PLAN_PATH_BSDF) && !plan_wants(&p, PLAN_PATH_LIGHT),
       "a wide light: bsdf and mis are tried");
    p = facts(1);
    p.features.lobes[PLAN_NARROW] = 1;
    p.features.solid_angle = .01;
    plan_consider(&p, true);
    ok(!plan_wants(&p, PLAN_PATH_LIGHT), "narrow lobes: not light");
    p = facts(0);
    p.features.emitters[PLAN_SURFACE] = 0;
    p.features.emitters[PLAN_POINT] = 1;
    plan_consider(&p, true);
    ok(p.pilot_pixels == 0 && verdict(&p, PLAN_PATH_BSDF) == PLAN_RULED_OUT, "points alone: %s",
       p.why_no_pilot);
    p = facts(1);
    p.max_bounces = 1;
    plan_consider(&p, true);
    ok(verdict(&p, PLAN_DIRECT) == PLAN_RULED_OUT && p.pilot_pixels == 0, "one bounce: %s",
       p.candidates[PLAN_DIRECT].why);
}

static void what_may_be_missing(void)
{
    struct plan p = facts(1);
    p.light.beyond_direct = p.light.beyond_whitted = 0;
    p.light.direct_paths = p.light.whitted_paths = 0;
    plan_consider(&p, true);
    ok(plan_wants(&p, PLAN_DIRECT) && plan_wants(&p, PLAN_WHITTED),
       "nothing is left out: both are tried");
    p.light.beyond_direct = 1e-6;
    plan_consider(&p, true);
    ok(verdict(&p, PLAN_DIRECT) == PLAN_INSUFFICIENT && plan_wants(&p, PLAN_WHITTED),
       "a little is too much: %s", p.candidates[PLAN_DIRECT].why);
    p.light.beyond_direct = 0;
    p.light.direct_paths = 1;
    plan_consider(&p, true);
    ok(verdict(&p, PLAN_DIRECT) == PLAN_INSUFFICIENT && plan_wants(&p, PLAN_WHITTED),
       "a path that goes on may find some: %s", p.candidates[PLAN_DIRECT].why);
}

static void pilots_are_small(void)
{
    struct plan p = facts(1);
    plan_consider(&p, true);
    const double samples = 10.0 * plan_places(&p) + 2.0 * p.pilot_pixels * 16;
    ok(p.pilot_pixels >= PLAN_LEAST_PIXELS && p.pilot_pixels % 4 == 0 &&
           samples <= PLAN_SAMPLES * (double)p.pixels && samples > .1 * (double)p.pixels,
       "%u places and two pilots of %u pixels: %.2f samples of each pixel", plan_places(&p),
       p.pilot_pixels, samples / (double)p.pixels);
    plan_consider(&p, false);
    ok(p.pilot_pixels == 0, "none: %s", p.why_no_pilot);
    p.pixels = 5000;
    plan_consider(&p, true);
    ok(p.pilot_pixels == 0, "none: %s", p.why_no_pilot);
    plan_choose(&p);
    p.outlook.work = 500;
    plan_forecast(&p, 1000, 1.5);
    ok(p.chosen == PLAN_PATH_MIS && p.forecast == 1000.0 * 500 * 5000,
       "then it is path, mis; samples x units x pixels are its work");
    ok(p.forecast_low == p.forecast / 1.5 && p.forecast_high == p.forecast * 1.5, "more or less");
    p.pixels = (uint64_t)1 << 28;
    plan_consider(&p, true);
    ok(p.pilot_pixels <= 4096 && plan_places(&p) <= 1024 && plan_light_paths(&p) <= 65536,
       "large images need no larger ones");
}

static struct plan two(double bsdf, double tail)
{
    struct plan p = facts(1);
    plan_consider(&p, true);
    pilot(&p, PLAN_PATH_BSDF, bsdf, 500);
    pilot(&p, PLAN_PATH_MIS, 1, 500);
    p.candidates[PLAN_PATH_BSDF].pilot.tail = tail;
    plan_choose(&p);
    return p;
}

static void choices(void)
{
    struct plan p = two(1.04, .1);
    ok(p.chosen == PLAN_PATH_BSDF && verdict(&p, PLAN_PATH_MIS) == PLAN_DEARER,
       "the simpler one of two alike");
    p = two(1.06, .1);
    ok(p.chosen == PLAN_PATH_MIS, "not if it costs more: %s", p.candidates[PLAN_PATH_BSDF].why);
    p = two(.5, .6);
    ok(p.chosen == PLAN_PATH_MIS && verdict(&p, PLAN_PATH_BSDF) == PLAN_TAILED,
       "nor if its variance may not exist: %s", p.candidates[PLAN_PATH_BSDF].why);
    p = two(.5, .6);
    p.candidates[PLAN_PATH_MIS].pilot.tail = .6;
    p.candidates[PLAN_PATH_MIS].verdict = p.candidates[PLAN_PATH_BSDF].verdict = PLAN_DEARER;
    plan_choose(&p);
    ok(p.chosen == PLAN_PATH_BSDF, "a tail that both have says nothing against either");
    p = two(3, .1);
    p.candidates[PLAN_PATH_MIS].pilot.tail = .9;
    p.candidates[PLAN_PATH_MIS].verdict = p.candidates[PLAN_PATH_BSDF].verdict = PLAN_DEARER;
    plan_choose(&p);
    ok(p.chosen == PLAN_PATH_MIS, "a heavy tail does not make the usual method dearer: %s",
       p.candidates[PLAN_PATH_MIS].why);
}

static void printed(void)
{
    struct plan p = two(1.06, .1);
    p.light.missed[PLAN_LSDE] = .25;
    plan_consider(&p, true);
    pilot(&p, PLAN_PATH_MIS, 1, 500);
    p.candidates[PLAN_PATH_MIS].pilot.variance = (double)INFINITY;
    plan_choose(&p);
    struct buf text = {0};
    plan_print(&p, &text);
    json_error_t e;
    json_t *root = json_loadb((const char *)text.data, text.size, JSON_REJECT_DUPLICATES, &e);
    ok(root != NULL && text.size < PLAN_MAX_BYTES, "JSON of %zu bytes %s", text.size,
       root ? "" : e.text);
    const char *integrator = "", *strategy = "", *sampler = "";
    double missing = 0;
    int sufficient = 1;
    ok(json_unpack(root, "{s:{s:s, s:s, s:s}, s:{s:f}, s:b}", "method", "integrator", &integrator,
                   "strategy", &strategy, "sampler", &sampler, "missing", "LS+DE", &missing,
                   "sufficient", &sufficient) == 0 &&
           !strcmp(integrator, "path") && !strcmp(strategy, "mis") && !strcmp(sampler, "sobol"),
       "says the method");
    ok(missing == .25 && !sufficient, "and what is missing: a quarter, by LS+DE");
    ok(p.candidates[PLAN_BIDIRECTIONAL].lacks == 0 &&
           strstr(p.candidates[PLAN_BIDIRECTIONAL].why, "25 %"),
       "bidirectional %s", p.candidates[PLAN_BIDIRECTIONAL].why);
    json_decref(root);
    buf_release(&text);
}

int main(void)
{
    rules();
    what_may_be_missing();
    pilots_are_small();
    choices();
    printed();
    return tap_done();
}
