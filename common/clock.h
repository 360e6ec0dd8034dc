/* clock.h - monotonic time. Only main loops call it; everything below takes now_ms.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_CLOCK_H
#define COMMON_CLOCK_H

#include "common/base.h"

int64_t clock_ms(void);      /* monotonic, arbitrary origin */
int64_t clock_unix_ms(void); /* wall clock, for people only: never compared with another's */
int64_t clock_thread_cpu_us(void);  /* CPU time of the calling thread */
int64_t clock_process_cpu_us(void); /* of all threads there have been */
void clock_sleep_ms(int64_t ms);

#endif
