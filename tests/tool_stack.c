/* Makes common/trace/stack_table.c: tool_stack >common/trace/stack_table.c
 * SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "tests/stack_make.h"

int main(void)
{
    puts("/* Made by tests/tool_stack.c.\n * SPDX-License-Identifier: MIT */\n"
         "#include \"common/trace/stack.h\"\n\n/* clang-format off */\n"
         "const uint16_t stack_table[STACK_LOBES][STACK_WIDTHS][STACK_COSINES][STACK_CELLS] = {");
    for (int lobe = 0; lobe < STACK_LOBES; lobe++) {
        puts("    {");
        for (int w = 0; w < STACK_WIDTHS; w++) {
            printf("        {");
            for (int z = 0; z < STACK_COSINES; z++) {
                uint16_t row[STACK_CELLS];
                stack_make_row((enum stack_lobe)lobe, w, z, row);
                printf("%s{", z % 4 == 3 ? "\n         " : "");
                for (int j = 0; j < STACK_CELLS; j++)
                    printf("%s%d", j ? ", " : "", row[j]);
                printf("}%s", z + 1 < STACK_COSINES ? ", " : "");
            }
            puts("},");
        }
        puts("    },");
    }
    puts("};\n/* clang-format on */");
    return 0;
}
