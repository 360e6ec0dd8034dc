/* SPDX-License-Identifier: MIT */
#include "common/trace/wave_pick.h"

#include "common/trace/bsdf.h"

void wave_pick(const struct wave *w, struct light_pick picks[WAVE_LANES])
{
    const struct stage *s = w->stage;
    const struct path8_vertex *lanes = w->lanes.vertex;
    struct surface at[WAVE_LANES];
    const struct surface *from[WAVE_LANES];
    uint32_t path[WAVE_LANES], bits[WAVE_LANES], count = 0;
    struct light_pick found[WAVE_LANES];
    for (uint32_t left = w->going; left; left &= left - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(left);
        const bool lane = w->plain >> i & 1;
        if (bsdf_is_delta(lane ? path8_material(s, lanes, i) : w->paths[i].vertex.material))
            continue;
        if (lane)
            at[count] = path8_surface(s, lanes, i);
        from[count] = lane ? &at[count] : &w->paths[i].vertex.at;
        bits[count] = w->lamp.u[i];
        path[count++] = i;
    }
    if (count == 0)
        return;
    light_pick(s, from, bits, count, found);
    for (uint32_t k = 0; k < count; k++)
        picks[path[k]] = found[k];
}
