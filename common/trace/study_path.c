/* Paths of a study, one at a time: what wave.c does with eight, in the same words of path.h.
 * SPDX-License-Identifier: MIT */
#include "common/trace/bvh.h"
#include "common/trace/material.h"
#include "common/trace/path_mask.h"
#include "common/trace/study_parts.h"
#include "common/trace/textured.h"

void study_path_init(struct study_path *p, const struct stage *s, struct rng rng,
                     struct film_work *work)
{
    *p = (struct study_path){.stage = s, .rng = rng, .work = work};
    p->path = (struct path){.work = work, .throughput = rgb_gray(1), .scale = 1};
    p->media.bodies = s->around;
    p->path.media = s->media ? &p->media : NULL;
}

bool study_path_go(struct study_path *p, struct ray ray, bool first)
{
    const struct stage *s = p->stage;
    const uint32_t bounce = first ? 0 : p->bounce + 1; /* of the numbers for masks, as waves do */
    struct ray_hit hit;
    p->work->bounce_rays++;
    uint32_t found = bvh_hit_closest(s, &ray, &hit);
    if (s->masked && found)
        found = path_mask_pass(
            s, found, &(struct path_mask_rays){&p->rng, u32x8_splat(bounce), &ray, &hit, p->work});
    if (first) {
        p->path.pdf_w = 0;
        p->path.vertex.at.p = ray.origin;
    } else {
        p->bounce++;
    }
    if (p->path.media) {
        const struct path_media_way way = {&ray, found ? &hit : NULL, 0, &p->rng, bounce};
        return path_media_arrive(s, &p->path, &way);
    }
    if (!found) {
        p->path.light += p->path.throughput * path_beyond(s, ray.dir, p->path.pdf_w);
        return false;
    }
    const struct path_vertex v = path_vertex_make(s, &ray, &hit, 0, p->work);
    path_arrive(s, &p->path, &v);
    return true;
}

const struct material *study_path_material(struct study_path *p)
{
    const struct stage *s = p->stage;
    struct path_vertex *v = &p->path.vertex;
    const struct material *materials = stage_at(s, s->materials);
    if (s->wrapped && v->material == &materials[v->at.material]) {
        const struct material_side side = {v->at.material, v->wo[2] < 0, &v->point};
        v->material = material_at(s, &side, rng_single(&p->rng, rng_dimension_choice(p->bounce)));
    }
    if (s->slots.count)
        v->material = textured_material(s, v->material, &v->point, &p->textured);
    return v->material;
}

bool study_path_scatter(struct study_path *p, bool first, bool may_end, struct ray *ray)
{
    const struct path_draw draw = {
        .direction = rng_pair(&p->rng, rng_dimension(p->bounce, RNG_BSDF_DIRECTION)),
        .lobe = rng_single(&p->rng, rng_dimension(p->bounce, RNG_BSDF_LOBE)),
        .roulette = rng_single(&p->rng, rng_dimension(p->bounce, RNG_ROULETTE)),
        .first = first,
        .may_end = may_end && p->bounce >= PATH_ROULETTE_BEGIN,
    };
    p->work->other_vertices++;
    return path_scatter(p->stage, &p->path, &draw, ray);
}
