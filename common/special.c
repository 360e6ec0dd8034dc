/* SPDX-License-Identifier: MIT */
#include "common/special.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

/* Its series below a + 1, its continued fraction (Lentz) above. NIST Digital Library of
 * Mathematical Functions, 8.11.4 and 8.9.2. */
double special_gamma_q(double a, double x)
{
    if (!(x > 0))
        return 1;
    const double front = exp(a * log(x) - x - lgamma(a));
    if (x < a + 1) {
        double term = 1 / a, sum = term;
        for (double n = a + 1; term > 1e-17 * sum; n++)
            sum += term *= x / n;
        return 1 - front * sum;
    }
    double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
    for (int i = 1; i < 100000; i++) {
        const double an = -i * (i - a);
        b += 2;
        d = 1 / (an * d + b);
        c = b + an / c;
        h *= c * d;
        if (fabs(c * d - 1) < 1e-15)
            break;
    }
    return front * h;
}

/* The continued fraction 8.17.22 of the same book, by Lentz's method; it converges fast for
 * x < (a + 1) / (a + b + 2), and the other side is its mirror image. */
double special_beta_i(double x, double a, double b)
{
    if (!(x > 0) || x >= 1)
        return x >= 1;
    if (x > (a + 1) / (a + b + 2))
        return 1 - special_beta_i(1 - x, b, a);
    const double front =
        exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * log1p(-x)) / a;
    double c = 1, d = 1 / (1 - (a + b) * x / (a + 1)), h = d;
    for (int m = 1; m < 100000; m++) {
        const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        d = 1 / (1 + even * d);
        c = 1 + even / c;
        h *= c * d;
        const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        d = 1 / (1 + odd * d);
        c = 1 + odd / c;
        h *= c * d;
        if (fabs(c * d - 1) < 1e-15)
            break;
    }
    return front * h;
}

/* --- limits: tails fall, so halving finds where they cross --- */

struct tail {
    double (*of)(const struct tail *, double x);
    double dof;
    size_t n;
};

static double limit(const struct tail *tail, double p, double lo, double hi)
{
    for (int i = 0; i < 200 && lo < hi; i++) {
        const double x = 0.5 * (lo + hi);
        if (x == lo || x == hi)
            break;
        if (tail->of(tail, x) > p)
            lo = x;
        else
            hi = x;
    }
    return hi;
}

double special_normal_tail(double z)
{
    return 0.5 * erfc(z / sqrt(2));
}

/* Hastings' start, off by 5e-4 at most (M. Abramowitz, I. Stegun, "Handbook of Mathematical
 * Functions", 26.2.23), made exact by Newton's steps. */
