/* Beams over bilinear heights, patch by patch from side to side, as one would write it: the highest
 * post first, then the root of the quadratic. Double precision, no table. */
#include <math.h>

static double beam(const float *z, long side, double x, double y, double up, double dx, double dy,
                   double dz, double reach)
{
    long i = (long)floor(y), j = (long)floor(x), di = dy > 0 ? 1 : -1, dj = dx > 0 ? 1 : -1;
    double ix = 1.0 / fabs(dx), iy = 1.0 / fabs(dy), e = 0.0;
    double tx = (dx > 0 ? j + 1 - x : x - j) * ix, ty = (dy > 0 ? i + 1 - y : y - i) * iy;
    while (e < reach && i >= 0 && j >= 0 && i < side - 1 && j < side - 1) {
        double t = tx < ty ? tx : ty, end = t < reach ? t : reach;
        double a = z[i * side + j], b = z[i * side + j + 1];
        double c = z[(i + 1) * side + j], d = z[(i + 1) * side + j + 1];
        if (fmin(up + e * dz, up + end * dz) <= fmax(fmax(a, b), fmax(c, d))) {
            double p = x + e * dx - j, q = y + e * dy - i, w = d - c - b + a;
            double f = a + (b - a) * p + (c - a) * q + w * p * q - up - e * dz;
            if (f >= 0.0) return e;
            double k = w * dx * dy, r = (b - a) * dx + (c - a) * dy + w * (p * dy + q * dx) - dz;
            double s = r * r - 4.0 * k * f;
            if (s >= 0.0 && (r > 0.0 || k > 0.0)) {
                double g = r < 0.0 ? (sqrt(s) - r) / (2.0 * k) : -2.0 * f / (r + sqrt(s));
                if (e + g <= end) return e + g;
            }
        }
        e = t;
        if (tx < ty) { tx += ix; j += dj; }
        else         { ty += iy; i += di; }
    }
    return reach;
}

long train(const double *eye, const double *axes, long n, const double *ways, long beams,
           const float *z, long side, double cell, double reach, double *mean)
{
    for (long k = 0; k < n; k++) {
        const double *o = eye + 3 * k, *f = axes + 6 * k, *l = f + 3;
        for (long b = 0; b < beams; b++) {
            double p = ways[b], q = ways[beams + b];
            double dx = (p * f[0] + q * l[0]) / cell, dy = (p * f[1] + q * l[1]) / cell;
            *mean += beam(z, side, o[0] / cell - 0.5, o[1] / cell - 0.5, o[2], dx, dy,
                          p * f[2] + q * l[2], reach) / (double)(n * beams);
        }
    }
    return 0;
}
