/* Sine and cosine by Taylor's series of orders 21 and 22, summed in a tree so that the terms overlap. */
#ifndef TRIG_H
#define TRIG_H
#include <math.h>

/* For |x| <= 1.6; absolute error below 5e-16. */
static inline __attribute__((always_inline)) void series(double x, double *sine, double *cosine)
{
    const double one = 1.0, b = x * x, b2 = b * b, b4 = b2 * b2, b8 = b4 * b4;
    const double s1 = -one / 6 + b * (one / 120), s2 = -one / 5040 + b * (one / 362880);
    const double s3 = -one / 39916800 + b * (one / 6227020800);
    const double s4 = -one / 1307674368000 + b * (one / 355687428096000);
    const double s5 = -one / 121645100408832000 + b * (one / 51090942171709440000.0);
    const double c1 = -one / 2 + b * (one / 24), c2 = -one / 720 + b * (one / 40320);
    const double c3 = -one / 3628800 + b * (one / 479001600);
    const double c4 = -one / 87178291200 + b * (one / 20922789888000);
    const double c5 = -one / 6402373705728000 + b * (one / 2432902008176640000);
    *sine = x + x * b * (((s1 + b2 * s2) + b4 * (s3 + b2 * s4)) + b8 * s5);
    *cosine = one + b * (((c1 + b2 * c2) + b4 * (c3 + b2 * c4)) + b8 * c5);
}

/* Without branches, so that a loop becomes vector code: x < 1e5 is brought into [-pi/2, pi/2] by three parts of pi. */
static inline __attribute__((always_inline)) void reduced_series(double x, double *sine, double *cosine)
{
    const double shift = 0x1.8p52, turns = (x * 0x1.45f306dc9c883p-2 + shift) - shift; /* rounded */
    const double odd = turns - 2.0 * ((0.5 * turns + shift) - shift), sign = 1.0 - 2.0 * odd * odd;
    series(((x - turns * 0x1.921fb544p1) - turns * 0x1.0b4611a6p-33) - turns * 0x1.3198a2e037073p-68, sine, cosine);
    *sine *= sign, *cosine *= sign;
}

/* Where angles are small as a rule: the jump is foreseen and costs nothing. */
static inline __attribute__((always_inline)) void sine_cosine(double x, double *sine, double *cosine)
{
    if (__builtin_expect(fabs(x) <= 1.6, 1)) series(x, sine, cosine);
    else *sine = sin(x), *cosine = cos(x);
}

#endif
