/* upload.h - a scene on disk to a job: its mesh and image files as assets, then the document.
 * SPDX-License-Identifier: MIT */
#ifndef CLIENT_UPLOAD_H
#define CLIENT_UPLOAD_H

#include "client/remote.h"
#include "common/scene_disk.h"

/* scene: after scene_disk_load. Sends the files the coordinator does not have. */
bool upload_assets(struct remote *, const struct scene_disk *scene, struct err *) MUST_CHECK;

/* The document with another target. A value of 0 is left out; not all are. In the arena. */
const char *upload_retarget(const char *json, const struct scene_target *, struct arena *);

#endif
