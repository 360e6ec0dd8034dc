/* flags.c: what is understood, and that everything else is refused with the reason.
 * SPDX-License-Identifier: MIT */
#include "common/flags.h"

#include <string.h>

#include "tests/tap.h"

struct values {
    bool quiet;
    const char *output;
    uint32_t spp;
    int32_t priority;
    uint64_t bytes;
    double error;
    const char *operands[2];
    size_t operand_count;
};

static bool parse(struct values *v, struct err *err, int argc, const char *const *args)
{
    *v = (struct values){.spp = 64};
    const struct flags_entry table[] = {
        {.name = "quiet", .kind = FLAGS_SWITCH, .value = &v->quiet, .letter = 'q'},
        {.name = "output", .kind = FLAGS_TEXT, .value = &v->output, .letter = 'o'},
        {.name = "spp", .kind = FLAGS_COUNT, .value = &v->spp, .least = 1, .most = 1000},
        {.name = "priority",
         .kind = FLAGS_SIGNED,
         .value = &v->priority,
         .least = -100,
         .most = 100},
        {.name = "cache-bytes", .kind = FLAGS_BYTES, .value = &v->bytes, .most = 0x1p53},
        {.name = "error", .kind = FLAGS_NUMBER, .value = &v->error, .least = 1e-5, .most = 1},
    };
    char copies[8][64];
    char *list[8];
    for (int i = 0; i < argc; i++) {
        strcpy(copies[i], args[i]);
        list[i] = copies[i];
    }
    static char kept[2][64];
    const bool good =
        flags_parse(table, countof(table), argc, list, v->operands, 2, &v->operand_count, err);
    for (size_t i = 0; good && i < v->operand_count; i++)
        v->operands[i] = strcpy(kept[i], v->operands[i]);
    static char output[64];
    v->output = good && v->output ? strcpy(output, v->output) : NULL;
    return good;
}

#define PARSE(v, e, ...)                                                                           \
    parse(v, e, (int)countof(((const char *[]){__VA_ARGS__})), (const char *[]){__VA_ARGS__})

static void understood(void)
{
    struct values v;
    struct err e;
    ok(PARSE(&v, &e, "a.json", "--spp", "16", "-q", "-o", "x.exr") && v.spp == 16 && v.quiet &&
           !strcmp(v.output, "x.exr") && v.operand_count == 1 && !strcmp(v.operands[0], "a.json"),
       "flags of every form around an operand");
    ok(PARSE(&v, &e, "--spp=1000", "--error=1e-2") && v.spp == 1000 && v.error == 0.01,
       "a value behind an equals sign; limits belong to the range");
    ok(PARSE(&v, &e, "--priority", "-100") && v.priority == -100, "a negative value is a value");
    ok(PARSE(&v, &e, "--cache-bytes", "3M") && v.bytes == 3u << 20, "a suffix is a power of 1024");
    ok(PARSE(&v, &e, "--", "--spp", "-q") && v.operand_count == 2 && v.spp == 64,
       "behind -- everything is an operand");
    ok(PARSE(&v, &e, "-") && v.operand_count == 1, "a single dash is an operand");
}

static void refused(void)
{
    static const struct {
        const char *args[2];
        const char *text;
    } cases[] = {
        {{"--spq", "3"}, "unknown flag '--spq'; did you mean --spp?"},
        {{"--unheard-of", ""}, "unknown flag '--unheard-of'"},
        {{"-x", ""}, "unknown flag '-x'"},
        {{"--quiet=1", ""}, "--quiet: takes no value, got '1'"},
        {{"--spp", "0"}, "--spp: expected a whole number from 1 to 1000, got '0'"},
        {{"--spp", "1001"}, "--spp: expected a whole number from 1 to 1000, got '1001'"},
        {{"--spp", "1.5"}, "--spp: expected a whole number from 1 to 1000, got '1.5'"},
        {{"--spp", "0x10"}, "--spp: expected a whole number from 1 to 1000, got '0x10'"},
        {{"--spp", ""}, "--spp: expected a whole number from 1 to 1000, got ''"},
        {{"--spp", "4k"}, "--spp: expected a whole number from 1 to 1000, got '4k'"},
        {{"--error", "nan"}, "--error: expected a number from 1e-05 to 1, got 'nan'"},
        {{"--error", "0x1p-3"}, "--error: expected a number from 1e-05 to 1, got '0x1p-3'"},
        {{"--error", " 1"}, "--error: expected a number from 1e-05 to 1, got ' 1'"},
        {{"--error", "0.1x"}, "--error: expected a number from 1e-05 to 1, got '0.1x'"},
        {{"--output", ""}, "--output: expected a value, got ''"},
    };
    struct values v;
    struct err e;
    for (size_t i = 0; i < countof(cases); i++)
        if (!ok(!parse(&v, &e, 2, cases[i].args) && !strcmp(e.text, cases[i].text),
                "refused: %s %s", cases[i].args[0], cases[i].args[1]))
            diag("got: %s", e.text);
    ok(!PARSE(&v, &e, "--spp") && !strcmp(e.text, "--spp: its value is missing"),
       "refused: a flag without its value");
    ok(!PARSE(&v, &e, "a", "b", "c") && !strcmp(e.text, "unexpected argument 'c'"),
       "refused: an operand too many");
}

int main(void)
{
    understood();
    refused();
    return tap_done();
}
