/* SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <string.h>

#include "client/cmd.h"
#include "client/upload.h"
#include "client/watch.h"

static const char usage[] =
    "Usage: smalti submit SCENE [OPTION]...\n"
    "Sends a scene to a coordinator, after the mesh and image files it does not have yet, and "
    "prints\n"
    "the job's id.\n"
    "\n"
    "  --server URL     ($SMALTI_SERVER, or http://127.0.0.1:7080)\n"
    "  --priority N     -100 to 100, higher first (0)\n"
    "  --wait           follow the job until it ends; Ctrl-C leaves it running\n"
    "  --json           the job as JSON, with --wait a line per change\n"
    "\n"
    "Exit status: 0 accepted (with --wait: done), 1 the job failed or was cancelled, 2 wrong\n"
    "usage, 3 the scene is not valid, 4 the coordinator does not answer, 130 interrupted.\n";

static int submit(struct remote *remote, const struct scene_disk *scene, int32_t priority,
                  bool json, bool wait, struct arena *arena)
{
    struct remote_job job;
    struct buf answer = {0};
    struct err err;
    const char *document = scene_disk_send(scene, arena);
    int status = CMD_OK;
    if (!upload_assets(remote, scene, &err) ||
        !remote_submit(remote, document, strlen(document), priority, &job, &answer, &err)) {
        status = cmd_fail(&err);
    } else {
        if (!json)
            puts(job.id);
        else if (!wait)
            printf("%.*s\n", (int)answer.size, (const char *)answer.data);
        fflush(stdout);
        if (wait)
            status = cmd_follow(remote, job.id, json, false);
        if (status == CMD_INTERRUPTED)
            fprintf(stderr, "smalti: job %s goes on\n", job.id);
    }
    buf_release(&answer);
    return status;
}

int cmd_submit(int argc, char *const *args)
{
    const char *server = NULL, *file;
    int32_t priority = 0;
    bool wait = false, json = false;
    const struct flags_entry flags[] = {
        {.name = "server", .kind = FLAGS_TEXT, .value = &server},
        {.name = "priority", .kind = FLAGS_SIGNED, .value = &priority, .least = -100, .most = 100},
        {.name = "wait", .kind = FLAGS_SWITCH, .value = &wait},
        {.name = "json", .kind = FLAGS_SWITCH, .value = &json},
    };
    const struct cmd_spec spec = {"submit", usage, flags, countof(flags), 1, 1};
    size_t operands;
    int status;
    if (!cmd_parse(&spec, argc, args, &file, &operands, &status))
        return status;

    struct arena arena = {0};
    struct scene_disk scene;
    struct scene_errors errors;
    struct remote remote;
    uint32_t unread;
    if (!scene_disk_open(&scene, file, &arena, &errors) ||
        !scene_disk_load(&scene, &arena, &unread, &errors)) {
        status = cmd_fail_scene(file, &errors);
    } else if (cmd_open(&remote, server, &status)) {
        cmd_warn_scene(file, &scene.scene);
        if (wait)
            watch_block();
        status = submit(&remote, &scene, priority, json, wait, &arena);
        remote_close(&remote);
    }
    arena_release(&arena);
    return status;
}
