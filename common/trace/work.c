/* SPDX-License-Identifier: MIT */
#include "common/trace/work.h"

#include "common/trace/bvh_cost.h"
#include "common/trace/light8.h"

/* Per visit of the tree, each ray being as many visits longer as its beginning and end are worth.
 */
#define RAY_ENDS           3
#define CAMERA_VISIT       11
#define BOUNCE_VISIT       26
#define SHADOW_VISIT       23
#define SHADOW_VISIT_ALONE 18 /* the light is sampled and the ray made for one path alone */
#define PICK_STEP          14 /* of the search among lights */

#define VERTEX_IN_LANES 57
#define VERTEX_ALONE    148 /* plain, but for its lights */
#define VERTEX_OTHER    440

static const uint32_t of_sampler[] = {
    [SAMPLER_SOBOL] = 0, [SAMPLER_INDEPENDENT] = 35, [SAMPLER_STRATIFIED] = 88};

static uint32_t pick_steps(const struct stage *s)
{
    uint32_t steps = 0;
    while (s->emitters.count >> steps)
        steps++;
    return steps;
}

struct stage_prices work_prices(const struct stage *s)
{
    const bool lanes = s->emitters.count == 0 || light8_can(s);
    const double visits = RAY_ENDS + bvh_cost_of_ray(s);
    const uint32_t numbers = of_sampler[s->settings.sampler];
    return (struct stage_prices){
        .camera_ray = (uint32_t)(CAMERA_VISIT * visits),
        .bounce_ray = (uint32_t)(BOUNCE_VISIT * visits),
        .shadow_ray = (uint32_t)((lanes ? SHADOW_VISIT : SHADOW_VISIT_ALONE) * visits) +
                      (lanes ? 0 : PICK_STEP * pick_steps(s)),
        .plain_vertex = (lanes ? VERTEX_IN_LANES : VERTEX_ALONE) + numbers,
        .other_vertex = VERTEX_OTHER + numbers,
    };
}

uint64_t work_units(const struct stage *s, const struct film_work *w)
{
    const struct stage_prices *p = &s->prices;
    return w->camera_rays * p->camera_ray + w->bounce_rays * p->bounce_ray +
           w->shadow_rays * p->shadow_ray + w->plain_vertices * p->plain_vertex +
           w->other_vertices * p->other_vertex;
}
