/* linear: the motion linearized about the hanging position, theta'' = -A theta, in closed form: at
 * any instant a sum of modes.
 * Leaves to others: finding the modes (modes), the forces of that motion (kinematics).
 * Invariant: mode k of `modes` is scaled by its amplitude, theta(t) = sum_k vector_k cos(omega_k t
 * + phase_k). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/integrate/methods/method.h"
#include "core/modes/modes.h"

struct linear {
    struct pend_modes *modes;
    struct pend_stepper_counts counts;
    int n;
    double *phase;      /* rad, one phase per mode */
    double *rest;       /* rad, the hanging position nearest to the start: phi = rest + theta */
    double *swing;      /* rad, the start's angle from the hanging position */
    double *phi, *rate; /* the initial state */
};

static void linear_close(void **stepper) {
    struct linear *linear = *stepper;
    if (linear) pend_modes_free(&linear->modes);
    free(linear);
    *stepper = NULL;
}

/* computes the modes, the initial phases, and the amplitudes, which scale the vectors; scratch has
 * n values */
static enum pend_status linear_start(struct linear *linear, const struct pend_problem *problem,
                                     double scratch[], struct pend_error *error) {
    const struct pend_tree *tree = problem->tree;
    size_t n = (size_t)tree->n;
    double *theta = linear->swing, *amplitude = scratch;
    memcpy(linear->phi, problem->phi, n * sizeof(double));
    memcpy(linear->rate, problem->rate, n * sizeof(double));
    PEND_TRY(pend_modes_new(&linear->modes, tree, &problem->loads, 1, error));
    for (size_t k = 0; k < n; k++) {
        theta[k] = pend_modes_theta(linear->phi[k], problem->phi_low ? problem->phi_low[k] : 0);
        linear->rest[k] = linear->phi[k] - theta[k];
    }
    if (pend_modes_decompose(linear->modes, tree, NULL, theta, linear->rate, amplitude,
                             linear->phase) != PEND_OK)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for the modes of %d arms",
                         tree->n);
    for (size_t i = 0; i < n * n; i++) linear->modes->vector[i] *= amplitude[i / n];
    return PEND_OK;
}

static enum pend_status linear_open(void **stepper, const struct pend_problem *problem,
                                    struct pend_error *error) {
    size_t n = (size_t)problem->tree->n;
    struct linear *linear = malloc(sizeof *linear + 6 * n * sizeof(double));
    *stepper = linear;
    if (!linear)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for the modes of %d arms",
                         (int)n);
    double *data = (double *)(linear + 1);
    *linear = (struct linear){.n = (int)n,
                              .phase = data,
                              .phi = data + n,
                              .rate = data + 2 * n,
                              .rest = data + 3 * n,
                              .swing = data + 4 * n};
    enum pend_status status = linear_start(linear, problem, data + 5 * n, error);
    if (status != PEND_OK) linear_close(stepper);
    return status;
}

/* the whole time span is one step */
static enum pend_status linear_step(void *stepper, double limit, double *reached,
                                    struct pend_error *error) {
    struct linear *linear = stepper;
    (void)error;
    linear->counts.steps++;
    *reached = limit;
    return PEND_OK;
}

/* rad, whole turns from theta = 0 to the hanging position nearest to the start */
static double linear_turns(const struct linear *linear, int k) {
    return rint(linear->rest[k] / (2 * M_PI) + 0.25) * (2 * M_PI);
}

/* the state at one instant: the sum of the modes; acc and theta may be NULL */
static void linear_sum(const struct linear *linear, double t, double phi[], double rate[],
                       double acc[], double theta[]) {
    int n = linear->n;
    const struct pend_modes *modes = linear->modes;
    for (int k = 0; k < n; k++) phi[k] = rate[k] = 0;
    if (acc) memset(acc, 0, (size_t)n * sizeof(double));
    for (int mode = 0; mode < n; mode++) {
        const double *vector = modes->vector + (size_t)mode * (size_t)n;
        double omega = modes->omega[mode], angle = omega * t + linear->phase[mode];
        double even = cos(angle), odd = -omega * sin(angle), bend = -omega * omega * even;
        for (int k = 0; k < n; k++) phi[k] += even * vector[k];
        for (int k = 0; k < n; k++) rate[k] += odd * vector[k];
        for (int k = 0; acc && k < n; k++) acc[k] += bend * vector[k];
    }
    for (int k = 0; k < n && theta; k++) theta[k] = phi[k] + linear_turns(linear, k);
    for (int k = 0; k < n; k++) phi[k] += linear->rest[k];
}

static void linear_at(void *stepper, const double t[], int count,
                      const struct pend_points *points) {
    const struct linear *linear = stepper;
    size_t n = (size_t)linear->n;
    for (int i = 0; i < count; i++) {
        double *phi = points->phi + (size_t)i * n, *rate = points->rate + (size_t)i * n;
        double *theta = points->theta ? points->theta + (size_t)i * n : NULL;
        linear_sum(linear, t[i], phi, rate, points->acc ? points->acc + (size_t)i * n : NULL,
                   theta);
        if (t[i] != 0) continue;
        for (size_t k = 0; k < n && theta; k++)
            theta[k] = linear->swing[k] + linear_turns(linear, (int)k);
        /* the initial state itself, without rounding errors */
        memcpy(phi, linear->phi, n * sizeof(double));
        memcpy(rate, linear->rate, n * sizeof(double));
    }
}

static struct pend_stepper_counts linear_counts(const void *stepper) {
    return ((const struct linear *)stepper)->counts;
}

/* nothing to save: the modes are computed again, with the same result */
static void linear_carry(void *stepper, struct pend_checkpoint *checkpoint) {
    struct linear *linear = stepper;
    pend_stepper_counts_carry(&linear->counts, checkpoint);
}

const struct pend_method pend_method_linear = {
    .name = "linear",
    .summary = "The motion linearised about hanging, as an exact sum of modes; valid for small "
               "swings; needs gravity > 0.",
    .flags = PEND_METHOD_LINEAR | PEND_METHOD_THETA,
    .open = linear_open,
    .step = linear_step,
    .at = linear_at,
    .counts = linear_counts,
    .carry = linear_carry,
    .close = linear_close,
};
