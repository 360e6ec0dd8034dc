/* smalti, the command line: picks the command.
 * SPDX-License-Identifier: MIT */
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "client/cmd.h"

static const char usage[] =
    "Usage: smalti COMMAND [ARGUMENT]...\n"
    "\n"
    "On this machine, nothing to set up:\n"
    "  render SCENE       render to an EXR file, with a coordinator and workers of its own\n"
    "\n"
    "With a coordinator (--server URL, $SMALTI_SERVER, or http://127.0.0.1:7080):\n"
    "  submit SCENE       send a scene and the files it names; prints the job's id\n"
    "  status [ID]        one job, or the newest ones\n"
    "  watch ID           follow a job until it ends\n"
    "  fetch ID           its image so far\n"
    "  cancel ID          end it; its image so far stays\n"
    "  continue ID        take a job that is done on to a smaller error or more samples\n"
    "  replay ID X,Y N    trace one sample of it again, and say where its path went\n"
    "\n"
    "Files:\n"
    "  check SCENE        everything that is wrong with a scene\n"
    "  plan SCENE         which method \"auto\" would render it with, why, and how much work it "
    "is\n"
    "  diff A.exr B.exr   how far A is from B\n"
    "  digest X.exr       SHA-256 of the pixels\n"
    "  chart SCENE        which method is how far off after how much work, as figures\n"
    "\n"
    "smalti COMMAND --help says more. --version prints the version.\n"
    "\n"
    "Exit status: 0 done, 1 the job failed or images differ, 2 wrong usage, 3 invalid input,\n"
    "4 the coordinator does not answer, 5 the system failed, 130 interrupted.\n";

static const struct {
    const char *name;
    int (*run)(int argc, char *const *args);
} commands[] = {
    {"render", cmd_render},     {"submit", cmd_submit}, {"status", cmd_status},
    {"watch", cmd_watch},       {"fetch", cmd_fetch},   {"cancel", cmd_cancel},
    {"check", cmd_check},       {"plan", cmd_plan},     {"diff", cmd_diff},
    {"digest", cmd_digest},     {"chart", cmd_chart},   {"replay", cmd_replay},
    {"continue", cmd_continue},
};

int main(int argc, char **argv)
{
    signal(SIGPIPE, SIG_IGN);
    const char *name = argc > 1 ? argv[1] : "";
    for (size_t i = 0; i < countof(commands); i++)
        if (!strcmp(name, commands[i].name))
            return commands[i].run(argc - 2, argv + 2);
    if (!strcmp(name, "--help") || !strcmp(name, "-h") || !strcmp(name, "help")) {
        fputs(usage, stdout);
        return CMD_OK;
    }
    if (!strcmp(name, "--version")) {
        puts("smalti " SMALTI_VERSION);
        return CMD_OK;
    }
    if (*name)
        fprintf(stderr, "smalti: unknown command '%s'\nTry 'smalti --help'.\n", name);
    else
        fputs(usage, stderr);
    return CMD_USAGE;
}
