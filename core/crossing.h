/* Where an angle given by a power series leaves an interval inside one step, grazing included.
 * Leaves to others: which intervals matter, and which steps are worth the look (ensemble).
 * Invariant: the first exit is found whatever the number of extrema, as long as they are a 32nd of the step apart. */
#ifndef PEND_CROSSING_H
#define PEND_CROSSING_H

#include <stddef.h>

/* phi(x) = phi + phi_low + sum_j rate[j * stride] x^{j + 1} / (j + 1), j = 0 .. order */
struct crossing_path {
    int order;
    size_t stride;
    const double *rate, *share; /* share[j] = 1 / (j + 1) */
    double phi, phi_low;
};

/** phi at x. O(order). */
double pend_crossing_phi(const struct crossing_path *path, double x);

/** d phi / dx at x. O(order). */
double pend_crossing_rate(const struct crossing_path *path, double x);

/**
 * The first x in (from, to] at which phi reaches low or high, coming from inside.
 *
 * from, to  from < to, in the units of the path.
 * way       out: +1 it left at high, -1 at low; unchanged when it did not.
 *
 * Returns infinity when it stays inside. O(order).
 */
double pend_crossing_next(const struct crossing_path *path, double from, double to, double low, double high, int *way);

#endif
