/* SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "client/cmd.h"
#include "client/exr_read.h"

static const char usage[] =
    "Usage: smalti digest X.exr ...\n"
    "Prints the SHA-256 of the file's pixels: of every channel's name, type and values and\n"
    "the size of the image. Attributes and compression do not take part, so equal images have\n"
    "equal digests. With several files each line ends with the file's name.\n"
    "Exit status: 0 printed, 2 wrong usage, 3 a file is not an image.\n";

enum { FILES_MOST = 1024 };

static bool digest_of(const char *file, char hex[HASH_HEX], struct err *err)
{
    struct arena arena = {0};
    struct image image;
    const bool ok = exr_read(&image, file, &arena, err);
    if (ok)
        image_digest(&image, hex);
    arena_release(&arena);
    return ok;
}

int cmd_digest(int argc, char *const *args)
{
    const struct cmd_spec spec = {
        .name = "digest", .usage = usage, .operand_least = 1, .operand_most = FILES_MOST};
    const char *files[FILES_MOST];
    size_t count;
    int status;
    if (!cmd_parse(&spec, argc, args, files, &count, &status))
        return status;
    for (size_t i = 0; i < count; i++) {
        char hex[HASH_HEX];
        struct err err;
        if (!digest_of(files[i], hex, &err)) {
            fprintf(stderr, "smalti: %s\n", err.text);
            status = CMD_INPUT;
        } else {
            printf(count > 1 ? "%s  %s\n" : "%s\n", hex, files[i]);
        }
    }
    return status;
}
