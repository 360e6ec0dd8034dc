/* "Model price": what a scene's pieces cost and buy, each left out in turn.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "client/chart.h"

enum piece {
    PIECE_MIS_BSDF,
    PIECE_MIS_LIGHT,
    PIECE_SOBOL,
    PIECE_DEPTH,
    PIECE_INDIRECT,
    PIECE_NORMALS,
    PIECE_MULTISCATTER,
    PIECE_THIN_FILM,
    PIECE_ABSORPTION,
};

static const char *const names[] = {
    [PIECE_MIS_BSDF] = "MIS (lights sampled alone)",
    [PIECE_MIS_LIGHT] = "MIS (BSDF sampled alone)",
    [PIECE_SOBOL] = "Sobol points (independent)",
    [PIECE_DEPTH] = "bounces beyond 8",
    [PIECE_INDIRECT] = "indirect light",
    [PIECE_NORMALS] = "vertex normals",
    [PIECE_MULTISCATTER] = "multiple scattering on facets",
    [PIECE_THIN_FILM] = "thin films",
    [PIECE_ABSORPTION] = "absorption",
};

_Static_assert(countof(names) <= CHART_MOST_PIECES, "a point each");

enum { FEW_BOUNCES = 8, OF_PRICE = 2000 };

/* Materials and shapes of its own, to be changed. */
static void own(struct scene *s, struct arena *arena)
{
    struct material *materials = arena_new(arena, struct material, s->material_count);
    struct shape *shapes = arena_new(arena, struct shape, s->shape_count);
    if (s->material_count)
        memcpy(materials, s->materials, s->material_count * sizeof *materials);
    if (s->shape_count)
        memcpy(shapes, s->shapes, s->shape_count * sizeof *shapes);
    s->materials = materials;
    s->shapes = shapes;
}

static bool cap_bounces(struct scene *s, uint32_t most)
{
    const bool more = s->settings.max_bounces > most;
    s->settings.max_bounces = min_u32(s->settings.max_bounces, most);
    return more;
}

static bool flatten(struct scene *s)
{
    bool any = false;
    for (uint32_t i = 0; i < s->shape_count; i++) {
        struct shape *shape = &s->shapes[i];
        if (shape->kind != SHAPE_MESH || shape->mesh.normals == MESH_NORMALS_FLAT)
            continue;
        any = any || s->meshes[shape->mesh.mesh].normals;
        shape->mesh.normals = MESH_NORMALS_FLAT;
    }
    return any;
}

static bool plain_metals(struct scene *s, enum piece piece)
{
    bool any = false;
    for (uint32_t i = 0; i < s->material_count; i++) {
        struct material *m = &s->materials[i];
        if (m->kind != MATERIAL_METAL)
            continue;
        if (piece == PIECE_MULTISCATTER) {
            any = any || m->metal.multiscatter;
            m->metal.multiscatter = false;
        } else {
            any = any || m->metal.film.thickness_nm > 0;
            m->metal.film.thickness_nm = 0;
        }
    }
    return any;
}

static bool clear_insides(struct scene *s)
{
    bool any = false;
    for (uint32_t i = 0; i < s->material_count; i++) {
        any = any || !rgb_is_black(s->materials[i].inside.absorption);
        s->materials[i].inside.absorption = rgb_gray(0);
    }
    return any;
}

/* False: the scene has no such piece. */
static bool leave_out(enum piece piece, struct scene *s, struct chart_method *m)
{
    switch (piece) {
    case PIECE_MIS_BSDF:
        m->strategy = STRATEGY_LIGHT;
        return true;
    case PIECE_MIS_LIGHT:
        m->strategy = STRATEGY_BSDF;
        return true;
    case PIECE_SOBOL:
        m->sampler = SAMPLER_INDEPENDENT;
        return true;
    case PIECE_DEPTH:
        return cap_bounces(s, FEW_BOUNCES);
    case PIECE_INDIRECT:
        return cap_bounces(s, 1);
    case PIECE_NORMALS:
        return flatten(s);
    case PIECE_MULTISCATTER:
    case PIECE_THIN_FILM:
        return plain_metals(s, piece);
    case PIECE_ABSORPTION:
        return clear_insides(s);
    }
    __builtin_unreachable();
}

struct outcome { /* by run */
    double work[CURVE_MOST_RUNS], error[CURVE_MOST_RUNS], energy[CURVE_MOST_RUNS];
};

static bool run(const struct chart *c, const struct scene *scene, const struct chart_method *m,
                struct chart_crew *crew, uint32_t of, struct outcome *out, struct err *err)
{
    struct arena arena = {0};
    const struct stage *stage;
    const uint32_t n = c->options.runs;
    const size_t pixels = (size_t)c->width_px * c->height_px;
    const bool good = chart_prepare(scene, m, &stage, &arena, err);
    if (good) {
        struct chart_run *runs =
            chart_make_runs(stage, c->piece_spp, n, scene->settings.seed, of, &arena);
        double *scratch = arena_new(&arena, double, pixels), trimmed;
        chart_runs_do(crew, runs, n);
        for (uint32_t r = 0; r < n; r++) {
            out->work[r] = (double)runs[r].work.units;
            out->error[r] =
                curve_relmse(runs[r].image, c->reference.image, pixels, &trimmed, scratch);
            out->energy[r] = chart_energy(c, runs[r].image);
        }
    }
    arena_release(&arena);
    return good;
}

static struct chart_piece compare(const char *name, const struct outcome *without,
                                  const struct outcome *with, uint32_t n)
{
    double saved[CURVE_MOST_RUNS], error[CURVE_MOST_RUNS], energy[CURVE_MOST_RUNS];
    for (uint32_t r = 0; r < n; r++) {
        saved[r] = 1 - without->work[r] / with->work[r];
        error[r] = without->error[r] - with->error[r];
        energy[r] = without->energy[r] - with->energy[r];
    }
    return (struct chart_piece){name, curve_mean(saved, n), curve_mean(error, n),
                                curve_mean(energy, n)};
}

bool chart_price(struct chart *c, const struct scene *scene, struct chart_crew *crew,
                 struct arena *arena, struct err *err)
{
    const struct scene small = chart_shrunk(scene, c->options.size_px);
    const struct chart_method all = *c->lines[0].method;
    struct outcome with, without;
    c->piece_spp = c->options.spp;
    if (!run(c, &small, &all, crew, OF_PRICE, &with, err))
        return false;
    c->piece_error = curve_mean(with.error, c->options.runs).at;
    for (uint32_t i = 0; i < countof(names); i++) {
        struct scene less = small;
        struct chart_method m = all;
        own(&less, arena);
        if (!leave_out((enum piece)i, &less, &m))
            continue;
        if (!run(c, &less, &m, crew, OF_PRICE + 1 + i, &without, err))
            return false;
        c->pieces[c->piece_count++] = compare(names[i], &without, &with, c->options.runs);
    }
    return true;
}
