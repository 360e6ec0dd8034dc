/* SPDX-License-Identifier: MIT */
#include "common/trace/path_media.h"

#include "common/trace/bvh.h"

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

bool path_media_arrive(const struct stage *s, struct path *p, const struct ray *ray,
                       const struct ray_hit *hit, float width)
{
    struct ray onward = *ray;
    struct ray_hit next;
    for (uint32_t n = 0; n < MEDIUM_MOST_HIDDEN; n++) {
        p->throughput *= medium_passed(s, &p->media->bodies, distance(s, p, &onward, hit));
        if (rgb_is_black(p->throughput))
            return false;
        if (!hit) {
            p->light += p->throughput * path_beyond(s, onward.dir, p->pdf_w);
            return false;
        }
        const struct path_vertex v = path_vertex_make(s, &onward, hit, width, p->work);
        path_arrive(s, p, &v);
        if (interface_is_there(s, p))
            return true;
        p->pdf_w = 0; /* no shadow ray comes through it */
        onward = surface_leave(&p->vertex.at, onward.dir);
        p->work->bounce_rays++;
        hit = bvh_hit_closest(s, &onward, &next) ? &next : NULL;
    }
    return false;
}

bool path_media_begin(const struct stage *s, struct path *p, const struct ray *ray,
                      const struct ray_hit *hit, float width)
{
    p->media->bodies = s->around;
    p->pdf_w = 0;
    return path_media_arrive(s, p, ray, hit, width);
}
