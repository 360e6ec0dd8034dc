/* stat/scatter.h: a right BSDF passes at the stated rate; each planted fault is found by the
 * procedure that is there for it.
 * SPDX-License-Identifier: MIT */
#include "tests/stat/scatter.h"

#include <math.h>

#include "tests/stat/ks.h"
#include "tests/stat/means.h"
#include "tests/tap.h"

/* A real material, and what is wrong with it. */
struct faulty {
    struct material m;
    float pdf_times, weight_times; /* of what pdf_w and sample say; eval and density stay */
    float odd;                     /* share by which f is larger where light turns upwards */
    bool flat;                     /* sampled evenly, not by the cosine */
    bool blind;                    /* never samples, and has no pdf, where x > 0 */
    bool no_g1;                    /* the pdf forgets that only visible facets are sampled */
    bool lost_beyond;              /* total reflection is absorbed */
    bool no_scale;                 /* refraction does not change radiance */
    float tilt;                    /* so much of what goes to x < 0 goes to x > 0 instead */
    bool nan;                      /* one direction in some thousand is no number */
};

static const struct material white = {.kind = MATERIAL_DIFFUSE, .diffuse = {{1, 1, 1, 0}}};

static rgb faulty_eval(const void *what, vec3 wo, vec3 wi)
{
    const struct faulty *f = what;
    return bsdf_eval(&f->m, wo, wi) * (fabsf(wi[2]) > fabsf(wo[2]) ? 1 + f->odd : 1);
}

static float faulty_pdf_w(const void *what, vec3 wo, vec3 wi)
{
    const struct faulty *f = what;
    if (f->blind && wi[0] > 0)
        return 0;
    const float g1 = 2 * wo[2] / (wo[2] + sqrtf(.04f + .96f * wo[2] * wo[2])); /* alpha = .2 */
    return bsdf_pdf_w(&f->m, wo, wi) * f->pdf_times / (f->no_g1 ? g1 : 1);
}

static bool faulty_sample(const void *what, vec3 wo, float lobe, struct square q,
                          struct bsdf_sample *s)
{
    const struct faulty *f = what;
    if (!bsdf_sample(&f->m, wo, lobe, q, s))
        return false;
    if (f->flat) {
        const float r = sqrtf(q.u * (2 - q.u)), phi = 6.2831853f * q.v;
        s->wi = vec3_make(r * cosf(phi), r * sinf(phi), (wo[2] < 0 ? -1 : 1) * (1 - q.u));
    }
    const float other = q.v * 4096 - floorf(q.v * 4096); /* digits of no weight, as a number */
    if (s->wi[0] < 0 && other < f->tilt)
        s->wi = vec3_make(-s->wi[0], s->wi[1], s->wi[2]);
    s->pdf_w = faulty_pdf_w(what, wo, s->wi);
    s->weight *= f->weight_times;
    if (f->no_scale)
        s->weight *= 1 / s->scale;
    if (f->nan && q.u < 1e-3f)
        s->weight *= NAN;
    return !(f->blind && s->wi[0] > 0) &&
           !(f->lost_beyond && wo[2] < 0 && s->wi[2] < 0 && wo[2] > -0.7f);
}

static struct faulty faultless(struct material m)
{
    return (struct faulty){.m = m, .pdf_times = 1, .weight_times = 1};
}

static struct scatter scatter_faulty(const struct faulty *f)
{
    struct scatter s = scatter_of(&f->m);
    s.eval = faulty_eval;
    s.pdf_w = faulty_pdf_w;
    s.sample = faulty_sample;
    s.what = f;
    return s;
}

static struct material silver(float alpha)
{
    return (struct material){.kind = MATERIAL_CONDUCTOR,
                             .conductor = {rgb_gray(1), rgb_gray(1e5f), alpha}};
}

static vec3 direction(double z)
{
    return vec3_make((float)sqrt(1 - z * z), 0, (float)z);
}

static const uint32_t samples = 100000 / STAT_SLOW;

/* --- a right one --- */

static void truth_passes(void)
{
    double p[1000];
    const uint32_t seeds = STAT_SLOW > 1 ? 20 : stat_tries(24, 1000);
    const struct faulty right = faultless(silver(.2f));
    const struct scatter s = scatter_faulty(&right);
    uint32_t rejected = 0;
    for (uint32_t i = 0; i < seeds; i++) {
        p[i] = scatter_follows(&s, direction(.8), 20000, i).chi2.p;
        rejected += p[i] < 0.01;
    }
    const double limit = 0.01 * seeds + 3 * sqrt(0.01 * 0.99 * seeds);
    ok(rejected <= limit, "of %u seeds 1 %% are rejected: %u, at most %.1f", seeds, rejected,
       limit);
    const struct ks ks = ks_test(p, seeds);
    ok(ks.p > 0.01, "their p values are uniform (p %.3f; detects a distance of %.2f)", ks.p,
       ks_detects(seeds, 0.01));
    const struct scatter_draw d = scatter_draw(&s, direction(.8), samples, 1);
    ok(d.off < 1e-4 && d.beyond == 0 && d.invalid == 0 && d.most < 1.000003,
       "weights are eval / pdf and at most 1");
    const struct scatter_reciprocal r = scatter_reciprocal(&s, samples, 1);
    ok(r.worst < 1 && r.invalid == 0 && r.alive > samples / 2, "light goes back (%.2f)", r.worst);
    const struct means m = means_from_truth(&d.albedo[0], scatter_albedo(&s, direction(.8), 0));
    ok(means_p(&m) > 0.01, "sampled albedo is the integral (detects %.4f)",
       means_detects(&m, 0.01));
}

