/* SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "client/cmd.h"
#include "client/watch.h"

static const char usage[] =
    "Usage: smalti continue ID [--error E] [--spp N] [OPTION]...\n"
    "Takes a job that is done on to a further target, from where it stands: its image becomes the\n"
    "one of a job that was asked for that at once.\n"
    "\n"
    "  --error E        until the error is at most E (.01: 1 % RMS)\n"
    "  --spp N          until every pixel has N samples; with --error, at most so many\n"
    "  --server URL     ($SMALTI_SERVER, or http://127.0.0.1:7080)\n"
    "  --wait           follow the job until it ends; Ctrl-C leaves it running\n"
    "  --json           with --wait, a line of JSON on stdout for every change\n"
    "\n"
    "Exit status: 0 accepted (with --wait: done), 1 no such job, it is not done, or it has met "
    "that\n"
    "target already (with --wait also: failed, cancelled), 2 wrong usage, 4 the coordinator does "
    "not\n"
    "answer, 130 interrupted.\n";

static int follow(struct remote *remote, const char *id, bool json)
{
    const int status = cmd_follow(remote, id, json, false);
    if (status == CMD_INTERRUPTED)
        fprintf(stderr, "smalti: job %s goes on\n", id);
    return status;
}

static int no_target(void)
{
    fputs("smalti: continue: expected --error, --spp, or both\n"
          "Try 'smalti continue --help'.\n",
          stderr);
    return CMD_USAGE;
}

int cmd_continue(int argc, char *const *args)
{
    struct cmd_job j = {0};
    struct remote_target target = {0};
    bool wait = false, json = false;
    const struct flags_entry flags[] = {
        {.name = "error", .kind = FLAGS_NUMBER, .value = &target.error, .least = 1e-5, .most = 1},
        {.name = "spp", .kind = FLAGS_COUNT, .value = &target.spp, .least = 1, .most = 1 << 24},
        {.name = "server", .kind = FLAGS_TEXT, .value = &j.server},
        {.name = "wait", .kind = FLAGS_SWITCH, .value = &wait},
        {.name = "json", .kind = FLAGS_SWITCH, .value = &json},
    };
    const struct cmd_spec spec = {"continue", usage, flags, countof(flags), 1, 1};
    struct err err;
    int status;
    if (!cmd_open_job(&j, &spec, argc, args, &status))
        return status;
    if (wait)
        watch_block();
    if (!(target.error > 0) && !target.spp)
        status = no_target();
    else if (!remote_continue(&j.remote, j.id, &target, &err))
        status = cmd_fail(&err);
    else if (wait)
        status = follow(&j.remote, j.id, json);
    remote_close(&j.remote);
    return status;
}
