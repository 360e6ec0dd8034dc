/* SPDX-License-Identifier: MIT */
#include "tests/stability/wild.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "common/image_asset.h"
#include "common/mesh.h"

/* --- the pen --- */

void wild_say(struct wild_pen *p, const char *fmt, ...)
{
    char text[1024];
    va_list args;
    va_start(args, fmt);
    const int n = vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    buf_append(&p->out, text, (size_t)n);
}

double wild_range(struct wild_pen *p, double from, double to)
{
    return dice_range(&p->d, from, to);
}

bool wild_chance(struct wild_pen *p, double chance)
{
    return dice_unit(&p->d) < chance;
}

uint32_t wild_below(struct wild_pen *p, uint32_t n)
{
    return (uint32_t)(dice_unit(&p->d) * n);
}

void wild_point(struct wild_pen *p, const double v[3])
{
    double w[3];
    for (int k = 0; k < 3; k++)
        w[k] = p->unit * (v[k] + p->at[k]);
    wild_say(p, "[%.9g, %.9g, %.9g]", w[0], w[1], w[2]);
}

void wild_direction(struct wild_pen *p)
{
    static const char *const even[] = {"[0, -1, 0]", "[1, 0, 0]", "[0, 0, -3]", "[1, -1, 0]"};
    const double z = wild_range(p, -1, 1), r = sqrt(1 - z * z), phi = wild_range(p, 0, 6.2832);
    if (wild_chance(p, .25))
        wild_say(p, "%s", even[wild_below(p, countof(even))]);
    else
        wild_say(p, "[%.9g, %.9g, %.9g]", r * cos(phi), z, r * sin(phi));
}

/* --- film, camera, settings --- */

static void film(struct wild_pen *p)
{
    static const char *const filters[] = {
        "{\"type\": \"box\"}",
        "{\"type\": \"box\", \"radius\": 3}",
        "{\"type\": \"tent\"}",
        "{\"type\": \"gaussian\", \"sigma\": 0.7}",
        "{\"type\": \"blackman_harris\"}",
        "{\"type\": \"mitchell\"}",
    };
    const uint32_t kind = p->traits & WILD_PLAIN ? 0 : wild_below(p, countof(filters));
    p->traits |= kind == 5 ? WILD_SIGNED : 0;
    wild_say(p, "\"film\": {\"width\": 8, \"height\": 8, \"filter\": %s},\n", filters[kind]);
}

/* Whether a point may be in a clear body. */
static bool is_in_body(const struct wild_pen *p, const double at[3], double reach)
{
    for (uint32_t i = 0; i < p->bodies; i++) {
        double square = 0;
        for (int k = 0; k < 3; k++)
            square += (at[k] - p->body[i][k]) * (at[k] - p->body[i][k]);
        if (sqrt(square) <= 1.01 * p->body[i][3] + reach)
            return true;
    }
    return false;
}

static void camera(struct wild_pen *p)
{
    static const char *const kinds[] = {"perspective", "thin_lens", "orthographic", "panoramic"};
    const uint32_t kind = p->traits & WILD_PLAIN ? 0 : wild_below(p, countof(kinds));
    double from[3], to[3];
    for (int k = 0; k < 3; k++) {
        from[k] = wild_range(p, .5, .9) * (wild_chance(p, .5) ? 1 : -1);
        to[k] = wild_range(p, -.3, .3);
    }
    if (is_in_body(p, from, kind == 1 ? .05 : kind == 2 ? 1.5 : 0))
        p->traits |= WILD_OPEN;
    wild_say(p, "\"camera\": {\"type\": \"%s\", \"look_at\": {\"from\": ", kinds[kind]);
    wild_point(p, from);
    wild_say(p, ", \"to\": ");
    wild_point(p, to);
    wild_say(p, ", \"up\": [%.6g, 1, %.6g]}", wild_range(p, -.2, .2), wild_range(p, -.2, .2));
    if (kind < 2)
        wild_say(p, ", \"fov_deg\": %.6g", wild_range(p, 20, 120));
    if (kind == 1)
        wild_say(p, ", \"aperture_radius\": %.9g, \"focus_distance\": %.9g%s",
                 p->unit * wild_range(p, 0, .05), p->unit * wild_range(p, .2, 2),
                 wild_chance(p, .5) ? ", \"blades\": 5, \"blade_angle_deg\": 33" : "");
    if (kind == 2)
        wild_say(p, ", \"width\": %.9g", p->unit * wild_range(p, .5, 2));
    wild_say(p, "},\n");
}

static void settings(struct wild_pen *p)
{
    static const uint32_t bounces[] = {1, 2, 3, 5, 8, 8, 16, 16, 32, 32, 64, 64};
    const uint32_t most = wild_chance(p, .02) ? 0 : bounces[wild_below(p, countof(bounces))];
    wild_say(p, "\"settings\": {\"seed\": %u, \"max_bounces\": %u, \"target\": {\"spp\": 64}}\n",
             wild_below(p, 1000), most);
}

