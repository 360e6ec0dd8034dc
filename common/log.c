/* SPDX-License-Identifier: MIT */
#include "common/log.h"

#include <stdarg.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

static const char *program_name = "smalti";
static enum log_level least_level = LOG_INFO;

void log_init(const char *program, enum log_level least)
{
    program_name = program;
    least_level = least;
}

void log_line(enum log_level level, const char *fmt, ...)
{
    static const char *const names[] = {"debug", "info", "warn", "error"};
    if (level < least_level)
        return;

    char line[1024];
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    struct tm tm;
    gmtime_r(&now.tv_sec, &tm);
    size_t n = strftime(line, sizeof line, "%Y-%m-%dT%H:%M:%S", &tm);
    n += (size_t)snprintf(line + n, sizeof line - n, ".%03dZ %-5s %s[%d] ",
                          (int)(now.tv_nsec / 1000000), names[level], program_name, (int)getpid());

    va_list ap;
    va_start(ap, fmt);
    const int body = vsnprintf(line + n, sizeof line - n, fmt, ap);
    va_end(ap);
    if (body > 0)
        n = min_size(n + (size_t)body, sizeof line - 2);
    for (size_t i = 0; i < n; i++)
        if ((unsigned char)line[i] < ' ')
            line[i] = ' '; /* nothing from a peer can forge a second line */
    line[n++] = '\n';
    fwrite(line, 1, n, stderr);
}
