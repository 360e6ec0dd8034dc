/* SPDX-License-Identifier: MIT */
#include "common/trace/sampler.h"

enum { MOST_LEVELS = 5 };

/* The random bits of a place, 64 of them: splitmix again, from the dimension's seeds on. */
static uint64_t hash(const struct rng *r, uint32_t dimension, uint64_t place)
{
    return rng_mix(rng_seeds(r, dimension) + (place + 1) * 0x9e3779b97f4a7c15u);
}

/* A permutation of the numbers of so many bits. Each step is one: a sum, a product with an odd
 * number, an exclusive or with higher bits. */
static uint32_t permute(uint32_t x, uint32_t bits, uint64_t seed)
{
    const uint32_t mask = (1u << bits) - 1, half = bits / 2;
    for (int round = 0; round < 4; round++, seed = rng_mix(seed)) {
        x = (x + (uint32_t)seed) & mask;
        x ^= x >> half;
        x = x * ((uint32_t)(seed >> 32) | 1) & mask;
    }
    return x ^ x >> half;
}

static uint32_t levels_of(uint32_t points)
{
    uint32_t k = 0;
    while (k < MOST_LEVELS && points >> (2 * k + 2))
        k++;
    return k;
}

/* The cell of a point in its block of 4^k, k > 0. */
static uint32_t cell_of(const struct rng *r, uint32_t dimension, uint32_t index, uint32_t k)
{
    const uint64_t block = index >> 2 * k;
    return permute(index & ((1u << 2 * k) - 1), 2 * k, hash(r, dimension, ~block));
}

/* `cell` in the leading bits, of which it has so many. */
static uint32_t jitter(uint32_t cell, uint32_t bits, uint32_t random)
{
    return cell << (32 - bits) | random >> bits;
}

static struct sobol_bits pair(const struct rng *r, uint32_t dimension, uint32_t k)
{
    const uint32_t index = sobol_reverse(r->index_reversed);
    const uint64_t h = hash(r, dimension, index);
    const struct sobol_bits random = {(uint32_t)h, (uint32_t)(h >> 32)};
    if (k == 0)
        return random;
    const uint32_t cell = cell_of(r, dimension, index, k);
    return (struct sobol_bits){jitter(cell & ((1u << k) - 1), k, random.u),
                               jitter(cell >> k, k, random.v)};
}

static uint32_t single(const struct rng *r, uint32_t dimension, uint32_t k)
{
    const uint32_t index = sobol_reverse(r->index_reversed);
    const uint32_t random = (uint32_t)hash(r, dimension, index);
    return k == 0 ? random : jitter(cell_of(r, dimension, index, k), 2 * k, random);
}

static struct rng lane_of(const struct rng8 *r, uint32_t i)
{
    return (struct rng){r->key[i / 4][i % 4], r->index_reversed[i]};
}

static uint32_t levels(const struct scene_settings *s, uint32_t points)
{
    return s->sampler == SAMPLER_STRATIFIED ? levels_of(points) : 0;
}

struct sobol8_bits sampler_other_pair(const struct scene_settings *s, const struct rng8 *r,
                                      uint32_t dimension, uint32_t points)
{
    const uint32_t k = levels(s, points);
    struct sobol8_bits eight;
    for (uint32_t i = 0; i < 8; i++) {
        const struct rng lane = lane_of(r, i);
        const struct sobol_bits b = pair(&lane, dimension, k);
        eight.u[i] = b.u;
        eight.v[i] = b.v;
    }
    return eight;
}

u32x8 sampler_other_single(const struct scene_settings *s, const struct rng8 *r, uint32_t dimension,
                           uint32_t points)
{
    const uint32_t k = levels(s, points);
    u32x8 eight;
    for (uint32_t i = 0; i < 8; i++) {
        const struct rng lane = lane_of(r, i);
        eight[i] = single(&lane, dimension, k);
    }
    return eight;
}

struct sobol8_square sampler_elders(const struct scene_settings *s, const struct rng_pixel *p,
                                    uint32_t dimension)
{
    struct rng elders[FILM_REPLICATES];
    struct rng8 eight;
    for (uint32_t i = 0; i < FILM_REPLICATES; i++)
        elders[i] = rng_elder(&p->replicate[i]);
    rng8_make(&eight, elders, FILM_REPLICATES);
    if (sampler_is_sobol(s))
        return rng8_pair(&eight, dimension);
    return sampler_square(sampler_other_pair(s, &eight, dimension, sampler_points(s) / 2));
}
