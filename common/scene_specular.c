/* SPDX-License-Identifier: MIT */
#include "common/scene_specular.h"

#include "common/scene_xform.h"

static const struct scene_range fraction = {0, 1, false};

_Static_assert(offsetof(struct material, conductor.eta) == offsetof(struct material, metal.eta) &&
                   offsetof(struct material, conductor.k) == offsetof(struct material, metal.k) &&
                   offsetof(struct material, conductor.alpha) ==
                       offsetof(struct material, metal.alpha_x),
               "a conductor begins like a metal");

/* --- metals by name --- */

/* Index of refraction eta + i k in the bands of the three channels, measured.
 *
 * Gold, silver, copper: P. Johnson, R. Christy, "Optical Constants of the Noble Metals", Physical
 * Review B 6, 1972; means of the tabled values at 1.88 and 2.01 eV (659, 617 nm; red), 2.26 and
 * 2.38 eV (549, 521 nm), 2.63 and 2.75 eV (471, 451 nm).
 *
 * The others at 650, 550 and 450 nm, linear between the wavelengths of the tables.
 * Iron, chromium: the same, "Optical constants of transition metals: Ti, V, Cr, Mn, Fe, Co, Ni, and
 * Pd", Physical Review B 9, 1974. Aluminium: A. Rakic, "Algorithm for the determination of
 * intrinsic optical constants of metal films: application to aluminum", Applied Optics 34, 1995.
 * Brass: M. Querry, "Optical constants", report CRDC-CR-85034, 1985 (70 % copper, 30 % zinc). */
enum metal {
    METAL_GOLD,
    METAL_SILVER,
    METAL_COPPER,
    METAL_ALUMINIUM,
    METAL_IRON,
    METAL_CHROMIUM,
    METAL_BRASS
};

static const char *const metal_names[] = {
    [METAL_GOLD] = "gold",           [METAL_SILVER] = "silver", [METAL_COPPER] = "copper",
    [METAL_ALUMINIUM] = "aluminium", [METAL_IRON] = "iron",     [METAL_CHROMIUM] = "chromium",
    [METAL_BRASS] = "brass",
};

static const struct {
    rgb eta, k;
} metals[] = {
    [METAL_GOLD] = {{.175f, .525f, 1.345f, 0}, {3.4845f, 2.268f, 1.8815f, 0}},
    [METAL_SILVER] = {{.055f, .055f, .045f, 0}, {4.3175f, 3.455f, 2.763f, 0}},
    [METAL_COPPER] = {{.26f, 1.1f, 1.245f, 0}, {3.476f, 2.5925f, 2.44f, 0}},
    [METAL_ALUMINIUM] = {{1.558f, 1.0152f, .6332f, 0}, {7.7124f, 6.6273f, 5.4544f, 0}},
    [METAL_IRON] = {{2.9114f, 2.9497f, 2.5845f, 0}, {3.0893f, 2.9318f, 2.767f, 0}},
    [METAL_CHROMIUM] = {{3.1071f, 3.1812f, 2.323f, 0}, {3.3314f, 3.3291f, 3.135f, 0}},
    [METAL_BRASS] = {{.444f, .527f, 1.094f, 0}, {3.695f, 2.765f, 1.829f, 0}},
};

static void read_metal(const struct scene_params *p, const struct scene_at *name, rgb *eta, rgb *k)
{
    size_t metal = 0;
    struct scene_at other;
    if (scene_doc_choice(p->doc, name, metal_names, countof(metal_names), &metal)) {
        *eta = metals[metal].eta;
        *k = metals[metal].k;
    }
    if (scene_at_member(p->at, "eta", &other) || scene_at_member(p->at, "k", &other))
        scene_doc_fault(p->doc, p->at, ERR_INPUT,
                        "a conductor material needs \"metal\", or \"eta\" and \"k\", got both");
}

/* --- parts --- */

static void read_flag(const struct scene_params *p, const char *key, bool *out)
{
    struct scene_at at;
    if (!scene_at_member(p->at, key, &at))
        return;
    if (scene_at_type(&at) == SCENE_BOOLEAN)
        *out = scene_at_boolean(&at);
    else
        scene_doc_expected(p->doc, &at, ERR_INPUT, "true or false");
}

