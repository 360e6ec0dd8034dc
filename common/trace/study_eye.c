/* Light by class, as paths from the eye find it. SPDX-License-Identifier: MIT */
#include "common/trace/bsdf.h"
#include "common/trace/bvh.h"
#include "common/trace/camera.h"
#include "common/trace/path_mask.h"
#include "common/trace/study_parts.h"

enum { SALT = 1 };

void study_chain_add(struct study_chain *c, bool smooth)
{
    c->count++;
    if (!smooth)
        c->rough++;
    if (smooth && c->rough == 0)
        c->head = true;
    c->tail = smooth;
}

enum plan_class study_class(bool eye, bool light, uint32_t rough)
{
    if (rough == 0)
        return eye || light ? PLAN_LSE : PLAN_LE;
    const int first = rough == 1 ? PLAN_LDE : PLAN_LDDE;
    return (enum plan_class)(first + 2 * light + eye);
}

struct eye {
    double found[PLAN_CLASSES];
    double all[FILM_REPLICATES], beyond_direct[FILM_REPLICATES], beyond_whitted[FILM_REPLICATES];
    uint32_t replicate;
    uint64_t direct_paths, whitted_paths;
};

/* Light that has come this way: chain with the scattering at which a lamp was looked at, if one
 * was. met: by the path itself; then `sky` says whether it is of a kind that nobody looks at. */
static void note(struct eye *e, const struct study_chain *c, double light, bool met, bool sky)
{
    if (!(light > 0))
        return;
    e->found[study_class(c->head, c->rough > 0 && c->tail, c->rough)] += light;
    e->all[e->replicate] += light;
    if (c->count > 1)
        e->beyond_direct[e->replicate] += light;
    const bool by_lamp = c->rough == 1 && !c->tail && !(met && sky);
    if (c->rough > 0 && !by_lamp)
        e->beyond_whitted[e->replicate] += light;
}

static double light_of(const struct study_path *p)
{
    return (double)rgb_luminance(p->path.light);
}

/* What a lamp sends to the vertex. */
static void look(struct study_path *p, struct eye *e, const struct study_chain *before)
{
    const struct stage *s = p->stage;
    struct ray shadow;
    rgb light;
    const double had = light_of(p);
    const struct path_lamp lamp = {rng_pair_bits(&p->rng, rng_dimension(p->bounce, RNG_LIGHT)),
                                   NULL};
    if (path_light_directly(s, &p->path, &lamp, &shadow, &light)) {
        p->work->shadow_rays++;
        if (!bvh_hit_any(s, &shadow))
            p->path.light += light;
        else if (s->masked)
            p->path.light += light * path_mask_share(s, shadow, p->work);
    }
    struct study_chain chain = *before;
    study_chain_add(&chain, false);
    note(e, &chain, light_of(p) - had, false, false);
}

static void follow(struct study_path *p, struct ray ray, struct eye *e)
{
    const struct stage *s = p->stage;
    struct study_chain chain = {0};
    for (bool first = true;; first = false) {
        const double had = light_of(p);
        const bool arrived = study_path_go(p, ray, first);
        note(e, &chain, light_of(p) - had, true, !arrived && !rgb_is_black(s->sky));
        if (!arrived || chain.count >= s->settings.max_bounces)
            return;
        study_path_material(p);
        look(p, e, &chain);
        if (!study_path_scatter(p, p->bounce == 0, true, &ray))
            return;
        e->direct_paths += chain.count > 0;
        e->whitted_paths += chain.rough > 0;
        study_chain_add(&chain, p->path.pdf_w == 0);
    }
}

static void follow_from(struct study *t, struct study_place at, uint32_t sample, struct eye *e)
{
    struct study_path p;
    const struct rng rng = study_rng(t->stage, at, sample, SALT);
    study_path_init(&p, t->stage, rng, &t->work);
    const struct square q = rng_pair(&rng, RNG_FILTER), lens = rng_pair(&rng, RNG_LENS);
    e->replicate = sample;
    follow(&p,
           camera_ray_through(&t->stage->camera, (float)at.x_px + q.u, (float)at.y_px + q.v, lens),
           e);
}

/* A share and its standard error by the replicates. */
static void share_of(const double part[], const double all[], double *share, double *error)
{
    double parts = 0, total = 0, square = 0;
    for (int r = 0; r < FILM_REPLICATES; r++) {
        parts += part[r];
        total += all[r];
    }
    *share = total > 0 ? parts / total : 0;
    for (int r = 0; r < FILM_REPLICATES; r++) {
        const double off = part[r] - *share * all[r];
        square += off * off;
    }
    const double n = FILM_REPLICATES;
    *error = total > 0 ? __builtin_sqrt(square * n / (n - 1)) / total : 0;
}

/* Absolute for the time being: mean light of a path. study_light makes shares of them. */
bool study_eye(struct study *t)
{
    struct eye e = {0};
    struct plan_light *to = &t->plan->light;
    const uint32_t places = plan_places(t->plan);
    for (uint32_t i = 0; i < places; i++) {
        if (study_is_halted(t))
            return false;
        for (uint32_t k = 0; k < FILM_REPLICATES; k++)
            follow_from(t, study_place(t->stage, i, SALT), k, &e);
    }
    to->eye_paths = (uint64_t)places * FILM_REPLICATES;
    for (int c = 0; places > 0 && c < PLAN_CLASSES; c++)
        to->found[c] = e.found[c] / (double)to->eye_paths;
    to->direct_paths = e.direct_paths;
    to->whitted_paths = e.whitted_paths;
    share_of(e.beyond_direct, e.all, &to->beyond_direct, &to->beyond_direct_error);
    share_of(e.beyond_whitted, e.all, &to->beyond_whitted, &to->beyond_whitted_error);
    return true;
}
