/* F-12: rays that leave a surface do not meet it again, shadow rays meet nothing but occluders, and
 * those however near. Coordinates of 1e-8 to 1e8. SPDX-License-Identifier: MIT */
#include "common/trace/surface.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "common/trace/bvh.h"
#include "common/trace/round.h"
#include "tests/catalog.h"
#include "tests/soup.h"
#include "tests/stat/stat.h"
#include "tests/tap.h"

enum { SCENES = 1000, RAYS = 300 / STAT_SLOW };

/* A direction on the side of ng that `side` says, at 1e-3 to pi/2 rad from the surface. */
static vec3 leaving(struct dice *d, vec3 ng, float side)
{
    const vec3 flat = vec3_unit(vec3_cross(ng, soup_direction(d)));
    const double angle = pow(10, dice_range(d, -3, log10(1.5)));
    return flat * (float)cos(angle) + ng * (side * (float)sin(angle));
}

/* Without the primitives it starts and ends on: where it starts must do without. */
static struct ray untold(struct ray ray)
{
    ray.from = ray.to = 0;
    return ray;
}

static vec3 any_point(struct dice *d, const struct stage_triangle *t)
{
    const float u = dice_float(d), v = dice_float(d) * (1 - u);
    return vec3_load(t->v[0]) * (1 - u - v) + vec3_load(t->v[1]) * u + vec3_load(t->v[2]) * v;
}

/* A point as the path finds it: by a ray from about one size away, or sampled. */
static bool find_point(struct dice *d, const struct stage *s, vec3 aim, float size,
                       struct surface *out)
{
    const vec3 from = aim + soup_direction(d) * (size * dice_float(d));
    const struct ray ray = {from, (aim - from) * (0.5f + dice_float(d)), INFINITY, 0, 0};
    struct ray_hit hit;
    if (!bvh_hit_closest(s, &ray, &hit))
        return false;
    *out = surface_at(s, &ray, &hit);
    return true;
}

struct tally {
    int rays, met, empty;
};

static void leave_both_sides(struct dice *d, const struct stage *s, const struct surface *p,
                             struct tally *n)
{
    for (float side = -1; side <= 1; side += 2) {
        const struct ray ray = untold(surface_leave(p, leaving(d, p->ng, side)));
        struct ray_hit hit;
        n->rays++;
        n->met += bvh_hit_any(s, &ray) || bvh_hit_closest(s, &ray, &hit);
    }
}

