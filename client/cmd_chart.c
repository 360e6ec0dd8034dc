/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "client/chart.h"
#include "client/cmd.h"
#include "client/local.h"
#include "client/save.h"
#include "common/scene_disk.h"

static const char usage[] =
    "Usage: smalti chart SCENE [-o DIR] [OPTION]...\n"
    "Charts error against work for every method, and what each piece of the scene's model costs\n"
    "and buys: DIR/NAME.svg and .csv, DIR/NAME-price.svg and -price.csv, NAME being SCENE's.\n"
    "The image is made small and rendered many times, here and now, by all cores.\n"
    "\n"
    "  -o, --output DIR    where the files go; made if it is not there (.)\n"
    "  --size N            pixels of the image's longer side (48)\n"
    "  --spp N             the most samples per pixel of a run, 8 times a power of two (512)\n"
    "  --runs N            independent runs of each point, 4 to 64 (10)\n"
    "  --reference N       samples per pixel of each of the reference's two methods (32 times\n"
    "                      those of --spp)\n"
    "  --threads N         (the cores there are)\n"
    "  --quiet             no progress\n"
    "\n"
    "Everything but seconds is a function of SCENE and these options alone.\n"
    "Exit status: 0 done, 2 wrong usage, 3 the scene is not valid or cannot be charted, 5 a file\n"
    "cannot be written.\n";

enum { FILES = 4 };

struct job {
    const char *scene_file, *dir;
    struct chart_options options;
    struct chart_crew crew;
    struct arena arena;
    struct scene_disk scene;
    struct chart chart;
    const char *paths[FILES];
    bool made_dir;
};

static bool is_spp(uint32_t spp)
{
    return spp >= 2 * CHART_FIRST_SPP && (spp & (spp - 1)) == 0;
}

static bool parse(struct job *j, int argc, char *const *args, int *status)
{
    struct chart_options *o = &j->options;
    const struct flags_entry flags[] = {
        {"output", FLAGS_TEXT, &j->dir, 0, 0, 'o'},
        {"size", FLAGS_COUNT, &o->size_px, 1, 1024, 0},
        {"spp", FLAGS_COUNT, &o->spp, 2 * CHART_FIRST_SPP, 1 << 16, 0},
        {"runs", FLAGS_COUNT, &o->runs, 4, CURVE_MOST_RUNS, 0},
        {"reference", FLAGS_COUNT, &o->reference_spp, 64, 1 << 22, 0},
        {"threads", FLAGS_COUNT, &j->crew.threads, 1, 64, 0},
        {"quiet", FLAGS_SWITCH, &j->crew.quiet, 0, 0, 'q'},
    };
    const struct cmd_spec spec = {"chart", usage, flags, countof(flags), 1, 1};
    size_t operands;
    *j = (struct job){.dir = ".", .options = {48, 512, 10, 0}};
    if (!cmd_parse(&spec, argc, args, &j->scene_file, &operands, status))
        return false;
    if (!is_spp(o->spp)) {
        fprintf(stderr, "smalti chart: --spp must be 8 times a power of two, got %u\n", o->spp);
        *status = CMD_USAGE;
        return false;
    }
    if (!o->reference_spp)
        o->reference_spp = 32 * o->spp;
    o->reference_spp -= o->reference_spp % (8 * CHART_REFERENCE_RUNS);
    if (!j->crew.threads)
        j->crew.threads = local_cores();
    return true;
}

/* --- files --- */

static const char *const endings[FILES] = {".svg", ".csv", "-price.svg", "-price.csv"};

static void name_files(struct job *j)
{
    const char *slash = strrchr(j->scene_file, '/');
    const char *name = slash ? slash + 1 : j->scene_file;
    const char *dot = strrchr(name, '.');
    const int length = dot && dot > name ? (int)(dot - name) : (int)strlen(name);
    for (int i = 0; i < FILES; i++)
        j->paths[i] = arena_printf(&j->arena, "%s/%.*s%s", j->dir, length, name, endings[i]);
}

/* Before the work, not after. */
static bool open_dir(struct job *j, struct err *err)
{
    j->made_dir = mkdir(j->dir, 0777) == 0;
    if (!j->made_dir && errno != EEXIST)
        return err_set(err, ERR_IO, "%s: %s", j->dir, strerror(errno));
    for (int i = 0; i < FILES; i++)
        if (!save_possible(j->paths[i], err))
            return false;
    return true;
}

static void leave_dir(const struct job *j)
{
    if (j->made_dir)
        rmdir(j->dir); /* if it is empty */
}

/* All or none. */
static bool save_all(struct job *j, struct err *err)
{
    struct buf files[FILES] = {{0}};
    int saved = 0;
    chart_draw(&j->chart, &files[0]);
    chart_table(&j->chart, &files[1]);
    chart_draw_price(&j->chart, &files[2]);
    chart_table_price(&j->chart, &files[3]);
    while (saved < FILES && save_file(j->paths[saved], &files[saved], err))
        saved++;
    for (int i = 0; saved < FILES && i < saved; i++)
        unlink(j->paths[i]);
    for (int i = 0; i < FILES; i++)
        buf_release(&files[i]);
    return saved == FILES;
}

static bool make(struct job *j, int *status, struct err *err)
{
    j->crew.runs_all = chart_run_count(&j->scene.scene, &j->options);
    *status = CMD_INPUT;
    if (!chart_measure(&j->chart, &j->scene.scene, &j->options, &j->crew, &j->arena, err) ||
        !chart_price(&j->chart, &j->scene.scene, &j->crew, &j->arena, err))
        return err_at(err, "%s", j->scene_file);
    *status = CMD_SYSTEM;
    return save_all(j, err);
}

static int chart(struct job *j)
{
    struct err err;
    int status = CMD_SYSTEM;
    name_files(j);
    if (open_dir(j, &err) && make(j, &status, &err)) {
        if (!j->crew.quiet)
            for (int i = 0; i < FILES; i++)
                fprintf(stderr, "%s\n", j->paths[i]);
        return CMD_OK;
    }
    fprintf(stderr, "smalti: %s\n", err.text);
    leave_dir(j);
    return status;
}

int cmd_chart(int argc, char *const *args)
{
    static struct job j; /* its lines are large */
    int status;
    if (!parse(&j, argc, args, &status))
        return status;
    if (cmd_can_trace(&status) && cmd_load_scene(j.scene_file, &j.scene, &j.arena, &status))
        status = chart(&j);
    arena_release(&j.arena);
    return status;
}
