/* The knuckle crane on springs. State: alpha, beta, gamma, the payload in the slewing frame (X, Y, Z), their rates. */
#include <math.h>
#include "trig.h"

enum { SIZE = 12 };

typedef struct {
    double boom, jib, tower, inv_payload, gravity; /* m, m, kg m^2, 1/kg, m/s^2 */
    double k1, k2, k3, luff, fold;                 /* kg m^2: terms of the inertia; boom and jib about their joints */
    double boom_excess, jib_excess;                /* kg m^2: across minus axial inertia of the rods */
    double boom_load, jib_load;                    /* N m: moments of the rods' weights, lying flat */
    double boom_stiffness, jib_stiffness, rope_stiffness, boom_rest, jib_rest, rope_rest;
} Crane;

static inline __attribute__((always_inline)) void derivative(const Crane *p, const double *x, double *dx)
{
    double sb, cb, sg, cg;
    sine_cosine(x[1], &sb, &cb);
    sine_cosine(x[2], &sg, &cg);
    const double wa = x[6], wb = x[7], wg = x[8], vx = x[9], vy = x[10], vz = x[11];
    const double r = p->boom * cb + p->jib * cg, h = p->boom * sb + p->jib * sg;
    const double ex = x[3] - r, ey = x[4], ez = x[5] - h;
    const double pull = p->rope_stiffness - p->rope_stiffness * p->rope_rest / sqrt(ex * ex + ey * ey + ez * ez);
    const double fr = pull * ex, ft = pull * ey, fz = pull * ez;
    const double p1 = p->k1 * cb + p->k3 * cg + p->boom_excess * cb, p2 = p->k2 * cg + p->k3 * cb + p->jib_excess * cg;
    const double hb = sb * p1, hg = sg * p2, c = p->k3 * (cb * cg + sb * sg), s = p->k3 * (sb * cg - cb * sg);
    const double fold = p->jib_stiffness * (x[2] - x[1] - p->jib_rest);
    const double ub = fold - p->boom_stiffness * (x[1] - p->boom_rest);
    const double b2 = p->boom * (cb * fz - sb * fr) + (ub - cb * p->boom_load - s * wg * wg - hb * wa * wa);
    const double b3 = p->jib * (cg * fz - sg * fr) - (fold + cg * p->jib_load - s * wb * wb + hg * wa * wa);
    const double inverse = 1.0 / (p->luff * p->fold - c * c);
    const double aa = (r * ft + 2.0 * wa * (hb * wb + hg * wg)) / (p->tower + cb * p1 + cg * p2);
    for (int i = 0; i < 6; i++) dx[i] = x[6 + i];
    dx[6] = aa;
    dx[7] = (p->fold * b2 - c * b3) * inverse;
    dx[8] = (p->luff * b3 - c * b2) * inverse;
    dx[9] = 2.0 * wa * vy + wa * wa * x[3] + aa * x[4] - fr * p->inv_payload;
    dx[10] = wa * wa * x[4] - 2.0 * wa * vx - aa * x[3] - ft * p->inv_payload;
    dx[11] = -fz * p->inv_payload - p->gravity;
}

#include "loop.h"
