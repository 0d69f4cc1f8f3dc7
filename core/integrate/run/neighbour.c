#include "core/integrate/run/neighbour.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <string.h>

enum { NEIGHBOUR_STATES = 4 };

static const double NEIGHBOUR_NEAR = 1e-7;    /* rad, largest distance of the neighbour */
static const double NEIGHBOUR_LINEAR = 1e-5;  /* largest distance of a rate, relative to the
                                               * friction speed */
static const double NEIGHBOUR_ROUNDED = 1e-8; /* rounding error relative to the distance */
static const double NEIGHBOUR_NEARLY = 2;     /* factor by which a step may exceed `least` */
static const double NEIGHBOUR_FALLS = 0.1;    /* if the last terms are below this fraction of the
                                               * largest, the series converges */
static const double NEIGHBOUR_LIMIT = 0.03;   /* largest difference of two limits of a series */

static size_t neighbour_rows(const struct pend_problem *problem, int cap) {
    size_t n = (size_t)problem->tree->n, states = NEIGHBOUR_STATES * pend_jets_stride((int)n);
    return (states + 4 * n * (size_t)(cap + 1) + 7) / 8 * 8 * sizeof(double);
}

size_t pend_neighbour_bytes(const struct pend_problem *problem, int cap) {
    return neighbour_rows(problem, cap) + pend_jets_bytes(problem->tree, problem->loads.terms, cap);
}

/* the largest deviation of a rate within which dry friction is linear */
static double neighbour_speed(const struct pend_problem *problem) {
    const struct pend_terms *terms = problem->loads.terms;
    const double *value = problem->loads.value;
    double least = INFINITY;
    for (int k = 0; terms && k < problem->tree->n; k++)
        if (pend_terms_get(terms, value, PEND_TERM_FRICTION, k) > 0)
            least = fmin(least, pend_terms_get(terms, value, PEND_TERM_FRICTION_SPEED, k));
    return isfinite(least) ? NEIGHBOUR_LINEAR * least : 0;
}

void pend_neighbour_init(struct pend_neighbour *neighbour, const struct pend_problem *problem,
                         int cap, double cart, void *memory) {
    size_t stride = pend_jets_stride(problem->tree->n);
    double *at = memory;
    assert(cap >= JETS_SPREAD && cap <= PEND_JETS_ORDER_MAX && cart >= 0);
    memset(at, 0, NEIGHBOUR_STATES * stride * sizeof *at);
    *neighbour = (struct pend_neighbour){
        .problem = problem, .order = JETS_SPREAD, .cart = cart, .speed = neighbour_speed(problem)};
    neighbour->state = (struct jets_state){
        .phi = at, .phi_low = at + stride, .rate = at + 2 * stride, .rate_low = at + 3 * stride};
    neighbour->sum = at + NEIGHBOUR_STATES * stride;
    neighbour->before = neighbour->sum + 2 * problem->tree->n * (cap + 1);
    pend_jets_init(&neighbour->jets, problem->tree, &problem->loads, cap,
                   (char *)memory + neighbour_rows(problem, cap));
}

/* stores x + d as a sum of two doubles */
static void neighbour_add(double x, double low, double d, double *sum, double *rest) {
    double s = x + d, part = s - x;
    *sum = s;
    *rest = (x - (s - part)) + (d - part) + low;
}

/* the size of an error, as the largest of angles and of rates times a time in s */
static double neighbour_size(const struct pend_neighbour *neighbour, const double phi[],
                             const double rate[], double time) {
    double most = 0;
    for (int k = 0; k < neighbour->problem->tree->n; k++)
        most = pend_larger(pend_larger(fabs(phi[k]), fabs(rate[k]) * time) *
                               pend_neighbour_share(neighbour->cart, k),
                           most);
    return most;
}

/* Computes the state displaced in the direction of the error. Returns the ratio of displacement to
 * error; 0 if there is no error. */
static double neighbour_displace(struct pend_neighbour *neighbour, const struct jets_state *from,
                                 double length, const double phi[], const double rate[]) {
    struct jets_state *near = &neighbour->state;
    double time = neighbour->speed > 0 ? fmax(length, NEIGHBOUR_NEAR / neighbour->speed) : length;
    double most = neighbour_size(neighbour, phi, rate, time),
           scale = most > DBL_MIN ? NEIGHBOUR_NEAR / most : 0;
    near->time = from->time;
    near->late = from->late;
    for (int k = 0; k < neighbour->problem->tree->n && scale > 0; k++) {
        neighbour_add(from->phi[k], from->phi_low[k], scale * phi[k], &near->phi[k],
                      &near->phi_low[k]);
        neighbour_add(from->rate[k], from->rate_low[k], scale * rate[k], &near->rate[k],
                      &near->rate_low[k]);
    }
    return scale;
}

/* Computes partial sums of the displacement's series: row j = 0 .. order has angles, then rates
 * times the step. `term` receives the sizes of the terms. */