static void test_leave_triangles(void)
{
    struct tally n = {0};
    for (uint64_t seed = 0; seed < SCENES; seed++) {
        struct dice d = dice_make(seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        scenes_triangle(&s, scenes_diffuse(&s, rgb_gray(0.5f)), soup_magnitudes(&d, -8, 8),
                        soup_magnitudes(&d, -8, 8), soup_magnitudes(&d, -8, 8));
        const struct stage *stage = scenes_stage(&s);
        n.empty += !stage->prim_count;
        if (!stage->prim_count) {
            scenes_release(&s);
            continue;
        }
        const struct stage_id id = catalog_id(stage, 0);
        const struct stage_triangle t = catalog_triangle(stage, 0);
        for (int i = 0; i < RAYS; i++) {
            struct surface p;
            const float u = dice_float(&d), v = dice_float(&d) * (1 - u);
            const float size = vec3_length(vec3_load(t.v[0]) - vec3_load(t.v[1]));
            if (!(i & 1) || !find_point(&d, stage, any_point(&d, &t), size, &p))
                p = surface_on_triangle(stage, id, u, v);
            leave_both_sides(&d, stage, &p, &n);
        }
        scenes_release(&s);
    }
    ok(n.met == 0 && n.empty == 0, "F-12: rays that leave a triangle do not meet it: %d of %d do", n.met,
       n.rays);
}

static void test_leave_discs(void)
{
    struct tally n = {0};
    for (uint64_t seed = 0; seed < SCENES; seed++) {
        struct dice d = dice_make(seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        const vec3 center = soup_magnitudes(&d, -8, 8), normal = soup_direction(&d);
        const float radius = fabsf(soup_magnitudes(&d, -8, 8)[0]);
        scenes_disc(&s, scenes_diffuse(&s, rgb_gray(0.5f)), center, normal, radius);
        const struct stage *stage = scenes_stage(&s);
        for (int i = 0; i < RAYS; i++) {
            const vec3 flat = vec3_unit(vec3_cross(normal, soup_direction(&d)));
            const vec3 at = center + flat * (radius * dice_float(&d));
            struct surface p;
            if (!(i & 1) || !find_point(&d, stage, at, radius, &p))
                p = surface_on_disc(stage, catalog_id(stage, 0), at);
            leave_both_sides(&d, stage, &p, &n);
        }
        scenes_release(&s);
    }
    ok(n.met == 0, "F-12: rays that leave a disc do not meet it: %d of %d do", n.met, n.rays);
}

/* Inwards the sphere is met at the other end of a chord of 2 r cos, which starting inside by the
 * error e lengthens by less than 4 sqrt(e r). What is left of a sphere whose radius is few units of
 * its centre's last place is not judged. */
static void test_leave_spheres(void)
{
    struct tally out = {0}, in = {0};
    for (uint64_t seed = 0; seed < SCENES; seed++) {
        struct dice d = dice_make(seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        const vec3 center = seed % 2 ? soup_magnitudes(&d, -8, 8) : vec3_make(0, 0, 0);
        const float radius = fabsf(soup_magnitudes(&d, -8, 8)[0]);
        scenes_sphere(&s, scenes_diffuse(&s, rgb_gray(0.5f)), center, radius);
        const struct stage *stage = scenes_stage(&s);
        for (int i = 0; i < RAYS; i++) {
            const vec3 way = soup_direction(&d);
            struct surface p;
            if (!(i & 1) || !find_point(&d, stage, center + radius * way, radius, &p))
                p = surface_on_sphere(stage, catalog_id(stage, 0), way);
            struct ray ray = untold(surface_leave(&p, leaving(&d, p.ng, 1)));
            struct ray_hit hit;
            out.rays++;
            out.met += bvh_hit_any(stage, &ray);
            const float error = vec3_length(p.p_error);
            if (error > 1e-6f * radius)
                continue;
            ray = untold(surface_leave(&p, leaving(&d, p.ng, -1)));
            const float chord = -2 * radius * vec3_dot(ray.dir, p.ng);
            in.rays++;
            in.met += !bvh_hit_closest(stage, &ray, &hit) || hit.t < 0.99f * chord ||
                      hit.t > 1.01f * chord + 4 * sqrtf(error * radius);
        }
        scenes_release(&s);
    }
    ok(out.met == 0, "F-12: rays that leave a sphere do not meet it: %d of %d do", out.met, out.rays);
    ok(in.met == 0 && in.rays > 1000, "F-12: rays into a sphere meet its far side: %d of %d do not",
       in.met, in.rays);
}

static vec3 cylinder_axis_of(const struct stage *s)
{
    return vec3_load(((const struct stage_cylinder *)stage_at(s, s->cylinders))->axis);
}

/* At any height and on any side of the only cylinder. */
static struct surface cylinder_point(struct dice *d, const struct stage *s, vec3 axis)
{
    const float along = dice_float(d);
    return surface_on_cylinder(s, catalog_id(s, 0), along, vec3_cross(axis, soup_direction(d)));
}

/* Inwards a cylinder is met at the other end of a chord, which starting inside by the error e
 * lengthens by less than 4 sqrt(e r) across the axis, or not at all where the chord leaves through
 * an end. Too near an end to tell, it is not judged. */
static void go_through(const struct stage *s, const struct surface *p, const struct ray *ray,
                       struct tally *n)
{
    const struct stage_cylinder *c = stage_at(s, s->cylinders);
    const vec3 axis = vec3_load(c->axis);
    const float height = vec3_length(axis), r = c->radius, error = vec3_length(p->p_error);
    const float rise = vec3_dot(ray->dir, axis / height);
    const vec3 across = ray->dir - rise * (axis / height);
    const float chord = -2 * r * vec3_dot(across, p->ng) / vec3_dot(across, across);
    const float least = 0.99f * chord,
                most = 1.01f * chord + 4 * sqrtf(error * r) / vec3_length(across);
    const float begin = vec3_dot(p->p - vec3_load(c->from), axis / height);
    const float low = fminf(begin + least * rise, begin + most * rise);
    const float high = fmaxf(begin + least * rise, begin + most * rise);
    struct ray_hit hit;
    const bool met = bvh_hit_closest(s, ray, &hit), missed = high < 0 || low > height;
    if (!missed && !(low > error && high < height - error))
        return;
    n->rays++;
    n->empty += missed;
    n->met += missed ? met : !met || hit.t < least || hit.t > most;
}

static void test_leave_cylinders(void)
{
    struct tally out = {0}, in = {0};
    for (uint64_t seed = 0; seed < SCENES; seed++) {
        struct dice d = dice_make(seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        const vec3 from = seed % 2 ? soup_magnitudes(&d, -8, 8) : vec3_make(0, 0, 0);
        const float radius = fabsf(soup_magnitudes(&d, -8, 8)[0]);
        scenes_cylinder(&s, scenes_diffuse(&s, rgb_gray(0.5f)), from,
                        from + soup_magnitudes(&d, -8, 8), radius);
        const struct stage *stage = scenes_stage(&s);
        const vec3 axis = cylinder_axis_of(stage);
        for (int i = 0; i < RAYS; i++) {
            struct surface p = cylinder_point(&d, stage, axis);
            if (i & 1)
                find_point(&d, stage, p.p, radius, &p);
            struct ray ray = untold(surface_leave(&p, leaving(&d, p.ng, 1)));
            out.rays++;
            out.met += bvh_hit_any(stage, &ray);
            if (vec3_length(p.p_error) > 1e-6f * radius)
                continue;
            ray = untold(surface_leave(&p, leaving(&d, p.ng, -1)));
            go_through(stage, &p, &ray, &in);
        }
        scenes_release(&s);
    }
    ok(out.met == 0, "F-12: rays that leave a cylinder do not meet it: %d of %d do", out.met, out.rays);
    ok(in.met == 0 && in.empty > 20000 / STAT_SLOW && in.rays - in.empty > 20000 / STAT_SLOW,
       "rays into a cylinder meet its far side, or go out by an end (%d): %d of %d do not",
       in.empty, in.met, in.rays);
}

/* A random light of any shape, of the size given, at a place. */
static void add_light(struct dice *d, struct scenes *s, uint32_t kind, vec3 at, float size)
{
    const vec3 a = soup_direction(d) * size, b = soup_direction(d) * size;
    if (kind == 0)
        scenes_triangle(s, 0, at, at + a, at + b);
    else if (kind == 1)
        scenes_disc(s, 0, at, a, size);
    else if (kind == 2)
        scenes_sphere(s, 0, at, size);
    else if (kind == 3)
        scenes_cylinder(s, 0, at, at + a, size * (dice_bits(d) & 1 ? 1 : 0.01f));
    else
        scenes_quad(s, 0, at, a, b);
}

static struct surface point_on(struct dice *d, const struct stage *s, uint32_t prim, vec3 seen_from)
{
    const struct stage_id id = catalog_id(s, prim);
    const float u = dice_float(d), v = dice_float(d) * (1 - u);
    if (id.place.kind == STAGE_TRIANGLE)
        return surface_on_triangle(s, id, u, v);
    if (id.place.kind == STAGE_DISC) {
        const struct stage_disc *disc =
            (const struct stage_disc *)stage_at(s, s->discs) + id.place.index;
        const vec3 n = vec3_load(disc->normal);
        const vec3 flat = vec3_unit(vec3_cross(n, soup_direction(d)));
        return surface_on_disc(s, id, vec3_load(disc->center) + flat * (disc->radius * u));
    }
    if (id.place.kind == STAGE_CYLINDER) {
        const struct stage_cylinder *cylinder =
            (const struct stage_cylinder *)stage_at(s, s->cylinders) + id.place.index;
        const vec3 axis = vec3_load(cylinder->axis);
        const vec3 out = vec3_cross(axis, soup_direction(d));
        const vec3 to_viewer = seen_from - vec3_load(cylinder->from) - axis * u;
        return surface_on_cylinder(s, id, u, vec3_dot(out, to_viewer) < 0 ? -out : out);
    }
    const struct stage_sphere *sphere =
        (const struct stage_sphere *)stage_at(s, s->spheres) + id.place.index;
    const vec3 to_viewer = seen_from - vec3_load(sphere->center);
    const vec3 way = soup_direction(d);
    return surface_on_sphere(s, id, vec3_dot(way, to_viewer) < 0 ? -way : way);
}

/* Two shapes of size 10^[-8, 8], 4 to 4e4 sizes from each other and up to as far from the origin.
 */
static void test_two_shapes(void)
{
    static const char *const names[] = {"triangle", "disc", "sphere", "cylinder", "quad"};
    for (uint32_t kind = 0; kind < 5; kind++) {
        struct tally n = {0};
        int edge_on = 0;
        for (uint64_t seed = 0; seed < SCENES; seed++) {
            struct dice d = dice_make(1000 * kind + seed);
            struct scenes s;
            scenes_init(&s, 1, 1);
            scenes_diffuse(&s, rgb_gray(0.5f));
            const float size = (float)pow(10, dice_range(&d, -8, 8));
            const vec3 away =
                soup_direction(&d) * (4 * size * (float)pow(10, dice_range(&d, 0, 4)));
            /* Half of the lights lie about the origin, where their own errors are smallest. */
            vec3 at = soup_point(&d, (double)size * pow(10, dice_range(&d, -1, 4)));
            at = seed & 1 ? soup_point(&d, (double)size) - away : at;
            add_light(&d, &s, kind, at, size);
            const uint32_t other = s.scene.shape_count + (kind == 4);
            add_light(&d, &s, dice_bits(&d) % 5, at + away, size);
            const struct stage *stage = scenes_stage(&s);
            for (int i = 0; i < RAYS; i++) {
                const struct surface from =
                    point_on(&d, stage, dice_bits(&d) % other, vec3_make(0, 0, 0));
                const struct surface to = point_on(&d, stage, other, from.p);
                const vec3 way = vec3_unit(to.p - from.p);
                const float rise = fabsf(vec3_dot(way, from.ng)),
                            fall = fabsf(vec3_dot(way, to.ng));
                /* A sphere or cylinder shadows what lies behind its own side. */
                const uint32_t other_kind = catalog_id(stage, other).place.kind;
                const bool behind = (kind == 2 || kind == 3) && vec3_dot(way, from.ng) < 1e-3f;
                const bool beyond = other_kind != STAGE_TRIANGLE && other_kind != STAGE_DISC &&
                                    vec3_dot(way, to.ng) > -1e-3f;
                if (rise < 1e-3f || fall < 1e-3f || behind || beyond) {
                    edge_on++;
                    continue;
                }
                const struct ray ray = untold(surface_to_surface(&from, &to));
                n.rays++;
                n.met += bvh_hit_any(stage, &ray);
            }
            scenes_release(&s);
        }
        ok(n.met == 0 && n.rays > 10 * edge_on / 16,
           "%s and light: %d of %d shadow rays are shadowed", names[kind], n.met, n.rays);
    }
}

/* From a floor of two triangles to a ceiling of two, at angles down to 1e-3 rad. */
static void test_floors(void)
{
    struct tally n = {0};
    for (uint64_t seed = 0; seed < SCENES; seed++) {
        struct dice d = dice_make(seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        const uint32_t m = scenes_diffuse(&s, rgb_gray(0.5f));
        const float size = (float)pow(10, dice_range(&d, -8, 8));
        const vec3 at = soup_point(&d, (double)size * 10), x = soup_direction(&d) * size;
        const vec3 y = vec3_unit(vec3_cross(x, soup_direction(&d))) * size;
        const vec3 up =
            vec3_unit(vec3_cross(x, y)) * (size * (float)pow(10, dice_range(&d, -3, 0)));
        scenes_quad(&s, m, at, x, y);
        scenes_quad(&s, m, at + up, y, x);
        const struct stage *stage = scenes_stage(&s);
        for (int i = 0; i < RAYS; i++) {
            const struct surface from = point_on(&d, stage, dice_bits(&d) % 2, at);
            const struct surface to = point_on(&d, stage, 2 + dice_bits(&d) % 2, at);
            const struct ray there = untold(surface_to_surface(&from, &to));
            const struct ray back = untold(surface_to_surface(&to, &from));
            const struct ray point =
                untold(surface_to_point(&from, from.p + up * 0.5f + (to.p - from.p) * 0.4f));
            n.rays += 3;
            n.met +=
                bvh_hit_any(stage, &there) + bvh_hit_any(stage, &back) + bvh_hit_any(stage, &point);
        }
        scenes_release(&s);
    }
    ok(n.met == 0, "F-12: between floor and ceiling nothing is shadowed: %d of %d rays are", n.met,
       n.rays);
}

/* A sheet 1e-4 of the floor's size above it; lights over both. The other way, no light leaks. */
static void test_near_occluder(void)
{
    int lit = 0, lit_from_point = 0, rays = 0, tiny = 0;
    for (uint64_t seed = 0; seed < SCENES; seed++) {
        struct dice d = dice_make(seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        const uint32_t m = scenes_diffuse(&s, rgb_gray(0.5f));
        const float size = (float)pow(10, dice_range(&d, -7, 7));
        const vec3 at = soup_point(&d, (double)size), x = soup_direction(&d) * size;
        const vec3 y = vec3_unit(vec3_cross(x, soup_direction(&d))) * size;
        const vec3 up = vec3_unit(vec3_cross(x, y)) * size;
        scenes_quad(&s, m, at, x, y);
        scenes_quad(&s, m, at - x * 50 - y * 50 + up * 1e-4f, x * 100, y * 100);
        const uint32_t light = 4;
        scenes_quad(&s, m, at + up, y, x);
        const struct stage *stage = scenes_stage(&s);
        for (int i = 0; i < RAYS; i++, rays++) {
            const struct surface from = point_on(&d, stage, dice_bits(&d) % 2, at);
            const struct surface to = point_on(&d, stage, light + dice_bits(&d) % 2, at);
            const struct ray ray = untold(surface_to_surface(&from, &to));
            const struct ray point = untold(surface_to_point(&from, to.p));
            lit += !bvh_hit_any(stage, &ray);
            lit_from_point += !bvh_hit_any(stage, &point);
            struct ray_hit hit;
            const struct ray away = untold(surface_leave(&from, leaving(&d, from.ng, 1)));
            tiny += !bvh_hit_closest(stage, &away, &hit) || hit.prim < 2 || hit.prim > 3;
        }
        scenes_release(&s);
    }
    ok(lit == 0 && lit_from_point == 0,
       "F-12: a sheet 1e-4 of the size above the floor shadows it: %d and %d of %d rays leak", lit,
       lit_from_point, rays);
    ok(tiny == 0, "and is what rays from the floor meet (%d of %d do not)", tiny, rays);
}

/* From the primitive to p, in double; *scale: how far off an error of ng would put it. */
static double height_over(const struct stage *s, uint32_t kind, const struct surface *p,
                          double *scale)
{
    const struct stage_sphere *sphere = stage_at(s, s->spheres);
    const struct stage_disc *disc = stage_at(s, s->discs);
    const struct stage_triangle t = kind ? (struct stage_triangle){{{0}}} : catalog_triangle(s, 0);
    const struct stage_cylinder *c = stage_at(s, s->cylinders);
    const float *anchor[] = {t.v[0], disc->center, sphere->center, c->from};
    double f[3], a[3], ff = 0, fn = 0, cc = 0, aa = 0;
    for (int k = 0; k < 3; k++) {
        f[k] = (double)p->p[k] - (double)anchor[kind][k];
        a[k] = kind == 3 ? (double)c->axis[k] : 0;
        ff += f[k] * f[k], aa += a[k] * a[k], fn += f[k] * (double)p->ng[k];
    }
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        cc += (f[i] * a[j] - f[j] * a[i]) * (f[i] * a[j] - f[j] * a[i]);
    }
    *scale = kind < 2 ? sqrt(ff) : 0;
    return kind == 2   ? sqrt(ff) - (double)sphere->radius
           : kind == 3 ? sqrt(cc / aa) - (double)c->radius
                       : fn;
}

/* The stated bound holds: the point lies within p_error of the primitive, in double. */
static void test_error_bounds(void)
{
    int off = 0, points = 0;
    for (uint64_t seed = 0; seed < SCENES; seed++) {
        struct dice d = dice_make(seed);
        struct scenes s;
        scenes_init(&s, 1, 1);
        scenes_diffuse(&s, rgb_gray(0.5f));
        add_light(&d, &s, (uint32_t)seed % 4, soup_magnitudes(&d, -2, 2), 1);
        const struct stage *stage = scenes_stage(&s);
        for (int i = 0; i < RAYS; i++, points++) {
            const struct surface p = point_on(&d, stage, 0, vec3_make(0, 0, 0));
            double bound = 0, scale;
            for (int k = 0; k < 3; k++)
                bound += fabs((double)p.ng[k]) * (double)p.p_error[k];
            const double height = height_over(stage, (uint32_t)seed % 4, &p, &scale);
            /* ng itself is rounded: another unit along the distance from the anchor. */
            off += !(fabs(height) <= bound + 0x1p-23 * scale);
        }
        scenes_release(&s);
    }
    ok(off == 0, "points lie within their error bound of the primitive (%d of %d do not)", off,
       points);
}

static uint32_t bits_of(float x)
{
    uint32_t b;
    memcpy(&b, &x, sizeof b);
    return b;
}

static void test_round_along(void)
{
    const float p[] = {0,       -0.0f,    1,        -1,        0x1p-149f, -0x1p-149f,
                       FLT_MAX, -FLT_MAX, INFINITY, -INFINITY, 0.1f,      -3e7f};
    const float ways[] = {0, -0.0f, 1e-30f, -1e-30f, 2, -2, NAN};
    int other = 0;
    for (size_t i = 0; i < countof(p); i++)
        for (size_t j = 0; j < countof(ways); j++) {
            const float x = p[i], way = ways[j];
            const float want = way > 0 ? round_up(x) : way < 0 ? round_down(x) : x;
            const vec3 got = round_along(vec3_make(x, 5, x), vec3_make(way, 0, way));
            other +=
                bits_of(got[0]) != bits_of(want) || got[1] != 5 || bits_of(got[2]) != bits_of(want);
        }
    ok(other == 0, "round_along is round_up and round_down: %d differ", other);
}

int main(void)
{
    test_leave_triangles();
    test_leave_discs();
    test_leave_spheres();
    test_leave_cylinders();
    test_two_shapes();
    test_floors();
    test_near_occluder();
    test_error_bounds();
    test_round_along();
    return tap_done();
}
