/* block.h's sets, and what becomes of a tile of which only some blocks are sampled: the samples,
 * the work and the evidence of those blocks, and nothing else. SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <string.h>

#include "common/trace/render.h"
#include "tests/scenes.h"
#include "tests/tap.h"

/* --- sets --- */

static struct block_set every_third(size_t count, size_t first)
{
    struct block_set s = {0};
    for (size_t i = first; i < count; i += 3)
        block_set_add(&s, i);
    return s;
}

static void sets_are_sets(void)
{
    static const size_t counts[] = {1, 4, 63, 64, 65, 1023, BLOCK_SET_MAX};
    bool good = true;
    for (size_t k = 0; k < countof(counts); k++) {
        const size_t n = counts[k];
        const struct block_set all = block_set_all(n), third = every_third(n, 0);
        good &= block_set_count(&all) == n && block_set_count(&third) == (n + 2) / 3;
        good &= block_set_has(&all, n - 1) && (n == BLOCK_SET_MAX || !block_set_has(&all, n));
        good &= block_set_within(&third, &all) && block_set_within(&all, &all);
        good &= n == 1 || (!block_set_within(&all, &third) && !block_set_equal(&all, &third));
    }
    ok(good, "sets of 1 to %d blocks count what they have", BLOCK_SET_MAX);
}

static void text_is_one_to_one(void)
{
    char hex[BLOCK_SET_HEX];
    struct block_set back;
    bool good = true;
    for (size_t n = 1; n <= BLOCK_SET_MAX; n++) {
        const struct block_set s = every_third(n, 0);
        block_set_print(&s, n, hex);
        good &= block_set_parse(&back, n, hex) && block_set_equal(&s, &back);
    }
    ok(good, "a set comes back from its text, of any number of blocks");
    const struct block_set s = every_third(10, 1);
    block_set_print(&s, 10, hex);
    ok(!strcmp(hex, "490"), "blocks 1, 4 and 7 of 10 are 0100 1001 00: %s", hex);
    static const char *const bad[] = {"", "49", "4900", "000", "492", "491", "49G", "4 0", "49A"};
    for (size_t i = 0; i < countof(bad); i++)
        ok(!block_set_parse(&back, 10, bad[i]), "no set of 10: '%s'", bad[i]);
}

/* --- a tile with and without the rest --- */

static const struct tile_rect rect = {8, 16, 8 + 37, 16 + 21}; /* 5 x 3 blocks, the last ones cut */

static struct film_samples render(const struct stage *s, const struct block_set *active,
                                  uint32_t layers, struct arena *arena)
{
    struct film_samples out = film_samples_make(rect, (struct tile_pass){8, 24}, arena);
    film_samples_add_layers(&out, layers, arena);
    if (active)
        film_samples_restrict(&out, active);
    render_tile(s, &out);
    return out;
}

/* What `part` has of its blocks is what `whole` has there, and it has nothing else. */
static bool agree(const struct film_samples *part, const struct film_samples *whole)
{
    const struct block nothing = {0};
    const size_t channels = layers_channels(part->layers);
    const float zeros[LAYERS_MAX_CHANNELS + FILM_CHANNELS] = {0};
    bool same = true;
    for (size_t i = 0; i < block_count(rect); i++) {
        const bool has = film_samples_has(part, i);
        const struct tile_rect b = block_rect_of(rect, i);
        same &= !memcmp(&part->blocks[i], has ? &whole->blocks[i] : &nothing, sizeof nothing);
        for (uint32_t y = b.y_begin; y < b.y_end; y++)
            for (uint32_t x = b.x_begin; x < b.x_end; x++) {
                const size_t at = (y - rect.y_begin) * 37 + (x - rect.x_begin);
                same &= !memcmp(part->sums + at * FILM_CHANNELS,
                                has ? whole->sums + at * FILM_CHANNELS : zeros,
                                FILM_CHANNELS * sizeof *zeros);
                same &= !channels || !memcmp(part->layer_sums + at * channels,
                                             has ? whole->layer_sums + at * channels : zeros,
                                             channels * sizeof *zeros);
            }
    }
    return same;
}

static double cut_of(const struct film_samples *s)
{
    double cut = 0;
    for (size_t i = 0; i < block_count(s->rect); i++)
        cut += s->blocks[i].cut;
    return cut;
}