static void neighbour_sums(const struct pend_neighbour *neighbour, const struct pend_series *step,
                           double x, double scale, const double phi[], const double rate[],
                           double term[]) {
    const struct pend_jets *near = &neighbour->jets, *own = step->jets;
    int n = neighbour->problem->tree->n, order = neighbour->order;
    memset(term, 0, (size_t)(order + 1) * sizeof(double));
    for (int k = 0; k < n; k++) {
        const double *to = near->rate + pend_jets_place(near, k, 0),
                     *from = own->rate + pend_jets_place(own, k, 0);
        double faster = rate[k] * (x * step->unit), turned = scale * (phi[k] + faster), power = x,
               share = pend_neighbour_share(neighbour->cart, k), *row = neighbour->sum + 2 * k;
        faster *= scale;
        row[0] = turned, row[1] = faster;
        for (int j = 1; j <= order; j++) {
            power *= x;
            double gap = power * (to[j * PEND_JETS_PAD] - from[j * PEND_JETS_PAD]);
            row += 2 * n;
            row[0] = turned += gap * near->share[j];
            row[1] = faster += gap;
            term[j] = pend_larger(fabs(gap) * share, term[j]);
        }
    }
}

/* Returns the limit of the partial sums, which are overwritten. Each sweep computes a column of
 * Wynn's table from the two previous columns; every second column contains limits. `differs`
 * becomes the largest difference between the last two. */
static const double *neighbour_limit(struct pend_neighbour *neighbour, double *differs) {
    int size = 2 * neighbour->problem->tree->n, last = neighbour->order / 2 * 2;
    double *sum = neighbour->sum, *before = neighbour->before;
    assert(last >= 2);
    memset(before, 0, (size_t)((last + 1) * size) * sizeof(double));
    for (int left = last; left > 0; left--) {
        for (int j = 0; j < left; j++) {
            double *row = sum + j * size, *old = before + j * size;
            double square = 0;
            for (int i = 0; i < size; i++)
                square += (row[size + i] - row[i]) * (row[size + i] - row[i]);
            // the inverse of the difference v of two rows, v / |v|^2, as a factor of v
            double inverse = square > DBL_MIN ? 1 / square : 0;
            for (int i = 0; i < size; i++) {
                double next = old[size + i] + (row[size + i] - row[i]) * inverse;
                old[i] = row[i];
                row[i] = next;
            }
        }
        memcpy(before + left * size, sum + left * size, (size_t)size * sizeof(double));
    }
    // the limit before the last is row 2 of `before`, where that column still is
    *differs = 0;
    for (int i = 0; i < size; i++) *differs = fmax(*differs, fabs(sum[i] - before[2 * size + i]));
    return sum;
}

/* Expands the neighbour to as many orders as needed. Returns its displacement from the motion x
 * units later: the angle of each arm and its rate times the step, like a row of partial sums. */
static const double *neighbour_later(struct pend_neighbour *neighbour,
                                     const struct pend_series *step, double x, double scale,
                                     double least, const double phi[], const double rate[]) {
    double term[PEND_JETS_ORDER_MAX + 1];
    double near = scale * neighbour_size(neighbour, phi, rate, fabs(x * step->unit));
    least = fmax(least, NEIGHBOUR_ROUNDED) * near;
    for (;;) {
        int order = neighbour->order, enough = order;
        double largest = 0, last, differs;
        pend_jets_expand(&neighbour->jets, &neighbour->problem->loads, step->unit,
                         &neighbour->state, order);
        neighbour_sums(neighbour, step, x, scale, phi, rate, term);
        for (int j = 1; j <= order; j++) largest = pend_larger(term[j], largest);
        last = term[order] + term[order - 1];
        while (enough > JETS_SPREAD && term[enough - 1] + term[enough - 2] < least) enough--;
        neighbour->order = enough;
        if (last < NEIGHBOUR_NEARLY * least) {
            // a slightly larger value matters only over many steps
            if (last >= least) neighbour->order = order < step->order ? order + 1 : order;
            return neighbour->sum + 2 * order * neighbour->problem->tree->n;
        }
        neighbour->order = order;
        if (last > NEIGHBOUR_FALLS * largest || order == step->order) {
            const double *limit = neighbour_limit(neighbour, &differs);
            if (differs <= NEIGHBOUR_LIMIT * near || order == step->order) return limit;
        }
        neighbour->order = order + 2 < step->order ? order + 2 : step->order;
    }
}

double pend_neighbour_spread(struct pend_neighbour *neighbour, const struct pend_series *step,
                             double x, double least, double phi[], double rate[]) {
    double length = x * step->unit, force = 0;
    assert(step->order <= neighbour->jets.order_cap && least >= 0);
    assert(neighbour->order >= JETS_SPREAD && neighbour->order <= neighbour->jets.order_cap);
    double scale = neighbour_displace(neighbour, step->begin, fabs(length), phi, rate);
    if (scale == 0) return 0;
    const double *later = neighbour_later(neighbour, step, x, scale, least, phi, rate);
    const struct pend_jets *near = &neighbour->jets, *own = step->jets;
    for (int k = 0; k < neighbour->problem->tree->n; k++) {
        double gap =
            near->force[pend_jets_place(near, k, 0)] - own->force[pend_jets_place(own, k, 0)];
        force = pend_larger(fabs(gap), force);
        phi[k] = later[2 * k] / scale;
        rate[k] = later[2 * k + 1] / (scale * length);
    }
    return force / (scale * step->unit * step->unit);
}
