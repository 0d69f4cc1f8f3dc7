#include "core/derivatives/radau.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "core/base/isa.h"
#include "core/bodies/bodies.h"
#include "core/derivatives/complex_factor.h"

enum {
    LANES = DERIVATIVES_LANES,
    FIRST = DERIVATIVES_FIRST,
    PASS = DERIVATIVES_PASS,
    STAGES = RADAU_STAGES,
    ITERATIONS = 17 /* maximum number of iterations of Newton's method */
};

const struct derivatives_kernel *pend_kernel_derivatives(void) {
    return PEND_ISA_PICK(pend_kernel_derivatives, pend_isa_best());
}

/* ---- the motion */

/* Computes the accelerations at an instant, s, relative to the start; at a stage of a step (stage
 * >= 0) also the power. */
static void radau_pull(struct radau *r, double time, const struct radau_state *state, double acc[],
                       int stage) {
    double sum = r->start + time, part = sum - r->start;
    struct bodies_state at = {.phi = state->phi,
                              .phi_low = state->low,
                              .rate = state->rate,
                              .time = sum,
                              .late = (r->start - (sum - part)) + (time - part)};
    r->counts.evaluations++;
    if (stage < 0 || !r->gives)
        pend_bodies_at(r->tree, &r->loads, &at, r->work, acc, NULL);
    else
        pend_bodies_power_at(r->tree, &r->loads, &at, r->work, acc, &r->kept->power_in[stage],
                             &r->kept->power_out[stage]);
}

void pend_radau_begin(struct radau *r) {
    int n = r->n;
    const struct derivatives_view view = {
        .phi = r->view_phi, .rate = r->view_rate, .acc = r->view_acc};
    radau_pull(r, r->kept->time, &r->begin, r->first, -1);
    memset(r->view_phi, 0, (size_t)n * LANES * sizeof(double));
    memset(r->view_rate, 0, (size_t)n * LANES * sizeof(double));
    for (int k = 0; k < n; k++) {
        r->view_phi[k * LANES] = r->begin.phi[k];
        r->view_rate[k * LANES] = r->begin.rate[k];
    }
    // computes eight derivatives at a time
    for (int from = 0; from < 2 * n; from += PASS) {
        for (int set = 1; set >= 0; set--) {
            for (int i = 0, d = from; i < PASS && d < 2 * n; i++, d++)
                (d < n ? r->view_phi + d * LANES : r->view_rate + (d - n) * LANES)[FIRST + i] = set;
            if (set) r->kernel->observe(&r->pass, r->start + r->kept->time, 1, &view);
        }
        for (int i = 0, d = from; i < PASS && d < 2 * n; i++, d++)
            for (int k = 0; k < n; k++)
                (d < n ? r->by_phi + d : r->by_rate + d - n)[k * n] =
                    r->view_acc[k * LANES + FIRST + i];
        r->counts.evaluations += PASS / 2;
    }
}

/* factors the matrices of a step of length h; returns 0 if a matrix is singular */
static int radau_matrices(struct radau *r, double h) {
    size_t n = (size_t)r->n, square = n * n;
    for (size_t p = 0; p < RADAU_POLES; p++) {
        double *re = r->matrix[0] + p * square, *im = r->matrix[1] + p * square;
        double a = radau_pole[0][p] / h, b = radau_pole[1][p] / h, norm = a * a + b * b;
        for (size_t i = 0; i < square; i++) {
            re[i] = -r->by_rate[i] - r->by_phi[i] * (a / norm);
            im[i] = r->by_phi[i] * (b / norm);
        }
        for (size_t i = 0; i < square; i += n + 1) re[i] += a, im[i] += b;
        if (!complex_factor(r->n, re, im, r->swap + p * n)) return 0;
    }
    return 1;
}

/* ---- stages */

void pend_radau_weights(double x, int zero, double weight[STAGES]) {
    for (int i = 0; i < STAGES; i++) {
        double c = radau_node[i];
        weight[i] = zero ? x / c : 1;
        for (int j = 0; j < STAGES; j++)
            if (j != i) weight[i] *= (x - radau_node[j]) / (c - radau_node[j]);
    }
}

double pend_radau_sum(const struct radau *r, const double weight[STAGES], const double rows[],
                      int k) {
    double sum = 0;
    for (int i = 0; i < STAGES; i++) sum += weight[i] * rows[i * r->n + k];
    return sum;
}

/* Sets Z for a step of length h to a first guess: the polynomial of the last step, extrapolated, or
 * 0 if the step reaches too far. */
static void radau_guess(struct radau *r, double h) {
    static const double longer = 2;
    const double *last = r->gain + (STAGES - 1) * r->n;
    double weight[STAGES];
    memset(r->try_gain, 0, (size_t)(STAGES * r->n) * sizeof(double));
    if (r->rough || fabs(h) > longer * fabs(r->kept->last)) return;
    for (int i = 0; i < STAGES; i++) {
        pend_radau_weights(1 + radau_node[i] * h / r->kept->last, 1, weight);
        for (int k = 0; k < r->n; k++)
            r->try_gain[i * r->n + k] = pend_radau_sum(r, weight, r->gain, k) - last[k];
    }
}

