/* The kernel's schemes in C, for the comparison alone: explicit Newmark with located impacts, walls in blocks of LANES.
 *
 * One function for each damper, so that each computes only what it needs. Same observables as rockdamp.solvers.kernel: peak,
 * its step, crossings of x = 0, collapse beyond a3. Dimensionless; compiled with -O3 -march=native -ffast-math.
 */
#include <math.h>

#define LANES 64
#define PATIENCE 256
#define TINY 1e-100

typedef struct {
    double x[LANES], v[LANES], a[LANES], alive[LANES], end[LANES], peak[LANES], peak_at[LANES], crossings[LANES];
    double k1[LANES], b1[LANES], ks[LANES], a1[LANES], a2[LANES], a3[LANES], h[LANES], g[LANES], e[LANES];
    double c[LANES];
} Block;

static inline double least(double a, double b) { return a < b ? a : b; }
static inline double largest(double a, double b) { return a > b ? a : b; }
static inline int crossed(double x0, double x1) { return ((x0 > 0) & (x1 <= 0)) | ((x0 < 0) & (x1 >= 0)); }

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

#ifdef PEAKS_ALONE /* what the march of peaks keeps: a wall whose peak is beyond a3 has collapsed */
static inline void update_lane(Block *restrict w, int i, double x, double v, double a, double step)
{
    (void)step;
    w->x[i] = x;
    w->v[i] = v;
    w->a[i] = a;
    w->peak[i] = largest(w->peak[i], fabs(x));
}
#else
static inline void update_lane(Block *restrict w, int i, double x, double v, double a, double step)
{
    int alive = w->alive[i] > 0;
    double old = w->x[i], z = alive ? fabs(x) : 0.0;
    w->crossings[i] += (alive & crossed(old, x)) ? 1.0 : 0.0;
    w->peak_at[i] = z > w->peak[i] ? step : w->peak_at[i];
    w->peak[i] = largest(w->peak[i], z);
    w->end[i] = alive ? step : w->end[i];
    w->alive[i] = (alive & (z <= w->a3[i])) ? 1.0 : 0.0;
    w->x[i] = alive ? x : old;
    w->v[i] = alive ? v : w->v[i];
    w->a[i] = alive ? a : w->a[i];
}
#endif

static inline int any_alive(const Block *w)
{
    double alive = 0;
    for (int i = 0; i < LANES; i++) alive += w->alive[i];
    return alive > 0;
}

static inline void step_CR(Block *restrict w, double p0, double p1, double step)
{
    for (int i = 0; i < LANES; i++) {
        double x = w->x[i], v = w->v[i], a = w->a[i], h = w->h[i];
        double start = w->g[i] * p0, stop = w->g[i] * p1;
        int hit = crossed(x, x + h * (v + 0.5 * h * a));
        double root = sqrt(largest(v * v - 2 * a * x, 0.0)), away = x > 0 ? v : -v;
        double s = hit ? least(2 * fabs(x) / largest(root - away, TINY), h) : 0.0;
        double load = start + (stop - start) * (s / h);
        v = hit ? w->e[i] * (v + 0.5 * s * (a + load)) : v;
        a = hit ? load : a;
        h -= s;
        x = (hit ? 0.0 : x) + h * (v + 0.5 * h * a);
        double f = force(w, i, fabs(x));
        double half = v + 0.5 * h * a;
        a = stop - (x < 0 ? -f : f);
        update_lane(w, i, x, half + 0.5 * h * a, a, step);
    }
}

static inline double sixteenth(double x)
{
    x *= x;
    x *= x;
    x *= x;
    return x * x;
}

/* q/(1 - q s) of order 16 over c: C is c times it, w_E taken out. v is away from x = 0. */
static inline double sixteenth_order(double c, double v, double double_v)
{
    double total = v * v + double_v, q = sixteenth(v * v / total);
    return q / (1 - c * q * v * sqrt(double_v) / total);
}

/* 1 - (z/(c v))^2 of BAND within its band. */
static inline double band(double c, double z, double v)
{
    double r = least(z / largest(c * fabs(v), 1e-90), 1.0);
    return 1 - r * r;
}

#define VISCOUS(NAME, COEFFICIENT)                                                  \
    static inline void step_##NAME(Block *restrict w, double p0, double p1, double step) \
    {                                                                               \
        (void)p0;                                                                   \
        for (int i = 0; i < LANES; i++) {                                           \
            double v = w->v[i], a = w->a[i], h = w->h[i];                           \
            double half = v + 0.5 * h * a, x = w->x[i] + h * half;                  \
            double z = largest(fabs(x), TINY), f = force(w, i, z);                  \
            double c = w->c[i] * (COEFFICIENT);                                     \
            a = (w->g[i] * p1 - (x < 0 ? -f : f) - c * half) / (1 + 0.5 * h * c);   \
            update_lane(w, i, x, half + 0.5 * h * a, a, step);                           \
        }                                                                           \
    }

VISCOUS(CDC, 1.0)
VISCOUS(CDR, sqrt(f / z))
VISCOUS(SDR, f / z)
VISCOUS(ECD, f / sqrt(double_energy(w, i, z)))
VISCOUS(ECD_order_16, f / sqrt(double_energy(w, i, z))
                   * sixteenth_order(w->c[i], x < 0 ? -v - h * a : v + h * a, double_energy(w, i, z)))
VISCOUS(BAND, band(w->e[i], z, v + h * a))

#define MARCH(NAME)                                                                                      \
    void march_##NAME(Block *blocks, long count, const double *ground, long samples, long substeps, long steps) \
    {                                                                                                    \
        for (long b = 0; b < count; b++) {                                                               \
            Block *w = blocks + b;                                                                       \
            double p1 = samples ? ground[0] : 0.0;                                                       \
            for (long step = 1; step <= steps; step++) {                                                 \
                double p0 = p1;                                                                          \
                if (samples) {                                                                           \
                    long sample = step / substeps, part = step % substeps;                               \
                    p1 = ground[sample];                                                                 \
                    if (part) p1 += (ground[sample + 1] - p1) * part / substeps;                         \
                }                                                                                        \
                step_##NAME(w, p0, p1, (double)step);                                                    \
                if (step % PATIENCE == 0 && !any_alive(w)) break;                                        \
            }                                                                                            \
        }                                                                                                \
    }

MARCH(CR)
MARCH(CDC)
MARCH(CDR)
MARCH(SDR)
MARCH(ECD)
MARCH(ECD_order_16)
MARCH(BAND)
