/* The assembler includes the files, by their paths from the root of the source tree, where the
 * compiler is run; the Makefile names them as prerequisites.
 * SPDX-License-Identifier: MIT */
#include "server/static.h"

#include <string.h>

#define EMBED(name, file)                                                                          \
    __asm__(".pushsection .rodata\n"                                                               \
            ".global static_" #name "_begin\n.global static_" #name "_end\n"                       \
            ".type static_" #name "_begin, @object\n.type static_" #name "_end, @object\n"         \
            "static_" #name "_begin:\n.incbin \"" file "\"\nstatic_" #name "_end:\n.byte 0\n"      \
            ".popsection\n");                                                                      \
    extern const unsigned char static_##name##_begin[], static_##name##_end[]

EMBED(page, "web/index.html");
EMBED(script, "web/app.js");
EMBED(curve, "web/curve.js");
EMBED(style, "web/style.css");
EMBED(schema, "docs/scene.schema.json");

static const struct static_file files[] = {
    {"/", "text/html; charset=utf-8", static_page_begin, static_page_end},
    {"/app.js", "text/javascript; charset=utf-8", static_script_begin, static_script_end},
    {"/curve.js", "text/javascript; charset=utf-8", static_curve_begin, static_curve_end},
    {"/style.css", "text/css; charset=utf-8", static_style_begin, static_style_end},
    {"/v1/schema/scene.json", "application/schema+json", static_schema_begin, static_schema_end},
};

const struct static_file *static_find(const char *path)
{
    for (size_t i = 0; i < countof(files); i++)
        if (!strcmp(files[i].path, path))
            return &files[i];
    return NULL;
}
