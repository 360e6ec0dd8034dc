/* SPDX-License-Identifier: MIT */
#include "common/trace/thinfilm.h"

#include "common/trace/fmath.h"

const float thinfilm_weight[3][THINFILM_WAVELENGTHS] = {
    {.0063108f,  .0357799f,  .1147258f,  .2317227f,  .3144957f,  .2961464f,  .2052379f,  .0966517f,
     .0036678f,  -.0576017f, -.0853226f, -.0792976f, -.0605949f, -.0419305f, -.0256274f, -.0140914f,
     -.0031964f, .0095793f,  .0171679f,  .0146991f,  .0100097f,  .0069714f,  .0035216f,  .0009749f},
    {.0005346f,  -.0025782f, -.0133699f, -.0245460f, -.0127588f, .0368949f,
     .1025542f,  .1568363f,  .1885938f,  .1942478f,  .1752194f,  .1278443f,
     .0799724f,  .0465186f,  .0231824f,  .0058426f,  -.0070836f, -.0159078f,
     -.0200905f, -.0186037f, -.0126854f, -.0068247f, -.0028798f, -.0009129f},
    {-.0002409f, -.0006266f, -.0013365f, -.0030233f, -.0068116f, -.0128519f,
     -.0190003f, -.0230058f, -.0239588f, -.0211160f, -.0135986f, .0003712f,
     .0189762f,  .0434213f,  .0809255f,  .1311743f,  .1696034f,  .1779822f,
     .1713034f,  .1531617f,  .1026315f,  .0492912f,  .0193043f,  .0074239f}};

struct complex {
    float re, im;
};

/* a / b. */
static struct complex quotient(struct complex a, struct complex b)
{
    const float bb = b.re * b.re + b.im * b.im;
    return (struct complex){(a.re * b.re + a.im * b.im) / bb, (a.im * b.re - a.re * b.im) / bb};
}

/* The root of re + i im, im >= 0, with parts that are not negative. */
static struct complex root(float re, float im)
{
    const float length = __builtin_sqrtf(re * re + im * im);
    if (re >= 0) {
        const float a = __builtin_sqrtf(0.5f * (length + re));
        return (struct complex){a, a > 0 ? 0.5f * im / a : 0};
    }
    const float b = __builtin_sqrtf(0.5f * (length - re));
    return (struct complex){0.5f * im / b, b};
}

/* The amplitudes that the faces reflect, for one polarisation. */
struct faces {
    float outer;
    struct complex inner;
};

/* |(outer + z) / (1 + outer z)|^2, z = inner e^(i phase). */
static float both(const struct faces *f, float c, float s)
{
    const float x = f->inner.re * c - f->inner.im * s, y = f->inner.re * s + f->inner.im * c;
    const float up = (f->outer + x) * (f->outer + x) + y * y;
    const float down = (1 + f->outer * x) * (1 + f->outer * x) + f->outer * f->outer * y * y;
    return up / down;
}

/* q: the film's index times the cosine in it. */
static void faces_of(float cos, float q, float ior, struct complex n, struct faces out[2])
{
    const float nn = ior * ior, ss = 1 - cos * cos;
    const struct complex n2 = {(n.re - n.im) * (n.re + n.im), 2 * n.re * n.im};
    const struct complex t = root(n2.re - ss, n2.im);
    out[0].outer = (cos - q) / (cos + q);
    out[0].inner = quotient((struct complex){q - t.re, -t.im}, (struct complex){q + t.re, t.im});
    out[1].outer = (nn * cos - q) / (nn * cos + q);
    out[1].inner = quotient((struct complex){n2.re * q - nn * t.re, n2.im * q - nn * t.im},
                            (struct complex){n2.re * q + nn * t.re, n2.im * q + nn * t.im});
}

rgb thinfilm_metal(float cos, rgb eta, rgb k, const struct thin_film *film)
{
    const float q = __builtin_sqrtf((film->ior - 1) * (film->ior + 1) + cos * cos);
    const float first = 1 / 700.0f, step = (1 / 400.0f - 1 / 700.0f) / THINFILM_WAVELENGTHS;
    struct faces faces[3][2];
    float sum[3] = {0, 0, 0};
    for (int c = 0; c < 3; c++)
        faces_of(cos, q, film->ior, (struct complex){eta[c], k[c]}, faces[c]);
    for (int i = 0; i < THINFILM_WAVELENGTHS; i++) {
        const float turns = 2 * film->thickness_nm * q * (first + step * ((float)i + 0.5f));
        float sine, cosine;
        fmath_sincos_turns(turns - __builtin_floorf(turns), &sine, &cosine);
        for (int c = 0; c < 3; c++)
            sum[c] += thinfilm_weight[c][i] * 0.5f *
                      (both(&faces[c][0], cosine, sine) + both(&faces[c][1], cosine, sine));
    }
    for (int c = 0; c < 3; c++)
        sum[c] = sum[c] > 0 ? (sum[c] < 1 ? sum[c] : 1) : 0;
    return vec3_load(sum);
}
