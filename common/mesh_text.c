/* Words and numbers of text meshes.
 * SPDX-License-Identifier: MIT */
#include "common/mesh_build.h"

#include <stdlib.h>
#include <string.h>

bool mesh_span_is(struct mesh_span s, const char *word)
{
    const size_t n = strlen(word);
    return (size_t)(s.end - s.at) == n && !memcmp(s.at, word, n);
}

/* Bytes of the space that the span begins with; 0 for none. */
static size_t space(struct mesh_span s)
{
    const size_t left = (size_t)(s.end - s.at);
    if (!left)
        return 0;
    switch (*s.at) {
    case ' ':
    case '\t':
    case '\r':
    case '\n':
    case '\v':
    case '\f':
        return 1;
    case '\\':
        if (left >= 2 && s.at[1] == '\n')
            return 2;
        return left >= 3 && s.at[1] == '\r' && s.at[2] == '\n' ? 3 : 0;
    }
    return 0;
}

bool mesh_span_token(struct mesh_span *line, struct mesh_span *token)
{
    for (size_t n; (n = space(*line)) > 0;)
        line->at += n;
    token->at = line->at;
    while (line->at < line->end && !space(*line))
        line->at++;
    token->end = line->at;
    return token->at < token->end;
}

struct decimal { /* digits * 10^exponent */
    bool negative;
    bool exact; /* all digits fit into `digits` */
    uint64_t digits;
    int64_t exponent;
};

static bool digits_scan(struct mesh_span *s, struct decimal *d, bool fraction)
{
    const char *begin = s->at;
    for (; s->at < s->end && *s->at >= '0' && *s->at <= '9'; s->at++) {
        if (d->digits > UINT64_MAX / 10 - 1)
            d->exact = false;
        else
            d->digits = d->digits * 10 + (uint64_t)(*s->at - '0');
        d->exponent -= fraction;
    }
    return s->at > begin;
}

static bool sign_scan(struct mesh_span *s)
{
    if (s->at < s->end && (*s->at == '+' || *s->at == '-'))
        return *s->at++ == '-';
    return false;
}

static bool decimal_scan(struct mesh_span s, struct decimal *d)
{
    *d = (struct decimal){.exact = true};
    d->negative = sign_scan(&s);
    bool some = digits_scan(&s, d, false);
    if (s.at < s.end && *s.at == '.') {
        s.at++;
        some |= digits_scan(&s, d, true);
    }
    if (some && s.at < s.end && (*s.at == 'e' || *s.at == 'E')) {
        s.at++;
        struct decimal e = {.exact = true};
        e.negative = sign_scan(&s);
        some = digits_scan(&s, &e, false);
        if (!e.exact || e.digits > 100000)
            d->exact = false;
        else
            d->exponent += e.negative ? -(int64_t)e.digits : (int64_t)e.digits;
    }
    return some && s.at == s.end;
}

bool mesh_span_number(struct mesh_span s, double *out)
{
    /* A product or quotient of two exact doubles is correctly rounded: W. D. Clinger, "How to
     * read floating point numbers accurately", PLDI 1990. The rest goes to strtod, which is
     * correctly rounded, too, but slow and wants a terminated copy. */
    static const double power[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                   1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                   1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    struct decimal d;
    if (!decimal_scan(s, &d))
        return false;
    if (d.exact && d.digits <= (UINT64_C(1) << 53) && d.exponent >= -22 && d.exponent <= 22) {
        const double m = d.negative ? -(double)d.digits : (double)d.digits;
        *out = d.exponent < 0 ? m / power[-d.exponent] : m * power[d.exponent];
        return true;
    }
    char copy[256];
    const size_t n = (size_t)(s.end - s.at);
    if (n >= sizeof copy)
        return false;
    memcpy(copy, s.at, n);
    copy[n] = '\0';
    *out = strtod(copy, NULL);
    return true;
}

bool mesh_span_integer(struct mesh_span s, int64_t *out)
{
    struct decimal d = {.exact = true};
    d.negative = sign_scan(&s);
    if (!digits_scan(&s, &d, false) || s.at != s.end || !d.exact ||
        d.digits >= UINT64_C(1000000000000000))
        return false;
    *out = d.negative ? -(int64_t)d.digits : (int64_t)d.digits;
    return true;
}

const char *mesh_span_print(struct mesh_span s, char out[64])
{
    const size_t shown = min_size((size_t)(s.end - s.at), 40);
    char *o = out;
    *o++ = '"';
    for (size_t i = 0; i < shown; i++)
        *o++ = (char)(s.at[i] >= 0x20 && s.at[i] < 0x7f ? s.at[i] : '?');
    if ((size_t)(s.end - s.at) > shown) {
        memcpy(o, "...", 3);
        o += 3;
    }
    *o++ = '"';
    *o = '\0';
    return out;
}
