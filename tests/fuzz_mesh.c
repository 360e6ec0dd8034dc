/* Any bytes as a mesh: an answer, never a crash, and indices that are vertices. The first byte
 * chooses the format.
 *
 *     build/fuzz-clang/bin/fuzz_mesh -max_len=5000 CORPUS
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "common/mesh.h"

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t bytes);

static void check_finite(const float *list, size_t count)
{
    for (size_t i = 0; list && i < count; i++)
        if (!isfinite(list[i]))
            abort();
}

/* Unit, or 0: there is none. */
static void check_normals(const float *n, size_t count)
{
    for (size_t i = 0; n && i < count; i++, n += 3) {
        const double square =
            (double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] + (double)n[2] * (double)n[2];
        if (square != 0 && !(fabs(square - 1) < 1e-6))
            abort();
    }
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t bytes)
{
    if (bytes == 0)
        return 0;
    struct arena arena = {0};
    struct err err = {0};
    struct mesh mesh = {.format = data[0] % 2 ? MESH_PLY : MESH_OBJ};
    bool good = mesh_read(&mesh, data + 1, bytes - 1, &arena, &err);
    if (!good && (!*err.text || (err.code != ERR_INPUT && err.code != ERR_LIMIT)))
        abort();
    for (size_t i = 0; good && i < (size_t)3 * mesh.triangle_count; i++)
        if (mesh.indices[i] >= mesh.vertex_count)
            abort();
    if (good) {
        check_finite(mesh.vertices, (size_t)3 * mesh.vertex_count);
        check_finite(mesh.uvs, (size_t)2 * mesh.vertex_count);
        check_finite(mesh.colors, (size_t)3 * mesh.vertex_count);
        check_normals(mesh.normals, mesh.vertex_count);
    }
    arena_release(&arena);
    return 0;
}
