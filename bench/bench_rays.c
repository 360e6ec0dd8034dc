/* bench_rays: our ray kernel beside Embree's on six scenes, in one run: rays per CPU second,
 * builds, memory, leaks. bench/meshes.h has the scenes, shots.h the rays, race.h how time is taken;
 * docs/speed.md says how to read the table. Last line: "bench-rays: geomean X min Y" over all
 * cells, our rate / Embree default's, single rays both; the lines before it say the same against
 * Embree robust, and of our batches of eight. SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/leaks.h"
#include "bench/meshes.h"
#include "bench/race.h"
#include "client/save.h"
#include "common/flags.h"

static const char usage[] =
    "usage: bench_rays [--scene NAME] [--quick] [--csv FILE] [--assets DIR]\n"
    "  --scene NAME   only bunny, interior, terrain, sphere, soup, cornell or leaks\n"
    "  --quick        fewer rays, rounds and builds: half a minute, for a first look\n"
    "  --csv FILE     every figure as a line: scene,row,kernel,figure,value\n"
    "  --assets DIR   where stanford-bunny.obj is (default ../shared/assets)\n";

static const char csv_head[] = "scene,row,kernel,figure,value\n";

struct options {
    const char *scene, *csv, *assets;
    bool quick, help;
};

struct effort { /* full, --quick */
    uint32_t side_px, rays, rounds, info_rounds, builds;
    uint32_t sphere; /* its triangles; 0: all 5 million */
    uint64_t aimed;  /* rays at each mesh and offset */
    bool sah;
};

static const struct effort full = {768, 500000, 5, 2, 3, 0, 1666667, true};
static const struct effort quick = {256, 60000, 3, 1, 1, 1000000, 50000, false};

enum { LARGE = 500000 }; /* triangles: builds of at least so many are judged */

static const double none = (double)NAN; /* a figure there is not */

/* Ratios, gathered for their geometric mean. */
struct score {
    double log_sum, least;
    int count;
};

struct report {
    const struct options *options;
    const struct effort *effort;
    struct score rays[EMBREE_KINDS], eights[EMBREE_KINDS], build;
    double sah, bytes;  /* the worst: ours / Embree's; of ours */
    uint32_t triangles; /* of the scene at hand */
    struct buf csv;
    struct arena arena;
};

static void score_add(struct score *s, double ratio)
{
    s->log_sum += log(ratio);
    s->least = s->count && s->least < ratio ? s->least : ratio;
    s->count++;
}

/* Without Embree there are no ratios. */
static const char *score_text(const struct score *s, char text[64])
{
    if (!s->count || !isfinite(s->log_sum))
        return "geomean - min -";
    snprintf(text, 64, "geomean %.3f min %.3f", exp(s->log_sum / s->count), s->least);
    return text;
}

/* where: "scene,row" */
static void write_csv(struct report *r, const char *where, const char *kernel, const char *what,
                      double value)
{
    char line[256];
    if (!isfinite(value))
        return;
    const int n = snprintf(line, sizeof line, "%s,%s,%s,%g\n", where, kernel, what, value);
    buf_append(&r->csv, line, min_size((size_t)n, sizeof line - 1));
}

/* A figure, or a dash where there is none. */
static const char *figure(double v, int digits, char text[32])
{
    snprintf(text, 32, "%.*f", digits, v);
    return isfinite(v) ? text : "-";
}

/* --- one scene --- */

static void print_trees(struct report *r, const char *name, const struct race_trees *t)
{
    char a[3][32];
    const char *where = arena_printf(&r->arena, "%s,build", name);
    printf("  %-8s %8s %8s %8s %8s\n", "tree", "CPU s", "/ours", "SAH", "B/tri");
    for (int k = 0; k <= RACE_OURS; k++) {
        const char *kernel = race_name((enum race_kernel)k);
        const double sah = k == RACE_OURS ? t->sah_ours : k == RACE_EMBREE ? t->sah : none;
        printf("  %-8s %8s", kernel, figure(t->seconds[k], 3, a[0]));
        printf(" %8s", k < RACE_OURS ? figure(t->ratio[k], 3, a[0]) : "");
        printf(" %8s %8s\n", figure(sah, 2, a[1]), figure(t->bytes[k], 1, a[2]));
        write_csv(r, where, kernel, "seconds", t->seconds[k]);
        write_csv(r, where, kernel, "sah", sah);
        write_csv(r, where, kernel, "bytes_per_triangle", t->bytes[k]);
    }
    if (r->triangles < LARGE)
        return;
    score_add(&r->build, t->ratio[RACE_EMBREE]);
    r->sah = fmax(r->sah, t->sah_ours / t->sah);
    r->bytes = fmax(r->bytes, t->bytes[RACE_OURS]);
}

