#include "core/integrate/events/event_series.h"

#include <assert.h>
#include <complex.h>
#include <math.h>
#include <string.h>

#include "core/dynamics/dynamics.h"
#include "core/integrate/pieces/balance.h"
#include "core/taylor/jets/jets.h"

static double event_get(const struct event_step *step, enum pend_term_row row, int k) {
    const struct pend_loads *loads = step->loads;
    return loads->terms ? pend_terms_get(loads->terms, loads->value, row, k) : 0;
}

int pend_event_series_degree(int order) {
    enum { BEYOND = 6 }; // additional degree of the series of positions over those of angles
    return order + BEYOND < EVENT_TERMS ? order + BEYOND : EVENT_TERMS - 1;
}

struct event_step pend_event_series_step(const struct pend_series *series,
                                         const struct pend_tree *tree,
                                         const struct pend_loads *loads) {
    const struct pend_jets *jets = series->jets;
    return (struct event_step){.tree = tree,
                               .loads = loads,
                               .jets = jets,
                               .lanes = 1,
                               .rate = jets->rate,
                               .force = jets->force,
                               .share = jets->share,
                               .phi = series->begin->phi,
                               .phi_low = series->begin->phi_low,
                               .order = series->order,
                               .unit = series->unit,
                               .degree = pend_event_series_degree(series->order)};
}

static size_t event_place(const struct event_step *step, int k, int j) {
    if (step->jets) return pend_jets_place(step->jets, k, j);
    return ((size_t)j * (size_t)step->tree->n + (size_t)k) * (size_t)step->lanes;
}

/* copies a series of the motion with `terms` orders, as coefficients in powers of s; order 0
 * becomes the coefficient of s^`first` */
static void event_scale(const struct event_step *step, const double *from, int k, int terms,
                        int first, double factor, double out[]) {
    double x = step->length / step->unit, power = factor;
    memset(out, 0, EVENT_TERMS * sizeof *out);
    for (int j = 0; j < first; j++) power *= x;
    for (int j = 0; j < terms && j + first < EVENT_TERMS; j++, power *= x) {
        double share = first ? step->share[j] : 1;
        out[j + first] = from[event_place(step, k, j)] * share * power;
    }
}

void pend_event_series_phi(const struct event_step *step, int k, double out[EVENT_TERMS]) {
    assert(k >= 0 && k < step->tree->n);
    event_scale(step, step->rate, k, step->order + 1, 1, 1, out);
    out[0] = step->phi[k * step->lanes];
}

void pend_event_series_rate(const struct event_step *step, int k, double out[EVENT_TERMS]) {
    assert(k >= 0 && k < step->tree->n);
    event_scale(step, step->rate, k, step->order + 1, 0, 1 / step->unit, out);
}

/* ---- forces */

static size_t event_truth_numbers(const struct pend_tree *tree) {
    size_t numbers = (3 * EVENT_NODES + 1) * (size_t)tree->n * sizeof(double);
    return (numbers + 63) / 64 * 64;
}

size_t pend_event_truth_bytes(const struct pend_tree *tree, const struct pend_loads *loads) {
    return event_truth_numbers(tree) + (pend_dynamics_at_bytes(tree, loads) + 63) / 64 * 64;
}

void pend_event_truth_place(struct event_truth *truth, const struct pend_tree *tree, void *memory) {
    size_t rows = EVENT_NODES * (size_t)tree->n;
    double *at = memory;
    assert((size_t)memory % 64 == 0);
    *truth = (struct event_truth){at, at + rows, at + 2 * rows, at + 3 * rows, NULL};
    truth->work = (char *)memory + event_truth_numbers(tree);
}

/* the position of node i in the step; both ends are nodes, so that adjacent steps agree there */
static double event_node(int i) { return pend_roots_node(i, EVENT_NODES); }

/* the value of a series at s without its first term */
static double event_beyond(const double a[EVENT_TERMS], double s) {
    double sum = 0;
    for (int j = EVENT_TERMS - 1; j > 0; j--) sum = (sum + a[j]) * s;
    return sum;
}

void pend_event_series_truth(const struct event_step *step, const struct event_truth *truth) {
    int n = step->tree->n;
    for (int k = 0; k < n; k++) {
        double phi[EVENT_TERMS], rate[EVENT_TERMS], low = step->phi_low[k * step->lanes];
        pend_event_series_phi(step, k, phi);
        pend_event_series_rate(step, k, rate);
        for (int i = 0; i < EVENT_NODES; i++) {
            double s = event_node(i);
            truth->phi[i * n + k] = phi[0] + (low + event_beyond(phi, s));
            truth->rate[i * n + k] = rate[0] + event_beyond(rate, s);
        }
    }
    for (int i = 0; i < EVENT_NODES; i++)
        pend_dynamics_at(step->tree, step->loads, step->time + event_node(i) * step->length,
                         truth->phi + i * n, truth->rate + i * n, truth->work, truth->acc,
                         truth->force + i * n);
}

