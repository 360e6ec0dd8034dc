/* SPDX-License-Identifier: MIT */
#include "common/trace/light8.h"

#include "common/trace/light.h"
#include "common/trace/warp8.h"

/* --- the choice of the lamp, and where on it: as pick_emitter and pick_rest of light.c --- */

/* The middle of what the bits stand for. There is no conversion from unsigned numbers: 2^31 is
 * taken away before, and added again. */
static f64x4 middle(i32x4 bits)
{
    const f64x4 low = __builtin_convertvector(bits ^ INT32_MIN, f64x4);
    return (low + (0x1p31 + 0.5)) * 0x1p-32;
}

/* Of four lanes: where u lies in its lamp's part of the table. */
static i32x4 rest_bits(f64x4 u, vec3 begin, vec3 end)
{
    const f64x4 from = f64x4_of(begin), rest = (u - from) / (f64x4_of(end) - from);
    const i32x4 bits = __builtin_convertvector(rest * 0x1p24, i32x4), most = (i32x4){0} + 0xffffff;
    return (i32x4)vec3_choose(bits < most, (vec3)bits, (vec3)most);
}

struct choice {
    u32x8 lamp;
    f32x8 probability, rest;
};

static inline __attribute__((always_inline)) void choose(const struct stage_lamps *l, u32x8 bits,
                                                         struct choice *c)
{
    const i32x8 b = (i32x8)bits;
    const f64x4 u[2] = {middle(__builtin_shufflevector(b, b, 0, 1, 2, 3)),
                        middle(__builtin_shufflevector(b, b, 4, 5, 6, 7))};
    i32x8 lamp = {0};
    for (uint32_t i = 1; i < l->count; i++) { /* -1 for each that ends before u */
        const double begin = (double)l->begin[i];
        const i32x4 low = __builtin_convertvector(begin <= u[0], i32x4),
                    high = __builtin_convertvector(begin <= u[1], i32x4);
        lamp -= __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
    }
    c->lamp = (u32x8)lamp;
    const f32x8 begin = f32x8_permute(f32x8_load(l->begin), c->lamp),
                end = f32x8_permute(f32x8_load(l->end), c->lamp);
    const i32x4 low = rest_bits(u[0], f32x8_low(begin), f32x8_low(end)),
                high = rest_bits(u[1], f32x8_high(begin), f32x8_high(end));
    c->rest =
        __builtin_convertvector(__builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7), f32x8) *
        0x1p-24f;
    const vec3 p0 = f64x4_round(f64x4_of(f32x8_low(end)) - f64x4_of(f32x8_low(begin))),
               p1 = f64x4_round(f64x4_of(f32x8_high(end)) - f64x4_of(f32x8_high(begin)));
    c->probability = f32x8_join(p0, p1);
}

static inline struct vec8 column(const float v[3][STAGE_LANES], u32x8 lamp)
{
    return (struct vec8){f32x8_permute(f32x8_load(v[0]), lamp),
                         f32x8_permute(f32x8_load(v[1]), lamp),
                         f32x8_permute(f32x8_load(v[2]), lamp)};
}

/* As light_solid_is_near. */
static inline i32x8 is_near(const struct stage_lamps *l, u32x8 lamp, const struct surface8 *from,
                            const struct vec8 *ng)
{
    const struct vec8 d = vec8_sub(column(l->middle, lamp), from->p);
    const f32x8 none = {0};
    return (vec8_dot(d, d) < f32x8_permute(f32x8_load(l->near_dd), lamp)) &
           (vec8_dot(d, *ng) < none);
}

/* Where the lamp is near; few vertices are, and it takes double. True: something may arrive. */
static bool sample_alone(const struct stage *s, const struct surface8 *from, struct sobol_bits q,
                         uint32_t i, struct light8_sample *out, struct ray *shadow)
{
    const struct surface at = {.p = vec8_lane(&from->p, i),
                               .p_error = vec8_lane(&from->p_error, i),
                               .ng = vec8_lane(&from->ng, i),
                               .prim = from->prim[i]};
    struct light_sample light;
    if (!light_sample(s, &at, q, &light))
        return false;
    vec8_set_lane(&out->wi, i, light.wi);
    vec8_set_lane(&out->value, i, light.value);
    out->pdf_w[i] = light.pdf_w;
    *shadow = light.shadow;
    return true;
}

