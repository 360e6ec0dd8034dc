/* Makes common/trace/inside_table.c: tool_inside >common/trace/inside_table.c
 * SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "tests/inside_make.h"

static void print_parts(struct inside_table *t, int n, int w)
{
    printf(w ? "         {" : "        {{");
    for (int h = 0; h < INSIDE_HEIGHTS; h++) {
        uint16_t *row = t->part[n][w][h];
        inside_make_row(n, w, h, row);
        printf(h ? ", {" : "{");
        for (int k = 0; k < INSIDE_PARTS; k++)
            printf("%s%d", k ? ", " : "", row[k]);
        printf("}");
    }
    puts(w + 1 < INSIDE_WIDTHS ? "}," : "}},");
}

static void print_floats(const float *x, int n, bool last)
{
    for (int k = 0; k < n; k++)
        printf("%s%.8ef", k ? ", " : "", (double)x[k]);
    puts(last ? "}}," : "},");
}

static void print_means(const struct inside_table *t, int n, int w)
{
    float mean[INSIDE_PARTS];
    inside_make_mean(t, n, w, mean);
    printf(w ? "         {" : "        {{");
    print_floats(mean, INSIDE_PARTS, w + 1 == INSIDE_WIDTHS);
}

static void print_several(int n, int w)
{
    float several[INSIDE_CELLS];
    inside_make_several(n, w, several);
    printf(w ? "         {" : "        {{");
    print_floats(several, INSIDE_CELLS, w + 1 == INSIDE_WIDTHS);
}

int main(void)
{
    static struct inside_table t;
    enum { ALL = INSIDE_IORS * INSIDE_WIDTHS };
    puts("/* Made by tests/tool_inside.c.\n * SPDX-License-Identifier: MIT */\n"
         "#include \"common/trace/inside.h\"\n\n/* clang-format off */\n"
         "const struct inside_table inside_table = {\n    .part = {");
    for (int i = 0; i < ALL; i++)
        print_parts(&t, i / INSIDE_WIDTHS, i % INSIDE_WIDTHS);
    puts("    },\n    .mean = {");
    for (int i = 0; i < ALL; i++)
        print_means(&t, i / INSIDE_WIDTHS, i % INSIDE_WIDTHS);
    puts("    },\n    .several = {");
    for (int i = 0; i < ALL; i++)
        print_several(i / INSIDE_WIDTHS, i % INSIDE_WIDTHS);
    puts("    },\n};\n/* clang-format on */");
    return 0;
}
