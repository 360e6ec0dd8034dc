/* SPDX-License-Identifier: MIT */
#include "common/err.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

bool err_set(struct err *err, enum err_code code, const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    err->code = code;
    vsnprintf(err->text, sizeof err->text, fmt, ap);
    va_end(ap);
    return false;
}

bool err_at(struct err *err, const char *fmt, ...)
{
    char where[sizeof err->text];
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(where, sizeof where, fmt, ap);
    va_end(ap);

    char text[sizeof err->text];
    memcpy(text, err->text, sizeof text);
    const size_t room = sizeof err->text - 1;
    size_t n = min_size(strlen(where), room);
    memcpy(err->text, where, n);
    const char *parts[] = {": ", text};
    for (size_t i = 0; i < countof(parts); i++) {
        const size_t len = min_size(strlen(parts[i]), room - n);
        memcpy(err->text + n, parts[i], len);
        n += len;
    }
    err->text[n] = '\0';
    return false;
}
