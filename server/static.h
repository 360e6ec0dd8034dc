/* static.h - the files of web/ and the scene schema, embedded in the binary.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_STATIC_H
#define SERVER_STATIC_H

#include "common/hash.h"

struct static_file {
    const char *path, *type; /* as they are served */
    const unsigned char *begin, *end;
};

const struct static_file *static_find(const char *path); /* NULL: no such file */

#endif
