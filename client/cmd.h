/* cmd.h - the commands of `smalti`, and what they share: flags, usage, exit status.
 *
 * A command takes the arguments after its own name and returns the program's exit status. Its usage
 * text stands in its own file.
 * SPDX-License-Identifier: MIT */
#ifndef CLIENT_CMD_H
#define CLIENT_CMD_H

#include "client/remote.h"
#include "common/err.h"
#include "common/flags.h"
#include "common/scene_disk.h"

enum cmd_status {
    CMD_OK = 0,
    CMD_FAILED = 1, /* the job failed or was cancelled; images differ */
    CMD_USAGE = 2,
    CMD_INPUT = 3,       /* the scene, image or id given is not valid */
    CMD_UNREACHABLE = 4, /* no answer from the coordinator */
    CMD_SYSTEM = 5,      /* a file cannot be written, a process cannot be started */
    CMD_INTERRUPTED = 130,
};

int cmd_render(int argc, char *const *args);
int cmd_submit(int argc, char *const *args);
int cmd_status(int argc, char *const *args);
int cmd_watch(int argc, char *const *args);
int cmd_fetch(int argc, char *const *args);
int cmd_cancel(int argc, char *const *args);
int cmd_continue(int argc, char *const *args);
int cmd_check(int argc, char *const *args);
int cmd_replay(int argc, char *const *args);
int cmd_plan(int argc, char *const *args);
int cmd_diff(int argc, char *const *args);
int cmd_digest(int argc, char *const *args);
int cmd_chart(int argc, char *const *args);

/* What a command accepts. */
struct cmd_spec {
    const char *name, *usage;
    const struct flags_entry *flags; /* --help is understood everywhere */
    size_t flag_count;
    size_t operand_least, operand_most;
};

/* False: the command is over, with *status (help was printed, or what is wrong). */
bool cmd_parse(const struct cmd_spec *, int argc, char *const *args, const char **operands,
               size_t *operand_count, int *status) MUST_CHECK;

/* The coordinator at the flag's address, $SMALTI_SERVER's or the default; false: *status. */
bool cmd_open(struct remote *, const char *flag, int *status) MUST_CHECK;

/* A command about one job: its only operand is the id. `server` is the flag's variable, among the
 * spec's flags. The coordinator is to be closed. */
struct cmd_job {
    const char *server, *id;
    struct remote remote;
};

bool cmd_open_job(struct cmd_job *, const struct cmd_spec *, int argc, char *const *args,
                  int *status) MUST_CHECK;

/* The document and every file that it needs; false: *status, and it was said on stderr what is
 * wrong or named by its hash only. */
bool cmd_load_scene(const char *file, struct scene_disk *, struct arena *, int *status) MUST_CHECK;

bool cmd_can_trace(int *status);     /* false: this CPU cannot; said on stderr */
bool cmd_check_id(const char *text); /* false: said on stderr that it is none */

/* Shows a job until it ends (call watch_block before); returns the exit status. */
int cmd_follow(struct remote *, const char *id, bool json, bool curve);

/* "smalti: TEXT" on stderr; returns the status that fits the code. */
int cmd_fail(const struct err *);

/* "warning: FILE: POINTER: TEXT", one line each, on stderr. */
void cmd_warn_scene(const char *file, const struct scene *);

/* "FILE: POINTER: TEXT", one line each, on stderr; returns CMD_INPUT. */
int cmd_fail_scene(const char *file, const struct scene_errors *);

#endif
