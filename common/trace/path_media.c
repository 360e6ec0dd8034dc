/* SPDX-License-Identifier: MIT */
#include "common/trace/path_media.h"

#include "common/trace/bvh.h"
#include "common/trace/path_mask.h"

/* Whether the vertex scatters: a surface of a body may not be there, and the path is then behind
 * it. An index below 1 is its inverse from the other side, which becomes the front: bsdf.h knows no
 * other indices. Emission has been looked at before. */
static bool interface_is_there(const struct stage *s, struct path *p)
{
    struct path_vertex *v = &p->vertex;
    struct path_media *m = p->media;
    float ratio;
    m->body = STAGE_NONE;
    if (!medium_is_body(v->material))
        return true;
    m->body = v->at.material;
    m->entering = v->wo[2] > 0;
    if (!medium_meets(s, &m->bodies, m->body, m->entering, &ratio)) {
        medium_cross(&m->bodies, m->body, m->entering);
        return false;
    }
    m->seen = *v->material;
    v->material = &m->seen;
    if (ratio < 1) {
        v->at.ng = -v->at.ng;
        v->frame.z = -v->frame.z;
        v->wo[2] = -v->wo[2];
    }
    m->seen.dielectric.ior = ratio < 1 ? 1 / ratio : ratio;
    return true;
}

/* The bodies around the vertex, on the side of wi. */
static struct stage_bodies bodies_towards(const struct path *p, vec3 wi)
{
    const struct path_vertex *v = &p->vertex;
    struct stage_bodies b = p->media->bodies;
    if (v->wo[2] * wi[2] < 0 && p->media->body != STAGE_NONE)
        medium_cross(&b, p->media->body, p->media->entering);
    return b;
}

rgb path_media_passed(const struct stage *s, const struct path *p, vec3 wi,
                      const struct ray *shadow)
{
    const struct stage_bodies b = bodies_towards(p, wi);
    return medium_passed(s, &b, shadow->t_max * vec3_length(shadow->dir));
}

void path_media_leave(struct path *p, vec3 wi)
{
    p->media->bodies = bodies_towards(p, wi);
}

/* From the vertex to the hit: the ray starts there, or where a mask has let it through. */
static float distance(const struct stage *s, const struct path *p, const struct ray *ray,
                      const struct ray_hit *hit)
{
    if (!hit)
        return __builtin_inff();
    return s->masked ? hit->t + vec3_length(ray->origin - p->vertex.at.p) : hit->t;
}

/* Behind the n-th surface that is not there. Masks before it have taken numbers of 2^8 each. */
static bool goes_on(const struct stage *s, struct path *p, const struct path_media_way *way,
                    uint32_t n, struct ray *ray, struct ray_hit *hit)
{
    const struct path_mask_ray masked = {way->rng, way->bounce, n << 8, ray, hit, p->work};
    *ray = surface_leave(&p->vertex.at, ray->dir);
    p->work->bounce_rays++;
    return bvh_hit_closest(s, ray, hit) && (!s->masked || path_mask_stops(s, &masked));
}

bool path_media_arrive(const struct stage *s, struct path *p, const struct path_media_way *way)
{
    const struct ray_hit *hit = way->hit;
    struct ray onward = *way->ray;
    struct ray_hit next;
    for (uint32_t n = 1; n <= MEDIUM_MOST_HIDDEN; n++) {
        p->throughput *= medium_passed(s, &p->media->bodies, distance(s, p, &onward, hit));
        if (rgb_is_black(p->throughput))
            return false;
        if (!hit) {
            p->light += p->throughput * path_beyond(s, onward.dir, p->pdf_w);
            return false;
        }
        const struct path_vertex v = path_vertex_make(s, &onward, hit, way->width, p->work);
        path_arrive(s, p, &v);
        if (interface_is_there(s, p))
            return true;
        p->pdf_w = 0; /* no shadow ray comes through it */
        hit = goes_on(s, p, way, n, &onward, &next) ? &next : NULL;
    }
    return false;
}

bool path_media_begin(const struct stage *s, struct path *p, const struct path_media_way *way)
{
    p->media->bodies = s->around;
    p->pdf_w = 0;
    return path_media_arrive(s, p, way);
}
