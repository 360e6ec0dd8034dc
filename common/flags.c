/* SPDX-License-Identifier: MIT */
#include "common/flags.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

struct parse {
    const struct flags_entry *table;
    size_t count;
    char *const *args;
    int argc, at;
};

static bool read_number(const char *text, double *out)
{
    if (!strchr("0123456789.-+", *text))
        return false; /* strtod would take blanks, nan, inf and hexadecimal */
    char *end;
    errno = 0;
    *out = strtod(text, &end);
    return end != text && !*end && !strpbrk(text, "xX") && (!errno || *out == 0);
}

/* Whole numbers up to 2^53, exact in a double. */
static bool read_whole(const char *text, bool suffix, double *out)
{
    static const char units[] = "kMGT";
    const bool negative = *text == '-';
    const char *digits = text + negative;
    const size_t n = strspn(digits, "0123456789");
    if (!n || n > 15)
        return false;
    double v = strtod(digits, NULL);
    const char *rest = digits + n;
    if (*rest && suffix && strchr(units, *rest)) {
        for (const char *u = units; u <= strchr(units, *rest); u++)
            v *= 1024;
        rest++;
    }
    *out = negative ? -v : v;
    return !*rest;
}

static bool out_of_range(const struct flags_entry *f, const char *text, const char *what,
                         struct err *err)
{
    return err_set(err, ERR_INPUT, "--%s: expected %s from %.15g to %.15g, got '%s'", f->name, what,
                   f->least, f->most, text);
}

static bool assign(const struct flags_entry *f, const char *text, struct err *err)
{
    double v = 0;
    switch (f->kind) {
    case FLAGS_SWITCH:
        *(bool *)f->value = true;
        return true;
    case FLAGS_TEXT:
        *(const char **)f->value = text;
        return *text || err_set(err, ERR_INPUT, "--%s: expected a value, got ''", f->name);
    case FLAGS_COUNT:
        if (!read_whole(text, false, &v) || !(v >= f->least && v <= f->most))
            return out_of_range(f, text, "a whole number", err);
        *(uint32_t *)f->value = (uint32_t)v;
        return true;
    case FLAGS_SIGNED:
        if (!read_whole(text, false, &v) || !(v >= f->least && v <= f->most))
            return out_of_range(f, text, "a whole number", err);
        *(int32_t *)f->value = (int32_t)v;
        return true;
    case FLAGS_BYTES:
        if (!read_whole(text, true, &v) || !(v >= f->least && v <= f->most))
            return out_of_range(f, text, "a number of bytes (k, M, G, T: powers of 1024)", err);
        *(uint64_t *)f->value = (uint64_t)v;
        return true;
    case FLAGS_NUMBER:
        if (!read_number(text, &v) || !(v >= f->least && v <= f->most))
            return out_of_range(f, text, "a number", err);
        *(double *)f->value = v;
        return true;
    }
    __builtin_unreachable();
}

enum { MAX_NAME = 32 };

/* Levenshtein distance of two names, one row at a time. */
static size_t distance(const char *a, size_t a_length, const char *b)
{
    size_t row[MAX_NAME + 1];
    const size_t b_length = strlen(b);
    for (size_t j = 0; j <= b_length; j++)
        row[j] = j;
    for (size_t i = 1; i <= a_length; i++) {
        size_t corner = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b_length; j++) {
            const size_t change = corner + (a[i - 1] != b[j - 1]);
            corner = row[j];
            row[j] = min_size(change, min_size(row[j], row[j - 1]) + 1);
        }
    }
    return row[b_length];
}

static bool unknown(const struct parse *p, const char *arg, struct err *err)
{
    const char *name = arg + strspn(arg, "-");
    const size_t length = strcspn(name, "=");
    const struct flags_entry *nearest = NULL;
    size_t least = 3;
    for (size_t i = 0; i < p->count && length <= MAX_NAME; i++) {
        const size_t d = distance(name, length, p->table[i].name);
        if (d < least && d < length) {
            least = d;
            nearest = &p->table[i];
        }
    }
    if (nearest)
        return err_set(err, ERR_INPUT, "unknown flag '%s'; did you mean --%s?", arg, nearest->name);
    return err_set(err, ERR_INPUT, "unknown flag '%s'", arg);
}

static const struct flags_entry *find(const struct parse *p, const char *arg)
{
    const bool is_long = arg[1] == '-';
    for (size_t i = 0; i < p->count; i++) {
        const struct flags_entry *f = &p->table[i];
        if (is_long ? !strncmp(arg + 2, f->name, strcspn(arg + 2, "=")) &&
                          f->name[strcspn(arg + 2, "=")] == 0
                    : arg[1] == f->letter && !arg[2])
            return f;
    }
    return NULL;
}

static bool parse_flag(struct parse *p, struct err *err)
{
    const char *arg = p->args[p->at++];
    const struct flags_entry *f = find(p, arg);
    if (!f)
        return unknown(p, arg, err);
    const char *value = arg[1] == '-' ? strchr(arg, '=') : NULL;
    if (value)
        value++;
    if (f->kind == FLAGS_SWITCH)
        return value ? err_set(err, ERR_INPUT, "--%s: takes no value, got '%s'", f->name, value)
                     : assign(f, "", err);
    if (!value && p->at == p->argc)
        return err_set(err, ERR_INPUT, "--%s: its value is missing", f->name);
    return assign(f, value ? value : p->args[p->at++], err);
}

bool flags_parse(const struct flags_entry *table, size_t count, int argc, char *const *args,
                 const char **operands, size_t operand_max, size_t *operand_count, struct err *err)
{
    struct parse p = {.table = table, .count = count, .args = args, .argc = argc};
    bool flags_over = false;
    *operand_count = 0;
    while (p.at < argc) {
        const char *arg = args[p.at];
        if (!flags_over && !strcmp(arg, "--")) {
            flags_over = true;
            p.at++;
        } else if (!flags_over && arg[0] == '-' && arg[1]) {
            if (!parse_flag(&p, err))
                return false;
        } else if (*operand_count == operand_max) {
            return err_set(err, ERR_INPUT, "unexpected argument '%s'", arg);
        } else {
            operands[(*operand_count)++] = arg;
            p.at++;
        }
    }
    return true;
}