/* One width, or one along the tangent and one across. */
static void read_widths(const struct scene_params *p, struct material *m)
{
    struct scene_at at;
    double both[2];
    if (!scene_at_member(p->at, "alpha", &at))
        return;
    if (scene_at_type(&at) != SCENE_ARRAY) {
        scene_param_both(p, "alpha", fraction, &m->metal.alpha_x, &m->metal.alpha_y);
    } else if (scene_doc_numbers(p->doc, &at, fraction, both, 2)) {
        m->metal.alpha_x = (float)both[0];
        m->metal.alpha_y = (float)both[1];
    }
}

/* Of an index of 1 there is none. */
static void read_film(const struct scene_params *p, struct thin_film *film)
{
    static const struct scene_key keys[] = {{"thickness_nm", true}, {"ior", true}};
    struct scene_at at;
    double thickness = 0, ior = 1;
    if (!scene_at_member(p->at, "thin_film", &at) ||
        !scene_doc_object(p->doc, &at, "a thin film", keys, countof(keys)))
        return;
    scene_key_number(p->doc, &at, "thickness_nm", (struct scene_range){0, 2000, false}, &thickness);
    scene_key_number(p->doc, &at, "ior", (struct scene_range){1, 4, false}, &ior);
    film->ior = (float)ior;
    film->thickness_nm = film->ior > 1 ? (float)thickness : 0;
}

static void read_turn(const struct scene_params *p, float *cos, float *sin)
{
    static const double normal[3] = {0, 0, 1};
    double deg = 0;
    scene_key_number(p->doc, p->at, "rotation_deg", (struct scene_range){-360, 360, false}, &deg);
    const struct scene_xform turn = scene_xform_rotate(normal, deg);
    *cos = (float)turn.m[0][0];
    *sin = (float)turn.m[1][0];
}

/* --- the materials --- */

void scene_specular_dielectric(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true},      {"ior", true},
                                            {"alpha", false},    {"absorption", false},
                                            {"priority", false}, {"multiscatter", false}};
    uint64_t priority = 0;
    m->dielectric.ior = 1;
    scene_params_of(p, "a dielectric material", keys, countof(keys));
    scene_param_number(p, "ior", (struct scene_range){1, 4, false}, &m->dielectric.ior);
    scene_param_number(p, "alpha", fraction, &m->dielectric.alpha);
    read_flag(p, "multiscatter", &m->dielectric.multiscatter);
    scene_key_rgb(p->doc, p->at, "absorption", (struct scene_range){0, 1e9, false},
                  &m->inside.absorption);
    scene_key_integer(p->doc, p->at, "priority", (struct scene_range){1, 1000, false}, &priority);
    m->inside.priority = (uint32_t)priority;
}

void scene_specular_pane(const struct scene_params *p, struct material *m)
{
    static const struct scene_key keys[] = {{"type", true}, {"ior", true}};
    m->pane.ior = 1;
    scene_params_of(p, "a thin_dielectric material", keys, countof(keys));
    scene_param_number(p, "ior", (struct scene_range){1, 4, false}, &m->pane.ior);
}

static void read_constants(const struct scene_params *p, rgb *eta, rgb *k)
{
    struct scene_at name;
    scene_param_rgb(p, "eta", (struct scene_range){1e-3, 100, false}, eta);
    scene_param_rgb(p, "k", (struct scene_range){0, 100, false}, k);
    if (scene_at_member(p->at, "metal", &name))
        read_metal(p, &name, eta, k);
}

void scene_specular_conductor(const struct scene_params *p, struct material *m)
{
    struct scene_at name;
    const bool named = scene_at_member(p->at, "metal", &name);
    const struct scene_key keys[] = {
        {"type", true},  {"metal", false},        {"eta", !named},         {"k", !named},
        {"alpha", true}, {"rotation_deg", false}, {"multiscatter", false}, {"thin_film", false}};
    m->kind = MATERIAL_METAL;
    scene_params_of(p, "a conductor material", keys, countof(keys));
    read_constants(p, &m->metal.eta, &m->metal.k);
    read_widths(p, m);
    read_turn(p, &m->metal.turn_cos, &m->metal.turn_sin);
    read_flag(p, "multiscatter", &m->metal.multiscatter);
    read_film(p, &m->metal.film);
    m->needs |= m->metal.alpha_x != m->metal.alpha_y ? MATERIAL_NEEDS_TANGENT : 0;
    /* What a conductor has, it has where a metal has it, also for the slots of textures. */
    if (m->metal.alpha_x == m->metal.alpha_y && !m->metal.multiscatter &&
        m->metal.film.thickness_nm == 0)
        m->kind = MATERIAL_CONDUCTOR;
}
