/* The march of peaks in C, for comparison: explicit Newmark with located impacts, walls in blocks of LANES.
 *
 * One function a damper. Dimensionless, as rockdamp.solvers.kernel. Compiled with -O3 -march=native -ffast-math.
 */
#include <math.h>

#define LANES 64
#define TINY 1e-100

typedef struct {
    double x[LANES], v[LANES], a[LANES], peak[LANES];
    double k1[LANES], b1[LANES], ks[LANES], a1[LANES], a2[LANES], a3[LANES];
    double factor[LANES], e[LANES], c[LANES]; /* e of CR, c u'/|u'| of BAND; c is the constant part of C */
} Block;

static inline double least(double a, double b) { return a < b ? a : b; }
static inline double largest(double a, double b) { return a > b ? a : b; }

static inline double force(const Block *w, int i, double z)
{
    return largest(least(least(w->k1[i] * z, w->b1[i]), w->ks[i] * (w->a3[i] - z)), 0.0);
}

static inline double double_energy(const Block *w, int i, double z)
{
    double a1 = w->a1[i], a2 = w->a2[i], a3 = w->a3[i];
    double z1 = least(z, a1), z2 = least(largest(z, a1), a2), z3 = least(largest(z, a2), a3);
    return w->k1[i] * z1 * z1 + 2 * w->b1[i] * (z2 - a1) + w->ks[i] * (z3 - a2) * (2 * a3 - a2 - z3);
}

static inline double band(double reach, double z, double v)
{
    double r = least(z / largest(reach * fabs(v), 1e-90), 1.0);
    return 1 - r * r;
}

static inline void store(Block *restrict w, int i, double x, double v, double a)
{
    w->x[i] = x;
    w->v[i] = v;
    w->a[i] = a;
    w->peak[i] = largest(w->peak[i], fabs(x));
}

static inline void step_CR(Block *restrict w, double p0, double p1, double h0)
{
    for (int i = 0; i < LANES; i++) {
        double x = w->x[i], v = w->v[i], a = w->a[i], h = h0;
        double start = w->factor[i] * p0, stop = w->factor[i] * p1;
        double after = x + h * (v + 0.5 * h * a);
        int hit = ((x > 0) & (after <= 0)) | ((x < 0) & (after >= 0));
        double root = sqrt(largest(v * v - 2 * a * x, 0.0)), away = x > 0 ? v : -v;
        double s = hit ? least(2 * fabs(x) / largest(root - away, TINY), h) : 0.0;
        double load = start + (stop - start) * (s / h);
        v = hit ? w->e[i] * (v + 0.5 * s * (a + load)) : v;
        a = hit ? load : a;
        h -= s;
        x = (hit ? 0.0 : x) + h * (v + 0.5 * h * a);
        double f = force(w, i, fabs(x)), half = v + 0.5 * h * a;
        a = stop - (x < 0 ? -f : f);
        store(w, i, x, half + 0.5 * h * a, a);
    }
}

#define VISCOUS(NAME, COEFFICIENT)                                                   \
    static inline void step_##NAME(Block *restrict w, double p0, double p1, double h) \
    {                                                                                \
        (void)p0;                                                                    \
        for (int i = 0; i < LANES; i++) {                                            \
            double v = w->v[i], a = w->a[i];                                         \
            double half = v + 0.5 * h * a, x = w->x[i] + h * half;                   \
            double z = largest(fabs(x), TINY), f = force(w, i, z);                   \
            double c = w->c[i] * (COEFFICIENT);                                      \
            a = (w->factor[i] * p1 - (x < 0 ? -f : f) - c * half) / (1 + 0.5 * h * c); \
            store(w, i, x, half + 0.5 * h * a, a);                                   \
        }                                                                            \
    }

VISCOUS(CDC, 1.0)
VISCOUS(CDR, sqrt(f / z))
VISCOUS(SDR, f / z)
VISCOUS(ECD, f / sqrt(double_energy(w, i, z)))
VISCOUS(BAND, band(w->e[i], z, v + h * a))

#define MARCH(NAME)                                                                              \
    void march_##NAME(Block *blocks, long count, const double *ground, long steps, long substeps, double h) \
    {                                                                                            \
        for (long b = 0; b < count; b++) {                                                       \
            double p1 = ground[0];                                                               \
            for (long step = 1; step <= steps; step++) {                                         \
                long sample = step / substeps, part = step % substeps;                           \
                double p0 = p1;                                                                  \
                p1 = ground[sample];                                                             \
                if (part) p1 += (ground[sample + 1] - p1) * part / substeps;                     \
                step_##NAME(blocks + b, p0, p1, h);                                              \
            }                                                                                    \
        }                                                                                        \
    }

MARCH(CR)
MARCH(CDC)
MARCH(CDR)
MARCH(SDR)
MARCH(ECD)
MARCH(BAND)
