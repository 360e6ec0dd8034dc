/* jansson: the tree is owned and released where it is printed.
 * SPDX-License-Identifier: MIT */
#include <jansson.h>
#include <stdio.h>

#include "client/cmd.h"
#include "common/plan.h"
#include "common/scene_disk.h"
#include "common/trace/prep.h"
#include "common/trace/study.h"

static const char usage[] =
    "Usage: smalti plan SCENE [--error E] [--json]\n"
    "Looks at a scene as a job that leaves its method open would, and prints which method it\n"
    "would be rendered with, why, and how much work it will be. Nothing is rendered.\n"
    "\n"
    "  --error E   plan for this error, as in 0.02, in place of the scene's target\n"
    "  --json      all that is known, as one JSON object (docs/plan.md)\n"
    "\n"
    "Exit status: 0 done, 2 wrong usage, 3 the scene is not valid.\n";

static const char *verdict_text(const struct plan_candidate *c)
{
    static const char *const texts[] = {
        [PLAN_CHOSEN] = "chosen",       [PLAN_DEARER] = "not chosen",
        [PLAN_TAILED] = "heavy tail",   [PLAN_INSUFFICIENT] = "not enough",
        [PLAN_RULED_OUT] = "ruled out", [PLAN_ABSENT] = "not there yet",
    };
    return texts[c->verdict];
}

static void print_classes(const struct plan_light *l)
{
    printf("\nlight      found   missed\n");
    for (int c = 0; c < PLAN_CLASSES; c++)
        if (l->found[c] > 0 || l->missed[c] > 0)
            printf("%-10s %5.1f %%  %5.1f %%\n", plan_class_name((enum plan_class)c),
                   100 * l->found[c], 100 * l->missed[c]);
}

static void print_text(const struct plan *p)
{
    const struct plan_candidate *c = &p->candidates[p->chosen];
    printf("method     %s: %s\n", plan_candidate_name(p->chosen), c->why);
    printf("target     %s%g %% RMS\n", p->is_asked ? "" : "(no error asked for) ", 100 * p->error);
    printf("forecast   %.0f samples per pixel, %.3g units of work (%.3g to %.3g)\n",
           p->forecast_spp, p->forecast, p->forecast_low, p->forecast_high);
    printf("planning   %.3g units, %.2f %% of that\n\n", p->studied,
           p->forecast > 0 ? 100 * p->studied / p->forecast : 0);
    for (int k = 0; k < PLAN_CANDIDATES; k++)
        printf("%-14s %-13s %s\n", plan_candidate_name((enum plan_candidate_kind)k),
               verdict_text(&p->candidates[k]), p->candidates[k].why);
    print_classes(&p->light);
    if (c->lacks > p->error / 2)
        printf("\nwarning: %.3g %% of the light cannot be found by any method that smalti has\n",
               100 * c->lacks);
}

static void print_json(const struct plan *p)
{
    struct buf text = {0};
    json_error_t e;
    plan_print(p, &text);
    json_t *root = json_loadb((const char *)text.data, text.size, 0, &e);
    json_dumpf(root, stdout, JSON_INDENT(2));
    putchar('\n');
    json_decref(root);
    buf_release(&text);
}

static bool prepare(const struct scene *scene, struct arena *arena, const struct stage **stage,
                    int *status)
{
    struct arena scratch = {0};
    struct err err;
    const bool good = prep_stage(scene, NULL, arena, &scratch, stage, &err);
    arena_release(&scratch);
    if (!good)
        *status = cmd_fail(&err);
    return good;
}

int cmd_plan(int argc, char *const *args)
{
    bool json = false;
    double error = 0;
    const struct flags_entry flags[] = {
        {.name = "json", .kind = FLAGS_SWITCH, .value = &json},
        {.name = "error", .kind = FLAGS_NUMBER, .value = &error, .least = 1e-5, .most = 1},
    };
    const struct cmd_spec spec = {"plan", usage, flags, countof(flags), 1, 1};
    const char *file;
    size_t operands;
    int status = CMD_OK;
    if (!cmd_parse(&spec, argc, args, &file, &operands, &status))
        return status;
    struct arena arena = {0};
    struct scene_disk scene;
    const struct stage *stage;
    struct plan plan;
    if (cmd_can_trace(&status) && cmd_load_scene(file, &scene, &arena, &status)) {
        scene.scene.settings.integrator = INTEGRATOR_AUTO;
        scene.scene.settings.strategy = STRATEGY_MIS;
        if (error > 0)
            scene.scene.settings.target = (struct scene_target){error, SCENE_MAX_SPP, 0};
        if (prepare(&scene.scene, &arena, &stage, &status)) {
            study_make(stage, NULL, &arena, &plan);
            if (json)
                print_json(&plan);
            else
                print_text(&plan);
        }
    }
    arena_release(&arena);
    return status;
}
