/* SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <string.h>

#include "client/cmd.h"
#include "client/local.h"
#include "client/progress.h"
#include "client/save.h"
#include "client/upload.h"
#include "client/watch.h"
#include "common/clock.h"
#include "common/tile.h"

static const char usage[] =
    "Usage: smalti render SCENE [-o OUT.exr] [OPTION]...\n"
    "Renders a scene on this machine with a coordinator and workers of its own.\n"
    "\n"
    "  -o, --output FILE   where the image goes (SCENE's name with .exr, here)\n"
    "  --png FILE          the picture beside it: 8 bits, sRGB (none is kept)\n"
    "  --spp N             stop at N samples per pixel\n"
    "  --error E           stop when the estimated relative error is below E, as in 0.02\n"
    "  --seconds S         stop after S seconds\n"
    "                      Each of these three replaces the scene's whole target; of several the\n"
    "                      first one reached counts\n"
    "  --workers N         worker processes (1)\n"
    "  --threads N         threads of each (the cores there are, divided among the workers)\n"
    "  --tile N            side of a tile in pixels, 8 to 256 (64)\n"
    "  --cache DIR         keep meshes and prepared scenes there: the same scene starts at once\n"
    "                      when it comes again (none is kept)\n"
    "  --quiet             no progress\n"
    "  --json              at the end one JSON object on stdout: the job, and where its image is\n"
    "\n"
    "Ctrl-C ends it and leaves the best image so far.\n"
    "Exit status: 0 done, 1 failed, 2 wrong usage, 3 the scene is not valid, 5 the system\n"
    "failed, 130 interrupted (the image is there unless nothing had been rendered).\n";

struct render {
    const char *scene_file, *output;
    const char *png; /* or NULL */
    char output_default[512];
    struct scene_target target; /* spp 0: not given */
    struct local_plan plan;
    bool quiet, json;

    struct arena arena;
    struct scene_disk scene;
    struct local farm;
    struct remote remote;
    struct remote_job job;
    struct progress progress;
};

/* "scenes/box.json" -> "box.exr" */
static void choose_output(struct render *r)
{
    const char *slash = strrchr(r->scene_file, '/');
    const char *name = slash ? slash + 1 : r->scene_file;
    const char *dot = strrchr(name, '.');
    const int length = dot && dot > name ? (int)(dot - name) : (int)strlen(name);
    snprintf(r->output_default, sizeof r->output_default, "%.*s.exr", (int)min_i64(length, 500),
             name);
    if (!r->output)
        r->output = r->output_default;
}

static bool parse(struct render *r, int argc, char *const *args, int *status)
{
    struct scene_target *target = &r->target;
    struct local_plan *plan = &r->plan;
    const struct flags_entry flags[] = {
        {"output", FLAGS_TEXT, &r->output, 0, 0, 'o'},
        {"png", FLAGS_TEXT, &r->png, 0, 0, 0},
        {"spp", FLAGS_COUNT, &target->spp, 1, SCENE_MAX_SPP, 0},
        {"error", FLAGS_NUMBER, &target->error, 1e-5, 1, 0},
        {"seconds", FLAGS_NUMBER, &target->seconds, .01, 1e7, 0},
        {"workers", FLAGS_COUNT, &plan->workers, 1, LOCAL_MAX_WORKERS, 0},
        {"threads", FLAGS_COUNT, &plan->threads, 1, 1024, 0},
        {"tile", FLAGS_COUNT, &plan->tile_px, TILE_MIN_PX, TILE_MAX_PX, 0},
        {"cache", FLAGS_TEXT, &plan->cache, 0, 0, 0},
        {"quiet", FLAGS_SWITCH, &r->quiet, 0, 0, 'q'},
        {"json", FLAGS_SWITCH, &r->json, 0, 0, 0},
    };
    const struct cmd_spec spec = {"render", usage, flags, countof(flags), 1, 1};
    size_t operands;
    r->plan.workers = 1;
    if (!cmd_parse(&spec, argc, args, &r->scene_file, &operands, status))
        return false;
    if (plan->tile_px && !tile_px_is_sane(plan->tile_px)) {
        fprintf(stderr, "smalti render: --tile: expected a multiple of %d, got %u\n", TILE_STEP_PX,
                plan->tile_px);
        *status = CMD_USAGE;
        return false;
    }
    if (!r->plan.threads)
        r->plan.threads = max_u32(local_cores() / r->plan.workers, 1);
    choose_output(r);
    return true;
}

static bool load(struct render *r, int *status)
{
    struct err err;
    if (!cmd_load_scene(r->scene_file, &r->scene, &r->arena, status))
        return false;
    cmd_warn_scene(r->scene_file, &r->scene.scene);
    if (save_possible(r->output, &err) && (!r->png || save_possible(r->png, &err)))
        return true;
    cmd_fail(&err);
    *status = CMD_SYSTEM;
    return false;
}

