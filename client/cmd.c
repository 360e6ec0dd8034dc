/* SPDX-License-Identifier: MIT */
#include "client/cmd.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "client/watch.h"

enum { MAX_FLAGS = 32 };

#define DEFAULT_SERVER "http://127.0.0.1:7080"

static int misuse(const struct cmd_spec *spec, const char *what)
{
    fprintf(stderr, "smalti %s: %s\nTry 'smalti %s --help'.\n", spec->name, what, spec->name);
    return CMD_USAGE;
}

bool cmd_parse(const struct cmd_spec *spec, int argc, char *const *args, const char **operands,
               size_t *operand_count, int *status)
{
    struct flags_entry table[MAX_FLAGS];
    bool help = false;
    struct err err;
    const size_t count = min_size(spec->flag_count, MAX_FLAGS - 1);
    for (size_t i = 0; i < count; i++)
        table[i] = spec->flags[i];
    table[count] =
        (struct flags_entry){.name = "help", .kind = FLAGS_SWITCH, .value = &help, .letter = 'h'};
    const bool good = flags_parse(table, count + 1, argc, args, operands, spec->operand_most,
                                  operand_count, &err);
    *status = CMD_OK;
    if (help) {
        fputs(spec->usage, stdout);
        return false;
    }
    if (!good)
        *status = misuse(spec, err.text);
    else if (*operand_count < spec->operand_least)
        *status = misuse(spec, "an argument is missing");
    return *status == CMD_OK;
}

bool cmd_open(struct remote *remote, const char *flag, int *status)
{
    const char *environment = getenv("SMALTI_SERVER");
    const char *server = flag ? flag : environment && *environment ? environment : DEFAULT_SERVER;
    struct err err;
    if (remote_open(remote, server, &err))
        return true;
    fprintf(stderr, "smalti: %s\n", err.text);
    *status = CMD_USAGE;
    return false;
}

bool cmd_check_id(const char *text)
{
    if (remote_is_id(text))
        return true;
    fprintf(stderr, "smalti: expected a job's id (16 hex digits), got '%s'\n", text);
    return false;
}

bool cmd_open_job(struct cmd_job *j, const struct cmd_spec *spec, int argc, char *const *args,
                  int *status)
{
    size_t operands;
    if (!cmd_parse(spec, argc, args, &j->id, &operands, status))
        return false;
    if (cmd_check_id(j->id))
        return cmd_open(&j->remote, j->server, status);
    *status = CMD_USAGE;
    return false;
}

int cmd_follow(struct remote *remote, const char *id, bool json, bool curve)
{
    struct err err;
    struct progress progress = progress_make(stderr, json);
    struct watch watch = {
        .remote = remote, .id = id, .progress = &progress, .json = json, .curve = curve};
    switch (watch_run(&watch, &err)) {
    case WATCH_RUNNING:
    case WATCH_OVER:
        return watch_verdict(&watch);
    case WATCH_SIGNAL:
        return CMD_INTERRUPTED;
    case WATCH_LOST:
        return cmd_fail(&err);
    }
    __builtin_unreachable();
}

bool cmd_load_scene(const char *file, struct scene_disk *scene, struct arena *arena, int *status)
{
    struct scene_errors errors;
    uint32_t unread;
    if (!scene_disk_open(scene, file, arena, &errors) ||
        !scene_disk_load(scene, arena, &unread, &errors)) {
        *status = cmd_fail_scene(file, &errors);
        return false;
    }
    if (!unread)
        return true;
    fprintf(stderr, "%s: %u meshes or images are named by their hash only; name their files\n",
            file, unread);
    *status = CMD_INPUT;
    return false;
}

bool cmd_can_trace(int *status)
{
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        return true;
    fprintf(stderr, "smalti: this CPU lacks AVX2 and FMA, which tracing is built for\n");
    *status = CMD_SYSTEM;
    return false;
}

int cmd_fail(const struct err *err)
{
    fprintf(stderr, "smalti: %s\n", err->text);
    switch (err->code) {
    case ERR_INPUT:
    case ERR_LIMIT:
        return CMD_INPUT;
    case ERR_NOT_FOUND:
    case ERR_CONFLICT:
    case ERR_PROTOCOL:
        return CMD_FAILED;
    case ERR_IO:
        return CMD_UNREACHABLE;
    }
    __builtin_unreachable();
}

void cmd_warn_scene(const char *file, const struct scene *scene)
{
    for (uint32_t i = 0; i < scene->warning_count; i++)
        fprintf(stderr, "warning: %s: %s: %s\n", file, scene->warnings[i].where,
                scene->warnings[i].what);
}

int cmd_fail_scene(const char *file, const struct scene_errors *errors)
{
    for (size_t i = 0; i < errors->count; i++) {
        const struct scene_error *e = &errors->list[i];
        if (*e->where)
            fprintf(stderr, "%s: %s: %s\n", file, e->where, e->what);
        else
            fprintf(stderr, "%s: %s\n", file, e->what);
    }
    return CMD_INPUT;
}
