/* Instants inside one step at which a quantity, given as a power series, has a turning point,
 * reaches the bounds of an interval (tangentially too), or is largest.
 * Leaves to others: which intervals and which steps are examined (ensemble).
 * Invariant: two turning points are found, even close together, if the quantity changes by more
 * than its rounding error between them. */
#pragma once

enum { PEND_ROOTS_DEGREE = 40 };

/* base + (low + sum_{j >= 1} a[j] s^j), with s the fraction of the step, 0 .. 1; a[0] is not
 * used */
struct roots_path {
    int degree; /* 1 .. PEND_ROOTS_DEGREE */
    double base, low;
    double a[PEND_ROOTS_DEGREE + 1];
    /* number of monotonic pieces; their ends, ascending, the last one 1 */
    int pieces;
    double end[PEND_ROOTS_DEGREE + 1];
};

/* The smallest and the largest value on [0, 1], and the s at which they occur. */
struct roots_extremes {
    double least, least_at, most, most_at;
};

/** Returns the quantity at s, 0 <= s <= 1. O(degree). */
double pend_roots_value(const struct roots_path *path, double s);
int pend_roots_valid(const struct roots_path *path);

/**
 * Divides a path: fills in `pieces` and `end`.
 *
 * The number of sign changes of the derivative's Bernstein coefficients, if it is 0 or 1, is the
 * number of turning points; otherwise the interval is halved. O(degree) if the first terms exclude
 * a turning point, otherwise O(degree^2) per halving.
 */
void pend_roots_divide(struct roots_path *path);

/**
 * Returns the first s in (from, 1] at which a divided path reaches low or high from inside, or
 * infinity if it stays inside.
 *
 * from  0 <= from < 1; a path that has left its interval before `from` can leave it again only
 *       after a turning point.
 * way   out: +1 if the path reaches high, -1 if low; unchanged if it stays inside.
 * O(degree) for each piece and each step of Newton's method.
 */
double pend_roots_next(const struct roots_path *path, double from, double low, double high,
                       int *way);

/** Returns the extremes of a divided path; of equal extremes, the first. O(degree) per piece. */
struct roots_extremes pend_roots_extremes(const struct roots_path *path);

/** Returns node i of `count` in [0, 1]; both ends are nodes. */
double pend_roots_node(int i, int count);

/** Computes the polynomial through values at `count` nodes: coefficients 0 .. count - 1.
 * O(count^2). */
void pend_roots_through(int count, const double at[], double out[]);
