/* Thousands of 2-3-2 networks, eight side by side: the loops of frozen.c over arrays whose last
 * axis is the network, for the compiler to vectorise. libm's exp does not vectorise, so this has
 * its own: 2^k times a polynomial of degree 12. */
#include <math.h>
#include <string.h>

enum { IN = 2, HIDDEN = 3, OUT = 2, WEIGHTS = HIDDEN * (IN + 1) + OUT * (HIDDEN + 1), LANES = 8 };

typedef double lane[LANES];

static inline double exponential(double x)
{
    const double log2e = 1.4426950408889634, magic = 6755399441055744.0;
    static const double c[13] = {
        1.0, 0x1.62e42fefa39efp-1, 0x1.ebfbdff82c58fp-3, 0x1.c6b08d704a0c0p-5,
        0x1.3b2ab6fba4e77p-7, 0x1.5d87fe78a6731p-10, 0x1.430912f86c787p-13,
        0x1.ffcbfc588b0c7p-17, 0x1.62c0223a5c824p-20, 0x1.b5253d395e7c4p-24,
        0x1.e4cf5158b8ecap-28, 0x1.e8cac7351bb25p-32, 0x1.c3bd650fc2986p-36,
    };
    double z = x * log2e;
    z = z < -1022.0 ? -1022.0 : z;
    z = z > 1022.0 ? 1022.0 : z;
    double whole = z + magic, r = z - (whole - magic), p = c[12];
    long bits;
    for (int i = 11; i >= 0; i--) p = p * r + c[i];
    memcpy(&bits, &whole, sizeof bits);
    bits = (bits + 1023) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return power * p;
}

static void block(lane *restrict w, lane *restrict v, const double *restrict x,
                  const double *restrict y, long patterns, long epochs, double eta, double mu)
{
    lane *hidden = w, *out = w + HIDDEN * (IN + 1);
    lane *vh = v, *vo = v + HIDDEN * (IN + 1);
    for (long e = 0; e < epochs; e++)
        for (long p = 0; p < patterns; p++)
#pragma GCC ivdep
            for (int l = 0; l < LANES; l++) {
                double h[HIDDEN], dh[HIDDEN], d[OUT];
                for (int j = 0; j < HIDDEN; j++) {
                    double s = hidden[j * (IN + 1) + IN][l];
                    for (int i = 0; i < IN; i++) s += hidden[j * (IN + 1) + i][l] * x[p * IN + i];
                    h[j] = 1.0 / (1.0 + exponential(-s));
                }
                for (int k = 0; k < OUT; k++) {
                    double s = out[k * (HIDDEN + 1) + HIDDEN][l];
                    for (int j = 0; j < HIDDEN; j++) s += out[k * (HIDDEN + 1) + j][l] * h[j];
                    d[k] = eta * (y[p * OUT + k] - s);
                }
                for (int j = 0; j < HIDDEN; j++) {
                    double s = 0.0;
                    for (int k = 0; k < OUT; k++) s += d[k] * out[k * (HIDDEN + 1) + j][l];
                    dh[j] = s * h[j] * (1.0 - h[j]);
                }
                for (int k = 0; k < OUT; k++)
                    for (int j = 0; j <= HIDDEN; j++) {
                        int q = k * (HIDDEN + 1) + j;
                        vo[q][l] = mu * vo[q][l] + d[k] * (j < HIDDEN ? h[j] : 1.0);
                        out[q][l] += vo[q][l];
                    }
                for (int j = 0; j < HIDDEN; j++)
                    for (int i = 0; i <= IN; i++) {
                        int q = j * (IN + 1) + i;
                        vh[q][l] = mu * vh[q][l] + dh[j] * (i < IN ? x[p * IN + i] : 1.0);
                        hidden[q][l] += vh[q][l];
                    }
            }
}

/* Train networks (n, 17) from the weights `start` to `end`; n is a multiple of eight. */
int train(const double *start, double *end, const double *x, const double *y, long networks,
          long patterns, long epochs, double eta, double mu)
{
    if (networks % LANES) return 1;
    for (long n = 0; n < networks; n += LANES) {
        lane w[WEIGHTS], v[WEIGHTS];
        memset(v, 0, sizeof v);
        for (int q = 0; q < WEIGHTS; q++)
            for (int l = 0; l < LANES; l++) w[q][l] = start[(n + l) * WEIGHTS + q];
        block(w, v, x, y, patterns, epochs, eta, mu);
        for (int q = 0; q < WEIGHTS; q++)
            for (int l = 0; l < LANES; l++) end[(n + l) * WEIGHTS + q] = w[q][l];
    }
    return 0;
}
