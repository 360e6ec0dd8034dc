/* tool_wild SEED [DIRECTORY]: the document of a wild scene (tests/stability/wild.h) to stdout; with
 * a directory, document and files into it, to be rendered by anything. SPDX-License-Identifier: MIT
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/stability/wild.h"

static bool write_file(const char *directory, const char *name, const void *data, size_t bytes)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    FILE *file = fopen(path, "wb");
    if (!file)
        return false;
    const bool whole = fwrite(data, 1, bytes, file) == bytes;
    return fclose(file) == 0 && whole;
}

static bool write_named(const char *directory, const char *name)
{
    struct buf file = {0};
    if (!name)
        return true;
    wild_file(name, &file);
    const bool fine = write_file(directory, name, file.data, file.size);
    buf_release(&file);
    return fine;
}

static bool write_all(const struct wild *w, const char *directory)
{
    bool fine = write_file(directory, "scene.json", w->json, strlen(w->json));
    for (uint32_t i = 0; fine && i < w->scene.mesh_count; i++)
        fine = write_named(directory, w->scene.meshes[i].file);
    for (uint32_t i = 0; fine && i < w->scene.image_count; i++)
        fine = write_named(directory, w->scene.images[i].file);
    return fine;
}

int main(int argc, char **argv)
{
    struct wild w;
    const char *why;
    if (argc < 2) {
        fprintf(stderr, "usage: tool_wild SEED [DIRECTORY]\n");
        return 2;
    }
    const bool made = wild_make(&w, strtoull(argv[1], NULL, 10), &why);
    bool fine = made;
    if (!made)
        fprintf(stderr, "%s\n", why);
    if (argc == 2)
        fputs(w.json, stdout);
    else if (made && !(fine = write_all(&w, argv[2])))
        perror(argv[2]);
    wild_release(&w);
    return fine ? 0 : 1;
}
