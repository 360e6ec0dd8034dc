/* SPDX-License-Identifier: MIT */
#include "common/hash.h"

#include <assert.h>
#include <string.h>

#include <openssl/evp.h>

/* struct hash is never defined: the pointer is libcrypto's context under our name. */
static EVP_MD_CTX *context(struct hash *h)
{
    return (EVP_MD_CTX *)h;
}

struct hash *hash_new(void)
{
    EVP_MD_CTX *c = EVP_MD_CTX_new();
    const int ok = c && EVP_DigestInit_ex(c, EVP_sha256(), NULL);
    assert(ok);
    (void)ok;
    return (struct hash *)c;
}

void hash_add(struct hash *h, const void *data, size_t bytes)
{
    const int ok = EVP_DigestUpdate(context(h), data, bytes);
    assert(ok);
    (void)ok;
}

void hash_finish(struct hash *h, char hex[HASH_HEX])
{
    unsigned char md[EVP_MAX_MD_SIZE];
    unsigned int n = 0;
    const int ok = EVP_DigestFinal_ex(context(h), md, &n);
    assert(ok && n == HASH_BYTES);
    (void)ok;
    EVP_MD_CTX_free(context(h));
    for (unsigned int i = 0; i < HASH_BYTES; i++) {
        hex[2 * i] = "0123456789abcdef"[md[i] >> 4];
        hex[2 * i + 1] = "0123456789abcdef"[md[i] & 15];
    }
    hex[HASH_HEX - 1] = '\0';
}

void hash_hex(const void *data, size_t bytes, char hex[HASH_HEX])
{
    struct hash *h = hash_new();
    hash_add(h, data, bytes);
    hash_finish(h, hex);
}

bool hash_is_hex(const char *text)
{
    return strspn(text, "0123456789abcdef") == HASH_HEX - 1 && strlen(text) == HASH_HEX - 1;
}
