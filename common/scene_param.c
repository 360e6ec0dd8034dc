/* SPDX-License-Identifier: MIT */
#include "common/scene_param.h"

void scene_params_of(const struct scene_params *p, const char *what, const struct scene_key *keys,
                     size_t count)
{
    scene_doc_object(p->doc, p->at, what, keys, count);
}

void scene_param_rgb(const struct scene_params *p, const char *key, struct scene_range range,
                     rgb *out)
{
    scene_key_rgb(p->doc, p->at, key, range, out);
}

void scene_param_number(const struct scene_params *p, const char *key, struct scene_range range,
                        float *out)
{
    double value = (double)*out;
    if (scene_key_number(p->doc, p->at, key, range, &value))
        *out = (float)value;
}
