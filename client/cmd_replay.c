/* jansson: the tree is owned and released where it is printed.
 * SPDX-License-Identifier: MIT */
#include <jansson.h>
#include <stdio.h>

#include "client/cmd.h"
#include "client/remote.h"
#include "common/plan.h"
#include "common/scene_fill.h"
#include "common/trace/prep.h"
#include "common/trace/render.h"

static const char usage[] =
    "Usage: smalti replay ID X,Y SAMPLE [--server URL] [--json]\n"
    "Traces one sample of a job again, here, and prints where its path went: the sample that was\n"
    "rendered, to the bit. X,Y: the pixel, counted from the upper left corner of the frame.\n"
    "SAMPLE counts from 0. A job's invalid samples are named in its report by these numbers.\n"
    "\n"
    "  --server URL     ($SMALTI_SERVER, or http://127.0.0.1:7080)\n"
    "  --json           one JSON object in place of a table\n"
    "\n"
    "Exit status: 0 done, 1 no such job, 2 wrong usage, 3 the job has no such pixel, 4 the\n"
    "coordinator does not answer, 5 this CPU cannot trace.\n";

/* ---- the scene of a job ---- */

static bool get_asset(void *remote, const char *hex, size_t max_bytes, struct buf *out,
                      struct err *err)
{
    return remote_get_asset(remote, hex, max_bytes, out, err);
}

static bool read_document(struct remote *remote, const char *id, struct scene *scene,
                          struct arena *arena, struct err *err)
{
    struct buf document = {0};
    struct scene_errors errors = {0};
    if (!remote_fetch(remote, id, "document", &document, err))
        return false;
    const bool good = scene_parse(scene, document.data ? (const char *)document.data : "",
                                  document.size, SCENE_FROM_NET, arena, &errors);
    buf_release(&document);
    return good ||
           err_set(err, errors.list[0].code, "%s: %s", errors.list[0].where, errors.list[0].what);
}

/* A planned job is traced by the method of its plan. */
static bool read_method(struct remote *remote, const char *id, struct scene_settings *s,
                        struct err *err)
{
    if (s->integrator != INTEGRATOR_AUTO)
        return true;
    struct buf text = {0};
    const char *integrator = "", *strategy = "";
    if (!remote_fetch(remote, id, "plan", &text, err))
        return err_at(err, "the job's plan");
    json_t *root = json_loadb(text.size ? (const char *)text.data : "", text.size, 0, NULL);
    buf_release(&text);
    json_unpack(root, "{s:{s:s, s:s}}", "method", "integrator", &integrator, "strategy", &strategy);
    const enum plan_candidate_kind k = plan_find(integrator, strategy);
    json_decref(root);
    if (k == PLAN_REAL)
        return err_set(err, ERR_PROTOCOL, "the job's plan has no method");
    const struct plan plan = {.sampler = s->sampler};
    s->integrator = plan_method_of(&plan, k).integrator;
    s->strategy = plan_method_of(&plan, k).strategy;
    return true;
}

static bool prepare(struct remote *remote, const char *id, struct scene *scene, struct arena *arena,
                    const struct stage **stage, struct err *err)
{
    struct arena scratch = {0};
    const struct scene_fill from = {get_asset, remote};
    const bool good = read_document(remote, id, scene, arena, err) &&
                      read_method(remote, id, &scene->settings, err) &&
                      scene_fill(scene, &from, arena, err) == SCENE_FILL_DONE &&
                      prep_stage(scene, NULL, arena, &scratch, stage, err);
    arena_release(&scratch);
    return good;
}

/* ---- what is printed ---- */

enum end { END_NONE, END_LEFT, END_STOPPED, END_CUT };

static const char *end_text(enum end e)
{
    static const char *const texts[] = {
        [END_NONE] = "goes on",
        [END_LEFT] = "leaves the scene",
        [END_STOPPED] = "absorbed, or ended by roulette",
        [END_CUT] = "cut by max_bounces",
    };
    return texts[e];
}

static json_t *vector_json(vec3 v)
{
    return json_pack("[f,f,f]", (double)v[0], (double)v[1], (double)v[2]);
}

static json_t *place_json(const struct scene *scene, const struct render_place *p)
{
    const char *name = scene->materials[p->material].name;
    return json_pack("{s:s, s:b, s:o, s:o, s:o, s:o}", "material", name ? name : "", "shines",
                     (int)p->shines, "point", vector_json(p->p), "normal", vector_json(p->ng),
                     "throughput", vector_json(p->throughput), "light", vector_json(p->light));
}

