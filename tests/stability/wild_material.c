/* SPDX-License-Identifier: MIT */
#include "tests/stability/wild.h"

#include <stdio.h>
#include <string.h>

/* --- textures: t0 a checker, t1 and t2 images, t3 the colours of vertices --- */

void wild_textures(struct wild_pen *p)
{
    static const char *const wraps[] = {"repeat", "clamp", "mirror"};
    static const char *const filters[] = {"trilinear", "bilinear", "nearest"};
    wild_say(p,
             "\"textures\": {\n"
             "\"t0\": {\"type\": \"checker\", \"colors\": [%.4g, [%.4g, %.4g, 1]], \"uv_scale\": "
             "[%.4g, %.4g]},\n",
             wild_range(p, 0, 1), wild_range(p, 0, 1), wild_range(p, 0, 1), wild_range(p, -20, -.1),
             wild_range(p, .1, 20));
    for (int i = 1; i < 3; i++)
        wild_say(p,
                 "\"t%d\": {\"type\": \"image\", \"file\": \"texture%d.exr\", \"wrap\": \"%s\", "
                 "\"filter\": \"%s\", \"uv_scale\": %.4g, \"uv_offset\": [%.4g, %.4g]},\n",
                 i, i, wraps[wild_below(p, 3)], filters[wild_below(p, 3)], wild_range(p, .1, 30),
                 wild_range(p, -9, 9), wild_range(p, -9, 9));
    wild_say(p, "\"t3\": {\"type\": \"vertex_color\"}\n},\n");
}

static bool from_texture(struct wild_pen *p)
{
    if (!p->textured || !wild_chance(p, .3))
        return false;
    wild_say(p, "{\"texture\": \"t%u\"}", wild_below(p, 4));
    return true;
}

/* --- values --- */

/* The ends of [lo, hi] as often as all between them; more of what is near lo if it is `wide`. */
static double value(struct wild_pen *p, double lo, double hi)
{
    const uint32_t kind = wild_below(p, 8);
    if (kind == 0)
        return lo;
    if (kind == 1)
        return hi;
    if (kind == 2)
        return lo + (hi - lo) * pow(10, wild_range(p, -4, 0));
    return wild_range(p, lo, hi);
}

static void number(struct wild_pen *p, const char *key, double lo, double hi)
{
    wild_say(p, ", \"%s\": ", key);
    if (!from_texture(p))
        wild_say(p, "%.9g", value(p, lo, hi));
}

static void color(struct wild_pen *p, const char *key, double most)
{
    wild_say(p, ", \"%s\": ", key);
    if (from_texture(p))
        return;
    if (wild_chance(p, .4))
        wild_say(p, "%.9g", value(p, 0, most));
    else
        wild_say(p, "[%.9g, %.9g, %.9g]", value(p, 0, most), value(p, 0, most), value(p, 0, most));
}

/* --- materials --- */

static void dielectric(struct wild_pen *p, struct wild_material *m)
{
    wild_say(p, "\"dielectric\"");
    m->clear = m->lets_through = true;
    wild_say(p, ", \"ior\": %.9g", value(p, 1, 3));
    if (wild_chance(p, .5))
        wild_say(p, ", \"alpha\": %.9g", value(p, 0, 1));
    if (wild_chance(p, .3))
        wild_say(p, ", \"absorption\": [0, %.9g, %.9g]", value(p, 0, 5) / p->unit,
                 value(p, 0, 5) / p->unit);
    if (wild_chance(p, .3))
        wild_say(p, ", \"priority\": %u", 1 + wild_below(p, 4));
}

static void conductor(struct wild_pen *p)
{
    wild_say(p, "\"conductor\"");
    if (!(p->traits & WILD_PLAIN) && wild_chance(p, .3))
        wild_say(p, ", \"metal\": \"%s\"", wild_chance(p, .5) ? "gold" : "aluminium");
    else
        wild_say(p, ", \"eta\": [%.6g, %.6g, %.6g], \"k\": %.6g", wild_range(p, .05, 4),
                 wild_range(p, .05, 4), wild_range(p, .05, 4), value(p, 0, 9));
    if (p->traits & WILD_PLAIN || wild_chance(p, .5)) {
        wild_say(p, ", \"alpha\": %.9g", value(p, 0, 1));
        return;
    }
    wild_say(p, ", \"alpha\": [%.9g, %.9g], \"rotation_deg\": %.6g, \"multiscatter\": %s",
             value(p, 0, 1), value(p, 0, 1), wild_range(p, -360, 360),
             wild_chance(p, .5) ? "true" : "false");
    if (wild_chance(p, .4))
        wild_say(p, ", \"thin_film\": {\"thickness_nm\": %.6g, \"ior\": %.6g}", value(p, 0, 2000),
                 wild_range(p, 1.01, 4));
}

