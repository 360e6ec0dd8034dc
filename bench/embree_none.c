/* What stands in for embree.c where Embree is not installed. SPDX-License-Identifier: MIT */
#include "bench/embree.h"

#include <stdlib.h>

const char *embree_version(void)
{
    return NULL;
}

struct embree *embree_new(const struct scene *scene, enum embree_kind kind)
{
    (void)scene;
    (void)kind;
    abort();
}

void embree_free(struct embree *e)
{
    (void)e;
    abort();
}

int64_t embree_build(struct embree *e)
{
    (void)e;
    abort();
}

uint64_t embree_bytes(const struct embree *e)
{
    (void)e;
    abort();
}

void embree_trace(const struct embree *e, enum embree_call call, const struct shots *shots,
                  struct shot_hit *hits)
{
    (void)e;
    (void)call;
    (void)shots;
    (void)hits;
    abort();
}

double embree_sah(const struct scene *scene)
{
    (void)scene;
    abort();
}
