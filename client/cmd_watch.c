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
    const char *server = NULL, *id = NULL;
    bool json = false;
    const struct flags_entry flags[] = {
        {.name = "server", .kind = FLAGS_TEXT, .value = &server},
        {.name = "json", .kind = FLAGS_SWITCH, .value = &json},
    };
    const struct cmd_spec spec = {"watch", usage, flags, countof(flags), 1, 1};
    struct remote remote;
    size_t operands;
    int status;
    if (!cmd_parse(&spec, argc, args, &id, &operands, &status))
        return status;
    if (!cmd_check_id(id))
        return CMD_USAGE;
    if (!cmd_open(&remote, server, &status))
        return status;
    watch_block();
    status = cmd_follow(&remote, id, json, true);
    if (status == CMD_INTERRUPTED)
        fprintf(stderr, "smalti: job %s goes on\n", id);
    remote_close(&remote);
    return status;
}
