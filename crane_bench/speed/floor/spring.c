/* A payload on a linear spring under a free trolley. State: trolley, payload (x, z), their rates. */
#ifdef __GNUC__ /* numbers this few are faster one by one: a vector waits for what was stored singly */
#pragma GCC optimize("no-tree-vectorize")
#endif
#include <math.h>

enum { SIZE = 6 };

typedef struct {
    double inv_trolley, inv_payload; /* 1/kg */
    double stiffness, length, gravity; /* N/m, m, m/s^2 */
} Crane;

static inline __attribute__((always_inline)) void derivative(const Crane *p, const double *x, double *dx)
{
    const double rx = x[1] - x[0], rz = x[2];
    const double pull = p->stiffness - p->stiffness * p->length / sqrt(rx * rx + rz * rz);
    dx[0] = x[3], dx[1] = x[4], dx[2] = x[5];
    dx[3] = pull * (p->inv_trolley * rx);
    dx[4] = -pull * (p->inv_payload * rx);
    dx[5] = -pull * (p->inv_payload * rz) - p->gravity;
}

#include "loop.h"

static inline __attribute__((always_inline)) void drift(double *x, const double *w, double h)
{
    for (int i = 0; i < 3; i++) x[i] += h * w[i];
}

#include "leapfrog.h"