uint32_t light8_sample(const struct stage *s, const struct surface8 *from, uint32_t lanes,
                       const struct sobol8_bits *q, struct light8_sample *out, struct ray shadow[8])
{
    const struct stage_lamps *l = stage_at(s, s->lamps);
    struct choice c;
    choose(l, q->u, &c);
    const struct surface8_corners t = {column(l->v[0], c.lamp), column(l->v[1], c.lamp),
                                       column(l->v[2], c.lamp)};
    const struct sobol8_square b =
        warp8_triangle((struct sobol8_square){c.rest, sobol8_float(q->v)});
    struct surface8 on;
    surface8_place(&t, b.u, b.v, &on);
    on.ng = column(l->normal, c.lamp);
    on.prim = (u32x8)f32x8_permute((f32x8)u32x8_load(l->prim), c.lamp);

    /* area_pdf_w of light.c */
    const struct vec8 d = vec8_sub(on.p, from->p);
    const f32x8 dd = vec8_dot(d, d), length = f32x8_sqrt(dd), none = {0};
    const f32x8 cos = -vec8_dot(d, on.ng) / length;
    const f32x8 pdf_w = dd / (cos * f32x8_permute(f32x8_load(l->area), c.lamp));
    const i32x8 seen = (cos > none) & (pdf_w > none) & (i32x8)(on.prim != from->prim);

    out->pdf_w = c.probability * pdf_w;
    out->value = vec8_over(column(l->radiance, c.lamp), out->pdf_w);
    out->wi = vec8_over(d, length);
    surface8_to_surface(from, &on, d, length, shadow);
    uint32_t lit = lanes & i32x8_mask(seen);
    uint32_t near = lanes & i32x8_mask(is_near(l, c.lamp, from, &on.ng));
    for (; near; near &= near - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(near);
        const struct sobol_bits bits = {q->u[i], q->v[i]};
        lit &= ~(1u << i);
        lit |= (uint32_t)sample_alone(s, from, bits, i, out, &shadow[i]) << i;
    }
    return lit;
}

/* --- the table --- */

static void lamp_fill(const struct stage *s, uint32_t lane, const struct emitter *e,
                      struct stage_lamps *l)
{
    const struct stage_triangle t = stage_triangle_at(s, e->place.index, STAGE_NONE);
    const struct stage_id id = {e->prim, e->place, STAGE_NONE};
    const struct surface on = surface_on_triangle(s, id, 0, 0);
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 3; i++)
            l->v[i][k][lane] = t.v[i][k];
        l->normal[k][lane] = on.ng[k];
        l->radiance[k][lane] = e->radiance[k];
        l->middle[k][lane] = e->at[k];
    }
    l->near_dd[lane] = e->near_dd;
    l->area[lane] = e->area;
    l->prim[lane] = e->prim;
}

bool light8_fit(const struct emitter *emitters, uint64_t count)
{
    for (uint64_t i = 0; i < count; i++)
        if (emitters[i].kind != EMITTER_PRIM || emitters[i].place.kind != STAGE_TRIANGLE ||
            emitters[i].texture != STAGE_NONE)
            return false;
    return count > 0 && count <= STAGE_LANES;
}

void light8_lamps(const struct stage *s, struct stage_lamps *l)
{
    const struct emitter *emitters = stage_at(s, s->emitters);
    const float *cdf = stage_at(s, s->pick_cdf);
    l->count = (uint32_t)s->emitters.count;
    for (uint32_t lane = 0; lane < STAGE_LANES; lane++) {
        const uint32_t i = lane < l->count ? lane : 0;
        lamp_fill(s, lane, &emitters[i], l);
        l->begin[lane] = cdf[i];
        l->end[lane] = cdf[i + 1];
    }
}