static void principled(struct wild_pen *p, struct wild_material *m)
{
    wild_say(p, "\"principled\"");
    color(p, "base_color", 1);
    number(p, "metallic", 0, 1);
    number(p, "roughness", 0, 1);
    wild_say(p, ", \"ior\": %.9g", value(p, 1.1, 3));
    if (wild_chance(p, .4)) {
        m->clear = m->lets_through = true;
        wild_say(p, ", \"transmission\": %.9g", value(p, .01, 1));
    }
    if (wild_chance(p, .5)) {
        number(p, "clearcoat", 0, 1);
        number(p, "clearcoat_roughness", 0, 1);
    }
    if (wild_chance(p, .5)) {
        color(p, "sheen_color", 1);
        number(p, "sheen_roughness", .1, 1);
    }
}

static const struct wild_material *part(struct wild_pen *p, const char *key, uint32_t i)
{
    wild_say(p, ", \"%s\": \"m%u\"", key, i);
    return &p->material[i];
}

/* Of one or two that are there already. A clear part is not passed by all light. */
static void wrapped(struct wild_pen *p, struct wild_material *m, uint32_t kind)
{
    const uint32_t i = wild_below(p, p->materials), k = wild_below(p, p->materials);
    const struct wild_material *one, *two;
    if (kind == 2 && !p->material[i].lets_through && !p->material[k].lets_through) {
        wild_say(p, "\"two_sided\"");
        one = part(p, "front", i);
        two = part(p, "back", k);
    } else if (kind == 1) {
        wild_say(p, "\"mask\"");
        one = two = part(p, "material", i);
        number(p, "opacity", 0, 1);
        m->masked = true;
    } else {
        wild_say(p, "\"mix\"");
        one = part(p, "first", i);
        two = part(p, "second", k);
        number(p, "amount", 0, 1);
    }
    m->masked = m->masked || one->masked || two->masked;
    m->clear = one->clear || two->clear;
    m->lets_through = m->masked || one->lets_through || two->lets_through;
    if (m->clear)
        p->traits |= WILD_OPEN;
}

static void leaf(struct wild_pen *p, struct wild_material *m)
{
    const double r = value(p, 0, 1);
    wild_say(p, "\"leaf\"");
    color(p, "reflectance", r);
    color(p, "transmittance", 1 - r);
    m->lets_through = true;
}

static void pane(struct wild_pen *p, struct wild_material *m)
{
    wild_say(p, "\"thin_dielectric\"");
    number(p, "ior", 1, 3);
    m->lets_through = true;
}

/* A type and two or three parameters. */
static void simple(struct wild_pen *p, const char *type, const char *tint, const char *first,
                   const char *second)
{
    wild_say(p, "\"%s\"", type);
    color(p, tint, 1);
    if (first)
        number(p, first, !strcmp(type, "cloth") ? .1 : 0, 1);
    if (second)
        number(p, second, 1.1, 3);
}

enum { NAIVE_KINDS = 6, KINDS = 12, WRAPS = 3 };

/* Those that the naive tracer knows come first. */
static void material(struct wild_pen *p, struct wild_material *m)
{
    const uint32_t wraps = p->materials > 1 ? WRAPS : 0;
    const uint32_t kinds = p->traits & WILD_PLAIN ? NAIVE_KINDS : KINDS;
    const uint32_t kind = wild_below(p, kinds + wraps);
    if (kind >= kinds) {
        wrapped(p, m, kind - kinds);
        return;
    }
    switch (kind) {
    case 0:
        simple(p, "diffuse", "albedo", NULL, NULL);
        break;
    case 1:
        simple(p, "mirror", "reflectance", NULL, NULL);
        break;
    case 2:
        dielectric(p, m);
        break;
    case 3:
        conductor(p);
        break;
    case 4:
        leaf(p, m);
        break;
    case 5:
        pane(p, m);
        break;
    case NAIVE_KINDS:
        simple(p, "rough_diffuse", "albedo", "roughness", NULL);
        break;
    case 7:
        simple(p, "retroreflector", "reflectance", "alpha", NULL);
        break;
    case 8:
        simple(p, "cloth", "albedo", "roughness", NULL);
        break;
    case 9:
        simple(p, "plastic", "albedo", "alpha", "ior");
        break;
    default:
        principled(p, m);
    }
}

/* m0 is always a matte one: walls and lamps are made of it. */
void wild_materials(struct wild_pen *p)
{
    const uint32_t count = 4 + wild_below(p, 6);
    wild_say(p, "\"materials\": {\n\"m0\": {\"type\": \"diffuse\", \"albedo\": [%.4g, %.4g, 0.5]}",
             value(p, 0, 1), wild_range(p, .2, .8));
    p->materials = 1;
    while (p->materials < count) {
        struct wild_material m = {0};
        wild_say(p, ",\n\"m%u\": {\"type\": ", p->materials);
        material(p, &m);
        wild_say(p, "}");
        p->material[p->materials++] = m;
    }
    wild_say(p, "\n},\n");
}
