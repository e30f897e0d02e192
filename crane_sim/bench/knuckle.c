/* The floor that the compiled Python is measured against: the knuckle crane with the energy law evaluated in every
 * stage of a classical Runge-Kutta step, written out by hand. State: alpha, beta, gamma, X, Y, Z and their rates, the
 * payload in the slewing frame. */
#include <math.h>

enum { N = 12 };

typedef struct {
    double boom_length, boom_mass, boom_inertia, jib_length, jib_mass, jib_inertia, tower_inertia, mass, gravity;
    double kp[4], kd[4], target[4];
} Crane;

static inline void derivative(const Crane *p, const double *restrict x, double *restrict dx)
{
    const double lb = p->boom_length, lj = p->jib_length, mb = p->boom_mass, mj = p->jib_mass, m = p->mass, g = p->gravity;
    const double k1 = lb * lb * (0.25 * mb + mj), k2 = 0.25 * lj * lj * mj, k3 = 0.5 * lb * lj * mj;
    const double sb = sin(x[1]), cb = cos(x[1]), sg = sin(x[2]), cg = cos(x[2]);
    const double wa = x[6], wb = x[7], wg = x[8], vx = x[9], vy = x[10], vz = x[11];
    const double r = lb * cb + lj * cg, h = lb * sb + lj * sg;
    const double ex = x[3] - r, ey = x[4], ez = x[5] - h;
    const double d = sqrt(ex * ex + ey * ey + ez * ez), inverse = 1.0 / d;
    const double dr = -lb * sb * wb - lj * sg * wg, dh = lb * cb * wb + lj * cg * wg;
    const double rate = (ex * (vx - dr) + ey * vy + ez * (vz - dh)) * inverse;
    const double u1 = p->kp[0] * (p->target[0] - x[0]) - p->kd[0] * wa;
    const double u2 = p->kp[1] * (p->target[1] - x[1]) - p->kd[1] * wb + g * lb * cb * (m + 0.5 * mb + mj);
    const double u3 = p->kp[2] * (p->target[2] - x[2]) - p->kd[2] * wg + g * lj * cg * (m + 0.5 * mj);
    const double u4 = p->kp[3] * (p->target[3] - d) - p->kd[3] * rate - m * g;
    const double f = u4 * inverse, fr = f * ex, ft = f * ey, fz = f * ez;
    const double p1 = k1 * cb + k3 * cg, p2 = k2 * cg + k3 * cb, hb = sb * p1, hg = sg * p2;
    const double c = k3 * (cb * cg + sb * sg), s = k3 * (sb * cg - cb * sg);
    const double b2 = u2 - lb * (cb * fz - sb * fr) - g * lb * cb * (0.5 * mb + mj) - s * wg * wg - hb * wa * wa;
    const double b3 = u3 - lj * (cg * fz - sg * fr) - g * lj * cg * 0.5 * mj + s * wb * wb - hg * wa * wa;
    const double jb = p->boom_inertia + k1, jj = p->jib_inertia + k2, det = 1.0 / (jb * jj - c * c), im = 1.0 / m;
    const double aa = (u1 - r * ft + 2.0 * wa * (hb * wb + hg * wg)) / (p->tower_inertia + cb * p1 + cg * p2);
    dx[0] = wa, dx[1] = wb, dx[2] = wg, dx[3] = vx, dx[4] = vy, dx[5] = vz;
    dx[6] = aa;
    dx[7] = (jj * b2 - c * b3) * det;
    dx[8] = (jb * b3 - c * b2) * det;
    dx[9] = fr * im + 2.0 * wa * vy + aa * x[4] + wa * wa * x[3];
    dx[10] = ft * im - 2.0 * wa * vx - aa * x[3] + wa * wa * x[4];
    dx[11] = fz * im - g;
}

void run(const Crane *p, double *restrict x, double h, long steps)
{
    double k1[N], k2[N], k3[N], k4[N], y[N];
    for (long n = 0; n < steps; n++) {
        derivative(p, x, k1);
        for (int i = 0; i < N; i++) y[i] = x[i] + 0.5 * h * k1[i];
        derivative(p, y, k2);
        for (int i = 0; i < N; i++) y[i] = x[i] + 0.5 * h * k2[i];
        derivative(p, y, k3);
        for (int i = 0; i < N; i++) y[i] = x[i] + h * k3[i];
        derivative(p, y, k4);
        for (int i = 0; i < N; i++) x[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
    }
}
