/* A payload on a rigid massless rope under a free trolley. State: trolley, angle from the vertical, their rates. */
#ifdef __GNUC__ /* numbers this few are faster one by one: a vector waits for what was stored singly */
#pragma GCC optimize("no-tree-vectorize")
#endif
#include "trig.h"

enum { SIZE = 4 };

typedef struct {
    double inv_trolley, inv_payload, length, gravity; /* 1/kg of the trolley, 1/kg of the payload, m, m/s^2 */
    double inv_length;                                /* 1/m, one over the length */
} Crane;

static inline __attribute__((always_inline)) void derivative(const Crane *p, const double *x, double *dx)
{
    double s, c;
    sine_cosine(x[1], &s, &c);
    const double across = s * p->inv_trolley;
    const double tension = (p->length * x[3] * x[3] + p->gravity * c) / (p->inv_payload + s * across);
    dx[0] = x[2], dx[1] = x[3];
    dx[2] = tension * across;
    dx[3] = -p->inv_length * (p->gravity * s + tension * (across * c));
}

#include "loop.h"
