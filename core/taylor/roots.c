#include "core/taylor/roots.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { DEPTH = 40 };

double pend_roots_value(const struct roots_path *path, double s) {
    double sum = 0;
    for (int j = path->degree; j >= 1; j--) sum = (sum + path->a[j]) * s;
    return path->base + (sum + path->low);
}

struct roots_pair {
    double value, slope;
};

typedef struct roots_pair roots_fn(const struct roots_path *path, double s);

static struct roots_pair roots_value_pair(const struct roots_path *path, double s) {
    struct roots_pair sum = {0, 0};
    for (int j = path->degree; j >= 1; j--) {
        sum.slope = sum.slope * s + j * path->a[j];
        sum.value = (sum.value + path->a[j]) * s;
    }
    sum.value = path->base + (sum.value + path->low);
    return sum;
}

static struct roots_pair roots_slope_pair(const struct roots_path *path, double s) {
    struct roots_pair sum = {0, 0};
    for (int j = path->degree; j >= 1; j--) {
        sum.slope = sum.slope * s + sum.value;
        sum.value = sum.value * s + j * path->a[j];
    }
    return sum;
}

/* the point between a and b at which f rises above `level` (above), or falls below it: Newton's
 * method, with bisection if a step would leave the bracket */
static double roots_root(const struct roots_path *path, roots_fn *f, double level, int above,
                         double a, double b) {
    assert(a <= b);
    double s = 0.5 * (a + b), last = 1;
    for (int i = 0; i < 100; i++) {
        struct roots_pair at = f(path, s);
        if ((at.value >= level) == (above != 0))
            b = s;
        else
            a = s;
        double next = s - (at.value - level) / at.slope;
        double step = fabs(next - s);
        // near the root, a step that leaves the bracket or does not shrink is a rounding error:
        // then all points in the bracket are equivalent
        if (last < 1e-7 && !(next > a && next < b && step < 0.25 * last)) {
            if (step <= 2 * last) s = fmin(fmax(next, a), b);
            break;
        }
        if (!(next > a && next < b)) next = 0.5 * (a + b);
        step = fabs(next - s);
        s = next;
        if (step <= 1e-15) break;
        last = step;
    }
    return s;
}

/* the derivative in Bernstein's form on [0, 1] */
static void roots_bernstein(const struct roots_path *path, double b[]) {
    int d = path->degree - 1;
    double choose = 1;
    for (int j = 0; j <= d; j++) {
        b[j] = (j + 1) * path->a[j + 1] / choose;
        choose = choose * (d - j) / (j + 1);
    }
    for (int r = 1; r <= d; r++)
        for (int i = d; i >= r; i--) b[i] += b[i - 1];
}

/* the first and last sign of the coefficients that exceed rounding errors, and the number of sign
 * changes */
struct roots_signs {
    int first, last, changes;
};

static struct roots_signs roots_signs(int d, const double b[], double noise) {
    struct roots_signs signs = {0, 0, 0};
    for (int i = 0; i <= d; i++) {
        int here = (b[i] > noise) - (b[i] < -noise);
        if (!here) continue;
        if (!signs.first) signs.first = here;
        signs.changes += signs.last == -here;
        signs.last = here;
    }
    return signs;
}

/* splits an interval in halves: b becomes the left one, `right` the right one */
static void roots_halve(int d, double b[], double right[]) {
    for (int r = 0; r <= d; r++) {
        right[d - r] = b[d];
        for (int i = d; i > r; i--) b[i] = 0.5 * (b[i] + b[i - 1]);
    }
}

static void roots_note(struct roots_path *path, double s) {
    if (path->pieces && s <= path->end[path->pieces - 1]) return;
    if (s < 1 && path->pieces < PEND_ROOTS_DEGREE) path->end[path->pieces++] = s;
}

/* adds the turning points of an interval that needs no further halving; *before is the sign of the
 * derivative at the start, and becomes that at the end */
static void roots_turns(struct roots_path *path, struct roots_signs signs, int *before, double a,
                        double b) {
    if (signs.first && *before == -signs.first) roots_note(path, a);
    if (signs.changes % 2)
        roots_note(path, roots_root(path, roots_slope_pair, 0, signs.last > 0, a, b));
    if (signs.last) *before = signs.last;
}

/* searches the whole step in Bernstein's form: intervals are halved until each has at most one
 * turning point, and visited in order */
