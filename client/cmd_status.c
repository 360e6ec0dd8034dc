/* SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "client/cmd.h"
#include "client/progress.h"

enum { MOST_JOBS = 50 };

static const char usage[] =
    "Usage: smalti status [ID] [--server URL] [--json]\n"
    "One job, or the newest ones.\n"
    "\n"
    "  --server URL     ($SMALTI_SERVER, or http://127.0.0.1:7080)\n"
    "  --json           what the coordinator says, as it says it\n"
    "\n"
    "Exit status: 0 shown, 1 no such job, 2 wrong usage, 4 the coordinator does not answer.\n";

static void print_json(const struct buf *json)
{
    fwrite(json->data, 1, json->size, stdout);
    putchar('\n');
}

static void print_job(const struct remote_job *job)
{
    char text[160];
    progress_text(job, text, sizeof text);
    printf("%s  %-9s %s  %s%s%s\n", job->id, remote_state_name(job->state), text, job->title,
           *job->failure ? "  failed: " : "", job->failure);
}

static int show(struct remote *remote, const char *id, bool json)
{
    static struct remote_job jobs[MOST_JOBS];
    struct buf answer = {0};
    struct err err;
    char etag[80] = "";
    size_t count = 1;
    bool changed;
    const bool good = id ? remote_look(remote, id, etag, &changed, &jobs[0], &answer, &err)
                         : remote_list(remote, jobs, MOST_JOBS, &count, &answer, &err);
    if (good && json)
        print_json(&answer);
    for (size_t i = 0; good && !json && i < count; i++)
        print_job(&jobs[i]);
    buf_release(&answer);
    return good ? CMD_OK : cmd_fail(&err);
}

int cmd_status(int argc, char *const *args)
{
    const char *server = NULL, *id = NULL;
    bool json = false;
    const struct flags_entry flags[] = {
        {.name = "server", .kind = FLAGS_TEXT, .value = &server},
        {.name = "json", .kind = FLAGS_SWITCH, .value = &json},
    };
    const struct cmd_spec spec = {"status", usage, flags, countof(flags), 0, 1};
    struct remote remote;
    size_t operands;
    int status;
    if (!cmd_parse(&spec, argc, args, &id, &operands, &status))
        return status;
    if (operands && !cmd_check_id(id))
        return CMD_USAGE;
    if (!cmd_open(&remote, server, &status))
        return status;
    status = show(&remote, operands ? id : NULL, json);
    remote_close(&remote);
    return status;
}
