/* layers.h - what a film keeps beside the image, and where.
 *
 * A set of layers is one number, so that a document, a job's row, a payload and a film on disk say the
 * same thing in the same way: bits 0 to 7 are enum layer, bits 8 to 15 the count of bounce layers
 * (0: none). Each layer is a run of channels, always in this order:
 *
 *     hits      1   samples whose camera ray met a surface; there whenever a layer of the first surface is
 *     albedo    3   what the first surface returns of light that is the same everywhere; 0 for a miss
 *     normal    3   its shading normal, unit, on the side that is seen; 0 for a miss
 *     depth     1   its distance along the view, m; 0 for a miss
 *     position  3   the point itself, world, m; 0 for a miss
 *     material  1   1 + the index of its material, of sample 0 alone; 0 for a miss
 *     bounces   3 each: light scattered k times on its way, for k = 0 up to the last one asked for, then
 *                   the rest. Their sum is the image
 *
 * Channels hold sums over samples. SPDX-License-Identifier: MIT */
#ifndef COMMON_LAYERS_H
#define COMMON_LAYERS_H

#include "common/base.h"

enum layer {
    LAYER_ALBEDO = 1 << 0,
    LAYER_NORMAL = 1 << 1,
    LAYER_DEPTH = 1 << 2,
    LAYER_POSITION = 1 << 3,
    LAYER_MATERIAL = 1 << 4,
    LAYER_SURFACE = (1 << 5) - 1, /* those of the first surface */
};

enum {
    LAYERS_MAX_BOUNCES = 8, /* layers bounce0 to bounce7 */
    LAYERS_MAX_CHANNELS = 1 + 3 + 3 + 1 + 3 + 1 + 3 * (LAYERS_MAX_BOUNCES + 1),
};

static inline uint32_t layers_make(uint32_t set, uint32_t bounces)
{
    return set | bounces << 8;
}

static inline uint32_t layers_bounces(uint32_t layers)
{
    return layers >> 8;
}

/* Of a number from outside. */
static inline bool layers_are_known(uint32_t layers)
{
    return !(layers & 0xff & ~(uint32_t)LAYER_SURFACE) &&
           layers_bounces(layers) <= LAYERS_MAX_BOUNCES;
}

/* Channels of the layers of the first surface that come before `layer`: where it begins. */
static inline uint32_t layers_at(uint32_t layers, uint32_t layer)
{
    const uint32_t before = layers & (layer - 1);
    return (layers & LAYER_SURFACE ? 1 : 0) + (before & LAYER_ALBEDO ? 3 : 0) +
           (before & LAYER_NORMAL ? 3 : 0) + (before & LAYER_DEPTH ? 1 : 0) +
           (before & LAYER_POSITION ? 3 : 0) + (before & LAYER_MATERIAL ? 1 : 0);
}

/* Where bounce0 begins. */
static inline uint32_t layers_bounces_at(uint32_t layers)
{
    return layers_at(layers, LAYER_SURFACE + 1);
}

static inline uint32_t layers_channels(uint32_t layers)
{
    const uint32_t bounces = layers_bounces(layers);
    return layers_bounces_at(layers) + (bounces ? 3 * (bounces + 1) : 0);
}

#endif
