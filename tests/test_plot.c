/* plot.c: what a curve looks like in characters, and what hostile numbers do to it.
 * SPDX-License-Identifier: MIT */
#include "client/plot.h"

#include <math.h>
#include <string.h>

#include "tests/tap.h"

/* Lines 0 to 9 are rows, 10 columns in. */
static char at(const char *text, int row, int column)
{
    for (; row; row--)
        text = strchr(text, '\n') + 1;
    return text[10 + column];
}

static int lines_of(const char *text)
{
    int n = 0;
    for (; *text; text++)
        n += *text == '\n';
    return n;
}

static void a_curve(void)
{
    static struct remote_curve c;
    char out[PLOT_BYTES];
    c = (struct remote_curve){.points = {{8, .8}, {32, .4}, {128, .2}},
                              .count = 3,
                              .target_error = .1,
                              .forecast_spp = 512};
    ok(plot_draw(&c, out) && lines_of(out) == PLOT_LINES, "a curve has its lines");
    ok(at(out, 0, 0) == '*' && at(out, 3, 21) == '*' && at(out, 6, 42) == '*',
       "a line of slope -1/2 is a straight one");
    ok(at(out, 9, 63) == '.' && at(out, 9, 0) == '-',
       "the forecast ends at the target, at the right");
    ok(strstr(out, "80 %") == out + 4 && strstr(out, "10 % |"), "rows are named");
    if (!ok(strstr(out, " 8 ") && strstr(out, " 512\n"), "columns are"))
        diag("%s", out);
}

static void no_curve(void)
{
    static struct remote_curve c;
    char out[PLOT_BYTES];
    ok(!plot_draw(&c, out) && !*out, "no points, no curve");
    c = (struct remote_curve){.points = {{8, .8}, {8, .8}}, .count = 2};
    ok(!plot_draw(&c, out), "nor where they are all one");
    c = (struct remote_curve){.points = {{8, .8}, {0, .1}, {16, -1}}, .count = 3};
    ok(!plot_draw(&c, out), "nor where they make no sense");
    c = (struct remote_curve){.points = {{8, .8}, {16, .6}}, .count = 2, .forecast_spp = 1e300};
    ok(plot_draw(&c, out) && lines_of(out) == PLOT_LINES,
       "a forecast beyond all bounds stays on the sheet");
    c = (struct remote_curve){
        .points = {{8, .8}, {16, .9}}, .count = 2, .target_error = 1e-300, .forecast_spp = 9};
    ok(plot_draw(&c, out) && lines_of(out) == PLOT_LINES, "so does a target");
    c = (struct remote_curve){.points = {{8, .8}, {16, (double)INFINITY}}, .count = 2};
    ok(!plot_draw(&c, out), "an infinite error is none");
}

int main(void)
{
    a_curve();
    no_curve();
    return tap_done();
}
