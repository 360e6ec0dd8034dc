/* Makes common/trace/sheen_table.c: tool_sheen >common/trace/sheen_table.c
 * SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "tests/sheen_make.h"

static void print_row(const float row[], int count)
{
    printf("        {");
    for (int k = 0; k < count; k++)
        printf("%s%.8ef", k ? ", " : "", (double)row[k]);
    puts("},");
}

int main(void)
{
    static struct sheen_table t;
    for (int i = 0; i < SHEEN_WIDTHS; i++)
        for (int k = 0; k < SHEEN_COSINES; k++)
            t.albedo[i][k] = sheen_make_entry(i, k);
    for (int i = 0; i < SHEEN_WIDTHS; i++)
        t.mean[i] = sheen_make_mean(&t, i);
    puts("/* Made by tests/tool_sheen.c.\n * SPDX-License-Identifier: MIT */\n"
         "#include \"common/trace/sheen.h\"\n\n/* clang-format off */\n"
         "const struct sheen_table sheen_table = {\n    .albedo = {");
    for (int i = 0; i < SHEEN_WIDTHS; i++)
        print_row(t.albedo[i], SHEEN_COSINES);
    puts("    },\n    .mean =");
    print_row(t.mean, SHEEN_WIDTHS);
    puts("};\n/* clang-format on */");
    return 0;
}
