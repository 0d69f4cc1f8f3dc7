#include "core/crossing.h"

#include <math.h>

double pend_crossing_phi(const struct crossing_path *path, double x) {
    double sum = 0;
    for (int j = path->order; j >= 0; j--) sum = sum * x + path->rate[(size_t)j * path->stride] * path->share[j];
    return path->phi + (x * sum + path->phi_low);
}

double pend_crossing_rate(const struct crossing_path *path, double x) {
    double sum = 0;
    for (int j = path->order; j >= 0; j--) sum = sum * x + path->rate[(size_t)j * path->stride];
    return sum;
}

typedef double crossing_fn(const struct crossing_path *path, double x);

/* where a function that changes sign relative to `level` between a and b does so; on b's side to the last bit */
static double crossing_bisect(const struct crossing_path *path, crossing_fn *f, double level, double a, double b) {
    int above = f(path, b) >= level;
    for (int i = 0; i < 64; i++) {
        double c = 0.5 * (a + b);
        if (c == a || c == b) break;
        if ((f(path, c) >= level) == above)
            b = c;
        else
            a = c;
    }
    return b;
}

/* which bound phi is beyond: +1, -1, or 0 inside */
static int crossing_side(double phi, double low, double high) { return (phi >= high) - (phi <= low); }

double pend_crossing_next(const struct crossing_path *path, double from, double to, double low, double high, int *way) {
    enum { PIECES = 32 };
    double a = from, slope = pend_crossing_rate(path, a);
    for (int i = 1; i <= PIECES; i++) {
        double b = i == PIECES ? to : from + (to - from) * i / PIECES, slope_b = pend_crossing_rate(path, b);
        // an extremum inside the piece is looked at before its end
        double stop[2] = {b, b};
        if ((slope < 0) != (slope_b < 0)) stop[0] = crossing_bisect(path, pend_crossing_rate, 0, a, b);
        for (int j = stop[0] == b; j < 2; j++) {
            int side = crossing_side(pend_crossing_phi(path, stop[j]), low, high);
            if (side) {
                *way = side;
                return crossing_bisect(path, pend_crossing_phi, side > 0 ? high : low, a, stop[j]);
            }
            a = stop[j];
        }
        slope = slope_b;
    }
    return INFINITY;
}