static void print_rays_head(void)
{
    printf("  %-8s", "Mrays/s");
    for (int k = 0; k < RACE_KERNELS; k++)
        printf(" %8s", race_name((enum race_kernel)k));
    printf(" %8s %8s %8s %8s %8s\n", "o/embree", "o/robust", "e/embree", "% hit", "% t");
}

static void print_rays(struct report *r, const char *name, const struct shots *shots,
                       const struct race_rays *c)
{
    static const char *const ratio_to[] = {"ratio_to_embree", "ratio_to_robust"};
    char text[32];
    const char *where = arena_printf(&r->arena, "%s,%s", name, shots_name(shots->kind));
    printf("  %-8s", shots_name(shots->kind));
    for (int k = 0; k < RACE_KERNELS; k++) {
        const char *kernel = race_name((enum race_kernel)k);
        printf(" %8s", figure(c->rate[k], 2, text));
        write_csv(r, where, kernel, "mrays_per_s", c->rate[k]);
        write_csv(r, where, kernel, "other_hit", c->other_hit[k]);
        write_csv(r, where, kernel, "other_t", c->other_t[k]);
    }
    for (int k = 0; k < EMBREE_KINDS; k++) {
        printf(" %8s", figure(c->ratio[k], 3, text));
        write_csv(r, where, race_name(RACE_OURS), ratio_to[k], c->ratio[k]);
        write_csv(r, where, race_name(RACE_EIGHTS), ratio_to[k], c->eights[k]);
        score_add(&r->rays[k], c->ratio[k]);
        score_add(&r->eights[k], c->eights[k]);
    }
    printf(" %8s", figure(c->eights[EMBREE_DEFAULT], 3, text));
    printf(" %8s", figure(100 * c->other_hit[RACE_OURS], 4, text));
    printf(" %8s\n", figure(100 * c->other_t[RACE_OURS], 4, text));
    fflush(stdout);
}

static void measure(struct report *r, const char *name, struct meshes *m)
{
    const struct effort *e = r->effort;
    struct scene_film *film = &m->scenes.scene.film;
    film->width_px = film->height_px = film->crop_x_end = film->crop_y_end = e->side_px;
    struct race race = {.stage = scenes_stage(&m->scenes),
                        .scene = &m->scenes.scene,
                        .rounds = e->rounds,
                        .info_rounds = e->info_rounds,
                        .builds = e->builds,
                        .sah = e->sah};
    struct race_trees trees;
    race_build(&race, &trees);
    print_trees(r, name, &trees);
    struct shots sets[SHOTS_KINDS];
    shots_make(race.stage, m->lamp, e->rays, &m->scenes.arena, sets);
    print_rays_head();
    for (int kind = 0; kind < SHOTS_KINDS; kind++) {
        struct race_rays cell;
        race_run(&race, &sets[kind], &cell);
        print_rays(r, name, &sets[kind], &cell);
    }
    race_release(&race);
}

static bool run_scene(struct report *r, enum meshes_kind kind, struct err *err)
{
    struct meshes m;
    const uint32_t size = kind == MESHES_SPHERE ? r->effort->sphere : 0;
    if (!meshes_init(&m, kind, size, r->options->assets, err))
        return false;
    r->triangles = m.triangles;
    printf("\n%s: %s, %u triangles\n", meshes_name(kind), m.what, m.triangles);
    measure(r, meshes_name(kind), &m);
    meshes_release(&m);
    return true;
}

/* --- leaks --- */