/* The path of a sample: what it met after 0, 1, 2 ... scatterings, and how it ended. */
static json_t *path_json(const struct scene *scene, const struct stage *stage, struct film_key key)
{
    json_t *places = json_array();
    struct render_place place;
    uint64_t traced = 0;
    enum end end = END_NONE;
    for (uint32_t n = 0; end == END_NONE; n++) {
        render_follow(stage, key, n, &place);
        if (place.material != STAGE_NONE)
            json_array_append_new(places, place_json(scene, &place));
        else if (n > stage->settings.max_bounces)
            end = END_CUT;
        else
            end = n == 0 || place.traced > traced ? END_LEFT : END_STOPPED;
        traced = place.traced;
    }
    const rgb light = render_sample(stage, key.x_px, key.y_px, key.sample);
    return json_pack("{s:[I,I], s:I, s:o, s:s, s:o}", "pixel", (json_int_t)key.x_px,
                     (json_int_t)key.y_px, "sample", (json_int_t)key.sample, "path", places, "end",
                     end_text(end), "radiance", vector_json(light));
}

static void print_vector(const json_t *object, const char *key)
{
    const json_t *v = json_object_get(object, key);
    printf("     %-10s %.9g, %.9g, %.9g\n", key, json_number_value(json_array_get(v, 0)),
           json_number_value(json_array_get(v, 1)), json_number_value(json_array_get(v, 2)));
}

static void print_path(const json_t *root)
{
    const json_t *place;
    size_t n;
    json_array_foreach(json_object_get(root, "path"), n, place)
    {
        printf("%3zu  %s%s\n", n, json_string_value(json_object_get(place, "material")),
               json_is_true(json_object_get(place, "shines")) ? ", shines" : "");
        print_vector(place, "point");
        print_vector(place, "normal");
        print_vector(place, "throughput");
        print_vector(place, "light");
    }
    printf("     %s\n", json_string_value(json_object_get(root, "end")));
    print_vector(root, "radiance");
}

static void follow(const struct scene *scene, const struct stage *stage, struct film_key key,
                   bool json)
{
    json_t *root = path_json(scene, stage, key);
    if (json) {
        json_dumpf(root, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(9));
        putchar('\n');
    } else {
        print_path(root);
    }
    json_decref(root);
}

/* ---- arguments ---- */

static bool read_key(const char *pixel, const char *sample, struct film_key *key)
{
    int used = 0, rest = 0;
    if (sscanf(pixel, "%9u,%9u%n", &key->x_px, &key->y_px, &used) == 2 && !pixel[used] &&
        sscanf(sample, "%9u%n", &key->sample, &rest) == 1 && !sample[rest])
        return true;
    fprintf(stderr, "smalti: expected a pixel X,Y and a sample's number, got '%s' and '%s'\n",
            pixel, sample);
    return false;
}

static bool is_in_frame(const struct scene_film *f, struct film_key key, struct err *err)
{
    if (key.x_px >= f->crop_x_begin && key.x_px < f->crop_x_end && key.y_px >= f->crop_y_begin &&
        key.y_px < f->crop_y_end)
        return true;
    return err_set(err, ERR_INPUT,
                   "pixel %u,%u: expected one of what is rendered, [%u, %u) x [%u, %u)", key.x_px,
                   key.y_px, f->crop_x_begin, f->crop_x_end, f->crop_y_begin, f->crop_y_end);
}

int cmd_replay(int argc, char *const *args)
{
    const char *server = NULL, *operands[3];
    bool json = false;
    const struct flags_entry flags[] = {
        {.name = "server", .kind = FLAGS_TEXT, .value = &server},
        {.name = "json", .kind = FLAGS_SWITCH, .value = &json},
    };
    const struct cmd_spec spec = {"replay", usage, flags, countof(flags), 3, 3};
    size_t count;
    int status = CMD_OK;
    struct film_key key;
    struct remote remote;
    if (!cmd_parse(&spec, argc, args, operands, &count, &status))
        return status;
    if (!cmd_check_id(operands[0]) || !read_key(operands[1], operands[2], &key))
        return CMD_USAGE;
    if (!cmd_can_trace(&status) || !cmd_open(&remote, server, &status))
        return status;
    struct arena arena = {0};
    struct scene scene;
    const struct stage *stage;
    struct err err;
    if (prepare(&remote, operands[0], &scene, &arena, &stage, &err) &&
        is_in_frame(&scene.film, key, &err))
        follow(&scene, stage, key, json);
    else
        status = cmd_fail(&err);
    arena_release(&arena);
    remote_close(&remote);
    return status;
}
