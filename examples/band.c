/* BAND, a damper of a rocking wall, for a program in C: copy `band_coefficient`.

       cc -O2 -o band band.c -lm && ./band

   prints the first peak under a half sine, 0.397, and x at tau = 4. Under restitution the first peak is 0.400. */
#include <math.h>
#include <stdio.h>

/* Return C [N s/m] at u [m] and v [m/s]; the damping force is C v.
   mass: m_eff [kg]; e: restitution; w1: circular frequency of the first branch [rad/s]; t_c: half-width [rad], 0.2. */
static double band_coefficient(double u, double v, double mass, double e, double w1, double t_c) {
    double c = t_c / w1, d = -log(e);
    double strength = d * (1 + 0.4 * t_c * t_c - 0.097 * pow(t_c, 4) - 0.043 * d * d);
    double r = fmin(fabs(u) / fmax(c * fabs(v), 1e-90), 1.0);
    return mass * 3 * strength / (4 * c) * (1 - r * r);
}

/* A wall to check with, dimensionless: a1 = 0.04, b1 = 0.85, unit mass. */
static double force(double x) {
    double z = fabs(x);
    return copysign(fmax(0.0, fmin(0.85, fmin(0.85 / 0.04 * z, 1 - z))), x);
}

int main(void) {
    const double h = 0.002, pi = acos(-1.0), w1 = sqrt(0.85 / 0.04); /* h is c/22 */
    double x = 0, v = 0, a = 0, peak = 0;
    for (int n = 1; n <= 2000; n++) {
        double p = n < 350 ? 2 * sin(pi * n / 350) : 0.0, half = v + h / 2 * a; /* 2 F0 for 0.7 in tau */
        double expected = v + h * a;
        x += h * v + h * h / 2 * a;
        double c = band_coefficient(x, expected, 1.0, 0.85, w1, 0.2); /* at the end of the step */
        a = (p - force(x) - c * half) / (1 + c * h / 2);
        v = half + h / 2 * a;
        if (n < 1000 && x > peak) peak = x;
    }
    printf("%.15f %.15f\n", peak, x);
}
