/* Online back-propagation as plain loops over sizes known only at run time.
 *
 * Weights are flat: layer by layer, unit by unit, a unit's incoming weights first, its bias last.
 * Rule 0 takes hidden errors through the old weights, rule 1 through the already updated ones. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LINEAR, SIGMOID, TANH };
enum { MAX_LAYERS = 16 };

struct layer {
    long inputs, units, kind;
    double *w, *v;     /* units x (inputs + 1): weights and their last changes */
    double *in;        /* outputs of the layer below */
    double *out, *d;   /* outputs and error signals of this layer */
};

static double activate(long kind, double s)
{
    if (kind == SIGMOID) return 1.0 / (1.0 + exp(-s));
    if (kind == TANH) return tanh(s);
    return s;
}

static double slope(long kind, double out)
{
    if (kind == SIGMOID) return out * (1.0 - out);
    if (kind == TANH) return 1.0 - out * out;
    return 1.0;
}

static void forward(const struct layer *l)
{
    const double *w = l->w;
    for (long u = 0; u < l->units; u++) {
        double s = w[l->inputs];
        for (long i = 0; i < l->inputs; i++) s += w[i] * l->in[i];
        l->out[u] = activate(l->kind, s);
        w += l->inputs + 1;
    }
}

static void back(const struct layer *l, const struct layer *below)
{
    long stride = l->inputs + 1;
    for (long i = 0; i < l->inputs; i++) {
        double s = 0.0;
        for (long u = 0; u < l->units; u++) s += l->d[u] * l->w[u * stride + i];
        below->d[i] = s * slope(below->kind, below->out[i]);
    }
}

static void change(const struct layer *l, double eta, double mu)
{
    double *w = l->w, *v = l->v;
    for (long u = 0; u < l->units; u++) {
        double g = eta * l->d[u];
        for (long i = 0; i < l->inputs; i++) {
            v[i] = mu * v[i] + g * l->in[i];
            w[i] += v[i];
        }
        v[l->inputs] = mu * v[l->inputs] + g;
        w[l->inputs] += v[l->inputs];
        w += l->inputs + 1;
        v += l->inputs + 1;
    }
}

static void update(struct layer *net, long layers, const double *x, const double *y,
                   double eta, double mu, long rule)
{
    struct layer *last = net + layers - 1;
    memcpy(net->in, x, net->inputs * sizeof *x);
    for (long k = 0; k < layers; k++) forward(net + k);
    for (long u = 0; u < last->units; u++)
        last->d[u] = (y[u] - last->out[u]) * slope(last->kind, last->out[u]);
    for (long k = layers - 1; k >= 0; k--) {
        if (k > 0 && rule == 0) back(net + k, net + k - 1);
        change(net + k, eta, mu);
        if (k > 0 && rule == 1) back(net + k, net + k - 1);
    }
}

/* From the weights `start`, train `epochs` epochs; all of that `repeats` times. `shape` has the
 * inputs, units and activation of each layer. The weights of the last time are in `w`. */
int train(const long *shape, long layers, const double *start, double *w, const double *x,
          const double *y, long patterns, long epochs, long repeats, double eta, double mu,
          long rule)
{
    struct layer net[MAX_LAYERS];
    long weights = 0, units = shape[0];
    for (long k = 0; k < layers; k++) {
        weights += shape[3 * k + 1] * (shape[3 * k] + 1);
        units += shape[3 * k + 1];
    }
    double *v = malloc(weights * sizeof *v), *o = calloc(2 * units, sizeof *o);
    if (!v || !o || layers > MAX_LAYERS) return 1;
    double *ww = w, *vv = v, *in = o, *d = o + units + shape[0];
    for (long k = 0; k < layers; k++, shape += 3) {
        net[k] = (struct layer){shape[0], shape[1], shape[2], ww, vv, in, in + shape[0], d};
        ww += shape[1] * (shape[0] + 1);
        vv += shape[1] * (shape[0] + 1);
        in += shape[0];
        d += shape[1];
    }
    long nx = net[0].inputs, ny = net[layers - 1].units;
    for (long r = 0; r < repeats; r++) {
        memcpy(w, start, weights * sizeof *w);
        memset(v, 0, weights * sizeof *v);
        for (long e = 0; e < epochs; e++)
            for (long p = 0; p < patterns; p++)
                update(net, layers, x + p * nx, y + p * ny, eta, mu, rule);
    }
    free(v);
    free(o);
    return 0;
}
