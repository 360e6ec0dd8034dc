/* special.h: every distribution against closed forms and printed tables.
 * SPDX-License-Identifier: MIT */
#include "common/special.h"

#include <math.h>

#include "tests/tap.h"

static const double pi = 3.14159265358979323846;

static double off(double worst, double got, double want)
{
    return fmax(worst, isfinite(got) ? fabs(got - want) : (double)INFINITY);
}

static void gamma_and_beta(void)
{
    double q = 0, i = 0;
    for (double x = 0.01; x < 60; x *= 1.2) {
        q = off(q, special_gamma_q(0.5, x), erfc(sqrt(x)));
        q = off(q, special_gamma_q(1, x), exp(-x));
        q = off(q, special_gamma_q(3, x), exp(-x) * (1 + x + x * x / 2));
    }
    for (double x = 0; x <= 1; x += 0.03125) {
        i = off(i, special_beta_i(x, 1, 7), 1 - pow(1 - x, 7));
        i = off(i, special_beta_i(x, 7, 1), pow(x, 7));
        i = off(i, special_beta_i(x, 2, 3), x * x * (6 - 8 * x + 3 * x * x));
        i = off(i, special_beta_i(x, 0.5, 0.5), 2 / pi * asin(sqrt(x)));
    }
    ok(q < 1e-14, "incomplete gamma function is its closed forms (%.1e)", q);
    ok(i < 1e-14, "incomplete beta function is its closed forms (%.1e)", i);
    near(special_beta_i(0.5, 5000, 5000), 0.5, 1e-11, "and a half in the middle");
}

static void normal_and_student(void)
{
    near(special_normal_limit(0.025), 1.959963984540054, 1e-12, "normal limit, 2.5 %%");
    near(special_normal_limit(0.995), -2.575829303548901, 1e-12, "normal limit, 99.5 %%");
    near(special_normal_tail(6), 9.865876450376946e-10, 1e-22, "normal tail far out");
    double back = 0;
    for (double z = -6; z < 37; z += 0.21)
        back = off(back, special_normal_limit(special_normal_tail(z)), z);
    ok(back < 1e-6, "the normal limit is the tail's inverse (%.1e)", back);
    double one = 0, two = 0, four = 0;
    for (double t = -20; t <= 20; t += 0.37) {
        const double r = sqrt(1 + t * t / 4), u = t / r;
        one = off(one, special_student_tail(t, 1), 0.5 - atan(t) / pi);
        two = off(two, special_student_tail(t, 2), 0.5 - t / (2 * sqrt(2 + t * t)));
        four = off(four, special_student_tail(t, 4), 0.5 - 0.375 * u * (1 - u * u / 12));
    }
    ok(one < 1e-14 && two < 1e-14 && four < 1e-14,
       "Student's t with 1, 2, 4 degrees of freedom is its closed form (%.1e)",
       fmax(one, fmax(two, four)));
    near(special_student_limit(0.025, 7), 2.364624252, 1e-8, "Student's limit, 7 degrees, 2.5 %%");
    near(special_student_limit(0.005, 30), 2.749995654, 1e-8, "30 degrees, 0.5 %%");
    near(special_student_limit(0.99, 10), -2.763769458, 1e-8, "10 degrees, 99 %%");
    near(special_student_limit(1e-5, (double)INFINITY), special_normal_limit(1e-5), 0,
         "no end of them");
}

static void chi2_values(void)
{
    near(special_chi2_tail(3.841458821, 1), 0.05, 1e-10, "chi-square tail, 1 degree of freedom");
    near(special_chi2_tail(18.30703805, 10), 0.05, 1e-10, "10 degrees of freedom");
    near(special_chi2_tail(82.35813581, 100), 0.9, 1e-9, "the other side of 100");
    near(special_chi2_tail(1e4, 1), 0, 1e-300, "far out");
    near(special_chi2_limit(0.01, 2), -2 * log(0.01), 1e-12, "limit, 2 degrees of freedom");
}

/* Noncentral: chi-square of 1 and 3 degrees of freedom and t of 2 have elementary forms, derived by
 * integrating by parts. */
static void shifted_values(void)
{
    double chi1 = 0, chi3 = 0, t2 = 0, sign = 0;
    for (double a = 0.2; a < 6; a += 0.4)
        for (double b = 0.1; b < 9; b += 0.45) {
            const double both = special_normal_tail(b - a) + special_normal_tail(b + a);
            const double more = (exp(-0.5 * (b - a) * (b - a)) - exp(-0.5 * (b + a) * (b + a))) /
                                (a * sqrt(2 * pi));
            chi1 = off(chi1, special_chi2_shifted_tail(b * b, 1, a * a), both);
            chi3 = off(chi3, special_chi2_shifted_tail(b * b, 3, a * a), both + more);
            const double s = sqrt(2 + b * b), turned = special_normal_tail(-a * b / s);
            t2 = off(t2, special_student_shifted_tail(b, 2, a),
                     special_normal_tail(-a) - b / s * exp(-a * a / (s * s)) * turned);
            sign = off(sign, special_student_shifted_tail(0, 1e5, a), special_normal_tail(-a));
        }
    ok(chi1 < 1e-13 && chi3 < 1e-13, "noncentral chi-square is its closed forms (%.1e)",
       fmax(chi1, chi3));
    ok(t2 < 1e-9 && sign < 1e-9, "noncentral t is its closed forms (%.1e)", fmax(t2, sign));
    near(special_student_shifted_tail(2.364624252, 7, 0), 0.025, 1e-9,
         "and Student's without shift");
    near(special_chi2_shifted_tail(5000, 4900, 0), special_chi2_tail(5000, 4900), 1e-13,
         "noncentral chi-square without shift");
}

/* Tables: L. Miller, "Table of Percentage Points of Kolmogorov Statistics", JASA 51, 1956. */
static void kolmogorov_values(void)
{
    near(special_kolmogorov_limit(0.05, 20), 0.29408, 5e-6, "Kolmogorov's limit, 20 values, 5 %%");
    near(special_kolmogorov_limit(0.01, 20), 0.35241, 5e-6, "20 values, 1 %%");
    near(special_kolmogorov_limit(0.05, 100), 0.13403, 5e-6, "100 values, 5 %%");
    near(special_kolmogorov_limit(0.01, 100), 0.16081, 5e-6, "100 values, 1 %%");
    near(special_kolmogorov_limit(0.05, 100000000) * 1e4, 1.35810, 1e-4, "very many, 5 %%");
    near(special_kolmogorov_tail(0.97, 25) / (2 * pow(0.03, 25)), 1, 1e-9, "the last step");
    double jump = 0;
    for (size_t n = 20; n < 12000; n += n - 1) { /* the two formulas meet at 0.05 */
        const double d = special_kolmogorov_limit(0.05, n);
        jump = off(jump, special_kolmogorov_tail(d * (1 - 1e-9), n),
                   special_kolmogorov_tail(d * (1 + 1e-9), n));
    }
    const double d = special_kolmogorov_limit(1e-4, 10000);
    near(special_kolmogorov_tail(d, 10001), special_kolmogorov_tail(d, 9999), 1e-6,
         "10 000 values and more by the asymptote alone");
    ok(jump < 1e-3, "asymptote and exact tail meet (%.1e)", jump);
}

int main(void)
{
    gamma_and_beta();
    normal_and_student();
    chi2_values();
    shifted_values();
    kolmogorov_values();
    return tap_done();
}
