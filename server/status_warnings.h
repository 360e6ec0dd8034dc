/* status_warnings.h - what a document's reader has changed (scene_share.h), as a job's status says
 * it. SPDX-License-Identifier: MIT */
#ifndef SERVER_STATUS_WARNINGS_H
#define SERVER_STATUS_WARNINGS_H

#include "common/scene.h"

/* A JSON array of {"pointer", "detail", "was", "became"}; when not all fit, the first ones, and one
 * more that says how many there are besides. "" when there is none. */
void status_warnings_print(const struct scene *, char *out, size_t size);

#endif
