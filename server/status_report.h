/* status_report.h - a job's report as JSON (docs/http.md): in its status, and in the image's
 * attributes. SPDX-License-Identifier: MIT */
#ifndef SERVER_STATUS_REPORT_H
#define SERVER_STATUS_REPORT_H

#include "server/store.h"

struct json_t;

struct json_t *status_report(const struct store_job *);         /* the caller's */
char *status_report_text(const struct store_job *);             /* likewise, by free() */
struct json_t *status_report_invalid(const struct store_job *); /* {"count", "keys"} */

#endif