/* --- wrong ones --- */

/* Half of all directions have 1 + tilt times their due, half 1 - tilt: a root mean square of tilt.
 */
static void smallest_bias_is_found(void)
{
    const uint32_t seeds = STAT_SLOW > 1 ? 20 : stat_tries(40, 1000);
    struct faulty f = faultless(white);
    const struct scatter s = scatter_faulty(&f);
    const struct chi2 chi2 = scatter_follows(&s, direction(.8), 20000, 0).chi2;
    f.tilt = (float)chi2_detects(&chi2, 20000, 0.01);
    uint32_t rejected = 0;
    for (uint32_t i = 0; i < seeds; i++)
        rejected += scatter_follows(&s, direction(.8), 20000, i).chi2.p < 0.01;
    const double least = STAT_POWER * seeds - 3 * sqrt(0.01 * 0.99 * seeds);
    ok(rejected >= least, "a density off by %.3f rms is found in 99 %% of %u seeds: %u",
       (double)f.tilt, seeds, rejected);
}

static void densities(void)
{
    struct faulty f = faultless(white);
    const struct scatter s = scatter_faulty(&f);
    f.flat = true;
    ok(scatter_follows(&s, direction(.8), samples, 1).chi2.p < 1e-6, "found: cosine not sampled");
    f = faultless(white);
    f.pdf_times = 1.01f;
    near(scatter_follows(&s, direction(.8), samples, 1).mass_off, 0.01, 1e-4,
         "found: pdf times 1.01, by its mass");
    ok(scatter_draw(&s, direction(.8), samples, 1).off > 0.009, "and by the weights");
    f = faultless(white);
    f.blind = true;
    const struct sphere_chi2_result half = scatter_follows(&s, direction(.8), samples, 1);
    ok(half.chi2.p > 0.01 && fabs(half.mass_off) < fmax(1e-3, 4 * half.mass_sd),
       "half a sphere out of reach and turned away: density and mass are right");
    ok(scatter_draw(&s, direction(.8), samples, 1).beyond > samples / 5,
       "but found: eval has what pdf has not");
}

static void facets(void)
{
    struct faulty f = faultless(silver(.2f));
    const struct scatter s = scatter_faulty(&f);
    f.no_g1 = true;
    const struct sphere_chi2_result r = scatter_follows(&s, direction(.3), samples, 1);
    ok(r.mass_off > 4 * r.mass_sd + 1e-3, "found: visible facets' pdf without G1, by its mass");
}

static void weights(void)
{
    struct faulty f = faultless(white);
    const struct scatter s = scatter_faulty(&f);
    f.weight_times = 1.001f;
    const struct scatter_draw more = scatter_draw(&s, direction(.8), samples, 1);
    near(more.off, 0.001, 1e-5, "found: weight times 1.001");
    ok(more.most > 1.0009, "and that it makes light");
    f.weight_times = 1;
    f.nan = true;
    ok(scatter_draw(&s, direction(.8), samples, 1).invalid > 0,
       "found: weights that are no numbers");
}

static void reciprocity(void)
{
    struct faulty f = faultless(white);
    const struct scatter s = scatter_faulty(&f);
    f.odd = 2e-5f;
    ok(scatter_reciprocal(&s, samples, 1).worst > 1, "found: f one way larger by 2e-5");
    f.odd = 4e-6f;
    ok(scatter_reciprocal(&s, samples, 1).worst < 1, "passed: larger by 4e-6");
}

static void choices(void)
{
    struct faulty f =
        faultless((struct material){.kind = MATERIAL_DIELECTRIC, .dielectric = {.ior = 1.5f}});
    const struct scatter s = scatter_faulty(&f);
    struct scatter_choice c[2];
    ok(scatter_choices(&s, direction(.8), c) == 2 && c[0].chance + c[1].chance == 1,
       "glass reflects or refracts");
    ok(scatter_choices(&s, direction(-.5), c) == 1 && c[0].chance == 1,
       "and from inside may reflect all");
    f.lost_beyond = true;
    ok(scatter_choices(&s, direction(-.5), c) == 0, "found: total reflection absorbed");
    f.lost_beyond = false;
    f.no_scale = true;
    ok(scatter_choices(&s, direction(.8), c) == 2 && c[1].sample.weight[0] > .9f,
       "found: radiance unchanged by refraction");
}

int main(void)
{
    truth_passes();
    smallest_bias_is_found();
    densities();
    facets();
    weights();
    reciprocity();
    choices();
    return tap_done();
}
