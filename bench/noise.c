/* SPDX-License-Identifier: MIT */
#include "bench/noise.h"

#include <math.h>

/* [-1, 1), a hash of the lattice point: the finalizer of MurmurHash3 (A. Appleby, public domain).
 */
static double at_lattice(int64_t x, int64_t y, int64_t z)
{
    uint64_t h = (uint64_t)x * 0x9e3779b97f4a7c15u ^ (uint64_t)y * 0xc2b2ae3d27d4eb4fu ^
                 (uint64_t)z * 0x165667b19e3779f9u;
    h = (h ^ h >> 33) * 0xff51afd7ed558ccdu;
    h = (h ^ h >> 33) * 0xc4ceb9fe1a85ec53u;
    return (double)(int64_t)(h ^ h >> 33) * 0x1p-63;
}

static double value_noise(const double p[3])
{
    int64_t cell[3];
    double f[3]; /* weights of the far points: 3 t^2 - 2 t^3 */
    for (int k = 0; k < 3; k++) {
        const double low = floor(p[k]), t = p[k] - low;
        cell[k] = (int64_t)low;
        f[k] = t * t * (3 - 2 * t);
    }
    double sum = 0;
    for (int i = 0; i < 8; i++) {
        const int x = i & 1, y = i >> 1 & 1, z = i >> 2;
        sum += at_lattice(cell[0] + x, cell[1] + y, cell[2] + z) * (x ? f[0] : 1 - f[0]) *
               (y ? f[1] : 1 - f[1]) * (z ? f[2] : 1 - f[2]);
    }
    return sum;
}

double noise_fbm(const double p[3], int octaves)
{
    double q[3] = {p[0], p[1], p[2]}, sum = 0, height = 1;
    for (int i = 0; i < octaves; i++, height /= 2) {
        sum += height * value_noise(q);
        for (int k = 0; k < 3; k++)
            q[k] = 2 * q[k] + 17.3; /* the lattices' points should not coincide */
    }
    return sum;
}