static bool run_leaks(struct report *r, struct err *err)
{
    struct leaks rows[LEAKS_ROWS];
    if (!leaks_count(r->options->assets, r->effort->aimed, rows, err))
        return false;
    printf("\nleaks: rays from inside, aimed at vertices and edges, that hit nothing\n"
           "  %-8s %8s %10s %8s %8s %8s\n",
           "mesh", "offset", "rays", "embree", "robust", "ours");
    struct leaks all = {.mesh = "all"};
    for (size_t i = 0; i < LEAKS_ROWS; i++) {
        const struct leaks *l = &rows[i];
        const char *where = arena_printf(&r->arena, "%s at %g,leaks", l->mesh, (double)l->offset);
        printf("  %-8s %8g %10llu", l->mesh, (double)l->offset, (unsigned long long)l->rays);
        all.rays += l->rays;
        for (int k = 0; k <= RACE_OURS; k++) {
            const bool ran = k == RACE_OURS || embree_version();
            char text[32];
            printf(" %8s", figure(ran ? (double)l->out[k] : none, 0, text));
            write_csv(r, where, race_name((enum race_kernel)k), "rays",
                      ran ? (double)l->out[k] : none);
            all.out[k] += l->out[k];
        }
        printf("\n");
    }
    printf("bench-rays: leaks of %llu aimed rays: ours %llu", (unsigned long long)all.rays,
           (unsigned long long)all.out[RACE_OURS]);
    if (embree_version())
        printf(", Embree default %llu, robust %llu", (unsigned long long)all.out[RACE_EMBREE],
               (unsigned long long)all.out[RACE_ROBUST]);
    printf("\n");
    return true;
}

/* --- all --- */

static bool run_all(struct report *r, struct err *err)
{
    const char *only = r->options->scene;
    bool found = false;
    for (int kind = 0; kind < MESHES_KINDS; kind++)
        if (!only || !strcmp(only, meshes_name((enum meshes_kind)kind))) {
            found = true;
            if (!run_scene(r, (enum meshes_kind)kind, err))
                return false;
        }
    if (!only || !strcmp(only, "leaks"))
        return run_leaks(r, err);
    return found || err_set(err, ERR_INPUT, "--scene: there is no scene '%s'", only);
}

static void print_summary(const struct report *r)
{
    char text[64], a[2][32];
    if (!embree_version())
        printf("Embree: left out (libembree-dev is not installed)\n");
    printf("bench-rays: build %s (CPU seconds of Embree / ours, from %d triangles on)\n",
           score_text(&r->build, text), LARGE);
    printf("bench-rays: tree SAH %s of Embree's at most, %s bytes per triangle at most\n",
           figure(r->sah > 0 ? r->sah : none, 3, a[0]),
           figure(r->bytes > 0 ? r->bytes : none, 1, a[1]));
    printf("bench-rays: by eights: %s", score_text(&r->eights[EMBREE_DEFAULT], text));
    printf("; against robust: %s\n", score_text(&r->eights[EMBREE_ROBUST], text));
    printf("bench-rays: against robust: %s\n", score_text(&r->rays[EMBREE_ROBUST], text));
    printf("bench-rays: %s\n", score_text(&r->rays[EMBREE_DEFAULT], text));
}

static bool parse(int argc, char **argv, struct options *o, struct err *err)
{
    const struct flags_entry table[] = {
        {.name = "scene", .kind = FLAGS_TEXT, .value = &o->scene},
        {.name = "quick", .kind = FLAGS_SWITCH, .value = &o->quick},
        {.name = "csv", .kind = FLAGS_TEXT, .value = &o->csv},
        {.name = "assets", .kind = FLAGS_TEXT, .value = &o->assets},
        {.name = "help", .kind = FLAGS_SWITCH, .value = &o->help, .letter = 'h'},
    };
    size_t operands;
    return flags_parse(table, countof(table), argc - 1, argv + 1, NULL, 0, &operands, err);
}

int main(int argc, char **argv)
{
    struct options options = {.assets = "../shared/assets"};
    struct err err;
    struct report report = {.options = &options};
    if (!parse(argc, argv, &options, &err)) {
        fprintf(stderr, "bench_rays: %s\n%s", err.text, usage);
        return 2;
    }
    if (options.help) {
        fputs(usage, stdout);
        return 0;
    }
    report.effort = options.quick ? &quick : &full;
    printf("one thread; Mrays per CPU second, best of %u rounds; ratios: median over rounds%s%s\n",
           report.effort->rounds, embree_version() ? "; Embree " : "",
           embree_version() ? embree_version() : "");
    buf_append(&report.csv, csv_head, strlen(csv_head));
    bool good = (!options.csv || save_possible(options.csv, &err)) && run_all(&report, &err);
    if (good)
        print_summary(&report);
    good = good && (!options.csv || save_file(options.csv, &report.csv, &err));
    if (!good)
        fprintf(stderr, "bench_rays: %s\n", err.text);
    buf_release(&report.csv);
    arena_release(&report.arena);
    return good ? 0 : 1;
}
