/* Which known name an unknown one was meant to be.
 * SPDX-License-Identifier: MIT */
#include "common/scene_doc.h"

#include <string.h>

enum { LONGEST = 32 }; /* bytes; nobody mistypes more, and hostile names cost nothing */

static size_t min3(size_t a, size_t b, size_t c)
{
    return min_size(a, min_size(b, c));
}

static char lower(char c)
{
    return (char)(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
}

/* Letters to insert, remove, replace or swap with their neighbour; case is free. The "optimal
 * string alignment" distance: F. J. Damerau, "A technique for computer detection and correction
 * of spelling errors", CACM 7(3), 1964. */
static size_t distance(const char *a, size_t a_len, const char *b, size_t b_len)
{
    size_t row[3][LONGEST + 1]; /* two rows back, one row back, this one; taken modulo 3 */
    for (size_t j = 0; j <= b_len; j++)
        row[0][j] = j;
    for (size_t i = 1; i <= a_len; i++) {
        size_t *now = row[i % 3];
        const size_t *last = row[(i + 2) % 3], *before = row[(i + 1) % 3];
        now[0] = i;
        for (size_t j = 1; j <= b_len; j++) {
            const char x = lower(a[i - 1]), y = lower(b[j - 1]);
            now[j] = min3(last[j] + 1, now[j - 1] + 1, last[j - 1] + (x != y));
            if (i > 1 && j > 1 && x == lower(b[j - 2]) && y == lower(a[i - 2]))
                now[j] = min_size(now[j], before[j - 2] + 1);
        }
    }
    return row[a_len % 3][b_len];
}

const char *scene_suggest(const char *name, const char *const *names, size_t count)
{
    const size_t len = strlen(name);
    if (len > LONGEST)
        return NULL;
    const char *best = NULL;
    size_t best_distance = len / 3 + 1; /* "k" may become "ks", not "eta" */
    for (size_t i = 0; i < count; i++) {
        const size_t n = strlen(names[i]);
        if (n > LONGEST || n + best_distance < len || len + best_distance < n)
            continue;
        const size_t d = distance(name, len, names[i], n);
        if (d <= best_distance && d < (n > len ? n : len)) {
            if (!best || d < best_distance)
                best = names[i];
            best_distance = d;
        }
    }
    return best;
}
