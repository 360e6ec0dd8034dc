/* SPDX-License-Identifier: MIT */
#include "bench/embree.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <pmmintrin.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/arena.h"
#include "common/clock.h"

#define STRING(x)  #x
#define VERSION(x) STRING(x)

struct embree {
    RTCDevice device;
    RTCScene scene; /* of the last build */
    RTCGeometry *geometries;
    uint32_t count;
    enum embree_kind kind;
    int64_t allocated; /* by the device, now */
    int64_t bytes;     /* by the last build */
};

const char *embree_version(void)
{
    return VERSION(RTC_VERSION_MAJOR) "." VERSION(RTC_VERSION_MINOR) "." VERSION(RTC_VERSION_PATCH);
}

/* --- the scene --- */

static void fail(void *unused, enum RTCError code, const char *text)
{
    (void)unused;
    fprintf(stderr, "embree: error %d: %s\n", (int)code, text);
    exit(1);
}

static bool count_memory(void *owner, ssize_t bytes, bool post)
{
    (void)post;
    ((struct embree *)owner)->allocated += bytes;
    return true;
}

static unsigned flush_denormals(void)
{
    const unsigned old = _mm_getcsr();
    _mm_setcsr(old | _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON);
    return old;
}

static RTCGeometry geometry_new(RTCDevice device, const struct xform *to_world,
                                const struct mesh *mesh)
{
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *v = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                       sizeof(float[3]), mesh->vertex_count);
    for (size_t i = 0; i < mesh->vertex_count; i++)
        vec3_store(v + 3 * i, xform_point(to_world, vec3_load(mesh->vertices + 3 * i)));
    uint32_t *t = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                          sizeof(uint32_t[3]), mesh->triangle_count);
    memcpy(t, mesh->indices, sizeof(uint32_t[3]) * mesh->triangle_count);
    rtcCommitGeometry(g);
    return g;
}

static RTCGeometry geometry_of(RTCDevice device, const struct scene *scene,
                               const struct shape *shape)
{
    static const uint32_t two[] = {0, 1, 2, 0, 2, 3};
    if (shape->kind == SHAPE_MESH)
        return geometry_new(device, &shape->to_world, &scene->meshes[shape->mesh.mesh]);
    if (shape->kind != SHAPE_QUAD)
        fail(NULL, RTC_ERROR_INVALID_ARGUMENT, "only meshes and quads are handed over");
    const struct mesh quad = {.vertices = shape->quad.vertices[0],
                              .indices = two,
                              .vertex_count = 4,
                              .triangle_count = 2};
    return geometry_new(device, &shape->to_world, &quad);
}

static struct embree *open_device(const struct scene *scene, enum embree_kind kind,
                                  const char *config)
{
    struct embree *e = arena_malloc(1, sizeof *e);
    e->kind = kind;
    e->device = rtcNewDevice(config);
    if (!e->device)
        fail(NULL, rtcGetDeviceError(NULL), "no device");
    rtcSetDeviceErrorFunction(e->device, fail, NULL);
    rtcSetDeviceMemoryMonitorFunction(e->device, count_memory, e);
    e->count = scene->shape_count;
    e->geometries = arena_malloc(e->count, sizeof *e->geometries);
    for (uint32_t i = 0; i < e->count; i++)
        e->geometries[i] = geometry_of(e->device, scene, &scene->shapes[i]);
    return e;
}

struct embree *embree_new(const struct scene *scene, enum embree_kind kind)
{
    return open_device(scene, kind, "threads=1");
}

void embree_free(struct embree *e)
{
    if (e->scene)
        rtcReleaseScene(e->scene);
    for (uint32_t i = 0; i < e->count; i++)
        rtcReleaseGeometry(e->geometries[i]);
    rtcReleaseDevice(e->device);
    free(e->geometries);
    free(e);
}

int64_t embree_build(struct embree *e)
{
    if (e->scene)
        rtcReleaseScene(e->scene);
    e->scene = rtcNewScene(e->device);
    if (e->kind == EMBREE_ROBUST)
        rtcSetSceneFlags(e->scene, RTC_SCENE_FLAG_ROBUST);
    for (uint32_t i = 0; i < e->count; i++)
        rtcAttachGeometry(e->scene, e->geometries[i]);
    const unsigned mode = flush_denormals();
    const int64_t allocated = e->allocated, begin = clock_process_cpu_us();
    rtcCommitScene(e->scene);
    const int64_t us = clock_process_cpu_us() - begin;
    _mm_setcsr(mode);
    e->bytes = e->allocated - allocated;
    return us;
}

uint64_t embree_bytes(const struct embree *e)
{
    return (uint64_t)e->bytes;
}

/* --- rays --- */

static inline struct RTCRay ray_of(const struct shot *s)
{
    return (struct RTCRay){.org_x = s->origin[0],
                           .org_y = s->origin[1],
                           .org_z = s->origin[2],
                           .tnear = s->t_min,
                           .dir_x = s->dir[0],
                           .dir_y = s->dir[1],
                           .dir_z = s->dir[2],
                           .tfar = s->t_max,
                           .mask = UINT32_MAX};
}

static inline void fill(struct RTCRayHit *r, const struct shot *s)
{
    r->ray = ray_of(s);
    r->hit.geomID = RTC_INVALID_GEOMETRY_ID;
    r->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}

static inline struct shot_hit hit_of(const struct RTCRayHit *r)
{
    return (struct shot_hit){r->ray.tfar, r->hit.u, r->hit.v,
                             r->hit.geomID == RTC_INVALID_GEOMETRY_ID ? SHOTS_MISS : r->hit.primID};
}

