/* The work of drives and the heat of friction in a motion by power series: integrals of a power,
 * step by step.
 * Leaves to others: the series of the power (jets, extended), which motions have a power (terms).
 * Invariant: the sum is compensated, so that a million steps add no more than their own
 * rounding. */
#pragma once

#include <assert.h>

#include "core/base/checkpoint.h"

enum { PEND_EXCHANGE_ORDERS = 80 };

/* The work or heat up to the start of the last step, J, as a sum of two doubles, and a power series
 * for that step, times unit^2: first the power, later its integral over x. */
struct pend_given {
    double sum, low;
    int count;  /* number of coefficients up to the last nonzero one */
    double end; /* J, integral over the whole step */
    double series[PEND_EXCHANGE_ORDERS];
};

struct pend_exchange {
    int order;   /* number of coefficients of both series, at most PEND_EXCHANGE_ORDERS */
    double unit; /* s, unit of the last step */
    double end;  /* length of the last step in units */
    double share[PEND_EXCHANGE_ORDERS]; /* 1 / (j + 1); set after the first step */
    struct pend_given work, heat;
};

/** Returns the integral of the series from the start of the step to x units after it, J.
 * O(order). */
static inline double pend_given_inside(const struct pend_exchange *exchange,
                                       const struct pend_given *given, double x) {
    // four separate sums, each of every fourth term, can be computed in parallel
    double sum[4] = {0}, square = x * x, fourth = square * square, inverse = 1 / exchange->unit;
    if (!given->count) return 0;
    for (int j = (given->count - 1) / 4 * 4; j >= 0; j -= 4)
        for (int i = 0; i < 4; i++) sum[i] = sum[i] * fourth + given->series[j + i];
    double even = sum[0] + square * sum[2], odd = sum[1] + square * sum[3];
    return (even + x * odd) * x * (inverse * inverse);
}

/** Returns the total, J, given the integral inside the last step. */
static inline double pend_given_plus(const struct pend_given *given, double inside) {
    return given->sum + (given->low + inside);
}

/** Returns the total x units after the start of the last step, J. O(order). */
static inline double pend_given_at(const struct pend_exchange *exchange,
                                   const struct pend_given *given, double x) {
    double inside = x == exchange->end ? given->end : pend_given_inside(exchange, given, x);
    return pend_given_plus(given, inside);
}

/**
 * Returns the part of the pivot's work, x units after the start of the step, that comes from orders
 * of its power beyond `from`. The power is the product of force and velocity, of which `order`
 * coefficients are known. With a fast drive, the later half of the product does not decrease. Unit:
 * J times unit^2 / unit.
 *
 * force, speed  components along the same two axes.
 * from          order .. 2 order - 1.
 *
 * O(order^2).
 */
static inline double pend_exchange_beyond(const double *const force[2],
                                          const double *const speed[2], int order, int from,
                                          double x) {
    double sum = 0;
    for (int k = 2 * order - 2; k >= from; k--) {
        double part = 0;
        for (int i = 0; i < 2; i++)
            for (int j = k - order + 1; j < order; j++) part += force[i][j] * speed[i][k - j];
        sum = sum * x + part / (k + 1);
    }
    for (int k = 0; k <= from; k++) sum *= x;
    return sum;
}

/** Turns the series of the powers of work and heat into those of their integrals over a step that
 * ends after x units. O(order). */
static inline void pend_exchange_take(struct pend_exchange *exchange, double x) {
    struct pend_given *both[] = {&exchange->work, &exchange->heat};
    assert(exchange->order >= 0 && exchange->order <= PEND_EXCHANGE_ORDERS && exchange->unit != 0);
    for (int j = 0; j < PEND_EXCHANGE_ORDERS && exchange->share[0] != 1; j++)
        exchange->share[PEND_EXCHANGE_ORDERS - 1 - j] = 1.0 / (PEND_EXCHANGE_ORDERS - j);
    exchange->end = x;
    for (int i = 0; i < 2; i++) {
        double *series = both[i]->series;
        int count = exchange->order;
        while (count && series[count - 1] == 0) count--;
        for (int j = 0; j < count; j++) series[j] *= exchange->share[j];
        for (int j = count; j % 4; j++) series[j] = 0;
        both[i]->count = count;
        both[i]->end = pend_given_inside(exchange, both[i], x);
    }
}

/** Adds a step without a series whose work and heat, J, are known. O(1). */
static inline void pend_exchange_put(struct pend_exchange *exchange, double x, double work,
                                     double heat) {
    exchange->end = x;
    exchange->work.count = exchange->heat.count = 0;
    exchange->work.end = work, exchange->heat.end = heat;
}

/** Adds a completed step. */
static inline void pend_exchange_add(struct pend_exchange *exchange) {
    struct pend_given *both[] = {&exchange->work, &exchange->heat};
    for (int i = 0; i < 2; i++) {
        double add = both[i]->end + both[i]->low;
        double sum = both[i]->sum + add;
        both[i]->low = add - (sum - both[i]->sum);
        both[i]->sum = sum;
    }
}

/** Saves the sums to a checkpoint, or restores them; the series of the last step are computed
 * again. */
static inline void pend_exchange_carry(struct pend_exchange *exchange,
                                       struct pend_checkpoint *checkpoint) {
    double *sums[] = {&exchange->work.sum, &exchange->work.low, &exchange->heat.sum,
                      &exchange->heat.low};
    for (int i = 0; i < 4; i++) pend_checkpoint_row(checkpoint, sums[i], 1);
}
