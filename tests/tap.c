/* SPDX-License-Identifier: MIT */
#include "tests/tap.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

static int count, failed;

static void line(const char *head, const char *fmt, va_list ap) __attribute__((format(printf, 2, 0)));
static bool report(bool cond, const char *fmt, va_list ap) __attribute__((format(printf, 2, 0)));

static void line(const char *head, const char *fmt, va_list ap)
{
    fputs(head, stdout);
    vprintf(fmt, ap);
    putchar('\n');
    fflush(stdout);
}

static bool report(bool cond, const char *fmt, va_list ap)
{
    char head[40];
    snprintf(head, sizeof head, "%sok %d - ", cond ? "" : "not ", ++count);
    line(head, fmt, ap);
    failed += !cond;
    return cond;
}

bool ok(bool cond, const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    report(cond, fmt, ap);
    va_end(ap);
    return cond;
}

bool near(double got, double want, double tolerance, const char *fmt, ...)
{
    const bool cond = fabs(got - want) <= tolerance; /* false for a NaN */
    va_list ap;
    va_start(ap, fmt);
    report(cond, fmt, ap);
    va_end(ap);
    if (!cond)
        diag("got %.17g, want %.17g +- %g", got, want, tolerance);
    return cond;
}

void diag(const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    line("# ", fmt, ap);
    va_end(ap);
}

void skip(const char *fmt, ...)
{
    char head[40];
    snprintf(head, sizeof head, "ok %d # skip ", ++count);
    va_list ap;
    va_start(ap, fmt);
    line(head, fmt, ap);
    va_end(ap);
}

int tap_done(void)
{
    printf("1..%d\n", count);
    return failed ? 1 : 0;
}
