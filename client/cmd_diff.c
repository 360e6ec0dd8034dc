/* jansson: the tree is owned and released where it is printed.
 * SPDX-License-Identifier: MIT */
#include <jansson.h>
#include <stdio.h>

#include "client/cmd.h"
#include "client/diff.h"
#include "client/exr_read.h"

static const char usage[] =
    "Usage: smalti diff A.exr B.exr [--tolerance T] [--json]\n"
    "How far A is from the reference B: relMSE (mean of (a-b)^2 / (b^2 + e^2) over pixels and\n"
    "R, G, B, e = 1 % of B's mean), the same without the worst 0.1 % of pixels, and the\n"
    "largest difference.\n"
    "\n"
    "  --tolerance T   a relMSE up to T is good enough (without: only identical images are)\n"
    "  --json          one JSON object\n"
    "\n"
    "Exit status: 0 identical or within the tolerance, 1 they differ, 2 wrong usage, 3 a file\n"
    "cannot be compared.\n";

/* JSON has no infinity: null. */
static json_t *number(double v)
{
    json_t *real = json_real(v);
    return real ? real : json_null();
}

static void print_json(const struct diff *d)
{
    json_t *root =
        json_pack("{s:b, s:o, s:o, s:f, s:[i, i], s:s%, s:f, s:f}", "identical", d->identical,
                  "relmse", number(d->relmse), "relmse_99_9", number(d->relmse_999), "largest",
                  d->largest, "at", (int)d->x_px, (int)d->y_px, "channel", &d->channel, (size_t)1,
                  "a", d->x_value, "b", d->y_value);
    if (root)
        json_dumpf(root, stdout, JSON_REAL_PRECISION(9));
    putchar('\n');
    json_decref(root);
}

static void print_text(const struct diff *d)
{
    printf("%s\n", d->identical ? "identical" : "different");
    printf("relMSE       %.6g\nrelMSE-99.9  %.6g\n", d->relmse, d->relmse_999);
    if (d->largest > 0)
        printf("largest      %.6g at (%u, %u) %c: %.9g, %.9g\n", d->largest, d->x_px, d->y_px,
               d->channel, d->x_value, d->y_value);
}

int cmd_diff(int argc, char *const *args)
{
    double tolerance = -1;
    bool json = false;
    const struct flags_entry flags[] = {
        {.name = "tolerance", .kind = FLAGS_NUMBER, .value = &tolerance, .most = 1e300},
        {.name = "json", .kind = FLAGS_SWITCH, .value = &json},
    };
    const struct cmd_spec spec = {"diff", usage, flags, countof(flags), 2, 2};
    const char *files[2];
    size_t operands;
    int status;
    if (!cmd_parse(&spec, argc, args, files, &operands, &status))
        return status;

    struct arena arena = {0};
    struct image a, b;
    struct diff d;
    struct err err;
    if (!exr_read(&a, files[0], &arena, &err) || !exr_read(&b, files[1], &arena, &err) ||
        !diff_images(&a, &b, &arena, &d, &err)) {
        fprintf(stderr, "smalti: %s\n", err.text);
        status = CMD_INPUT;
    } else {
        (json ? print_json : print_text)(&d);
        status = d.identical || d.relmse <= tolerance ? CMD_OK : CMD_FAILED;
    }
    arena_release(&arena);
    return status;
}
