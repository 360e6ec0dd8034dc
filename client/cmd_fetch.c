/* SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "client/cmd.h"
#include "client/remote.h"
#include "client/save.h"

static const char usage[] =
    "Usage: smalti fetch ID [-o FILE] [--png] [--server URL]\n"
    "The best image of a job so far, whether it has ended or not.\n"
    "\n"
    "  -o, --output FILE   where it goes (ID.exr or ID.png, here)\n"
    "  --png               the preview instead: 8 bits, sRGB\n"
    "  --server URL        ($SMALTI_SERVER, or http://127.0.0.1:7080)\n"
    "\n"
    "Exit status: 0 fetched, 1 no such job or no image yet, 2 wrong usage, 4 the coordinator\n"
    "does not answer, 5 the file cannot be written.\n";

int cmd_fetch(int argc, char *const *args)
{
    struct cmd_job j = {0};
    const char *output = NULL;
    bool png = false;
    const struct flags_entry flags[] = {
        {.name = "output", .kind = FLAGS_TEXT, .value = &output, .letter = 'o'},
        {.name = "png", .kind = FLAGS_SWITCH, .value = &png},
        {.name = "server", .kind = FLAGS_TEXT, .value = &j.server},
    };
    const struct cmd_spec spec = {"fetch", usage, flags, countof(flags), 1, 1};
    struct err err;
    int status;
    if (!cmd_open_job(&j, &spec, argc, args, &status))
        return status;
    char name[32];
    snprintf(name, sizeof name, "%s.%s", j.id, png ? "png" : "exr");
    struct buf image = {0};
    if (!remote_fetch(&j.remote, j.id, png ? "preview.png" : "image.exr", &image, &err)) {
        status = cmd_fail(&err);
    } else if (!save_file(output ? output : name, &image, &err)) {
        cmd_fail(&err);
        status = CMD_SYSTEM;
    }
    buf_release(&image);
    remote_close(&j.remote);
    return status;
}
