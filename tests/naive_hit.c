/* SPDX-License-Identifier: MIT */
#include "tests/naive_hit.h"

#include <math.h>

#include "tests/catalog.h"

static const double margin = 1e-5, least_sine = 1e-2;

struct vec {
    double x, y, z;
};

struct line { /* a ray in double, unit direction: t in metres */
    struct vec o, d;
    double t_max;
};

struct candidate { /* what one primitive says */
    double t, reach;
    bool hit, doubtful;
};

static struct vec load(const float v[3])
{
    return (struct vec){(double)v[0], (double)v[1], (double)v[2]};
}

static struct vec sub(struct vec a, struct vec b)
{
    return (struct vec){a.x - b.x, a.y - b.y, a.z - b.z};
}

static double dot(struct vec a, struct vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static struct vec cross(struct vec a, struct vec b)
{
    return (struct vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static double length(struct vec a)
{
    return sqrt(dot(a, a));
}

static double extent(struct vec a)
{
    return fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
}

/* t of a surface met at a given sine, when the line runs inside its outline by `inside` metres. */
static struct candidate judge(const struct line *l, double t, double inside, double sine,
                              double reach)
{
    const double tol = margin * reach, t_tol = tol / fmax(sine, least_sine);
    const bool may = inside > -tol && t > -t_tol && t < l->t_max + t_tol;
    const bool must = inside > tol && t > t_tol && t < l->t_max - t_tol && sine > least_sine;
    return (struct candidate){t, reach, inside >= 0 && t > 0 && t < l->t_max, may && !must};
}

static struct candidate triangle_hit(const struct line *l, const struct stage_triangle *t)
{
    const struct vec a = load(t->v[0]), b = load(t->v[1]), c = load(t->v[2]);
    const struct vec e1 = sub(b, a), e2 = sub(c, a), e3 = sub(c, b), s = sub(l->o, a);
    const struct vec p = cross(l->d, e2), q = cross(s, e1);
    const double det = dot(e1, p);
    const double far = fmax(extent(s), fmax(extent(sub(l->o, b)), extent(sub(l->o, c))));
    const double u = dot(s, p) / det, v = dot(l->d, q) / det, w = 1 - u - v;
    /* Weight times det is the moment of the line about the opposite edge. */
    const double d1 = u * fabs(det) / length(cross(l->d, e2));
    const double d2 = v * fabs(det) / length(cross(l->d, e1));
    const double d0 = w * fabs(det) / length(cross(l->d, e3));
    const double sine = fabs(det) / length(cross(e1, e2));
    if (!(isfinite(d0) && isfinite(d1) && isfinite(d2))) /* along an edge, or in the plane */
        return (struct candidate){0, 0, false, true};
    return judge(l, dot(e2, q) / det, fmin(d0, fmin(d1, d2)), sine, far);
}

/* Of two places along the line the one that is met first. */
static struct candidate nearer(struct candidate first, struct candidate second)
{
    first.doubtful |= second.doubtful && !first.hit;
    first.t = first.hit || first.doubtful ? first.t : second.t;
    first.hit |= second.hit;
    return first;
}

static struct candidate sphere_hit(const struct line *l, const struct stage_sphere *s)
{
    const struct vec f = sub(l->o, load(s->center));
    const double r = (double)s->radius, far = extent(f) + r;
    const double b = dot(f, l->d), gap = length(cross(f, l->d));
    const double h = r * r - gap * gap, root = sqrt(h > 0 ? h : 0), sine = root / r;
    return nearer(judge(l, -b - root, r - gap, sine, far), judge(l, -b + root, r - gap, sine, far));
}

/* In coordinates x, y across the axis and z along it, in which the side is x^2 + y^2 = r^2. */
static struct candidate cylinder_hit(const struct line *l, const struct stage_cylinder *c)
{
    const struct vec a = load(c->axis), f = sub(l->o, load(c->from));
    const double r = (double)c->radius, h = length(a), far = extent(f) + h + r;
    const struct vec z = {a.x / h, a.y / h, a.z / h};
    const struct vec off = fabs(z.x) < 0.5 ? (struct vec){1, 0, 0} : (struct vec){0, 1, 0};
    struct vec x = cross(z, off);
    const double s = length(x);
    x = (struct vec){x.x / s, x.y / s, x.z / s};
    const struct vec y = cross(z, x);
    const double fx = dot(f, x), fy = dot(f, y), dx = dot(l->d, x), dy = dot(l->d, y);
    const double across = hypot(dx, dy), gap = fabs(fx * dy - fy * dx) / across;
    if (!isfinite(gap) || across < 1e-9) /* along the axis: on the side or beside it */
        return (struct candidate){0, 0, false, fabs(hypot(fx, fy) - r) < margin * far};
    const double chord = sqrt(fmax(r * r - gap * gap, 0)), middle = -(fx * dx + fy * dy) / across;
    const double sine = across * chord / r;
    struct candidate at[2];
    for (int i = 0; i < 2; i++) {
        const double t = (middle + (i ? chord : -chord)) / across;
        const double height = dot(f, z) + t * dot(l->d, z);
        at[i] = judge(l, t, fmin(r - gap, fmin(height, h - height) * sine), sine, far);
    }
    return nearer(at[0], at[1]);
}

static struct candidate disc_hit(const struct line *l, const struct stage_disc *s)
{
    const struct vec n = load(s->normal), f = sub(load(s->center), l->o);
    const double cosine = dot(n, l->d) / length(n), t = dot(n, f) / dot(n, l->d);
    const struct vec p = {t * l->d.x - f.x, t * l->d.y - f.y, t * l->d.z - f.z};
    if (!isfinite(t))
        return (struct candidate){0, 0, false, true};
    const double r = (double)s->radius;
    return judge(l, t, (r - length(p)) * fabs(cosine), fabs(cosine), extent(f) + r);
}

static struct candidate prim_hit(const struct stage *s, struct stage_id id, const struct line *l)
{
    const uint32_t index = id.place.index;
    switch ((enum stage_kind)id.place.kind) {
    case STAGE_TRIANGLE: {
        const struct stage_triangle t = stage_triangle_at(s, index, id.instance);
        return triangle_hit(l, &t);
    }
    case STAGE_SPHERE:
        return sphere_hit(l, (const struct stage_sphere *)stage_at(s, s->spheres) + index);
    case STAGE_DISC:
        return disc_hit(l, (const struct stage_disc *)stage_at(s, s->discs) + index);
    case STAGE_CYLINDER:
        return cylinder_hit(l, (const struct stage_cylinder *)stage_at(s, s->cylinders) + index);
    }
    return (struct candidate){0, 0, false, true};
}

struct naive_hit naive_hit_closest(const struct stage *s, const struct ray *r)
{
    struct line l = {{(double)r->origin[0], (double)r->origin[1], (double)r->origin[2]},
                     {(double)r->dir[0], (double)r->dir[1], (double)r->dir[2]},
                     0};
    const double scale = length(l.d);
    l.d = (struct vec){l.d.x / scale, l.d.y / scale, l.d.z / scale};
    l.t_max = (double)r->t_max * scale;
    struct stage_id id;
    struct naive_hit best = {.t = HUGE_VAL, .prim = STAGE_NONE};
    double doubt = HUGE_VAL; /* from here on */
    for (uint64_t at = 0; catalog_next(s, &at, &id);) {
        const struct candidate c = prim_hit(s, id, &l);
        if (c.hit && (c.t < best.t || (c.t == best.t && id.prim < best.prim)))
            best = (struct naive_hit){c.t, c.reach, id.prim, true, false};
        if (c.doubtful && c.t < doubt)
            doubt = c.t;
    }
    best.doubtful = doubt <= best.t + margin * fabs(best.t) && (best.hit || doubt < HUGE_VAL);
    best.t /= scale;
    best.t_reach /= scale;
    return best;
}
