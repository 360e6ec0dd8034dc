/* SPDX-License-Identifier: MIT */
#include "worker/pool.h"

#include <pthread.h>
#include <stdlib.h>

#include "common/clock.h"
#include "common/trace/render.h"
#include "common/trace/study.h"
#include "common/wire.h"

struct pool {
    pthread_t *threads;
    uint32_t thread_count;
    struct mailbox *ready; /* passes that no thread has begun */
    struct mailbox *done;  /* the owner's */
    atomic_int_fast64_t idle_ms;
};

static void encode(struct pass *pass, struct film_samples *samples)
{
    const struct wire_samples message = {
        .job = pass->lease.job_number,
        .tile = pass->lease.tile,
        .pass = pass->lease.pass_index,
        .cpu_us = pass->cpu_us,
        .samples = *samples,
    };
    wire_encode(&message, &pass->payload);
    pass->invalid_count = samples->invalid_count;
}

static void render(struct pass *pass, struct arena *scratch)
{
    const int64_t begin_us = clock_thread_cpu_us();
    const struct tile_rect rect = pass->lease.rect;
    struct film_samples samples = film_samples_make(rect, pass->lease.pass, scratch);
    film_samples_add_layers(&samples, pass->stage->film.layers, scratch);
    film_samples_restrict(&samples, &pass->lease.blocks);
    for (uint32_t y = rect.y_begin; y < rect.y_end; y++) {
        if (atomic_load_explicit(&pass->abandon, memory_order_relaxed))
            return;
        render_row(pass->stage, &samples, y);
    }
    pass->cpu_us = (uint64_t)(clock_thread_cpu_us() - begin_us);
    encode(pass, &samples);
    pass->finished = true;
}

static bool is_abandoned(const void *user)
{
    const atomic_bool *flag = user;
    return atomic_load_explicit(flag, memory_order_relaxed);
}

static void make_plan(struct pass *pass, struct arena *scratch)
{
    struct plan plan;
    const int64_t begin_us = clock_thread_cpu_us();
    const struct study_halt halt = {is_abandoned, &pass->abandon};
    if (!study_make(pass->stage, &halt, scratch, &plan))
        return;
    pass->cpu_us = (uint64_t)(clock_thread_cpu_us() - begin_us);
    plan_print(&plan, &pass->payload);
    pass->finished = true;
}

static void *run(void *user)
{
    struct pool *pool = user;
    struct arena scratch = {0};
    for (;;) {
        const int64_t begin_ms = clock_ms();
        struct pass *pass = mailbox_pop(pool->ready);
        if (!pass)
            break;
        atomic_fetch_add(&pool->idle_ms, clock_ms() - begin_ms);
        if (pass->lease.plan)
            make_plan(pass, &scratch);
        else
            render(pass, &scratch);
        arena_reset(&scratch);
        mailbox_push(pool->done, pass);
    }
    arena_release(&scratch);
    return NULL;
}

struct pool *pool_new(uint32_t threads, size_t room, struct mailbox *done)
{
    struct pool *pool = arena_malloc(1, sizeof *pool);
    pool->threads = arena_malloc(threads, sizeof *pool->threads);
    pool->ready = mailbox_new(room, -1);
    pool->done = done;
    atomic_init(&pool->idle_ms, 0);
    while (pool->thread_count < threads &&
           !pthread_create(&pool->threads[pool->thread_count], NULL, run, pool))
        pool->thread_count++;
    if (!pool->thread_count)
        abort(); /* not one thread: the machine is full */
    return pool;
}

void pool_free(struct pool *pool)
{
    mailbox_close(pool->ready);
    for (uint32_t i = 0; i < pool->thread_count; i++)
        pthread_join(pool->threads[i], NULL);
    mailbox_free(pool->ready);
    free(pool->threads);
    free(pool);
}

void pool_submit(struct pool *pool, struct pass *pass)
{
    mailbox_push(pool->ready, pass);
}

struct pass *pool_take_back(struct pool *pool)
{
    return mailbox_try_pop(pool->ready);
}

int64_t pool_idle_ms(const struct pool *pool)
{
    return atomic_load(&pool->idle_ms);
}
