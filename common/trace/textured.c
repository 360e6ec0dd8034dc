/* SPDX-License-Identifier: MIT */
#include "common/trace/textured.h"

struct texture_point textured_point(const struct stage *s, const struct ray *ray,
                                    const struct ray_hit *hit, const struct surface *at,
                                    float width)
{
    const struct stage_detail *detail = surface_detail_of(s, hit->prim, hit->instance);
    const struct surface_detail d = surface_detail_at(s, detail, hit, at);
    const float slant = vec3_dot(at->ng, ray->dir);
    const float uv_m2 = vec3_length(vec3_cross(d.dp_du, d.dp_dv)); /* of a unit square of uv */
    const float area = width * width / ((slant < 0 ? -slant : slant) * uv_m2);
    return (struct texture_point){
        .u = d.u,
        .v = d.v,
        .area = uv_m2 > 0 && area >= 0 ? area : 0, /* all of it, or none, has one uv */
        .color = d.color,
    };
}

static float keep(float v, const struct material_slot *slot)
{
    return v < slot->lo ? slot->lo : v > slot->hi ? slot->hi : v;
}

static void fill(const struct stage *s, const struct material_slot *slot,
                 const struct texture_point *at, struct material *m)
{
    const struct texture_value t = texture_at(s, slot->texture, at);
    unsigned char *member = (unsigned char *)m + slot->member;
    if (slot->is_rgb) {
        const rgb c = vec3_load(slot->scale) * t.color;
        const rgb kept = vec3_make(keep(c[0], slot), keep(c[1], slot), keep(c[2], slot));
        memcpy(member, &kept, sizeof kept);
    } else {
        const float v = keep(slot->scale[0] * texture_channel(&t, slot->channel), slot);
        memcpy(member, &v, sizeof v);
    }
}

/* Two values that are in range each may be too much together. */
static void keep_energy(struct material *m)
{
    if (m->kind != MATERIAL_LEAF)
        return;
    for (int k = 0; k < 3; k++) {
        const float sum = m->leaf.reflectance[k] + m->leaf.transmittance[k];
        if (sum > 1) {
            m->leaf.reflectance[k] /= sum;
            m->leaf.transmittance[k] /= sum;
        }
    }
}

const struct material *textured_material(const struct stage *s, const struct material *m,
                                         const struct texture_point *at, struct material *scratch)
{
    if (!textured_has(m))
        return m;
    const struct material_slot *slots = stage_at(s, s->slots);
    *scratch = *m;
    scratch->slot_begin = scratch->slot_end = 0; /* they are filled */
    for (uint32_t i = m->slot_begin; i < m->slot_end; i++)
        fill(s, &slots[i], at, scratch);
    keep_energy(scratch);
    return scratch;
}
