/* A chain of LINKS >= 2 rigid massless links with point masses, under a free trolley.
 *
 * State, in two halves of WIDE numbers: the first link's angle from the vertical and the bends from link to link, then
 * the trolley; after them the links' angular velocities (absolute), then the trolley's velocity. The equations need
 * sines and cosines of bends only.
 *
 * The tensions solve a tridiagonal system, made symmetric with a unit diagonal by the parameters. It is eliminated from
 * both ends to the middle, without division: a pivot is the ratio of successive leading determinants, and those obey
 * d_k = d_{k-1} - c_k^2 d_{k-2}, one multiply-add a row. */
#include "trig.h"

enum { WIDE = (LINKS + 8) / 8 * 8, SIZE = 2 * WIDE, MIDDLE = LINKS / 2 };

#define VECTOR(name) double name[WIDE] __attribute__((aligned(64)))
#if LINKS > 16 /* inlined into twelve stages it would not fit into the instruction cache */
#define FITTING static __attribute__((noinline))
#else
#define FITTING static inline __attribute__((always_inline))
#endif

typedef struct {
    double coupling[WIDE]; /* times the bend's cosine: minus the system's entry between the link and the one above */
    double reach[WIDE];    /* times the squared rate: centripetal term of a link */
    double under[WIDE];    /* times the sine of the bend below and the tension there: angular acceleration */
    double over[WIDE];     /* the same of the bend and the tension above */
    double mass_ratio, gravity_term, gravity_rate, trolley_coupling, inv_first_length; /* of the first link */
} Crane;

/* Fill the scaled tensions t from c, the system's off-diagonal, and b, its right-hand side. */
static inline __attribute__((always_inline)) void solve(double top, const double *restrict c, const double *restrict b,
                                                        double *restrict t)
{
    VECTOR(den);
    VECTOR(num);
    VECTOR(off);
    double d = top, before = 1.0, z = b[0], e = 1.0, after = 1.0, f = b[LINKS - 1];
    for (int k = 0; k < WIDE; k++) den[k] = 1.0, num[k] = off[k] = 0.0;
    for (int k = 1; k < MIDDLE; k++) {
        den[k - 1] = d, num[k - 1] = z, off[k - 1] = c[k] * before;
        const double next = d - c[k] * c[k] * before;
        z = d * b[k] + c[k] * z;
        before = d, d = next;
    }
    for (int k = LINKS - 1; k > MIDDLE; k--) {
        den[k] = e, num[k] = f, off[k] = c[k] * after;
        const double next = e - c[k] * c[k] * after;
        f = e * b[k - 1] + c[k] * f;
        after = e, e = next;
    }
    const double across = c[MIDDLE], inverse = 1.0 / (d * e - across * across * before * after);
    t[MIDDLE - 1] = (e * z + across * before * f) * inverse;
    t[MIDDLE] = (d * f + across * after * z) * inverse;
    for (int k = 0; k < WIDE; k++) {
        const double pivot = 1.0 / den[k];
        num[k] *= pivot, off[k] *= pivot;
    }
    for (int k = MIDDLE - 2; k >= 0; k--) t[k] = num[k] + off[k] * t[k + 1];
    for (int k = MIDDLE + 1; k < LINKS; k++) t[k] = num[k] + off[k] * t[k - 1];
}

FITTING void derivative(const Crane *restrict p, const double *restrict x, double *restrict dx)
{
    VECTOR(s);
    VECTOR(c);
    VECTOR(b);
    VECTOR(t);
    const double *restrict w = x + WIDE;
    int far = 0;
    for (int k = 0; k < LINKS; k++) far |= fabs(x[k]) > 1.6;
    if (__builtin_expect(!far, 1))
        for (int k = 0; k < WIDE; k++) series(x[k], &s[k], &c[k]);
    else
        for (int k = 0; k < WIDE; k++) reduced_series(x[k], &s[k], &c[k]);
    const double cosine = c[0], sine = s[0];
    for (int k = 0; k < WIDE; k++) c[k] *= p->coupling[k], b[k] = p->reach[k] * w[k] * w[k];
    b[0] += p->gravity_term * cosine;
    solve(1.0 + p->mass_ratio * sine * sine, c, b, t);
    const double trolley_acceleration = p->trolley_coupling * sine * t[0];
    double *restrict angular_acceleration = dx + WIDE;
    dx[0] = w[0];
    for (int k = 1; k < LINKS; k++) dx[k] = w[k] - w[k - 1];
    for (int k = LINKS; k < WIDE; k++) dx[k] = w[k];
    angular_acceleration[0] =
        p->under[0] * (s[1] * t[1]) - p->gravity_rate * sine - p->inv_first_length * cosine * trolley_acceleration;
    for (int k = 1; k < LINKS - 1; k++)
        angular_acceleration[k] = p->under[k] * (s[k + 1] * t[k + 1]) - p->over[k] * (s[k] * t[k - 1]);
    angular_acceleration[LINKS - 1] = -p->over[LINKS - 1] * (s[LINKS - 1] * t[LINKS - 2]);
    angular_acceleration[LINKS] = trolley_acceleration;
    for (int k = LINKS + 1; k < WIDE; k++) angular_acceleration[k] = 0.0;
}

#include "loop.h"

static inline __attribute__((always_inline)) void drift(double *restrict x, const double *restrict w, double h)
{
    x[0] += h * w[0];
    for (int k = 1; k < LINKS; k++) x[k] += h * (w[k] - w[k - 1]);
    x[LINKS] += h * w[LINKS];
}

#include "leapfrog.h"
