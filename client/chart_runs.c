/* SPDX-License-Identifier: MIT */
#include "client/chart_runs.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "common/clock.h"
#include "common/evidence.h"
#include "common/trace/render.h"

enum { MOST_THREADS = 64 };

struct share {
    struct chart_crew *crew;
    struct chart_run *runs;
    uint32_t count;
    pthread_mutex_t lock; /* of what follows, and of the crew's counts */
    uint32_t next;
};

/* One thread's copy of a stage, whose seed it may set. */
struct copy {
    struct arena arena;
    const struct stage *of; /* NULL: none yet */
    struct stage *stage;
};

static struct tile_rect window_of(const struct stage *s)
{
    const struct scene_film *f = &s->film;
    return (struct tile_rect){f->crop_x_begin, f->crop_y_begin, f->crop_x_end, f->crop_y_end};
}

size_t chart_runs_pixels(const struct stage *s)
{
    return tile_rect_pixels(window_of(s));
}

static struct stage *copy_of(struct copy *c, const struct stage *s)
{
    if (c->of == s)
        return c->stage;
    arena_reset(&c->arena);
    c->stage = arena_alloc(&c->arena, s->bytes, 1, STAGE_ALIGN);
    memcpy(c->stage, s, s->bytes);
    c->of = s;
    return c->stage;
}

/* Tiles as small as a farm's would only cost time here; the pixels are the same. */
static void go(struct chart_run *r, struct copy *copy, struct arena *scratch)
{
    struct stage *s = copy_of(copy, r->stage);
    const struct tile_rect window = window_of(s);
    struct film film;
    s->settings.seed = r->seed;
    s->settings.target.spp = r->spp;
    const int64_t begin = clock_thread_cpu_us();
    film_init(&film, window);
    for (uint32_t p = 0; p < tile_pass_count(r->spp); p++) {
        arena_reset(scratch);
        struct film_samples samples = film_samples_make(window, tile_pass_of(p, r->spp), scratch);
        render_tile(s, &samples);
        film_merge(&film, &samples);
    }
    r->seconds = (double)(clock_thread_cpu_us() - begin) * 1e-6;
    r->work = film.work;
    const struct evidence e = evidence_make(&film, scratch);
    r->unknown = e.few;
    r->heavy = e.heavy;
    for (size_t i = 0; i < tile_rect_pixels(window); i++)
        film_mean(&film, i, r->image + 3 * i);
    film_release(&film);
}

static void tell(struct chart_crew *c)
{
    const uint32_t before = 100 * c->runs_done / max_u32(c->runs_all, 1);
    c->runs_done++;
    const uint32_t now = 100 * c->runs_done / max_u32(c->runs_all, 1);
    if (c->quiet || now == before || (!isatty(2) && now % 10 != 0))
        return;
    fprintf(stderr, isatty(2) ? "\rchart: %3u %% of the samples' runs%s" : "chart: %u %%%s\n", now,
            isatty(2) && c->runs_done == c->runs_all ? "\n" : "");
}

static void *work(void *arg)
{
    struct share *s = arg;
    struct copy copy = {0};
    struct arena scratch = {0};
    for (;;) {
        pthread_mutex_lock(&s->lock);
        const uint32_t i = s->next++;
        pthread_mutex_unlock(&s->lock);
        if (i >= s->count)
            break;
        go(&s->runs[i], &copy, &scratch);
        pthread_mutex_lock(&s->lock);
        tell(s->crew);
        pthread_mutex_unlock(&s->lock);
    }
    arena_release(&scratch);
    arena_release(&copy.arena);
    return NULL;
}

void chart_runs_do(struct chart_crew *crew, struct chart_run runs[], uint32_t count)
{
    struct share s = {.crew = crew, .runs = runs, .count = count};
    pthread_t thread[MOST_THREADS];
    uint32_t started = 0;
    const uint32_t wanted = min_u32(min_u32(crew->threads, count), MOST_THREADS);
    pthread_mutex_init(&s.lock, NULL);
    while (started + 1 < wanted && !pthread_create(&thread[started], NULL, work, &s))
        started++; /* fewer will do */
    work(&s);
    for (uint32_t i = 0; i < started; i++)
        pthread_join(thread[i], NULL);
    pthread_mutex_destroy(&s.lock);
}

/* G. Steele, D. Lea, C. Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014. */
uint64_t chart_runs_seed(uint64_t base, uint32_t of, uint32_t n)
{
    uint64_t z = base + 0x9e3779b97f4a7c15u * (((uint64_t)of << 32 | n) + 1);
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (z ^ z >> 31) & ((1ull << 53) - 1);
}