void pend_event_series_force(const struct event_step *step, int k, double out[EVENT_TERMS]) {
    assert(k >= 0 && k < step->tree->n);
    double inverse = 1 / step->unit;
    event_scale(step, step->force, k, step->order, 0, inverse * inverse, out);
    if (!step->truth) return;
    // the error of the series, interpolated from the nodes
    double gap[EVENT_NODES], sum[EVENT_NODES];
    for (int i = 0; i < EVENT_NODES; i++)
        gap[i] =
            step->truth->force[i * step->tree->n + k] - (out[0] + event_beyond(out, event_node(i)));
    pend_roots_through(EVENT_NODES, gap, sum);
    for (int j = 0; j < EVENT_NODES; j++) out[j] += sum[j];
}

/* ---- positions */

/* adds p e^{i phi} of arm k, computed by u' = i phi' u */
static void event_turn(const struct event_step *step, int k, double complex p,
                       double complex out[EVENT_TERMS]) {
    double phi[EVENT_TERMS];
    double complex u[EVENT_TERMS];
    pend_event_series_phi(step, k, phi);
    u[0] = p * cexp(I * phi[0]) * (1 + I * step->phi_low[k * step->lanes]);
    for (int j = 1; j <= step->degree; j++) {
        u[j] = 0;
        for (int i = 1; i <= j; i++) u[j] += i * phi[i] * u[j - i];
        u[j] *= I / (double)j; // in doubles, because the constant I is a float
    }
    for (int j = 0; j <= step->degree; j++) out[j] += u[j];
}

static void event_pivot(const struct event_step *step, double complex out[EVENT_TERMS]) {
    const struct pend_terms *terms = step->loads->terms;
    const double *value = step->loads->value;
    if (!terms) return;
    int at = terms->one[PEND_TERM_PIVOT_ACCELERATION_X];
    if (at >= 0) {
        double complex a = value[at] + I * value[terms->one[PEND_TERM_PIVOT_ACCELERATION_Y]];
        out[0] += a * step->time * step->time / 2;
        out[1] += a * step->time * step->length;
        out[2] += a * step->length * step->length / 2;
    }
    int track = terms->one[PEND_TERM_PIVOT_TRACK];
    double late = track < 0 ? 0 : step->time - value[terms->one[PEND_TERM_PIECE]], share = 1;
    for (int order = 0; order < 4 && track >= 0; share *= step->length / ++order) {
        double complex sum = 0;
        for (int j = 3; j >= order; j--)
            sum =
                value[track + 2 * j] + I * value[track + 2 * j + 1] + sum * late / (j + 1 - order);
        out[order] += sum * share;
    }
    for (int i = 0; i < terms->harmonics && terms->harmonic[i].drives < 0; i++) {
        const double *h = value + terms->harmonic[i].at;
        double complex way = terms->harmonic[i].drives == PEND_DRIVE_PIVOT_X ? 1 : I;
        double angle = h[1] * step->time + h[2], size = h[0], x = cos(angle), y = sin(angle);
        const double turned[] = {x, -y, -x, y}; // rotations by quarter turns
        for (int j = 0; j <= step->degree; j++) {
            out[j] += way * size * turned[j % 4];
            size *= h[1] * step->length / (j + 1);
        }
    }
}

/* adds the vector from the joint of arm k to a point of it; for a cart, the vector on the rail */
static void event_point(const struct event_step *step, int k, double complex p,
                        double complex out[EVENT_TERMS]) {
    if (k || !pend_terms_cart(step->loads->terms)) {
        event_turn(step, k, p, out);
        return;
    }
    double phi[EVENT_TERMS];
    double rail = step->loads->value[step->loads->terms->one[PEND_TERM_RAIL]];
    pend_event_series_phi(step, k, phi);
    for (int j = 0; j <= step->degree; j++) out[j] += cexp(I * rail) * phi[j];
}

static void event_tip(const struct event_step *step, int k, double complex out[EVENT_TERMS]) {
    memset(out, 0, EVENT_TERMS * sizeof *out);
    event_pivot(step, out);
    event_point(step, k, step->tree->len[k], out);
    for (int c = k; step->tree->parent[c] >= 0; c = step->tree->parent[c])
        event_point(step, step->tree->parent[c], pend_balance_hangs(step->tree, step->loads, c),
                    out);
}

void pend_event_series_tip(const struct event_step *step, int k, double x[EVENT_TERMS],
                           double y[EVENT_TERMS]) {
    double complex tip[EVENT_TERMS];
    assert(k >= 0 && k < step->tree->n);
    event_tip(step, k, tip);
    for (int j = 0; j < EVENT_TERMS; j++) {
        x[j] = creal(tip[j]);
        y[j] = cimag(tip[j]);
    }
}

/* adds factor times Re(conj(a) b), coefficients up to the degree */
static void event_product(const struct event_step *step, double factor, const double complex a[],
                          const double complex b[], double out[EVENT_TERMS]) {
    for (int j = 0; j <= step->degree; j++) {
        double sum = 0;
        for (int i = 0; i <= j; i++)
            sum += creal(a[i]) * creal(b[j - i]) + cimag(a[i]) * cimag(b[j - i]);
        out[j] += factor * sum;
    }
}

