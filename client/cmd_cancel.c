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
    struct cmd_job j = {0};
    const struct flags_entry flags[] = {{.name = "server", .kind = FLAGS_TEXT, .value = &j.server}};
    const struct cmd_spec spec = {"cancel", usage, flags, countof(flags), 1, 1};
    struct remote_job job;
    struct err err;
    int status;
    if (!cmd_open_job(&j, &spec, argc, args, &status))
        return status;
    if (!remote_cancel(&j.remote, j.id, &job, &err))
        status = cmd_fail(&err);
    remote_close(&j.remote);
    return status;
}
