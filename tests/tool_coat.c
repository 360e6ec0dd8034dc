/* Makes common/trace/coat_table.c: tool_coat >common/trace/coat_table.c
 * SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "tests/coat_make.h"

static void print_plane(const struct coat_table *t, int n)
{
    puts("        {");
    for (int i = 0; i < COAT_WIDTHS; i++) {
        printf("            {");
        for (int k = 0; k < COAT_SLOPES; k++)
            printf("%s%d", k ? ", " : "", t->ratio[n][i][k]);
        puts("},");
    }
    puts("        },");
}

int main(void)
{
    static struct coat_table t;
    for (int n = 0; n < COAT_IORS; n++)
        for (int i = 0; i < COAT_WIDTHS; i++)
            for (int k = 0; k < COAT_SLOPES; k++)
                t.ratio[n][i][k] = coat_make_ratio(n, i, k);
    puts("/* Made by tests/tool_coat.c.\n * SPDX-License-Identifier: MIT */\n"
         "#include \"common/trace/coat_table.h\"\n\n/* clang-format off */\n"
         "const struct coat_table coat_table = {\n    .ratio = {");
    for (int n = 0; n < COAT_IORS; n++)
        print_plane(&t, n);
    puts("    },\n    .mean = {");
    for (int n = 0; n < COAT_IORS; n++) {
        printf("        {");
        for (int i = 0; i < COAT_WIDTHS; i++)
            printf("%s%.9gf%s", i % 6 ? ", " : "", (double)coat_make_mean(&t, n, i),
                   i % 6 == 5 ? ",\n         " : "");
        puts("},");
    }
    puts("    },\n};\n/* clang-format on */");
    return 0;
}
