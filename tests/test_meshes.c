/* The benchmarks' scenes: as many triangles as they say, closed where they should be, fronts
 * outside. SPDX-License-Identifier: MIT */
#include "bench/meshes.h"

#include <math.h>

#include "bench/closure.h"
#include "tests/aim.h"
#include "tests/tap.h"

static size_t open_edges(const struct mesh *m)
{
    struct arena arena = {0};
    struct closure_edge *open;
    const size_t n = closure_open_edges(m, &arena, &open);
    arena_release(&arena);
    return n;
}

static void test_sizes(void)
{
    static const uint32_t full[MESHES_KINDS] = {0, 1058410, 1048352, 5120002, 1000000, 36};
    for (int kind = 0; kind < MESHES_KINDS; kind++) {
        struct meshes m;
        struct err err;
        const char *name = meshes_name((enum meshes_kind)kind);
        if (!ok(meshes_init(&m, (enum meshes_kind)kind, 20000, "no such directory", &err), "%s",
                name))
            continue;
        const struct stage *s = scenes_stage(&m.scenes);
        ok(m.triangles == s->prim_count && !s->dropped_degenerate && !s->dropped_nonfinite,
           "%s: no triangle is degenerate (%u)", name, m.triangles);
        if (kind == MESHES_CORNELL)
            ok(m.triangles == full[kind], "%s: %u triangles", name, m.triangles);
        else if (kind == MESHES_BUNNY)
            near(m.triangles, 69453, 150, "%s: the stand-in is as large", name);
        else
            near(m.triangles, 20000, 600, "%s: about as many triangles as asked for", name);
        meshes_release(&m);
    }
    struct meshes m;
    struct err err;
    for (int kind = MESHES_INTERIOR; kind <= MESHES_TERRAIN; kind++)
        if (ok(meshes_init(&m, (enum meshes_kind)kind, 0, "", &err), "built")) {
            ok(m.triangles == full[kind], "%s: %u triangles", meshes_name((enum meshes_kind)kind),
               m.triangles);
            meshes_release(&m);
        }
}

static void test_ball(void)
{
    struct scenes s;
    scenes_init(&s, 1, 1);
    const struct meshes_ball ball = {
        .center = vec3_make(1, 2, 3), .radius = 2, .bump = 0.15f, .rings = 31, .columns = 30};
    meshes_add_ball(&s, scenes_diffuse(&s, rgb_gray(0.5f)), &ball);
    const struct mesh *mesh = &s.scene.meshes[0];
    ok(mesh->triangle_count == 2 * 30 * 30, "ball: 2 columns (rings - 1) triangles");
    ok(open_edges(mesh) == 0, "ball: closed");
    const struct stage *stage = scenes_stage(&s);
    near(aim_winding(stage, ball.center), 1, 1e-9,
         "ball: its centre is inside, fronts are outside");
    near(aim_winding(stage, vec3_make(9, 2, 3)), 0, 1e-9, "ball: a point beside it is outside");
    scenes_release(&s);
}

/* A ball without its north cap and one triangle elsewhere. */
static void test_closure(void)
{
    enum { N = 12 };
    struct scenes s;
    scenes_init(&s, 1, 1);
    meshes_add_ball(&s, scenes_diffuse(&s, rgb_gray(0.5f)),
                    &(struct meshes_ball){.radius = 1, .rings = N, .columns = N});
    struct mesh *mesh = &s.scene.meshes[0];
    uint32_t *t = arena_new(&s.arena, uint32_t, 3 * (size_t)mesh->triangle_count);
    uint32_t kept = 0, left_out = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *from = mesh->indices + 3 * (size_t)i;
        if (!from[0] || i == mesh->triangle_count - 3) {
            left_out++;
            continue;
        }
        for (uint32_t k = 0; k < 3; k++)
            t[3 * kept + k] = from[k];
        kept++;
    }
    mesh->indices = t;
    mesh->triangle_count = kept;
    ok(left_out == N + 1 && open_edges(mesh) == N + 3, "closure: the edges of both holes are open");
    closure_fill(mesh, &s.arena);
    ok(open_edges(mesh) == 0 && mesh->triangle_count == kept + N + 3, "closure: filled is closed");
    near(fabs(aim_winding(scenes_stage(&s), vec3_make(-0.1f, -0.2f, 0.05f))), 1, 1e-9,
         "closure: a point inside is inside");
    scenes_release(&s);
}

int main(void)
{
    test_sizes();
    test_ball();
    test_closure();
    return tap_done();
}
