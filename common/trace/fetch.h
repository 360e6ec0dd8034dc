/* fetch.h - data, asked for before they are needed: what many paths are about to look at lies in
 * nobody's cache in a large scene.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_TRACE_FETCH_H
#define COMMON_TRACE_FETCH_H

#include <stddef.h>

enum { FETCH_LINE = 64 };

/* at: where a cache line begins. The empty statement is one that gcc believes to do something: a
 * function that prefetches and does nothing else counts as pure, and its calls are left out. */
static inline void fetch_lines(const void *at, size_t bytes)
{
    for (size_t i = 0; i < bytes; i += FETCH_LINE)
        __builtin_prefetch((const unsigned char *)at + i);
    __asm__ volatile("" : : "r"(at));
}

#endif