/* computes Q of a step of length h from Z */
static void radau_bend(const struct radau *r, double h) {
    for (int i = 0; i < STAGES; i++)
        for (int k = 0; k < r->n; k++)
            r->try_bent[i * r->n + k] = h * (radau_node[i] * r->begin.rate[k] +
                                             pend_radau_sum(r, radau_through[i], r->try_gain, k));
}

void pend_radau_differ(const struct radau *r, const double bent[], const double gain[],
                       const struct radau_state *state) {
    for (int k = 0; k < r->n; k++) {
        radau_add(r->begin.phi[k], r->begin.low[k], bent[k], &state->phi[k], &state->low[k]);
        state->rate[k] = r->begin.rate[k] + gain[k];
    }
}

/* Computes R of a step h into `pull`, and the power at the stages. Returns 0 if not finite. */
static int radau_rest(struct radau *r, double h) {
    double bad = 0, column[STAGES];
    int n = r->n;
    for (int i = 0; i < STAGES; i++) {
        pend_radau_differ(r, r->try_bent + i * n, r->try_gain + i * n, &r->stage);
        radau_pull(r, r->kept->time + radau_node[i] * h, &r->stage, r->pull + i * n, i);
    }
    for (int k = 0; k < n; k++) {
        for (int i = 0; i < STAGES; i++) {
            column[i] =
                h * pend_radau_sum(r, radau_through[i], r->pull, k) - r->try_gain[i * n + k];
            bad += 0 * column[i];
        }
        for (int i = 0; i < STAGES; i++) r->pull[i * n + k] = column[i];
    }
    return bad == 0;
}

static void radau_correct(struct radau *r, double h) {
    int n = r->n;
    memset(r->change, 0, (size_t)(STAGES * n) * sizeof(double));
    for (int p = 0; p < RADAU_POLES; p++) {
        double a = radau_pole[0][p] / h, b = radau_pole[1][p] / h, twice = p ? 2 : 1;
        for (int k = 0; k < n; k++) {
            double x = pend_radau_sum(r, radau_to[0][p], r->pull, k),
                   y = pend_radau_sum(r, radau_to[1][p], r->pull, k);
            r->sum[0][k] = a * x - b * y, r->sum[1][k] = a * y + b * x;
        }
        complex_solve(n, r->matrix[0] + p * n * n, r->matrix[1] + p * n * n, r->swap + p * n,
                      r->sum[0], r->sum[1]);
        for (int i = 0; i < STAGES * n; i++)
            r->change[i] += twice * (radau_from[0][p][i / n] * r->sum[0][i % n] -
                                     radau_from[1][p][i / n] * r->sum[1][i % n]);
    }
    for (int i = 0; i < STAGES * n; i++) r->try_gain[i] += r->change[i];
}

/* ---- errors */

/* computes the unit of errors: the largest angles and rates in the tried step */
static void radau_level(const struct radau *r) {
    for (int k = 0; k < r->n; k++) {
        double phi = r->begin.phi[k], rate = r->begin.rate[k], far = fabs(phi), fast = fabs(rate);
        for (int i = k; i < STAGES * r->n; i += r->n) {
            far = fmax(far, fabs(phi + r->try_bent[i]));
            fast = fmax(fast, fabs(rate + r->try_gain[i]));
        }
        r->level_phi[k] = r->atol + r->rtol * far;
        r->level_rate[k] = r->atol + r->rtol * fast;
    }
}

/* the largest entry of dQ and dZ, relative to the allowed error */
static double radau_norm(const struct radau *r, double h) {
    double most = 0;
    for (int i = 0; i < STAGES * r->n; i++)
        most = fmax(most, fabs(r->change[i]) *
                              fmax(1 / r->level_rate[i % r->n], fabs(h) / r->level_phi[i % r->n]));
    return most;
}

/* runs Newton's method for the stages of a step of length h; returns the number of iterations, or 0
 * if it does not converge */
static int radau_iterate(struct radau *r, double h) {
    // the true error can exceed the estimate from the last two corrections by the factor `more`,
    // calibrated on tumbling pendulums
    static const double least = 0.01, rounding = 20 * DBL_EPSILON, more = 4;
    double before = INFINITY, enough = fmax(least, rounding / r->rtol);
    for (int i = 1; i <= ITERATIONS; i++) {
        radau_bend(r, h);
        if (!radau_rest(r, h)) return 0;
        radau_correct(r, h);
        radau_level(r);
        double norm = radau_norm(r, h), ratio = norm / before;
        if (!(ratio < 1)) return 0;
        double part = i > 1 ? ratio / (1 - ratio) : 1; // ratio of the remaining error to dZ
        if (norm * part <= enough) {
            for (int k = 0; k < r->n; k++) {
                double change = more * part * fabs(r->change[(STAGES - 1) * r->n + k]);
                r->off_phi[k] = fabs(h) * change, r->off_rate[k] = change;
            }
            radau_bend(r, h);
            return i;
        }
        // estimate of the error after all remaining iterations
        if (i > 1 && norm * part * pow(ratio, ITERATIONS - i) > enough) return 0;
        before = norm;
    }
    return 0;
}