static void roots_search(struct roots_path *path) {
    struct {
        double from, to, b[PEND_ROOTS_DEGREE];
    } stack[DEPTH + 1];
    int d = path->degree - 1, before = 0;
    double noise = 0;
    for (int j = 1; j <= path->degree; j++) noise += 1e-15 * j * fabs(path->a[j]);
    roots_bernstein(path, stack[0].b);
    stack[0].from = 0, stack[0].to = 1;
    for (int top = 1; top--;) {
        double from = stack[top].from, to = stack[top].to;
        struct roots_signs signs = roots_signs(d, stack[top].b, noise);
        if (signs.changes <= 1 || top == DEPTH) {
            roots_turns(path, signs, &before, from, to);
            continue;
        }
        // the left half goes on top of the stack, so that it is visited first
        memcpy(stack[top + 1].b, stack[top].b, sizeof stack[top].b);
        roots_halve(d, stack[top + 1].b, stack[top].b);
        stack[top].from = stack[top + 1].to = 0.5 * (from + to);
        stack[top].to = to;
        stack[top + 1].from = from;
        top += 2;
    }
}

int pend_roots_valid(const struct roots_path *path) {
    if (path->pieces < 1 || path->pieces > PEND_ROOTS_DEGREE + 1) return 0;
    for (int i = 0; i < path->pieces; i++)
        if (path->end[i] < (i ? path->end[i - 1] : 0)) return 0;
    return path->end[path->pieces - 1] == 1;
}

void pend_roots_divide(struct roots_path *path) {
    assert(path->degree >= 1 && path->degree <= PEND_ROOTS_DEGREE);
    path->pieces = 0;
    // no zero if the derivative's leading coefficient exceeds the sum of all others
    double rest = 0;
    for (int j = 2; j <= path->degree; j++) rest += j * fabs(path->a[j]);
    if (!(fabs(path->a[1]) > rest * (1 + 1e-12))) roots_search(path);
    path->end[path->pieces++] = 1;
    assert(pend_roots_valid(path));
}

double pend_roots_next(const struct roots_path *path, double from, double low, double high,
                       int *way) {
    assert(pend_roots_valid(path) && from >= 0 && low <= high);
    double a = from;
    for (int i = 0; i < path->pieces; i++) {
        double b = path->end[i];
        if (b <= a) continue;
        double at_a = pend_roots_value(path, a), at_b = pend_roots_value(path, b);
        int up = at_b > at_a, out = up ? at_b >= high : at_b <= low;
        if (out) {
            *way = up ? 1 : -1;
            double level = up ? high : low;
            // rounding may put the start of the piece at the level
            if (up ? at_a >= level : at_a <= level) return a;
            return roots_root(path, roots_value_pair, level, up, a, b);
        }
        a = b;
    }
    return INFINITY;
}

struct roots_extremes pend_roots_extremes(const struct roots_path *path) {
    assert(pend_roots_valid(path));
    double value = pend_roots_value(path, 0);
    struct roots_extremes found = {value, 0, value, 0};
    for (int i = 0; i < path->pieces; i++) {
        value = pend_roots_value(path, path->end[i]);
        if (value > found.most) found.most = value, found.most_at = path->end[i];
        if (value < found.least) found.least = value, found.least_at = path->end[i];
    }
    assert(!(found.least > found.most));
    return found;
}

double pend_roots_node(int i, int count) { return (1 - cos(M_PI * i / (count - 1))) / 2; }

void pend_roots_through(int count, const double at[], double out[]) {
    double gap[PEND_ROOTS_DEGREE];
    assert(count >= 1 && count <= PEND_ROOTS_DEGREE);
    memcpy(gap, at, (size_t)count * sizeof *gap);
    memset(out, 0, (size_t)count * sizeof *out);
    // divided differences, then Horner's rule
    for (int i = 1; i < count; i++)
        for (int j = count - 1; j >= i; j--)
            gap[j] =
                (gap[j] - gap[j - 1]) / (pend_roots_node(j, count) - pend_roots_node(j - i, count));
    for (int i = count - 1; i >= 0; i--) {
        for (int j = count - 1; j > 0; j--)
            out[j] = out[j - 1] - pend_roots_node(i, count) * out[j];
        out[0] = gap[i] - pend_roots_node(i, count) * out[0];
    }
}
