/* SPDX-License-Identifier: MIT */
#include "common/block.h"

#include <assert.h>
#include <string.h>

struct tile_rect block_around(struct tile_rect r, size_t i)
{
    const uint32_t columns = block_columns(r), rows = block_rows(r);
    const uint32_t x = (uint32_t)(i % columns), y = (uint32_t)(i / columns);
    return (struct tile_rect){x - (x > 0), y - (y > 0), min_u32(x + 2, columns),
                              min_u32(y + 2, rows)};
}

struct tile_rect block_rect_of(struct tile_rect r, size_t i)
{
    const uint32_t columns = block_columns(r);
    const uint32_t x = r.x_begin + (uint32_t)(i % columns) * BLOCK_PX;
    const uint32_t y = r.y_begin + (uint32_t)(i / columns) * BLOCK_PX;
    return (struct tile_rect){x, y, min_u32(x + BLOCK_PX, r.x_end), min_u32(y + BLOCK_PX, r.y_end)};
}

void block_keep(struct block *b, float x)
{
    uint32_t at = BLOCK_TOP - 1;
    for (; at > 0 && x > b->top[at - 1]; at--)
        b->top[at] = b->top[at - 1];
    b->top[at] = x;
}

void block_merge(struct block *b, const struct block *more)
{
    b->sum += more->sum;
    b->square += more->square;
    b->clamped += more->clamped;
    b->cut += more->cut;
    b->met += more->met;
    for (uint32_t i = 0; i < BLOCK_TOP && more->top[i] > b->top[BLOCK_TOP - 1]; i++)
        block_keep(b, more->top[i]);
}

double block_variance(const struct block *b, double n)
{
    const double mean = b->sum / n, v = b->square / n - mean * mean;
    return v > 0 ? v : 0;
}

struct block_set block_set_all(size_t count)
{
    assert(count <= BLOCK_SET_MAX);
    struct block_set s = {0};
    for (size_t i = 0; i < count / 64; i++)
        s.bits[i] = UINT64_MAX;
    if (count % 64)
        s.bits[count / 64] = (UINT64_C(1) << count % 64) - 1;
    return s;
}

size_t block_set_count(const struct block_set *s)
{
    size_t n = 0;
    for (size_t i = 0; i < countof(s->bits); i++)
        n += (size_t)__builtin_popcountll(s->bits[i]);
    return n;
}

uint32_t block_set_pixels(const struct block_set *s, struct tile_rect r)
{
    uint32_t pixels = 0;
    for (size_t i = 0; i < block_count(r); i++)
        if (block_set_has(s, i))
            pixels += tile_rect_pixels(block_rect_of(r, i));
    return pixels;
}

bool block_set_equal(const struct block_set *a, const struct block_set *b)
{
    return !memcmp(a->bits, b->bits, sizeof a->bits);
}

bool block_set_within(const struct block_set *part, const struct block_set *whole)
{
    for (size_t i = 0; i < countof(part->bits); i++)
        if (part->bits[i] & ~whole->bits[i])
            return false;
    return true;
}

void block_set_print(const struct block_set *s, size_t count, char hex[BLOCK_SET_HEX])
{
    const size_t digits = (count + 3) / 4;
    for (size_t k = 0; k < digits; k++) {
        uint32_t four = 0;
        for (size_t i = 0; i < 4; i++)
            four = four << 1 | block_set_has(s, 4 * k + i);
        hex[k] = "0123456789abcdef"[four];
    }
    hex[digits] = '\0';
}

bool block_set_parse(struct block_set *s, size_t count, const char *hex)
{
    static const char digits[] = "0123456789abcdef";
    const struct block_set all = block_set_all(count);
    *s = (struct block_set){0};
    if (strlen(hex) != (count + 3) / 4 || strspn(hex, digits) != strlen(hex))
        return false;
    for (size_t i = 0; i < 4 * strlen(hex); i++)
        if ((size_t)(strchr(digits, hex[i / 4]) - digits) >> (3 - i % 4) & 1)
            block_set_add(s, i);
    return block_set_count(s) > 0 && block_set_within(s, &all);
}
