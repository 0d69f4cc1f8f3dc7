#include "core/ensemble/ensemble_shadow.h"

#include <assert.h>
#include <math.h>

/* The initial distance of the neighbour, rad. It balances two relative errors, both near 1e-8: the
 * linear law neglects the square of the distance, and rounding errors are divided by the
 * distance. */
static const double shadow_distance = 1e-8;

/* computes b = a + gap, where a and b are sums of two doubles */
static void shadow_put(double high[], double low[], int at, double gap) {
    double add = low[at] + gap, total = high[at] + add, part = total - high[at];
    high[at + 1] = total;
    low[at + 1] = (high[at] - (total - part)) + (add - part);
}

/* the divisor of the gap of coordinate k; for a cart a length, m, for comparison with angles */
static double shadow_unit(const struct pend_ensemble *e, int i, int k) {
    return k || !pend_terms_cart(e->lanes.terms) ? 1 : e->seat[i].shortest;
}

/* Sets the factors that convert rates, and a cart's position, to angles. Without gravity, the
 * factor of rates is the largest rate of an arm, or 1 over the duration. */
static void shadow_scale(struct pend_ensemble *e, int i) {
    const struct ensemble_lanes *lanes = &e->lanes;
    double length = 0, turning = 0, shortest = INFINITY;
    for (int k = pend_terms_cart(lanes->terms); k < lanes->n; k++) {
        int at = k * lanes->width + i;
        length += lanes->len[at];
        shortest = fmin(shortest, lanes->len[at]);
        turning = fmax(turning, fabs(lanes->from.rate[at]));
    }
    double frequency = sqrt(fabs(lanes->gravity[i]) / length);
    if (!(frequency > 0)) frequency = turning;
    if (!(frequency > 0)) frequency = 1 / fabs(lanes->stop[i]);
    e->seat[i].frequency = frequency;
    e->seat[i].shortest = shortest;
}

void pend_ensemble_shadow_start(struct pend_ensemble *e, int i) {
    assert(e->lanes.paired && i % 2 == 0 && i < e->lanes.width);
    struct ensemble_lanes *lanes = &e->lanes;
    struct ensemble_state *from = &lanes->from;
    double sum = 0;
    shadow_scale(e, i);
    for (int k = 0; k < lanes->n; k++) {
        int at = k * lanes->width + i;
        sum += cos(k + 1) * cos(k + 1) + sin(3 * k + 2) * sin(3 * k + 2);
        lanes->len[at + 1] = lanes->len[at];
        lanes->inv_len[at + 1] = lanes->inv_len[at];
        lanes->mass[at + 1] = lanes->mass[at];
        if (lanes->bound > 0) lanes->cell[at + 1] = lanes->cell[at];
    }
    e->seat[i].growth = 0;
    // the initial direction is not a symmetry of any tree
    for (int k = 0; k < lanes->n; k++) {
        int at = k * lanes->width + i;
        double distance = shadow_distance * shadow_unit(e, i, k) / sqrt(sum);
        shadow_put(from->phi, from->phi_low, at, distance * cos(k + 1));
        shadow_put(from->rate, from->rate_low, at,
                   distance * e->seat[i].frequency * sin(3 * k + 2));
    }
    for (int j = 0; lanes->terms && j < lanes->terms->count; j++)
        lanes->value[j * lanes->width + i + 1] = lanes->value[j * lanes->width + i];
    from->time[i + 1] = from->time[i];
    from->gain[i + 1] = from->gain[i];
    lanes->start[i + 1] = lanes->start[i];
    lanes->stop[i + 1] = lanes->stop[i];
    lanes->gravity[i + 1] = lanes->gravity[i];
    lanes->unit[i + 1] = lanes->unit[i];
}

/* b - a, where a and b are sums of two doubles */
static double shadow_gap(const double high[], const double low[], int at) {
    return (high[at + 1] - high[at]) + (low[at + 1] - low[at]);
}

static double shadow_far(const struct pend_ensemble *e, int i) {
    const struct ensemble_state *to = &e->lanes.to;
    double sum = 0;
    for (int k = 0; k < e->lanes.n; k++) {
        int at = k * e->lanes.width + i;
        double unit = shadow_unit(e, i, k), phi = shadow_gap(to->phi, to->phi_low, at) / unit;
        double rate = shadow_gap(to->rate, to->rate_low, at) / (unit * e->seat[i].frequency);
        sum += phi * phi + rate * rate;
    }
    return sqrt(sum);
}

void pend_ensemble_shadow_step(struct pend_ensemble *e, int i) {
    assert(e->lanes.paired && i % 2 == 0 && i < e->lanes.width);
    const struct ensemble_state *to = &e->lanes.to;
    double far = shadow_far(e, i), grown = far / shadow_distance;
    if (grown > 0.1 && grown < 10) return;
    if (!(grown > 0) || !isfinite(grown)) return;
    e->seat[i].growth += log(grown);
    for (int k = 0; k < e->lanes.n; k++) {
        int at = k * e->lanes.width + i;
        shadow_put(to->phi, to->phi_low, at, shadow_gap(to->phi, to->phi_low, at) / grown);
        shadow_put(to->rate, to->rate_low, at, shadow_gap(to->rate, to->rate_low, at) / grown);
    }
}

double pend_ensemble_shadow_exponent(const struct pend_ensemble *e, int i) {
    assert(e->lanes.paired && i % 2 == 0 && i < e->lanes.width);
    double time = e->lanes.to.time[i];
    return time == 0 ? NAN
                     : (e->seat[i].growth + log(shadow_far(e, i) / shadow_distance)) / fabs(time);
}
