/* jansson: each tree is owned and released where it is made.
 * SPDX-License-Identifier: MIT */
#include "server/status_warnings.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

static json_t *color_json(const float c[3])
{
    return json_pack("[f,f,f]", (double)c[0], (double)c[1], (double)c[2]);
}

static json_t *one(const struct scene_warning *w)
{
    return json_pack("{s:s, s:s, s:o, s:o}", "pointer", w->where, "detail", w->what, "was",
                     color_json(w->was), "became", color_json(w->became));
}

/* Appends when there is room for it, a comma, the bracket and `spare` bytes. */
static bool put(char *out, size_t size, size_t *used, json_t *value, size_t spare)
{
    char *text = json_dumps(value, JSON_COMPACT | JSON_REAL_PRECISION(9));
    const size_t n = strlen(text);
    const bool fits = *used + n + 3 + spare <= size;
    if (fits)
        *used += (size_t)snprintf(out + *used, size - *used, "%c%s", *used ? ',' : '[', text);
    free(text);
    json_decref(value);
    return fits;
}

void status_warnings_print(const struct scene *scene, char *out, size_t size)
{
    enum { REST = 128 }; /* bytes of "and ... more" */
    size_t used = 0;
    uint32_t i = 0;
    *out = '\0';
    while (i < scene->warning_count && put(out, size, &used, one(&scene->warnings[i]), REST))
        i++;
    if (i < scene->warning_count) {
        char more[64];
        snprintf(more, sizeof more, "and %u more warnings", scene->warning_count - i);
        put(out, size, &used,
            json_pack("{s:s, s:s, s:n, s:n}", "pointer", "", "detail", more, "was", "became"), 0);
    }
    if (used)
        snprintf(out + used, size - used, "]");
}
