/* hash.h - SHA-256, the name of every asset, document and digest (FIPS 180-4; by libcrypto).
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_HASH_H
#define COMMON_HASH_H

#include "common/base.h"

enum { HASH_BYTES = 32, HASH_HEX = 65 }; /* HASH_HEX: 64 lower-case digits and a NUL */

struct hash; /* a running SHA-256; opaque, heap */

struct hash *hash_new(void);
void hash_add(struct hash *, const void *data, size_t bytes);
void hash_finish(struct hash *, char hex[HASH_HEX]); /* and frees it */

void hash_hex(const void *data, size_t bytes, char hex[HASH_HEX]); /* all at once */
bool hash_is_hex(const char *text); /* exactly 64 lower-case hex digits */

#endif
