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
    const char *server = NULL, *id = NULL, *output = NULL;
    bool png = false;
    const struct flags_entry flags[] = {
        {.name = "output", .kind = FLAGS_TEXT, .value = &output, .letter = 'o'},
        {.name = "png", .kind = FLAGS_SWITCH, .value = &png},
        {.name = "server", .kind = FLAGS_TEXT, .value = &server},
    };
    const struct cmd_spec spec = {"fetch", usage, flags, countof(flags), 1, 1};
    struct remote remote;
    struct err err;
    size_t operands;
    int status;
    if (!cmd_parse(&spec, argc, args, &id, &operands, &status))
        return status;
    if (!cmd_check_id(id))
        return CMD_USAGE;
    if (!cmd_open(&remote, server, &status))
        return status;
    char name[32];
    snprintf(name, sizeof name, "%s.%s", id, png ? "png" : "exr");
    struct buf image = {0};
    if (!remote_fetch(&remote, id, png ? "preview.png" : "image.exr", &image, &err)) {
        status = cmd_fail(&err);
    } else if (!save_file(output ? output : name, &image, &err)) {
        cmd_fail(&err);
        status = CMD_SYSTEM;
    }
    buf_release(&image);
    remote_close(&remote);
    return status;
}
