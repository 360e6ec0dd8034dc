/* SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "client/cmd.h"
#include "client/watch.h"

static const char usage[] =
    "Usage: smalti watch ID [--server URL] [--json]\n"
    "Follows a job until it ends; on a terminal with the curve of its error. Ctrl-C ends the\n"
    "watching, not the job.\n"
    "\n"
    "  --server URL     ($SMALTI_SERVER, or http://127.0.0.1:7080)\n"
    "  --json           a line of JSON on stdout for every change\n"
    "\n"
    "Exit status: 0 done, 1 failed, cancelled or no such job, 2 wrong usage, 4 the\n"
    "coordinator does not answer for a minute, 130 interrupted.\n";

int cmd_watch(int argc, char *const *args)
{
    struct cmd_job j = {0};
    bool json = false;
    const struct flags_entry flags[] = {
        {.name = "server", .kind = FLAGS_TEXT, .value = &j.server},
        {.name = "json", .kind = FLAGS_SWITCH, .value = &json},
    };
    const struct cmd_spec spec = {"watch", usage, flags, countof(flags), 1, 1};
    int status;
    if (!cmd_open_job(&j, &spec, argc, args, &status))
        return status;
    watch_block();
    status = cmd_follow(&j.remote, j.id, json, true);
    if (status == CMD_INTERRUPTED)
        fprintf(stderr, "smalti: job %s goes on\n", j.id);
    remote_close(&j.remote);
    return status;
}
