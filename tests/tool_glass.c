/* Makes common/trace/glass_albedo_table.c: tool_glass >common/trace/glass_albedo_table.c
 * SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "tests/glass_make.h"

static void print_missing(struct glass_albedo_table *t, int side, int ior)
{
    for (int w = 0; w < GLASS_ALBEDO_WIDTHS; w++) {
        printf(w ? "             {" : "            {{");
        for (int h = 0; h < GLASS_ALBEDO_HEIGHTS; h++) {
            t->missing[side][ior][w][h] = glass_make_missing(side, ior, w, h);
            printf("%s%d", h ? ", " : "", t->missing[side][ior][w][h]);
        }
        puts(w + 1 < GLASS_ALBEDO_WIDTHS ? "}," : "}},");
    }
}

static void print_means(const struct glass_albedo_table *t, int side)
{
    puts("        {");
    for (int n = 0; n < GLASS_ALBEDO_IORS; n++) {
        printf("            {");
        for (int w = 0; w < GLASS_ALBEDO_WIDTHS; w++)
            printf("%s%.9gf", w ? ", " : "", (double)glass_make_mean(t, side, n, w));
        puts("},");
    }
    puts("        },");
}

int main(void)
{
    static struct glass_albedo_table t;
    puts("/* Made by tests/tool_glass.c.\n * SPDX-License-Identifier: MIT */\n"
         "#include \"common/trace/glass_albedo.h\"\n\n/* clang-format off */\n"
         "const struct glass_albedo_table glass_albedo_table = {\n    .missing = {");
    for (int side = 0; side < 2; side++) {
        puts("        {");
        for (int n = 0; n < GLASS_ALBEDO_IORS; n++)
            print_missing(&t, side, n);
        puts("        },");
    }
    puts("    },\n    .mean = {");
    for (int side = 0; side < 2; side++)
        print_means(&t, side);
    puts("    },\n};\n/* clang-format on */");
    return 0;
}