static bool submit(struct render *r, struct err *err)
{
    const char *json = scene_disk_send(&r->scene, &r->arena);
    if (r->target.spp || r->target.error > 0 || r->target.seconds > 0)
        json = upload_retarget(json, &r->target, &r->arena);
    return remote_open(&r->remote, r->farm.url, err) && upload_assets(&r->remote, &r->scene, err) &&
           remote_submit(&r->remote, json, strlen(json), 0, &r->job, NULL, err);
}

static bool save(struct render *r, const char *image, const char *path, struct err *err)
{
    struct buf bytes = {0};
    const bool good =
        remote_fetch(&r->remote, r->job.id, image, &bytes, err) && save_file(path, &bytes, err);
    buf_release(&bytes);
    return good;
}

/* False: there is none yet, or it cannot be had or written. */
static bool save_image(struct render *r, struct err *err)
{
    return save(r, "image.exr", r->output, err) && (!r->png || save(r, "preview.png", r->png, err));
}

static int fail(struct render *r, const struct err *err)
{
    progress_end(&r->progress);
    fprintf(stderr, "smalti: %s\n", err->text);
    local_show_logs(&r->farm, stderr);
    return CMD_SYSTEM;
}

static int interrupt(struct render *r)
{
    struct err err;
    progress_end(&r->progress);
    if (!remote_cancel(&r->remote, r->job.id, &r->job, &err) && err.code != ERR_CONFLICT)
        return fail(r, &err);
    if (save_image(r, &err))
        fprintf(stderr, "smalti: interrupted; %s has what there was\n", r->output);
    else if (err.code == ERR_NOT_FOUND)
        fprintf(stderr, "smalti: interrupted before there was an image\n");
    else
        return fail(r, &err);
    return CMD_INTERRUPTED;
}

static void print_end(const struct render *r, const struct buf *json)
{
    if (r->json) {
        /* The job's object with one more member in front. */
        const char *brace = memchr(json->data, '{', json->size);
        const size_t rest = brace ? json->size - (size_t)(brace + 1 - (const char *)json->data) : 0;
        printf("{\"output\": \"");
        for (const char *c = r->output; *c; c++)
            if (*c == '"' || *c == '\\')
                printf("\\%c", *c);
            else if ((unsigned char)*c < ' ')
                printf("\\u%04x", (unsigned)*c);
            else
                putchar(*c);
        printf("\", %.*s\n", (int)rest, brace ? brace + 1 : "");
    } else if (!r->quiet) {
        char samples[40];
        progress_samples(&r->job, samples, sizeof samples);
        fprintf(stderr, "%s: %s", r->output, samples);
        if (r->job.error >= 0)
            fprintf(stderr, ", error %.3g", r->job.error);
        fprintf(stderr, ", %.1f s, digest %.16s\n", r->job.elapsed_seconds, r->job.digest);
    }
}

static int finish(struct render *r, const struct watch *watch)
{
    struct err err;
    struct buf json = {0};
    char etag[80] = "";
    bool changed;
    int status = watch_verdict(watch);
    r->job = watch->job;
    if (status != CMD_OK)
        local_show_logs(&r->farm, stderr);
    else if (!save_image(r, &err) ||
             !remote_look(&r->remote, r->job.id, etag, &changed, &r->job, &json, &err))
        status = fail(r, &err);
    else
        print_end(r, &json);
    buf_release(&json);
    return status;
}

static int follow(struct render *r)
{
    struct err err;
    struct watch watch = {
        .remote = &r->remote, .id = r->job.id, .progress = &r->progress, .nap_ms = 100};
    for (;;) {
        const enum watch_event event = watch_step(&watch, &err);
        switch (event) {
        case WATCH_RUNNING:
            if (!local_check(&r->farm, &err))
                return fail(r, &err);
            break;
        case WATCH_OVER:
            progress_end(&r->progress);
            return finish(r, &watch);
        case WATCH_SIGNAL:
            return interrupt(r);
        case WATCH_LOST:
            return fail(r, &err);
        }
    }
}

int cmd_render(int argc, char *const *args)
{
    struct render r = {0};
    struct err err;
    int status;
    if (!parse(&r, argc, args, &status))
        return status;
    if (load(&r, &status)) {
        watch_block();
        r.progress = progress_make(stderr, r.quiet);
        const bool started = local_start(&r.farm, &r.plan, &err);
        if (started && submit(&r, &err))
            status = follow(&r);
        else
            status = fail(&r, &err);
        remote_close(&r.remote);
        local_stop(&r.farm);
    }
    arena_release(&r.arena);
    return status;
}
