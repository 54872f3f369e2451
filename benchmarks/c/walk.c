/* Rovers that look along 64 beams, turn away from what is near, and move: the plain walk from cell
 * to cell, as one would write it. Corners are not looked at; a rover moves by its chord. */
#include <math.h>
#include <stdint.h>

static double beam(const uint8_t *grid, long side, double x, double y, double a, double reach)
{
    double c = cos(a), s = sin(a), ix = 1.0 / fabs(c), iy = 1.0 / fabs(s);
    long i = (long)floor(y), j = (long)floor(x), di = s > 0 ? 1 : -1, dj = c > 0 ? 1 : -1;
    double tx = (c > 0 ? j + 1 - x : x - j) * ix, ty = (s > 0 ? i + 1 - y : y - i) * iy, t = 0.0;
    while (t < reach && (unsigned long)i < (unsigned long)side
           && (unsigned long)j < (unsigned long)side) {
        if (grid[i * side + j]) return t;
        if (tx < ty) { t = tx; tx += ix; j += dj; }
        else         { t = ty; ty += iy; i += di; }
    }
    return reach;
}

long train(double *pose, long n, const double *angles, long beams, const uint8_t *grid, long side,
           long steps, double reach, double speed, double turn, double period, double *mean)
{
    for (long step = 0; step < steps; step++)
        for (long k = 0; k < n; k++) {
            double *p = pose + 3 * k, right = reach, left = reach;
            for (long b = 0; b < beams; b++) {
                double r = beam(grid, side, p[0], p[1], p[2] + angles[b], reach);
                if (step == 0) *mean += r / (double)(n * beams);
                if (b < beams / 2) right = r < right ? r : right;
                else left = r < left ? r : left;
            }
            double w = left >= right ? turn : -turn, half = 0.5 * w * period;
            double chord = speed * period * sin(half) / half, a = p[2] + half;
            double x = p[0] + chord * cos(a), y = p[1] + chord * sin(a);
            long i = (long)floor(y), j = (long)floor(x);
            if (i >= 0 && j >= 0 && i < side && j < side && !grid[i * side + j]) {
                p[0] = x;
                p[1] = y;
                p[2] += w * period;
            }
        }
    return 0;
}