/* The error of a step relative to the allowed error: the error of the embedded formula, filtered by
 * the real system, with rates and accelerations at the start or near it. Stores the components of
 * the error in `change`. */
static double radau_error_at(struct radau *r, double h, const double rate[], const double acc[]) {
    int n = r->n;
    double m = radau_pole[0][0] / h, most = 0, *turned = r->change, *faster = r->change + n;
    double *x = r->sum[0], *y = r->sum[1];
    for (int k = 0; k < n; k++) {
        turned[k] = rate[k] / m + pend_radau_sum(r, radau_error, r->try_bent, k);
        faster[k] = acc[k] / m + pend_radau_sum(r, radau_error, r->try_gain, k);
    }
    for (int k = 0; k < n; k++) {
        x[k] = m * faster[k], y[k] = 0;
        for (int j = 0; j < n; j++) x[k] += r->by_phi[k * n + j] * turned[j];
    }
    complex_solve(n, r->matrix[0], r->matrix[1], r->swap, x, y);
    for (int k = 0; k < n; k++) {
        turned[k] += x[k] / m, faster[k] = x[k];
        double ratio = fmax(fabs(turned[k]) / r->level_phi[k], fabs(x[k]) / r->level_rate[k]);
        if (!(ratio <= most)) most = ratio;
    }
    return most;
}

/* As radau_error_at, but if the error is too large and the previous step was not similar, repeats
 * the estimate from a state shifted by the error, because for stiff motions the first estimate may
 * be far too large. */
static double radau_judge(struct radau *r, double h) {
    double ratio = radau_error_at(r, h, r->begin.rate, r->first);
    if (!(ratio >= 1) || !r->rough) return ratio;
    pend_radau_differ(r, r->change, r->change + r->n, &r->stage);
    radau_pull(r, r->kept->time, &r->stage, r->pull, -1);
    return radau_error_at(r, h, r->stage.rate, r->pull);
}

double pend_radau_try(struct radau *r, double h, double *longer) {
    static const double safe = 0.9, least = 0.2, most = 8, unsolved = 0.5;
    *longer = unsolved;
    radau_guess(r, h);
    int iterations = radau_matrices(r, h) ? radau_iterate(r, h) : 0;
    double ratio = iterations ? radau_judge(r, h) : INFINITY;
    if (!(ratio < INFINITY)) return INFINITY;
    // the embedded formula has order 7, the end of the step order 13: the end has at least 1.5
    // times the digits
    double share = sqrt(ratio * r->rtol);
    for (int k = 0; k < r->n; k++) {
        r->off_phi[k] += share * fabs(r->change[k]);
        r->off_rate[k] += share * fabs(r->change[r->n + k]);
    }
    double part = safe * (2 * ITERATIONS + 1) / (2 * ITERATIONS + iterations);
    *longer = fmin(fmax(part * pow(ratio, -1.0 / (STAGES + 1)), least), most);
    return ratio;
}

/* ---- neighbours */

/* Solves the step again from a neighbouring state, displaced by the estimated error or by 1e-10 of
 * the motion, with the matrices and stages of the step. An accuracy of a few percent suffices. */
void pend_radau_spread(struct radau *r, double phi[], double rate[]) {
    static const double enough = 1e-2, least = 1e-10;
    enum { MOST = 4 };
    const struct radau_state begin = r->begin, *end = &r->end, *near = &r->stage;
    int n = r->n, last = (STAGES - 1) * n;
    double h = r->kept->last, far = 0;
    for (int k = 0; k < n; k++)
        far = fmax(far, fmax(fabs(phi[k]) / r->level_phi[k], fabs(rate[k]) / r->level_rate[k]));
    double scale = far > 0 && far < INFINITY ? fmax(1, least / r->rtol) / far : 0;
    memcpy(r->try_gain, r->gain, (size_t)(STAGES * n) * sizeof(double));
    for (int k = 0; k < n; k++) {
        radau_add(begin.phi[k], begin.low[k], scale * phi[k], &r->near.phi[k], &r->near.low[k]);
        r->near.rate[k] = begin.rate[k] + scale * rate[k];
    }
    r->begin = r->near;
    for (int i = 0; i < MOST && scale > 0; i++) {
        radau_bend(r, h);
        if (!radau_rest(r, h)) break;
        radau_correct(r, h);
        if (radau_norm(r, h) <= enough * scale * far) break;
    }
    radau_bend(r, h);
    pend_radau_differ(r, r->try_bent + last, r->try_gain + last, near);
    r->begin = begin;
    for (int k = 0; k < n; k++) {
        if (scale > 0) {
            phi[k] = ((near->phi[k] - end->phi[k]) + (near->low[k] - end->low[k])) / scale;
            rate[k] = (near->rate[k] - end->rate[k]) / scale;
        }
        phi[k] += copysign(r->off_phi[k], phi[k]);
        rate[k] += copysign(r->off_rate[k], rate[k]);
    }
}