/* --- the document --- */

static void begin(struct wild_pen *p, uint64_t seed)
{
    *p = (struct wild_pen){.d = dice_make(seed), .unit = 1, .gain = 1};
    p->traits = wild_chance(p, .25) ? WILD_PLAIN : 0;
    p->extreme = wild_chance(p, .25);
    p->textured = !(p->traits & WILD_PLAIN) && wild_chance(p, .35);
    if (wild_chance(p, .4))
        p->unit = pow(10, wild_range(p, -6, 6));
    if (wild_chance(p, .3))
        p->gain = pow(10, wild_range(p, -12, 12));
    if (wild_chance(p, .2))
        for (int k = 0; k < 3; k++)
            p->at[k] = wild_range(p, -1, 1) * (wild_chance(p, .5) ? 10 : 1000);
}

static void document(struct wild_pen *p, uint64_t seed)
{
    begin(p, seed);
    wild_say(p, "{\n\"smalti\": 1, \"title\": \"wild %llu\",\n", (unsigned long long)seed);
    if (p->textured)
        wild_textures(p);
    wild_materials(p);
    wild_shapes(p);
    wild_lights(p);
    film(p);
    camera(p);
    settings(p);
    wild_say(p, "}\n");
    buf_append(&p->out, "", 1);
}

/* --- its files --- */

/* What files of meshes do not carry today: normals, uv and colours of a ball. */
static void give_detail(struct mesh *m, struct arena *arena)
{
    float *normals = arena_new(arena, float, 3 * (size_t)m->vertex_count);
    float *uvs = arena_new(arena, float, 2 * (size_t)m->vertex_count);
    float *colors = arena_new(arena, float, 3 * (size_t)m->vertex_count);
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        const vec3 n = vec3_unit(vec3_load(m->vertices + 3 * i));
        vec3_store(normals + 3 * i, n);
        uvs[2 * i] = 3 * n[0];
        uvs[2 * i + 1] = 2 * n[1];
        vec3_store(colors + 3 * i, .5f + .5f * n);
    }
    m->normals = normals;
    m->uvs = uvs;
    m->colors = colors;
}

static bool load(struct wild *w, struct err *err)
{
    struct scene *s = &w->scene;
    bool fine = true;
    for (uint32_t i = 0; fine && i < s->mesh_count; i++) {
        struct buf file = {0};
        if (s->meshes[i].format == MESH_INLINE)
            continue;
        wild_file(s->meshes[i].file, &file);
        fine = mesh_read(&s->meshes[i], file.data, file.size, &w->arena, err);
        buf_release(&file);
        if (fine && strstr(s->meshes[i].file, "smooth"))
            give_detail(&s->meshes[i], &w->arena);
    }
    for (uint32_t i = 0; fine && i < s->image_count; i++) {
        struct buf file = {0};
        wild_file(s->images[i].file, &file);
        fine = image_asset_read(&s->images[i], file.data, file.size, &w->arena, err);
        buf_release(&file);
    }
    return fine;
}

/* Its document is in w->json. */
static bool read_document(struct wild *w, const char **why)
{
    struct scene_errors errors;
    struct err err;
    if (!scene_parse(&w->scene, w->json, strlen(w->json), SCENE_FROM_DISK, &w->arena, &errors)) {
        *why = arena_printf(&w->arena, "%s: %s", errors.list[0].where, errors.list[0].what);
        return false;
    }
    if (!load(w, &err)) {
        *why = arena_printf(&w->arena, "%s", err.text);
        return false;
    }
    return true;
}

bool wild_make(struct wild *w, uint64_t seed, const char **why)
{
    struct wild_pen p;
    document(&p, seed);
    *w = (struct wild){.seed = seed, .unit = p.unit, .gain = p.gain, .traits = p.traits};
    w->json = arena_strdup(&w->arena, (const char *)p.out.data);
    buf_release(&p.out);
    return read_document(w, why);
}

bool wild_read(struct wild *w, const char *path, uint32_t traits, const char **why)
{
    struct buf file = {0};
    struct err err;
    *w = (struct wild){.unit = 1, .gain = 1, .traits = traits};
    if (!buf_read_file(&file, path, SCENE_MAX_BYTES, &err)) {
        *why = arena_printf(&w->arena, "%s", err.text);
        return false;
    }
    buf_append(&file, "", 1);
    w->json = arena_strdup(&w->arena, (const char *)file.data);
    buf_release(&file);
    return read_document(w, why);
}

void wild_release(struct wild *w)
{
    arena_release(&w->arena);
}
