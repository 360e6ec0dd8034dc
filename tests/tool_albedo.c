/* tool_albedo - writes common/trace/albedo_table.c: the albedo of GGX facets, by quadrature.
 *
 *     build/bin/tool_albedo >albedo_table.c
 *
 * SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "tests/albedo_make.h"

static void print_shares(const char *name, const uint16_t v[], size_t count)
{
    printf("    .%s = {", name);
    for (size_t i = 0; i < count; i++)
        printf("%s%u,", i % 14 ? " " : "\n        ", v[i]);
    printf("\n    },\n");
}

static void print_means(const char *name, const float v[], size_t count)
{
    printf("    .%s = {", name);
    for (size_t i = 0; i < count; i++)
        printf("%s%.9gf,", i % 6 ? " " : "\n        ", (double)v[i]);
    printf("\n    },\n");
}

int main(void)
{
    static struct albedo_table t;
    for (uint32_t i = 0; i < countof(t.one); i++)
        t.one[i] = albedo_make_one(i);
    for (uint32_t i = 0; i < countof(t.two); i++)
        t.two[i] = albedo_make_two(i);
    for (uint32_t i = 0; i < countof(t.mean_one); i++)
        t.mean_one[i] = albedo_make_mean_one(&t, i);
    for (uint32_t i = 0; i < countof(t.mean_two); i++)
        t.mean_two[i] = albedo_make_mean_two(&t, i);
    printf("/* Made by tests/tool_albedo.c.\n * SPDX-License-Identifier: MIT */\n");
    printf("#include \"common/trace/albedo_table.h\"\n\n/* clang-format off */\n");
    printf("const struct albedo_table albedo_table = {\n");
    print_shares("one", t.one, countof(t.one));
    print_shares("two", t.two, countof(t.two));
    print_means("mean_one", t.mean_one, countof(t.mean_one));
    print_means("mean_two", t.mean_two, countof(t.mean_two));
    printf("};\n");
    return 0;
}
