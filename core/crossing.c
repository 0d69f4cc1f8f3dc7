#include "core/crossing.h"

#include <math.h>
#include <string.h>

enum { DEPTH = 40 };

double pend_crossing_value(const struct crossing_path *path, double s) {
    double sum = 0;
    for (int j = path->degree; j >= 1; j--) sum = (sum + path->a[j]) * s;
    return path->base + (sum + path->low);
}

static double crossing_slope(const struct crossing_path *path, double s) {
    double sum = 0;
    for (int j = path->degree; j >= 1; j--) sum = sum * s + j * path->a[j];
    return sum;
}

typedef double crossing_fn(const struct crossing_path *path, double s);

/* where a function that changes sign relative to `level` between a and b does so, on b's side to the last bits: the
 * false position of both ends in turn, and halving, so that it ends in any case */
static double crossing_root(const struct crossing_path *path, crossing_fn *f, double level, double a, double b) {
    double at_a = f(path, a) - level, at_b = f(path, b) - level;
    int above = at_b >= 0;
    for (int i = 0; i < 160 && b - a > 0x1p-53; i++) {
        double c = i % 3 == 2 ? 0.5 * (a + b) : b - at_b * ((b - a) / (at_b - at_a));
        // a hair towards the far end, so that the bracket closes from both sides
        c += c - a < b - c ? 0x1p-53 : -0x1p-53;
        if (!(c > a && c < b)) c = 0.5 * (a + b);
        if (c == a || c == b) break;
        double at_c = f(path, c) - level;
        if ((at_c >= 0) == above) {
            b = c;
            at_b = at_c;
        } else {
            a = c;
            at_a = at_c;
        }
    }
    return b;
}

/* the derivative in Bernstein's form on [0, 1] */
static void crossing_bernstein(const struct crossing_path *path, double b[]) {
    int d = path->degree - 1;
    double choose = 1;
    for (int j = 0; j <= d; j++) {
        b[j] = (j + 1) * path->a[j + 1] / choose;
        choose = choose * (d - j) / (j + 1);
    }
    for (int r = 1; r <= d; r++)
        for (int i = d; i >= r; i--) b[i] += b[i - 1];
}

/* sign changes of coefficients, those within rounding of zero left out; more than one counts as two */
static int crossing_changes(int d, const double b[], double noise) {
    int changes = 0, sign = 0;
    for (int i = 0; i <= d && changes < 2; i++) {
        int here = (b[i] > noise) - (b[i] < -noise);
        if (here && sign && here != sign) changes++;
        if (here) sign = here;
    }
    return changes;
}

/* the two halves of an interval: left over b, right into `right` */
static void crossing_halve(int d, double b[], double right[]) {
    for (int r = 0; r <= d; r++) {
        right[d - r] = b[d];
        for (int i = d; i > r; i--) b[i] = 0.5 * (b[i] + b[i - 1]);
    }
}

static void crossing_turn(struct crossing_path *path, double a, double b) {
    double from = crossing_slope(path, a), to = crossing_slope(path, b);
    if ((from < 0) == (to < 0)) return;
    double s = crossing_root(path, crossing_slope, 0, a, b);
    if (path->pieces && s <= path->end[path->pieces - 1]) return;
    if (s < 1 && path->pieces < PEND_CROSSING_DEGREE) path->end[path->pieces++] = s;
}

/* true where the derivative's leading coefficient outweighs all others */
static int crossing_plain(const struct crossing_path *path) {
    double rest = 0;
    for (int j = 2; j <= path->degree; j++) rest += j * fabs(path->a[j]);
    return fabs(path->a[1]) > rest * (1 + 1e-12);
}

void pend_crossing_divide(struct crossing_path *path) {
    struct {
        double from, to, b[PEND_CROSSING_DEGREE];
    } stack[DEPTH + 1];
    int d = path->degree - 1, top = 0;
    path->pieces = 0;
    if (!crossing_plain(path)) {
        double noise = 0;
        for (int j = 1; j <= path->degree; j++) noise += 1e-15 * j * fabs(path->a[j]);
        crossing_bernstein(path, stack[0].b);
        stack[0].from = 0, stack[0].to = 1, top = 1;
        while (top) {
            top--;
            int changes = crossing_changes(d, stack[top].b, noise);
            double from = stack[top].from, to = stack[top].to;
            if (changes > 1 && top < DEPTH) {
                // the left half goes on top: turns come out in order
                double right[PEND_CROSSING_DEGREE];
                memcpy(stack[top + 1].b, stack[top].b, sizeof right);
                crossing_halve(d, stack[top + 1].b, stack[top].b);
                stack[top].from = stack[top + 1].to = 0.5 * (from + to);
                stack[top].to = to;
                stack[top + 1].from = from;
                top += 2;
            } else if (changes) {
                crossing_turn(path, from, to);
            }
        }
    }
    path->end[path->pieces++] = 1;
}

double pend_crossing_next(const struct crossing_path *path, double from, double low, double high, int *way) {
    double a = from;
    for (int i = 0; i < path->pieces; i++) {
        double b = path->end[i];
        if (b <= a) continue;
        double at_a = pend_crossing_value(path, a), at_b = pend_crossing_value(path, b);
        int up = at_b > at_a, out = up ? at_b >= high : at_b <= low;
        if (out) {
            *way = up ? 1 : -1;
            double level = up ? high : low;
            // it may be there already, by rounding
            if (up ? at_a >= level : at_a <= level) return b;
            return crossing_root(path, pend_crossing_value, level, a, b);
        }
        a = b;
    }
    return INFINITY;
}

struct crossing_extremes pend_crossing_extremes(const struct crossing_path *path) {
    double value = pend_crossing_value(path, 0);
    struct crossing_extremes found = {value, 0, value, 0};
    for (int i = 0; i < path->pieces; i++) {
        value = pend_crossing_value(path, path->end[i]);
        if (value > found.most) found.most = value, found.most_at = path->end[i];
        if (value < found.least) found.least = value, found.least_at = path->end[i];
    }
    return found;
}
