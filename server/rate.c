/* SPDX-License-Identifier: MIT */
#include "server/rate.h"

void rate_add(struct rate *r, double amount, int64_t now_ms)
{
    const int64_t bucket = now_ms / RATE_BUCKET_MS;
    if (!r->started) {
        r->started = true;
        r->since_ms = now_ms;
        r->bucket = bucket;
        return;
    }
    for (int i = 0; r->bucket < bucket && i < RATE_BUCKETS; i++)
        r->amount[++r->bucket % RATE_BUCKETS] = 0;
    r->bucket = bucket;
    r->amount[bucket % RATE_BUCKETS] += amount;
    r->total += amount;
}

double rate_per_second(const struct rate *r, int64_t now_ms)
{
    if (!r->started || now_ms <= r->since_ms)
        return 0;
    const int64_t now = now_ms / RATE_BUCKET_MS;
    const int64_t oldest = now - RATE_BUCKETS + 1; /* its bucket is whole */
    double sum = 0;
    for (int64_t b = oldest; b <= r->bucket && b <= now; b++)
        if (b >= 0 && r->bucket - b < RATE_BUCKETS)
            sum += r->amount[b % RATE_BUCKETS];
    const int64_t from_ms = max_i64(oldest * RATE_BUCKET_MS, r->since_ms);
    if (sum > 0 && now_ms > from_ms)
        return sum * 1000 / (double)(now_ms - from_ms);
    /* Passes longer than the window: the mean since the first event. */
    return r->total * 1000 / (double)(now_ms - r->since_ms);
}
