/* The loops around a crane's `derivative(crane, x, dx)` of SIZE numbers: classical Runge-Kutta and the method of order 8
 * of Dormand and Prince, whose coefficients (COMBINE_1 to COMBINE_12, ERROR_5, ERROR_3) the build writes.
 * Each run starts from x0 `repeats` times over and leaves the last end in `out`. */
#include <math.h>
#include <string.h>
#include "dop853.h"

#define EACH(i) for (int i = 0; i < SIZE; i++)
/* The compiler must assume that anything may have changed, or it would do the work once. */
#define FORGET(pointer) __asm__ volatile("" : : "r"(pointer) : "memory")

static inline __attribute__((always_inline)) void rk4_step(const Crane *restrict p, double *restrict x, double h)
{
    double k1[SIZE], k2[SIZE], k3[SIZE], k4[SIZE], y[SIZE];
    derivative(p, x, k1);
    EACH(i) y[i] = x[i] + 0.5 * h * k1[i];
    derivative(p, y, k2);
    EACH(i) y[i] = x[i] + 0.5 * h * k2[i];
    derivative(p, y, k3);
    EACH(i) y[i] = x[i] + h * k3[i];
    derivative(p, y, k4);
    EACH(i) x[i] += h / 6.0 * ((k1[i] + 2.0 * (k2[i] + k3[i])) + k4[i]);
}

#define STAGE(n) { EACH(i) y[i] = x[i] + h * COMBINE_##n(k, i); derivative(p, y, k[n]); }

/* k[0] is given; y becomes the end of the step. */
static inline __attribute__((always_inline)) void rk8_stages(const Crane *restrict p, const double *restrict x, double h,
                                                             double (*restrict k)[SIZE], double *restrict y)
{
    STAGE(1) STAGE(2) STAGE(3) STAGE(4) STAGE(5) STAGE(6) STAGE(7) STAGE(8) STAGE(9) STAGE(10) STAGE(11)
    EACH(i) y[i] = x[i] + h * COMBINE_12(k, i);
}

static inline __attribute__((always_inline)) void rk8_step(const Crane *restrict p, double *restrict x, double h)
{
    double k[12][SIZE], y[SIZE];
    derivative(p, x, k[0]);
    rk8_stages(p, x, h, k, y);
    EACH(i) x[i] = y[i];
}

/* counts: steps and evaluations of a run. */
#define FIXED(name, step, evaluations)                                                                        \
    void name(const Crane *p, const double *x0, double *out, double h, long steps, long repeats, long *counts) \
    {                                                                                                         \
        for (long repeat = 0; repeat < repeats; repeat++) {                                                   \
            double x[SIZE];                                                                                   \
            FORGET(x0);                                                                                       \
            memcpy(x, x0, sizeof x);                                                                          \
            for (long n = 0; n < steps; n++) step(p, x, h);                                                   \
            memcpy(out, x, sizeof x);                                                                         \
        }                                                                                                     \
        counts[0] = steps, counts[1] = evaluations * steps;                                                   \
    }

FIXED(run_rk4, rk4_step, 4)
FIXED(run_rk8, rk8_step, 12)

/* The error of a step relative to the tolerance, atol = rtol / 100. */
static inline double mistake(const double *restrict x, const double *restrict y, double (*restrict k)[SIZE], double h,
                             double rtol)
{
    double e5 = 0.0, e3 = 0.0;
    EACH(i) {
        const double weight = 1.0 / (rtol * (0.01 + fmax(fabs(x[i]), fabs(y[i]))));
        const double a = weight * (ERROR_5(k, i)), b = weight * (ERROR_3(k, i));
        e5 += a * a, e3 += b * b;
    }
    return e5 == 0.0 ? 0.0 : h * e5 / sqrt((e5 + 0.01 * e3) * SIZE);
}

/* With error control; counts[0] has the steps tried, rejected ones among them. */
void run_dop853(const Crane *p, const double *x0, double *out, double rtol, double duration, long repeats, long *counts)
{
    for (long repeat = 0; repeat < repeats; repeat++) {
        double x[SIZE], y[SIZE], k[12][SIZE], t = 0.0, h = 1e-3, growth = 6.0;
        long tried = 0, accepted = 0;
        FORGET(x0);
        memcpy(x, x0, sizeof x);
        derivative(p, x, k[0]);
        while (t < duration && tried < 10000000) {
            h = fmin(h, duration - t);
            rk8_stages(p, x, h, k, y);
            const double error = mistake(x, y, k, h, rtol);
            const int good = error <= 1.0;
            const double factor = error == 0.0 ? 6.0 : fmin(growth, fmax(0.2, 0.9 * pow(error, -0.125)));
            tried++;
            growth = good ? 6.0 : 1.0;
            if (good) {
                t = h >= duration - t ? duration : t + h;
                memcpy(x, y, sizeof x);
                derivative(p, x, k[0]);
                accepted++;
            }
            h *= error == error ? factor : 0.2;
        }
        memcpy(out, x, sizeof x);
        counts[0] = tried, counts[1] = 1 + 11 * tried + accepted;
    }
}
