/* SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "client/cmd.h"
#include "client/exr_read.h"

static const char usage[] =
    "Usage: smalti digest X.exr\n"
    "Prints the SHA-256 of the file's pixels: of every channel's name, type and values and the size\n"
    "of the image. Attributes and compression do not take part, so equal images have equal digests.\n";

int cmd_digest(int argc, char *const *args)
{
    const struct cmd_spec spec = {.name = "digest", .usage = usage, .operand_least = 1, .operand_most = 1};
    const char *file;
    size_t operands;
    int status;
    if (!cmd_parse(&spec, argc, args, &file, &operands, &status))
        return status;
    struct arena arena = {0};
    struct image image;
    struct err err;
    char hex[HASH_HEX];
    if (!exr_read(&image, file, &arena, &err)) {
        fprintf(stderr, "smalti: %s\n", err.text);
        status = CMD_INPUT;
    } else {
        image_digest(&image, hex);
        puts(hex);
    }
    arena_release(&arena);
    return status;
}
