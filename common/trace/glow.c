/* SPDX-License-Identifier: MIT */
#include "common/trace/glow.h"

rgb glow_at(const struct stage *s, const struct emitter *e, const struct texture_point *at)
{
    struct texture_point fine = *at;
    fine.area = 0;
    rgb c = texture_at(s, e->texture, &fine).color;
    for (int k = 0; k < 3; k++)
        c[k] = c[k] > 0 ? c[k] : 0;
    return vec3_load(e->radiance) * c;
}

rgb glow_on(const struct stage *s, const struct emitter *e, const struct ray_hit *hit,
            const struct surface *on)
{
    const struct stage_detail *detail = surface_detail_of(s, hit->prim, hit->instance);
    const struct surface_detail d = surface_detail_at(s, detail, hit, on);
    return glow_at(s, e, &(struct texture_point){.u = d.u, .v = d.v, .color = d.color});
}
