/* Störmer and Verlet's method: one evaluation a step, and stable up to twice 1/frequency, which no Runge-Kutta method is
 * at the price. Rates run half a step ahead of coordinates; where the accelerations depend on rates they get ones
 * extrapolated by half a step. `drift(x, w, h)` moves the coordinates by h times the rates w. */

enum { HALF = SIZE / 2 };

void run_leapfrog(const Crane *p, const double *x0, double *out, double h, long steps, long repeats, long *counts)
{
    for (long repeat = 0; repeat < repeats; repeat++) {
        double x[SIZE], dx[SIZE], w[HALF];
        FORGET(x0);
        memcpy(x, x0, sizeof x);
        derivative(p, x, dx);
        for (int i = 0; i < HALF; i++) w[i] = x[HALF + i] + 0.5 * h * dx[HALF + i];
        for (long n = 1; n < steps; n++) {
            drift(x, w, h);
            for (int i = 0; i < HALF; i++) x[HALF + i] = w[i] + 0.5 * h * dx[HALF + i];
            derivative(p, x, dx);
            for (int i = 0; i < HALF; i++) w[i] += h * dx[HALF + i];
        }
        drift(x, w, h);
        memcpy(out, x, sizeof x);
    }
    counts[0] = counts[1] = steps;
}