static void parts_make_the_whole(const struct stage *s, uint32_t layers, const char *name)
{
    struct arena arena = {0};
    const struct film_samples whole = render(s, NULL, layers, &arena);
    struct film_work work = {0};
    uint64_t invalid = 0;
    bool same = true;
    for (size_t first = 0; first < 3; first++) {
        const struct block_set active = every_third(block_count(rect), first);
        const struct film_samples part = render(s, &active, layers, &arena);
        same &= part.partial && agree(&part, &whole);
        film_work_add(&work, &part.work);
        invalid += part.invalid_count;
    }
    ok(same, "%s: a block's sums and evidence are the same without the others", name);
    ok(!memcmp(&work, &whole.work, sizeof work) && invalid == whole.invalid_count,
       "%s: and the parts' work is the whole's", name);
    if (s->settings.max_bounces <= 2)
        ok(cut_of(&whole) > 0, "%s: also the light beyond the cut, by probes", name);
    const struct block_set all = block_set_all(block_count(rect));
    const struct film_samples again = render(s, &all, layers, &arena);
    ok(!again.partial && agree(&again, &whole), "%s: all of a tile's blocks are the tile", name);
    arena_release(&arena);
}

static void of_document(const char *name, uint32_t max_bounces, float clamp, uint32_t layers)
{
    struct scenes s;
    char what[96];
    snprintf(what, sizeof what, "%s, %u bounces%s%s", name, max_bounces,
             clamp > 0 ? ", clamped" : "", layers ? ", layers" : "");
    if (ok(scenes_open(&s, name), "%s opens", name)) {
        struct scene_film *f = &s.scene.film;
        f->width_px = f->crop_x_end = 53;
        f->height_px = f->crop_y_end = 40;
        s.scene.settings.max_bounces = max_bounces;
        s.scene.settings.clamp = clamp;
        parts_make_the_whole(scenes_stage(&s), layers, what);
    }
    scenes_release(&s);
}

/* --- into a film --- */

static void a_film_takes_the_parts(void)
{
    struct arena arena = {0};
    struct film whole, parts;
    film_init(&whole, rect);
    film_init(&parts, rect);
    film_add_layers(&whole, LAYER_DEPTH);
    film_add_layers(&parts, LAYER_DEPTH);
    struct film_samples s = film_samples_make(rect, (struct tile_pass){0, 8}, &arena);
    film_samples_add_layers(&s, LAYER_DEPTH, &arena);
    for (size_t i = 0; i < (size_t)tile_rect_pixels(rect) * FILM_CHANNELS; i++)
        s.sums[i] = (float)(i % 1009) / 7;
    for (size_t i = 0; i < tile_rect_pixels(rect); i++)
        s.layer_sums[i] = (float)i;
    for (size_t i = 0; i < block_count(rect); i++)
        block_add(&s.blocks[i], (float)i);
    film_merge(&whole, &s);
    const struct block_set first = every_third(block_count(rect), 0);
    film_samples_restrict(&s, &first);
    film_merge(&parts, &s);
    bool left = true;
    for (uint32_t i = 0; i < tile_rect_pixels(rect); i++) {
        const size_t block = i / 37 / BLOCK_PX * 5 + i % 37 / BLOCK_PX;
        left &= parts.spp[i] == (block % 3 ? 0 : 8) && (block % 3 == 0 || parts.sum[3 * i] == 0);
    }
    ok(left, "what is not sampled stays as it was");
    for (size_t k = 1; k < 3; k++) {
        const struct block_set more = every_third(block_count(rect), k);
        film_samples_restrict(&s, &more);
        film_merge(&parts, &s);
    }
    const size_t n = tile_rect_pixels(rect);
    ok(!memcmp(parts.sum, whole.sum, n * 3 * sizeof *whole.sum) &&
           !memcmp(parts.replicate, whole.replicate, n * FILM_CHANNELS * sizeof(float)) &&
           !memcmp(parts.spp, whole.spp, n * sizeof *whole.spp) &&
           !memcmp(parts.layer, whole.layer, n * sizeof *whole.layer) &&
           !memcmp(parts.blocks, whole.blocks, block_count(rect) * sizeof *whole.blocks) &&
           !memcmp(parts.variance, whole.variance,
                   block_count(rect) * BLOCK_DOUBLINGS * sizeof *whole.variance),
       "and the parts make the whole");
    film_release(&whole);
    film_release(&parts);
    arena_release(&arena);
}

int main(void)
{
    sets_are_sets();
    text_is_one_to_one();
    a_film_takes_the_parts();
    of_document("cornell-box", 12, 0, 0);
    of_document("cornell-box", 1, 0, 0);
    of_document("glass-and-metal", 2, 0, 0);
    of_document("glass-and-metal", 8, .5f, 0);
    of_document("tiles", 8, 0, 0);
    of_document("cornell-box", 3, 0, LAYER_SURFACE | 4 << 8);
    return tap_done();
}