double special_normal_limit(double tail)
{
    if (tail > 0.5)
        return -special_normal_limit(1 - tail);
    if (!(tail > 0))
        return (double)INFINITY;
    const double t = sqrt(-2 * log(tail));
    double z = t - (2.515517 + t * (0.802853 + t * 0.010328)) /
                       (1 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
    for (int i = 0; i < 4; i++)
        z += (special_normal_tail(z) - tail) * sqrt(2 * pi) * exp(0.5 * z * z);
    return z;
}

double special_student_tail(double t, double dof)
{
    if (isinf(dof))
        return special_normal_tail(t);
    const double half = 0.5 * special_beta_i(dof / (dof + t * t), 0.5 * dof, 0.5);
    return t < 0 ? 1 - half : half;
}

static double student_of(const struct tail *tail, double t)
{
    return special_student_tail(t, tail->dof);
}

double special_student_limit(double tail, double dof)
{
    if (tail > 0.5)
        return -special_student_limit(1 - tail, dof);
    if (isinf(dof))
        return special_normal_limit(tail);
    double hi = 1; /* heavy tails: no bound holds for all */
    while (special_student_tail(hi, dof) > tail)
        hi *= 2;
    return limit(&(struct tail){student_of, dof, 0}, tail, 0, hi);
}

/* The mean over s = sqrt(chi2 / dof) of P(Z + shift > t s), by Simpson's rule over the ten standard
 * deviations of s, about 1 / sqrt(2 dof) each, that matter. */
double special_student_shifted_tail(double t, double dof, double shift)
{
    if (isinf(dof))
        return special_normal_tail(t - shift);
    enum { STEPS = 2000 };
    const double sd = 1 / sqrt(2 * dof);
    const double lo = fmax(0, 1 - 10 * sd), hi = 1 + 10 * sd, h = (hi - lo) / STEPS;
    const double scale = log(2) + 0.5 * dof * log(0.5 * dof) - lgamma(0.5 * dof);
    double sum = 0;
    for (int i = 0; i <= STEPS; i++) {
        const double s = lo + h * i;
        const double density = s > 0 ? exp(scale + (dof - 1) * log(s) - 0.5 * dof * s * s)
                                     : (dof > 1 ? 0 : exp(scale));
        const double weight = i == 0 || i == STEPS ? 1 : (i & 1 ? 4 : 2);
        sum += weight * density * special_normal_tail(t * s - shift);
    }
    return sum * h / 3;
}

double special_chi2_tail(double x, double dof)
{
    return special_gamma_q(0.5 * dof, 0.5 * x);
}

static double chi2_of(const struct tail *tail, double x)
{
    return special_chi2_tail(x, tail->dof);
}

double special_chi2_limit(double tail, double dof)
{
    double hi = 2 * dof + 10;
    while (special_chi2_tail(hi, dof) > tail)
        hi *= 2;
    return limit(&(struct tail){chi2_of, dof, 0}, tail, 0, hi);
}

/* A Poisson number of mean shift / 2 of pairs of degrees of freedom is added: DLMF 8.8.6 gives
 * Q(a + 1, y) = Q(a, y) + y^a e^-y / Gamma(a + 1), a sum of positive terms. */
double special_chi2_shifted_tail(double x, double dof, double shift)
{
    const double mean = 0.5 * shift, y = 0.5 * x;
    double a = 0.5 * dof, q = special_gamma_q(a, y), sum = 0, all = 0;
    for (int j = 0; j < 1000000; j++, a++) {
        const double poisson = mean > 0 ? exp(j * log(mean) - mean - lgamma(j + 1.0)) : j == 0;
        sum += poisson * q;
        all += poisson;
        if (j > mean && (1 - all < 1e-14 || poisson < 1e-17))
            break;
        q += y > 0 ? exp(a * log(y) - y - lgamma(a + 1)) : 0;
    }
    return sum;
}

/* --- Kolmogorov --- */

/* P(sup (F_n - F) > d), exact: N. Smirnov 1944; Z. Birnbaum, F. Tingey, "One-sided Confidence
 * Contours for Probability Distribution Functions", Ann. Math. Stat. 22, 1951. All terms are
 * positive. */
static double one_sided(double d, double n)
{
    double sum = 0;
    for (double j = 0; j <= n * (1 - d); j++) {
        const double rest = 1 - d - j / n;
        if (!(rest > 0))
            break;
        sum += exp(lgamma(n + 1) - lgamma(j + 1) - lgamma(n - j + 1) + (j - 1) * log(d + j / n) +
                   (n - j) * log(rest));
    }
    return d * sum;
}

/* Kolmogorov's limit, 2 sum (-1)^(k-1) exp(-2 k^2 x^2), at an argument moved for finite n: J.
 * Vrbik, "Small-Sample Corrections to Kolmogorov-Smirnov Test Statistic", 2018. For small x the
 * same by the theta function's other series. */
static double asymptotic(double d, double n)
{
    double x = sqrt(n) * d;
    x += 1 / (6 * sqrt(n)) + (x - 1) / (4 * n);
    double sum = 0;
    if (x <= 0)
        return 1;
    if (x < 1) {
        for (int k = 1; k < 20; k += 2)
            sum += exp(-k * k * pi * pi / (8 * x * x));
        return 1 - sqrt(2 * pi) / x * sum;
    }
    for (int k = 1; k < 20; k++)
        sum += (k & 1 ? 2 : -2) * exp(-2 * k * k * x * x);
    return sum;
}

/* Twice the one-sided tail counts only those samples twice that leave the band on both sides:
 * (tail / 2)^4 of all, roughly. */
double special_kolmogorov_tail(double d, size_t n)
{
    if (!(d > 0) || d >= 1)
        return d < 1;
    const double rough = asymptotic(d, (double)n);
    if (rough > 0.06 || n > 10000) /* so many: its error, about n^-1.5, is as small */
        return rough;
    const double tail = 2 * one_sided(d, (double)n);
    return tail < 0.05 ? tail : rough;
}

static double kolmogorov_of(const struct tail *tail, double d)
{
    return special_kolmogorov_tail(d, tail->n);
}

double special_kolmogorov_limit(double tail, size_t n)
{
    return limit(&(struct tail){kolmogorov_of, 0, n}, tail, 0, 1);
}
