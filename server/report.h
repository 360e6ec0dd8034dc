/* report.h - what a film says of itself besides its error: how much of it may be trusted, and what
 * was left out of it. `stopped` is not a film's to know, and is left 0. Pure.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_REPORT_H
#define SERVER_REPORT_H

#include "server/store.h"

struct store_report report_make(const struct film *);
struct store_report report_none(void); /* nothing is known yet */

#endif