static inline struct shot_hit blocked_of(float t_far) /* Embree sets it to -infinity */
{
    return (struct shot_hit){.prim = t_far < 0 ? 0 : SHOTS_MISS};
}

static void trace_single(RTCScene scene, struct RTCIntersectContext *context, const struct shots *s,
                         struct shot_hit *hits)
{
    if (s->kind == SHOTS_SHADOW)
        for (size_t i = 0; i < s->count; i++) {
            struct RTCRay r = ray_of(&s->list[i]);
            rtcOccluded1(scene, context, &r);
            hits[i] = blocked_of(r.tfar);
        }
    else
        for (size_t i = 0; i < s->count; i++) {
            struct RTCRayHit r;
            fill(&r, &s->list[i]);
            rtcIntersect1(scene, context, &r);
            hits[i] = hit_of(&r);
        }
}

enum { WIDE = 8 };

static void fill_wide(struct RTCRay8 *r, const struct shot *s, size_t count, int valid[WIDE])
{
    for (size_t k = 0; k < WIDE; k++) {
        const struct shot *shot = &s[min_size(k, count - 1)];
        valid[k] = k < count ? -1 : 0;
        r->org_x[k] = shot->origin[0];
        r->org_y[k] = shot->origin[1];
        r->org_z[k] = shot->origin[2];
        r->tnear[k] = shot->t_min;
        r->dir_x[k] = shot->dir[0];
        r->dir_y[k] = shot->dir[1];
        r->dir_z[k] = shot->dir[2];
        r->tfar[k] = shot->t_max;
        r->time[k] = 0;
        r->mask[k] = UINT32_MAX;
        r->id[k] = 0;
        r->flags[k] = 0;
    }
}

static void trace_packets(RTCScene scene, struct RTCIntersectContext *context,
                          const struct shots *s, struct shot_hit *hits)
{
    alignas(32) int valid[WIDE];
    for (size_t i = 0; i < s->count; i += WIDE) {
        const size_t count = min_size(WIDE, s->count - i);
        struct RTCRayHit8 r;
        fill_wide(&r.ray, s->list + i, count, valid);
        if (s->kind == SHOTS_SHADOW) {
            rtcOccluded8(valid, scene, context, &r.ray);
            for (size_t k = 0; k < count; k++)
                hits[i + k] = blocked_of(r.ray.tfar[k]);
            continue;
        }
        for (size_t k = 0; k < WIDE; k++)
            r.hit.geomID[k] = r.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect8(valid, scene, context, &r);
        for (size_t k = 0; k < count; k++)
            hits[i + k] = (struct shot_hit){
                r.ray.tfar[k], r.hit.u[k], r.hit.v[k],
                r.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID ? SHOTS_MISS : r.hit.primID[k]};
    }
}

static void trace_stream(RTCScene scene, struct RTCIntersectContext *context, const struct shots *s,
                         struct shot_hit *hits)
{
    enum { STREAM = 256 };
    for (size_t i = 0; i < s->count; i += STREAM) {
        const size_t count = min_size(STREAM, s->count - i);
        const struct shot *shots = s->list + i;
        if (s->kind == SHOTS_SHADOW) {
            struct RTCRay r[STREAM];
            for (size_t k = 0; k < count; k++)
                r[k] = ray_of(&shots[k]);
            rtcOccluded1M(scene, context, r, (unsigned)count, sizeof *r);
            for (size_t k = 0; k < count; k++)
                hits[i + k] = blocked_of(r[k].tfar);
        } else {
            struct RTCRayHit r[STREAM];
            for (size_t k = 0; k < count; k++)
                fill(&r[k], &shots[k]);
            rtcIntersect1M(scene, context, r, (unsigned)count, sizeof *r);
            for (size_t k = 0; k < count; k++)
                hits[i + k] = hit_of(&r[k]);
        }
    }
}

void embree_trace(const struct embree *e, enum embree_call call, const struct shots *s,
                  struct shot_hit *hits)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (s->kind == SHOTS_PRIMARY)
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    const unsigned mode = flush_denormals();
    switch (call) {
    case EMBREE_SINGLE:
        trace_single(e->scene, &context, s, hits);
        break;
    case EMBREE_PACKETS:
        trace_packets(e->scene, &context, s, hits);
        break;
    case EMBREE_STREAM:
        trace_stream(e->scene, &context, s, hits);
        break;
    }
    _mm_setcsr(mode);
}

/* --- the cost of the tree --- */

/* What `build` writes to standard output, into `file`. */
static void build_into(const struct scene *scene, FILE *file)
{
    fflush(stdout);
    const int out = dup(STDOUT_FILENO);
    if (out < 0 || dup2(fileno(file), STDOUT_FILENO) < 0)
        fail(NULL, RTC_ERROR_UNKNOWN, "standard output cannot be redirected");
    struct embree *e = open_device(scene, EMBREE_DEFAULT, "threads=1,verbose=2");
    embree_build(e);
    embree_free(e);
    fflush(stdout); /* its C++ stream writes through C's */
    dup2(out, STDOUT_FILENO);
    close(out);
}

double embree_sah(const struct scene *scene)
{
    FILE *file = tmpfile();
    if (!file)
        fail(NULL, RTC_ERROR_UNKNOWN, "no temporary file");
    build_into(scene, file);
    rewind(file);
    char line[512];
    double sah = (double)NAN;
    while (fgets(line, sizeof line, file))
        if (sscanf(line, " total : sah = %lf", &sah) == 1)
            break;
    fclose(file);
    return sah;
}
