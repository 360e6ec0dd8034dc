/* Analytic truths of lights that are no shapes (docs/accuracy.md; the numbers A-xx are those of its
 * table): suns and spots. The frame is 8 x 8 pixels, the gate that of judge.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>

#include "tests/judge.h"
#include "tests/scenes.h"
#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

/* E on a small white receiver at the origin: L = E / pi after one bounce. */
static void receiver(struct scenes *s, vec3 normal)
{
    scenes_init(s, 8, 8);
    const vec3 n = vec3_unit(normal);
    scenes_look(s, n * 0.01f, vec3_make(0, 0, 0), 1e-3);
    s->scene.settings.max_bounces = 1;
    scenes_disc(s, scenes_diffuse(s, rgb_gray(1)), vec3_make(0, 0, 0), n, 1e-3f);
}

/* Straight down. Above the horizon E = pi L sin^2 a cos t; a quarter sphere's disc whose middle
 * lies on the horizon is half of the hemisphere's projection. */
static void sun_disc(double diameter_deg, vec3 normal, bool by_irradiance)
{
    struct scenes s;
    char name[64];
    receiver(&s, normal);
    struct light *sun = scenes_light(&s, LIGHT_SUN);
    const double a = diameter_deg * pi / 360, projected = pi * sin(a) * sin(a);
    const vec3 n = vec3_unit(normal);
    const double cosine = (double)n[1], sine = sqrt(1 - cosine * cosine);
    sun->sun.direction[1] = -1;
    sun->sun.radius_rad = (float)a;
    if (by_irradiance)
        sun->sun.irradiance = rgb_gray((float)projected);
    else
        sun->sun.radiance = rgb_gray(1);
    double e = projected * cosine;
    if (cosine < sin(a)) { /* A-05's form for a sphere that the horizon cuts, s = sin a */
        const double x = 1 / tan(a), y = -x * cosine / sine, q = sine * sqrt(1 - y * y);
        e = (cosine * acos(y) - x * q) * sin(a) * sin(a) + atan(q / x);
    }
    snprintf(name, sizeof name, "A-06: sun of %g degrees at %.0f degrees", diameter_deg,
             acos(cosine) * 180 / pi);
    judge_scene(&s, 512, e / pi, name);
}

/* One metre above, aimed at the point `beside` of the receiver. */
static void spot(double outer_deg, float inner_part, float beside, const char *what)
{
    struct scenes s;
    char name[64];
    receiver(&s, vec3_make(0, 1, 0));
    struct light *l = scenes_light(&s, LIGHT_SPOT);
    l->spot.intensity = rgb_gray((float)pi);
    l->spot.position[1] = 1;
    vec3_store(l->spot.direction, vec3_unit(vec3_make(beside, -1, 0)));
    const double outer = outer_deg * pi / 180, inner = fmin(outer, outer * (double)inner_part);
    l->spot.outer_rad = (float)outer;
    l->spot.inner_rad = (float)inner;
    const double c = 1 / sqrt(1 + (double)beside * (double)beside);
    const double part = (c - cos(outer)) / (cos(inner) - cos(outer));
    snprintf(name, sizeof name, "A-06: spot of %g degrees, %s", outer_deg, what);
    judge_scene(&s, 8, c >= cos(inner) ? 1 : part * part * (3 - 2 * part), name);
}

/* In an integrating sphere what is not lit directly has L = P a / (4 pi^2 R^2 (1 - a)) a,
 * P the power, whatever shines: it says the power of a spot. */
static void spot_in_sphere(double inner_deg, double outer_deg)
{
    struct scenes s;
    char name[64];
    scenes_init(&s, 8, 8);
    scenes_look(&s, vec3_make(0, .1f, 0), vec3_make(0, 1, .1f), pi / 6);
    s.scene.settings.max_bounces = 1000;
    scenes_sphere(&s, scenes_diffuse(&s, rgb_gray(.5f)), vec3_make(0, 0, 0), 1);
    struct light *l = scenes_light(&s, LIGHT_SPOT);
    l->spot.intensity = rgb_gray(1);
    vec3_store(l->spot.position, vec3_make(.3f, -.2f, .1f));
    l->spot.direction[1] = -1;
    l->spot.inner_rad = (float)(inner_deg * pi / 180);
    l->spot.outer_rad = (float)(outer_deg * pi / 180);
    const double power = pi * (2 - cos(inner_deg * pi / 180) - cos(outer_deg * pi / 180));
    snprintf(name, sizeof name, "A-09: power of a spot from %g to %g degrees", inner_deg,
             outer_deg);
    judge_scene(&s, 16384, power * .5 * .5 / (4 * pi * pi * (1 - .5)), name);
}

int main(void)
{
    sun_disc(20, vec3_make(.6f, .8f, 0), false);
    sun_disc(.53, vec3_make(.6f, .8f, 0), true);
    sun_disc(60, vec3_make(1, .1f, 0), false);
    spot(60, .5f, 0, "on its axis");
    spot(60, .25f, .8f, "in its falloff");
    spot(60, 0, 1.2f, "far out in its falloff");
    spot(10, 10, .17f, "near a hard edge");
    spot_in_sphere(20, 85);
    return tap_done();
}