void pend_event_series_square(const struct event_step *step, int k, int other,
                              double out[EVENT_TERMS]) {
    double complex one[EVENT_TERMS], two[EVENT_TERMS];
    assert(other >= 0 && other < step->tree->n);
    event_tip(step, k, one);
    event_tip(step, other, two);
    for (int j = 0; j < EVENT_TERMS; j++) one[j] -= two[j];
    memset(out, 0, EVENT_TERMS * sizeof *out);
    event_product(step, 1, one, one, out);
}

/* ---- energies */

size_t pend_event_series_room(int n) { return 2 * (size_t)n * EVENT_TERMS; }

/* derivative with respect to time of a series in s, the fraction of the step */
static void event_slope(const struct event_step *step, const double complex from[],
                        double complex out[EVENT_TERMS]) {
    for (int j = 0; j + 1 < EVENT_TERMS; j++) out[j] = (j + 1) * from[j + 1] / step->length;
    out[EVENT_TERMS - 1] = 0;
}

static void event_spring(const struct event_step *step, int k, double potential[EVENT_TERMS]) {
    double stiffness = event_get(step, PEND_TERM_STIFFNESS, k), own[EVENT_TERMS], base[EVENT_TERMS];
    double complex bent[EVENT_TERMS];
    const struct pend_terms *terms = step->loads->terms;
    int p = pend_terms_holder(terms, step->tree->parent, k);
    if (stiffness == 0) return;
    pend_event_series_phi(step, k, own);
    memset(base, 0, sizeof base);
    base[0] = !k && pend_terms_cart(terms) ? 0 : -M_PI_2;
    if (p >= 0) pend_event_series_phi(step, p, base);
    for (int j = 0; j < EVENT_TERMS; j++) bent[j] = own[j] - base[j];
    bent[0] -= event_get(step, PEND_TERM_REST, k);
    event_product(step, stiffness / 2, bent, bent, potential);
}

/* adds the energies of a cart, and the position of the pivot to that of the cart */
static void event_cart(const struct event_step *step, const double complex pivot[],
                       double kinetic[EVENT_TERMS], double potential[EVENT_TERMS]) {
    double mass = step->tree->mass[0];
    double complex place[EVENT_TERMS], v[EVENT_TERMS];
    memcpy(place, pivot, sizeof place);
    event_point(step, 0, 1, place);
    event_slope(step, place, v);
    event_product(step, mass / 2, v, v, kinetic);
    for (int j = 0; j <= step->degree; j++)
        potential[j] += step->loads->gravity * mass * cimag(place[j]);
    event_spring(step, 0, potential);
}

/* adds the energies of arm k, whose joint is at `joint` */
static void event_arm(const struct event_step *step, int k, const double complex joint[],
                      double kinetic[EVENT_TERMS], double potential[EVENT_TERMS]) {
    double inertia, rate[EVENT_TERMS];
    double complex moment;
    double mass = pend_balance_masses(step->tree, step->loads, k, &moment, &inertia);
    double complex center[EVENT_TERMS] = {0}, v[EVENT_TERMS], w[EVENT_TERMS], spin[EVENT_TERMS];
    event_turn(step, k, moment, center);
    event_slope(step, joint, v);
    event_slope(step, center, w);
    pend_event_series_rate(step, k, rate);
    for (int j = 0; j < EVENT_TERMS; j++) spin[j] = rate[j];
    event_product(step, mass / 2, v, v, kinetic);
    event_product(step, 1, v, w, kinetic);
    event_product(step, inertia / 2, spin, spin, kinetic);
    for (int j = 0; j <= step->degree; j++)
        potential[j] += step->loads->gravity * cimag(mass * joint[j] + center[j]);
    event_spring(step, k, potential);
}

void pend_event_series_energy(const struct event_step *step, double kinetic[EVENT_TERMS],
                              double potential[EVENT_TERMS]) {
    double complex *joint = (double complex *)(void *)step->room;
    assert(joint);
    memset(kinetic, 0, EVENT_TERMS * sizeof *kinetic);
    memset(potential, 0, EVENT_TERMS * sizeof *potential);
    for (int k = 0; k < step->tree->n; k++) {
        double complex *own = joint + (size_t)k * EVENT_TERMS;
        int p = step->tree->parent[k];
        if (p < 0) {
            memset(own, 0, EVENT_TERMS * sizeof *own);
            event_pivot(step, own);
        } else {
            memcpy(own, joint + (size_t)p * EVENT_TERMS, EVENT_TERMS * sizeof *own);
            event_point(step, p, pend_balance_hangs(step->tree, step->loads, k), own);
        }
        if (!k && pend_terms_cart(step->loads->terms))
            event_cart(step, own, kinetic, potential);
        else
            event_arm(step, k, own, kinetic, potential);
    }
    // the last coefficient of a derivative is unknown
    kinetic[step->degree] = 0;
}
