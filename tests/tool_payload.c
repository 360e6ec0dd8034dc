/* tool_payload SCENE JOB TILE PASS X0 Y0 X1 Y1 S0 S1: what a worker would deliver for that lease, to
 * stdout. For tests that play a worker: the samples are the real core's.
 * SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>

#include "common/trace/render.h"
#include "common/wire.h"
#include "tests/local.h"

int main(int argc, char **argv)
{
    if (argc != 11) {
        fprintf(stderr, "usage: tool_payload SCENE JOB TILE PASS X0 Y0 X1 Y1 S0 S1\n");
        return 2;
    }
    uint32_t n[8];
    for (int i = 0; i < 8; i++)
        n[i] = (uint32_t)strtoul(argv[3 + i], NULL, 10);
    struct local l;
    local_open(&l, argv[1]);
    struct wire_samples w = {
        .job = strtoull(argv[2], NULL, 16),
        .tile = n[0],
        .pass = n[1],
        .samples = film_samples_make((struct tile_rect){n[2], n[3], n[4], n[5]},
                                     (struct tile_pass){n[6], n[7]}, &l.arena),
    };
    film_samples_add_layers(&w.samples, l.stage->film.layers, &l.arena);
    render_tile(l.stage, &w.samples);
    struct buf out = {0};
    wire_encode(&w, &out);
    const bool ok = fwrite(out.data, 1, out.size, stdout) == out.size && fflush(stdout) == 0;
    buf_release(&out);
    local_release(&l);
    return ok ? 0 : 1;
}
