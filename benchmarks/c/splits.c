/* One training of one small network, split among threads in three ways, and not split.
 *
 * One hidden layer of sigmoids, linear outputs, momentum, textbook rule, table's order. The clock
 * runs once all threads have started, so what is measured is the best that each way can do. */
#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { SERIAL, AVERAGING, HOGWILD, NODES };
enum { SPINS = 2000, MAX_THREADS = 64 };

typedef _Atomic double shared_t; /* relaxed reads and writes: plain moves, but no data race */

static struct {
    long mode, threads, every, nx, nh, ny, patterns, epochs, weights, stride;
    const double *x, *y;
    double eta, mu, tolerance;
    shared_t *w;                 /* the common weights */
    double *own_w, *own_v;       /* threads x stride: no two threads share a cache line */
    double *h, *d;               /* outputs of hidden units, error signals of outputs (NODES) */
    atomic_long waiting, round, updates;
    atomic_int stop, solved;
    double seconds;
} job;

static void barrier(void)
{
    long round = atomic_load(&job.round);
    if (atomic_fetch_add(&job.waiting, 1) == job.threads - 1) {
        atomic_store(&job.waiting, 0);
        atomic_fetch_add(&job.round, 1);
        return;
    }
    for (long spins = 0; atomic_load(&job.round) == round; spins++) {
        if (spins < SPINS) __builtin_ia32_pause();
        else sched_yield();
    }
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static double get(const shared_t *w) { return atomic_load_explicit(w, memory_order_relaxed); }
static void put(shared_t *w, double a) { atomic_store_explicit(w, a, memory_order_relaxed); }

/* Weights: hidden units first, then outputs; a unit's bias last. READ and WRITE differ only in
 * whether the weights are this thread's own. */
#define FORWARD(READ, W)                                                                          \
    for (long i = 0; i < nh; i++) {                                                               \
        double s = READ((W) + i * (nx + 1) + nx);                                                 \
        for (long j = 0; j < nx; j++) s += READ((W) + i * (nx + 1) + j) * x[j];                   \
        h[i] = 1.0 / (1.0 + exp(-s));                                                             \
    }                                                                                             \
    for (long k = 0; k < ny; k++) {                                                               \
        double s = READ((W) + top + k * (nh + 1) + nh);                                           \
        for (long i = 0; i < nh; i++) s += READ((W) + top + k * (nh + 1) + i) * h[i];             \
        d[k] = y[k] - s;                                                                          \
    }
#define CHANGE(READ, WRITE, W, AT, G, IN)                                                         \
    do {                                                                                          \
        double c = mu * v[AT] + (G) * (IN);                                                       \
        v[AT] = c;                                                                                \
        WRITE((W) + (AT), READ((W) + (AT)) + c);                                                  \
    } while (0)
#define UPDATE(READ, WRITE, W)                                                                    \
    FORWARD(READ, W)                                                                              \
    for (long i = 0; i < nh; i++) {                                                               \
        double s = 0.0;                                                                           \
        for (long k = 0; k < ny; k++) s += d[k] * READ((W) + top + k * (nh + 1) + i);             \
        back[i] = s * h[i] * (1.0 - h[i]);                                                        \
    }                                                                                             \
    for (long k = 0; k < ny; k++) {                                                               \
        for (long i = 0; i < nh; i++)                                                             \
            CHANGE(READ, WRITE, W, top + k * (nh + 1) + i, eta * d[k], h[i]);                     \
        CHANGE(READ, WRITE, W, top + k * (nh + 1) + nh, eta * d[k], 1.0);                         \
    }                                                                                             \
    for (long i = 0; i < nh; i++) {                                                               \
        for (long j = 0; j < nx; j++)                                                             \
            CHANGE(READ, WRITE, W, i * (nx + 1) + j, eta * back[i], x[j]);                        \
        CHANGE(READ, WRITE, W, i * (nx + 1) + nx, eta * back[i], 1.0);                            \
    }
#define PLAIN_GET(p) (*(p))
#define PLAIN_PUT(p, a) (*(p) = (a))

static int within(const double *w)
{
    const long nx = job.nx, nh = job.nh, ny = job.ny, top = nh * (nx + 1);
    double h[nh], d[ny];
    for (long p = 0; p < job.patterns; p++) {
        const double *x = job.x + p * nx, *y = job.y + p * ny;
        FORWARD(PLAIN_GET, w)
        for (long k = 0; k < ny; k++)
            if (!(fabs(d[k]) < job.tolerance)) return 0;
    }
    return 1;
}

static int within_shared(void)
{
    double w[job.weights];
    for (long q = 0; q < job.weights; q++) w[q] = get(job.w + q);
    return within(w);
}

static void learn(double *w, double *v, long p)
{
    const long nx = job.nx, nh = job.nh, ny = job.ny, top = nh * (nx + 1);
    const double eta = job.eta, mu = job.mu, *x = job.x + p * nx, *y = job.y + p * ny;
    double h[nh], d[ny], back[nh];
    UPDATE(PLAIN_GET, PLAIN_PUT, w)
}

static void learn_shared(double *v, long p)
{
    const long nx = job.nx, nh = job.nh, ny = job.ny, top = nh * (nx + 1);
    const double eta = job.eta, mu = job.mu, *x = job.x + p * nx, *y = job.y + p * ny;
    double h[nh], d[ny], back[nh];
    UPDATE(get, put, job.w)
}

static void serial(double *w, double *v)
{
    for (long e = 0; e < job.epochs; e++) {
        if (within(w)) { job.solved = 1; return; }
        for (long p = 0; p < job.patterns; p++) learn(w, v, p);
        job.updates += job.patterns;
    }
}

/* Each thread learns its own share of the patterns for `every` epochs; then weights and last
 * changes are averaged. */
static void averaging(long me, double *w, double *v)
{
    for (long e = 0; e < job.epochs; e += job.every) {
        if (me == 0 && within(w)) { job.solved = 1; job.stop = 1; }
        barrier();
        if (job.stop) return;
        for (long k = 0; k < job.every; k++)
            for (long p = me; p < job.patterns; p += job.threads) learn(w, v, p);
        barrier();
        double mw[job.weights], mv[job.weights];
        for (long q = 0; q < job.weights; q++) {
            double sw = 0.0, sv = 0.0;
            for (long t = 0; t < job.threads; t++) {
                sw += job.own_w[t * job.stride + q];
                sv += job.own_v[t * job.stride + q];
            }
            mw[q] = sw / job.threads;
            mv[q] = sv / job.threads;
        }
        barrier();
        memcpy(w, mw, sizeof mw);
        memcpy(v, mv, sizeof mv);
        if (me == 0) job.updates += job.every * job.patterns;
    }
}

/* All threads learn all patterns on common weights, without a lock; each begins elsewhere. */
static void hogwild(long me, double *v)
{
    long share = job.epochs / job.threads + 1;
    for (long e = 0; e < share && !atomic_load_explicit(&job.stop, memory_order_relaxed); e++) {
        if (me == 0 && within_shared()) { job.solved = 1; job.stop = 1; break; }
        for (long p = 0; p < job.patterns; p++)
            learn_shared(v, (p + me * job.patterns / job.threads) % job.patterns);
        atomic_fetch_add_explicit(&job.updates, job.patterns, memory_order_relaxed);
    }
}

/* Each thread owns some hidden units and some outputs; four meetings per pattern. */
static void nodes(long me, double *v)
{
    const long nx = job.nx, nh = job.nh, ny = job.ny, top = nh * (nx + 1), n = job.threads;
    const long h0 = nh * me / n, h1 = nh * (me + 1) / n, k0 = ny * me / n, k1 = ny * (me + 1) / n;
    const double eta = job.eta, mu = job.mu;
    double *h = job.h, *d = job.d, *w = job.own_w;
    for (long e = 0; e < job.epochs; e++) {
        if (me == 0 && within(w)) { job.solved = 1; job.stop = 1; }
        barrier();
        if (job.stop) return;
        for (long p = 0; p < job.patterns; p++) {
            const double *x = job.x + p * nx, *y = job.y + p * ny;
            for (long i = h0; i < h1; i++) {
                double s = w[i * (nx + 1) + nx];
                for (long j = 0; j < nx; j++) s += w[i * (nx + 1) + j] * x[j];
                h[i] = 1.0 / (1.0 + exp(-s));
            }
            barrier();
            for (long k = k0; k < k1; k++) {
                double s = w[top + k * (nh + 1) + nh];
                for (long i = 0; i < nh; i++) s += w[top + k * (nh + 1) + i] * h[i];
                d[k] = y[k] - s;
            }
            barrier();
            for (long i = h0; i < h1; i++) {
                double s = 0.0;
                for (long k = 0; k < ny; k++) s += d[k] * w[top + k * (nh + 1) + i];
                double back = s * h[i] * (1.0 - h[i]);
                for (long j = 0; j < nx; j++)
                    CHANGE(PLAIN_GET, PLAIN_PUT, w, i * (nx + 1) + j, eta * back, x[j]);
                CHANGE(PLAIN_GET, PLAIN_PUT, w, i * (nx + 1) + nx, eta * back, 1.0);
            }
            barrier();
            for (long k = k0; k < k1; k++) {
                for (long i = 0; i < nh; i++)
                    CHANGE(PLAIN_GET, PLAIN_PUT, w, top + k * (nh + 1) + i, eta * d[k], h[i]);
                CHANGE(PLAIN_GET, PLAIN_PUT, w, top + k * (nh + 1) + nh, eta * d[k], 1.0);
            }
            barrier(); /* h must not change while another thread still reads it */
        }
        if (me == 0) job.updates += job.patterns;
    }
}

static void *work(void *number)
{
    long me = (long)number;
    double *w = job.own_w + me * job.stride, *v = job.own_v + me * job.stride, begun;
    barrier();
    begun = now();
    if (job.mode == SERIAL) serial(w, v);
    else if (job.mode == AVERAGING) averaging(me, w, v);
    else if (job.mode == HOGWILD) hogwild(me, v);
    else nodes(me, job.own_v); /* every weight has one owner */
    barrier();
    if (me == 0) job.seconds = now() - begun;
    return NULL;
}

/* Train from `start`; `sizes` = inputs, hidden, outputs, patterns. `out` gets seconds, updates,
 * whether the tolerance was met; `end` the weights. Returns 0, or 1 if memory or threads fail. */
int train(long mode, long threads, long every, const long *sizes, const double *start,
          const double *x, const double *y, long epochs, double eta, double mu, double tolerance,
          double *end, double *out)
{
    pthread_t thread[MAX_THREADS];
    memset(&job, 0, sizeof job);
    job.mode = mode, job.threads = threads, job.every = every;
    job.nx = sizes[0], job.nh = sizes[1], job.ny = sizes[2], job.patterns = sizes[3];
    job.weights = job.nh * (job.nx + 1) + job.ny * (job.nh + 1);
    job.stride = (job.weights + 15) / 16 * 16;
    job.x = x, job.y = y, job.epochs = epochs;
    job.eta = eta, job.mu = mu, job.tolerance = tolerance;
    job.w = malloc(job.weights * sizeof *job.w);
    job.own_w = aligned_alloc(128, threads * job.stride * sizeof(double));
    job.own_v = aligned_alloc(128, threads * job.stride * sizeof(double));
    job.h = calloc(job.nh, sizeof(double));
    job.d = calloc(job.ny, sizeof(double));
    if (!job.w || !job.own_w || !job.own_v || !job.h || !job.d || threads > MAX_THREADS) return 1;
    memset(job.own_v, 0, threads * job.stride * sizeof(double));
    for (long q = 0; q < job.weights; q++) put(job.w + q, start[q]);
    for (long t = 0; t < threads; t++)
        memcpy(job.own_w + t * job.stride, start, job.weights * sizeof(double));
    for (long t = 1; t < threads; t++)
        if (pthread_create(thread + t, NULL, work, (void *)t)) return 1;
    work((void *)0);
    for (long t = 1; t < threads; t++) pthread_join(thread[t], NULL);
    for (long q = 0; q < job.weights; q++) end[q] = mode == HOGWILD ? get(job.w + q) : job.own_w[q];
    out[0] = job.seconds, out[1] = job.updates, out[2] = job.solved;
    free(job.w), free(job.own_w), free(job.own_v), free(job.h), free(job.d);
    return 0;
}
