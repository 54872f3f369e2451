/* Online back-propagation of one network only: 2-3-2, sigmoid below, linear outputs.
 *
 * Every size is known to the compiler, so it can unroll all loops and keep weights in registers;
 * hidden errors go through the old weights. The flat order of weights is that of generic.c. */
#include <math.h>
#include <string.h>

enum { IN = 2, HIDDEN = 3, OUT = 2 };

struct net {
    double hidden[HIDDEN][IN + 1];
    double out[OUT][HIDDEN + 1];
};

static inline void update(struct net *w, struct net *v, const double *x, const double *y,
                          double eta, double mu)
{
    double h[HIDDEN], dh[HIDDEN], d[OUT];
    for (int j = 0; j < HIDDEN; j++) {
        double s = w->hidden[j][IN];
        for (int i = 0; i < IN; i++) s += w->hidden[j][i] * x[i];
        h[j] = 1.0 / (1.0 + exp(-s));
    }
    for (int k = 0; k < OUT; k++) {
        double s = w->out[k][HIDDEN];
        for (int j = 0; j < HIDDEN; j++) s += w->out[k][j] * h[j];
        d[k] = eta * (y[k] - s);
    }
    for (int j = 0; j < HIDDEN; j++) {
        double s = 0.0;
        for (int k = 0; k < OUT; k++) s += d[k] * w->out[k][j];
        dh[j] = s * h[j] * (1.0 - h[j]);
    }
    for (int k = 0; k < OUT; k++)
        for (int j = 0; j <= HIDDEN; j++) {
            v->out[k][j] = mu * v->out[k][j] + d[k] * (j < HIDDEN ? h[j] : 1.0);
            w->out[k][j] += v->out[k][j];
        }
    for (int j = 0; j < HIDDEN; j++)
        for (int i = 0; i <= IN; i++) {
            v->hidden[j][i] = mu * v->hidden[j][i] + dh[j] * (i < IN ? x[i] : 1.0);
            w->hidden[j][i] += v->hidden[j][i];
        }
}

/* From the weights `start`, train `epochs` epochs; all of that `repeats` times. */
int train(const struct net *start, struct net *end, const double *x, const double *y,
          long patterns, long epochs, long repeats, double eta, double mu)
{
    for (long r = 0; r < repeats; r++) {
        struct net w = *start, v;
        memset(&v, 0, sizeof v);
        for (long e = 0; e < epochs; e++)
            for (long p = 0; p < patterns; p++)
                update(&w, &v, x + p * IN, y + p * OUT, eta, mu);
        *end = w;
    }
    return 0;
}
