/* The pixel filter.
 * SPDX-License-Identifier: MIT */
#include "common/scene_read.h"

static void read_float(struct scene_doc *doc, const struct scene_at *at, const char *key,
                       struct scene_range range, float *out)
{
    double value = (double)*out;
    scene_key_number(doc, at, key, range, &value);
    *out = (float)value;
}

void scene_read_filter(struct scene_doc *doc, const struct scene_at *at, struct scene_film *film)
{
    static const char *const kinds[] = {[FILTER_BOX] = "box",
                                        [FILTER_TENT] = "tent",
                                        [FILTER_GAUSSIAN] = "gaussian",
                                        [FILTER_BLACKMAN_HARRIS] = "blackman_harris",
                                        [FILTER_MITCHELL] = "mitchell"};
    static const float radii[] = {[FILTER_BOX] = .5f,
                                  [FILTER_TENT] = 1,
                                  [FILTER_GAUSSIAN] = 1.5f,
                                  [FILTER_BLACKMAN_HARRIS] = 1.5f,
                                  [FILTER_MITCHELL] = 2};
    static const struct scene_key plain[] = {{"type", true}, {"radius", false}};
    static const struct scene_key gaussian[] = {
        {"type", true}, {"sigma", false}, {"radius", false}};
    static const struct scene_key mitchell[] = {
        {"type", true}, {"b", false}, {"c", false}, {"radius", false}};
    static const struct scene_range fraction = {0, 1, false};
    size_t kind;
    if (!scene_doc_kind(doc, at, "the filter", kinds, countof(kinds), &kind))
        return;
    film->filter = (enum filter_kind)kind;
    film->filter_radius_px = radii[kind];
    switch (film->filter) {
    case FILTER_BOX:
    case FILTER_TENT:
    case FILTER_BLACKMAN_HARRIS:
        scene_doc_object(doc, at, "the filter", plain, countof(plain));
        break;
    case FILTER_GAUSSIAN:
        scene_doc_object(doc, at, "a gaussian filter", gaussian, countof(gaussian));
        film->filter_sigma_px = .5f;
        read_float(doc, at, "sigma", (struct scene_range){.05, 16, false}, &film->filter_sigma_px);
        break;
    case FILTER_MITCHELL:
        scene_doc_object(doc, at, "a mitchell filter", mitchell, countof(mitchell));
        film->filter_b = film->filter_c = 1 / 3.f;
        read_float(doc, at, "b", fraction, &film->filter_b);
        read_float(doc, at, "c", fraction, &film->filter_c);
        break;
    }
    read_float(doc, at, "radius", (struct scene_range){.1, 16, false}, &film->filter_radius_px);
}
