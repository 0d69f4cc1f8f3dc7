/* Where a quantity given by a power series turns, leaves an interval or is largest inside one
 * step, grazing included.
 * Leaves to others: which intervals matter, and which steps are worth the look (ensemble).
 * Invariant: no turning point is missed that moves the quantity by more than its rounding,
 * however close two may be. */
#ifndef PEND_ROOTS_H
#define PEND_ROOTS_H

enum { PEND_ROOTS_DEGREE = 40 };

/* base + (low + sum_{j >= 1} a[j] s^j), s from 0 to 1: the step; a[0] is not used */
struct roots_path {
    int degree; /* 1 .. PEND_ROOTS_DEGREE */
    double base, low;
    double a[PEND_ROOTS_DEGREE + 1];
    /* the ends of the pieces on which it only rises or only falls, ascending; the last is 1 */
    int pieces;
    double end[PEND_ROOTS_DEGREE + 1];
};

/* The least and the largest value on [0, 1], and where. */
struct roots_extremes {
    double least, least_at, most, most_at;
};

/** The quantity at s. O(degree). */
double pend_roots_value(const struct roots_path *path, double s);

/**
 * Fills in `pieces` and `end`.
 *
 * Counts the sign changes of the derivative's Bernstein coefficients: none or one says for certain
 * how many times it turns; with more the interval is halved. O(degree) where the first terms show
 * that it does not turn, else O(degree^2) a halving.
 */
void pend_roots_divide(struct roots_path *path);

/**
 * The first s in (from, 1] at which a divided path reaches low or high, coming from inside.
 *
 * from  0 <= from < 1; where a path left its interval before, it is not taken to leave it again
 *       without having turned.
 * way   out: +1 it left at high, -1 at low; unchanged when it did not.
 *
 * Returns infinity when it stays inside.
 */
double pend_roots_next(const struct roots_path *path, double from, double low, double high,
                       int *way);

/** Extremes of a divided path; of equal ones the first. */
struct roots_extremes pend_roots_extremes(const struct roots_path *path);

#endif
