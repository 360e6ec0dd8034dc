/* flags.h - command-line flags to variables, by a table.
 *
 * `--name VALUE`, `--name=VALUE` and, where a letter is given, `-l VALUE`; `--` ends the flags.
 * Operands may stand between flags. A flag that is not in the table, a missing or an unreadable
 * value is ERR_INPUT, and the text names the nearest flag there is.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_FLAGS_H
#define COMMON_FLAGS_H

#include "common/err.h"

enum flags_kind {
    FLAGS_SWITCH, /* bool: takes no value */
    FLAGS_TEXT,   /* const char *: not empty; points into argv */
    FLAGS_COUNT,  /* uint32_t: a whole number in [least, most] */
    FLAGS_BYTES,  /* uint64_t: likewise, and may end in k, M, G or T (powers of 1024) */
    FLAGS_NUMBER, /* double: in [least, most] */
    FLAGS_SIGNED, /* int32_t: a whole number in [least, most] */
};

struct flags_entry {
    const char *name; /* without the dashes */
    enum flags_kind kind;
    void *value;        /* where to put it; untouched when the flag is absent */
    double least, most; /* COUNT, BYTES, NUMBER, SIGNED */
    char letter;        /* 0: none */
};

/* args: argc strings after the program's (or command's) name. Operands are put into `operands` in
 * order; more than operand_max of them is an error. */
bool flags_parse(const struct flags_entry *table, size_t count, int argc, char *const *args,
                 const char **operands, size_t operand_max, size_t *operand_count,
                 struct err *) MUST_CHECK;

#endif
