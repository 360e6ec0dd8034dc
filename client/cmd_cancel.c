/* SPDX-License-Identifier: MIT */
#include "client/cmd.h"
#include "client/remote.h"

static const char usage[] =
    "Usage: smalti cancel ID [--server URL]\n"
    "Ends a job; its image so far stays.\n"
    "\n"
    "  --server URL     ($SMALTI_SERVER, or http://127.0.0.1:7080)\n"
    "\n"
    "Exit status: 0 cancelled, 1 no such job, or it has ended, 2 wrong usage, 4 the\n"
    "coordinator does not answer.\n";

int cmd_cancel(int argc, char *const *args)
{
    const char *server = NULL, *id = NULL;
    const struct flags_entry flags[] = {{.name = "server", .kind = FLAGS_TEXT, .value = &server}};
    const struct cmd_spec spec = {"cancel", usage, flags, countof(flags), 1, 1};
    struct remote remote;
    struct remote_job job;
    struct err err;
    size_t operands;
    int status;
    if (!cmd_parse(&spec, argc, args, &id, &operands, &status))
        return status;
    if (!cmd_check_id(id))
        return CMD_USAGE;
    if (!cmd_open(&remote, server, &status))
        return status;
    if (!remote_cancel(&remote, id, &job, &err))
        status = cmd_fail(&err);
    remote_close(&remote);
    return status;
}
