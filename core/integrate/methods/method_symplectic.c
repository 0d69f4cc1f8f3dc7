/* symplectic: Gauss-Legendre collocation of order 16 with a fixed step, for very long runs.
 * Leaves to others: the stages (kernel_symplectic), the series for instants inside a step
 * (jets), the time loop (run).
 * Invariant: step i ends at exactly i times the step, for any requested instants. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics/kinematics_at.h"
#include "core/integrate/methods/gauss_table.h"
#include "core/integrate/methods/kernel_symplectic.h"
#include "core/integrate/methods/method.h"
#include "core/taylor/jets/jets.h"
#include "core/tree/turns.h"

enum { SYMPLECTIC_ORDER = 22 };

/* the state at one end of a step, and the power series about it if it was needed */
struct symplectic_end {
    struct symplectic_state state;
    double *rate, *zero;
    struct pend_jets jets;
    int known;
};

struct symplectic {
    const struct pend_tree *tree;
    const struct symplectic_kernel *kernel;
    struct symplectic_system system;
    double length, unit; /* s, signed: length of the step, and unit of the series */
    double time;         /* s, start of the last step */
    struct symplectic_end end[2];
    struct symplectic_state spare; /* state between the parts of a divided step */
    int own;                       /* whether the method itself chooses the step */
    int now; /* which of the two ends is the end of the last step; the other is its start */
    struct pend_stepper_counts counts;
};

/* ---- the length of the step */

/* Upper bound on the arms' rates, 1/s, from the energy of the start above that of hanging at rest.
 * The initial rates alone would miss a start at an unstable equilibrium. scratch: 4 n values. */
static double symplectic_speed(const struct pend_problem *problem, double scratch[]) {
    const struct pend_tree *tree = problem->tree;
    const struct pend_loads *loads = &problem->loads;
    struct pend_energy energy = pend_kinematics_energy_at(
        tree, loads, pend_times_at(&problem->times, 0), problem->phi, problem->rate, scratch);
    double free =
               energy.kinetic + energy.potential + pend_kinematics_energy_scale_at(tree, loads, 0),
           inertia = 0;
    for (int k = 0; k < tree->n; k++)
        inertia += loads->terms ? pend_terms_inertia(loads->terms, tree->len[k], tree->mass[k],
                                                     loads->value, k)
                                : tree->subtree_mass[k] * tree->len[k] * tree->len[k];
    return free > 0 && inertia > 0 ? sqrt(2 * free * tree->n / inertia) : 0;
}

/* The shortest of the first steps of method taylor with rtol 1e-12: about a quarter of the distance
 * to the nearest singularity of the motion in complex time, which limits the step of every method.
 * `state` is scratch of 4 n values. */
static enum pend_status symplectic_scout(const struct pend_problem *problem, double span,
                                         double state[], double *shortest,
                                         struct pend_error *error) {
    int steps = 20000 / problem->tree->n;
    struct pend_problem scout = *problem;
    void *stepper;
    double reached = 0, last = 0;
    double *phi = state, *rate = state + problem->tree->n, largest = 0;
    const struct pend_points points = {.phi = phi, .rate = rate};
    scout.rtol = 1e-12;
    scout.atol = 0;
    PEND_TRY(pend_method_taylor.open(&stepper, &scout, error));
    // if the motion cannot be computed, the first step will report it
    enum pend_status status = PEND_OK;
    *shortest = INFINITY;
    steps = steps < 16 ? 16 : steps > 512 ? 512 : steps;
    for (int i = 0; i < steps && status == PEND_OK && fabs(reached) < fabs(span); i++) {
        // the limit is beyond the last instant, so that no step is cut short
        status = pend_method_taylor.step(stepper, 4 * span, &reached, NULL);
        if (status != PEND_OK) break;
        *shortest = fmin(*shortest, fabs(reached - last));
        pend_method_taylor.at(stepper, &reached, 1, &points);
        for (int k = 0; k < problem->tree->n; k++) largest = fmax(largest, fabs(rate[k]));
        last = reached;
    }
    pend_method_taylor.close(&stepper);
    double speed = symplectic_speed(problem, state);
    if (largest < 1e-3 * speed) *shortest = fmin(*shortest, 0.1 / speed);
    return PEND_OK;
}

/* rounds a step down to 24 bits, so that half a billion multiples of it are exact */
static double symplectic_round(double step) {
    int exponent;
    double part = frexp(step, &exponent);
    return ldexp(floor(ldexp(part, 24)), exponent - 24);
}

static void symplectic_take(struct symplectic *s, double length) {
    s->length = length;
    s->system.length = fabs(length);
    s->unit = copysign(exp2(floor(log2(fabs(length)))), length);
    for (int j = 0; j < GAUSS_STAGES; j++) s->system.weight[j] = s->length * gauss_weight[j];
}

static enum pend_status symplectic_choose(struct symplectic *s, const struct pend_problem *problem,
                                          struct pend_error *error) {
    const struct pend_times *times = &problem->times;
    double span = pend_times_at(times, times->count - 1) - pend_times_at(times, 0),
           length = problem->step;
    if (length == 0 && span != 0) {
        double *state = malloc(4 * (size_t)problem->tree->n * sizeof *state);
        if (!state)
            return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a state of %d arms",
                             problem->tree->n);
        enum pend_status status = symplectic_scout(problem, span, state, &length, error);
        free(state);
        PEND_TRY(status);
        // without motion, the length of a step is unlimited
        length = fmin(symplectic_round(length), pend_method_symplectic.step_max);
    }
    symplectic_take(s, copysign(length, span));
    return PEND_OK;
}

/* ---- creation and release */

/* lays out the arrays in a zeroed block; if base is NULL, only counts its bytes */
static size_t symplectic_place(struct symplectic *s, char *base) {
    int n = s->tree->n;
    size_t used = (sizeof *s + 63) / 64 * 64, row = pend_jets_stride(n),
           series = pend_jets_bytes(s->tree, s->system.loads.terms, SYMPLECTIC_ORDER);
    for (int i = 0; i < 2; i++) {
        struct symplectic_end *end = &s->end[i];
        double **part[] = {&end->state.phi,   &end->state.phi_low, &end->state.p,
                           &end->state.p_low, &end->rate,          &end->zero};
        for (size_t j = 0; j < sizeof part / sizeof *part; j++) {
            if (base) *part[j] = (double *)(void *)(base + used);
            used += row * sizeof(double);
        }
        if (base)
            pend_jets_init(&end->jets, s->tree, &s->system.loads, SYMPLECTIC_ORDER, base + used);
        used += series;
    }
    double **spare[] = {&s->spare.phi, &s->spare.phi_low, &s->spare.p, &s->spare.p_low};
    for (size_t j = 0; j < sizeof spare / sizeof *spare; j++) {
        if (base) *spare[j] = (double *)(void *)(base + used);
        used += row * sizeof(double);
    }
    if (base) s->system.lanes = (double *)(void *)(base + used);
    return used + s->kernel->count(s->system.loads.terms, n) * sizeof(double);
}

static void symplectic_close(void **stepper) {
    free(*stepper);
    *stepper = NULL;
}

/* Halves a step chosen by the method until the stages of the first step converge. In long chains
 * they may not converge at first. */
static void symplectic_halve(struct symplectic *s) {
    enum { HALVINGS = 40 };
    const struct symplectic_end *begin = &s->end[s->now], *end = &s->end[!s->now];
    size_t lanes = s->kernel->count(s->system.loads.terms, s->tree->n) * sizeof(double);
    for (int i = 0; i < HALVINGS && s->length != 0; i++) {
        int good = s->kernel->step(&s->system, &begin->state, &end->state);
        // clears the first guess for the stages of the next step
        memset(s->system.lanes, 0, lanes);
        s->kernel->load(&s->system, s->tree->len, s->tree->mass);
        if (good) break; // true also for values that are not finite, which the first step reports
        symplectic_take(s, s->length / 2);
    }
    s->system.iterations = 0;
}

static enum pend_status symplectic_open(void **stepper, const struct pend_problem *problem,
                                        struct pend_error *error) {
    const struct pend_tree *tree = problem->tree;
    struct symplectic sketch = {.tree = tree,
                                .kernel = PEND_ISA_PICK(pend_kernel_symplectic, pend_isa_best())};
    sketch.system = (struct symplectic_system){.n = tree->n,
                                               .parent = tree->parent,
                                               .end = tree->end,
                                               .loads = problem->loads,
                                               .subtree_mass = tree->subtree_mass};
    *stepper = NULL;
    PEND_TRY(symplectic_choose(&sketch, problem, error));
    size_t bytes = symplectic_place(&sketch, NULL);
    char *block = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (!block)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0,
                         "no memory for the stages of %d arms: %zu bytes", tree->n, bytes);
    memset(block, 0, bytes);
    struct symplectic *s = (struct symplectic *)(void *)block;
    *s = sketch;
    symplectic_place(s, block);
    s->kernel->load(&s->system, tree->len, tree->mass);
    struct symplectic_end *end = &s->end[s->now];
    memcpy(end->state.phi, problem->phi, (size_t)tree->n * sizeof(double));
    memcpy(end->rate, problem->rate, (size_t)tree->n * sizeof(double));
    if (problem->phi_low)
        memcpy(end->state.phi_low, problem->phi_low, (size_t)tree->n * sizeof(double));
    s->kernel->momenta(&s->system, problem->phi, problem->rate, end->state.p);
    s->own = problem->step == 0;
    if (s->own) symplectic_halve(s);
    *stepper = s;
    return PEND_OK;
}

/* ---- steps */

/* Largest number of parts into which a step chosen by the method is divided. Of a step chosen by
 * the caller, only the first part is tried, to suggest a step that is short enough. */
enum { PARTS_OWN = 256, PARTS_TOLD = 1 << 30 };

/* If the stages of a step do not converge, divides it into equal parts whose stages do converge.
 * Each part is symplectic, and so is the whole step. Returns the kernel's result for the last part;
 * `used` becomes the number of parts. Afterwards the lanes hold no guess. */
static int symplectic_divide(struct symplectic *s, const struct symplectic_state *begin,
                             const struct symplectic_state *end, int *used) {
    double whole = s->length;
    int most = s->own ? PARTS_OWN : PARTS_TOLD;
    size_t row = pend_jets_stride(s->tree->n) * sizeof(double);
    int good = 0;
    for (int parts = 2; parts < most && !good; parts *= 2) {
        *used = parts;
        symplectic_take(s, whole / parts);
        s->kernel->load(&s->system, s->tree->len, s->tree->mass);
        good = s->kernel->step(&s->system, begin, end);
        for (int i = 1; i < parts && good > 0 && s->own; i++) {
            const double *from[] = {end->phi, end->phi_low, end->p, end->p_low};
            double *to[] = {s->spare.phi, s->spare.phi_low, s->spare.p, s->spare.p_low};
            for (int j = 0; j < 4; j++) memcpy(to[j], from[j], row);
            good = s->kernel->step(&s->system, &s->spare, end);
        }
    }
    symplectic_take(s, whole);
    s->kernel->load(&s->system, s->tree->len, s->tree->mass);
    return good;
}

static enum pend_status symplectic_step(void *stepper, double limit, double *reached,
                                        struct pend_error *error) {
    struct symplectic *s = stepper;
    (void)limit; /* the step has a fixed length and may pass the last instant */
    struct symplectic_end *begin = &s->end[s->now], *end = &s->end[!s->now];
    s->now = !s->now;
    end->known = 0;
    s->time = (double)s->counts.steps * s->length;
    long before = s->system.iterations;
    int good = s->kernel->step(&s->system, &begin->state, &end->state);
    int parts = 1, divided = good ? good : symplectic_divide(s, &begin->state, &end->state, &parts);
    if (s->own) good = divided;
    s->counts.evaluations += GAUSS_STAGES * (s->system.iterations - before);
    if (good < 0)
        return pend_fail(error, PEND_NOT_FINITE, -1, s->time,
                         "the motion ceased to be finite in a step of %.6g s", fabs(s->length));
    if (!good && divided > 0)
        return pend_fail(error, PEND_STEP_TOO_SMALL, -1, s->time,
                         "a step of %.6g s is too long for the speed of this motion: at this "
                         "instant %.3g s would be short enough",
                         fabs(s->length), fabs(s->length) / parts);
    if (!good)
        return pend_fail(error, PEND_STEP_TOO_SMALL, -1, s->time,
                         "the stages of a step of %.6g s do not converge, nor those of 1/%d of it: "
                         "ask for a much shorter step, or for method taylor",
                         fabs(s->length), parts);
    s->counts.steps++;
    *reached = (double)s->counts.steps * s->length;
    if (*reached == s->time)
        return pend_fail(error, PEND_STEP_TOO_SMALL, -1, s->time,
                         "the step is too small to advance the time");
    s->kernel->rates(&s->system, &end->state, end->rate);
    return PEND_OK;
}

/* Angles from the vertical x units after an end of the step. For a small swing, the sum of the
 * series is added to the angles from the vertical at that end, which are known to all digits. */
static void symplectic_theta(const struct symplectic *s, const struct symplectic_end *end, double x,
                             const double phi[], double theta[], double rate[]) {
    int n = s->tree->n;
    struct jets_state hanging = {
        .phi = s->spare.phi, .phi_low = end->zero, .rate = end->rate, .rate_low = end->zero};
    struct jets_values values = {.phi = theta, .rate = rate};
    double largest = 0;
    for (int k = 0; k < n; k++) {
        theta[k] = phi[k] + M_PI_2;
        largest = fmax(largest, fabs(theta[k]));
        hanging.phi[k] = pend_turns_theta(end->state.phi[k], end->state.phi_low[k]);
    }
    if (largest > PEND_TURNS_SMALL) return;
    if (x == 0)
        memcpy(theta, hanging.phi, (size_t)n * sizeof(double));
    else
        pend_jets_values(&end->jets, SYMPLECTIC_ORDER, &x, 1, s->unit, &hanging, &values);
}

/* a state inside the step, from the power series about its nearer end; theta may be NULL */
static void symplectic_inside(struct symplectic *s, double t, double phi[], double rate[],
                              double theta[]) {
    double end_time = (double)s->counts.steps * s->length;
    int late = fabs(end_time - t) < fabs(t - s->time);
    struct symplectic_end *end = &s->end[late ? s->now : !s->now];
    struct jets_state state = {.phi = end->state.phi,
                               .phi_low = end->state.phi_low,
                               .rate = end->rate,
                               .rate_low = end->zero};
    struct jets_values values = {.phi = phi, .rate = rate};
    if (!end->known)
        pend_jets_expand(&end->jets, &s->system.loads, s->unit, &state, SYMPLECTIC_ORDER);
    s->counts.evaluations += end->known ? 0 : SYMPLECTIC_ORDER;
    end->known = 1;
    double x = (t - (late ? end_time : s->time)) / s->unit;
    pend_jets_values(&end->jets, SYMPLECTIC_ORDER, &x, 1, s->unit, &state, &values);
    if (theta) symplectic_theta(s, end, x, phi, theta, rate);
}

static void symplectic_at(void *stepper, const double t[], int count,
                          const struct pend_points *points) {
    struct symplectic *s = stepper;
    const struct symplectic_end *end = &s->end[s->now];
    size_t n = (size_t)s->tree->n;
    double end_time = (double)s->counts.steps * s->length;
    for (int i = 0; i < count; i++) {
        double *phi = points->phi + (size_t)i * n, *rate = points->rate + (size_t)i * n;
        double *theta = points->theta ? points->theta + (size_t)i * n : NULL;
        if (t[i] != end_time) {
            symplectic_inside(s, t[i], phi, rate, theta);
            continue;
        }
        memcpy(phi, end->state.phi, n * sizeof(double));
        memcpy(rate, end->rate, n * sizeof(double));
        if (theta) symplectic_theta(s, end, 0, phi, theta, rate);
    }
}

static struct pend_stepper_counts symplectic_counts(const void *stepper) {
    return ((const struct symplectic *)stepper)->counts;
}

/* saves the lanes too: they hold the first guess for the stages of the next step */
static void symplectic_carry(void *stepper, struct pend_checkpoint *checkpoint) {
    struct symplectic *s = stepper;
    size_t row = pend_jets_stride(s->tree->n);
    pend_stepper_counts_carry(&s->counts, checkpoint);
    pend_checkpoint_counts(checkpoint, &s->system.iterations, 1);
    pend_checkpoint_int(checkpoint, &s->now, 1);
    pend_checkpoint_row(checkpoint, &s->time, 1);
    pend_checkpoint_row(checkpoint, s->system.lanes,
                        s->kernel->count(s->system.loads.terms, s->tree->n));
    for (int i = 0; i < 2; i++) {
        struct symplectic_end *end = &s->end[i];
        double *rows[] = {end->state.phi, end->state.phi_low, end->state.p, end->state.p_low,
                          end->rate};
        pend_checkpoint_int(checkpoint, &end->known, 1);
        for (size_t j = 0; j < sizeof rows / sizeof *rows; j++)
            pend_checkpoint_row(checkpoint, rows[j], row);
        struct jets_state state = {.phi = end->state.phi,
                                   .phi_low = end->state.phi_low,
                                   .rate = end->rate,
                                   .rate_low = end->zero};
        if (pend_checkpoint_puts(checkpoint) && end->known)
            pend_jets_expand(&end->jets, &s->system.loads, s->unit, &state, SYMPLECTIC_ORDER);
    }
}

const struct pend_method pend_method_symplectic = {
    .name = "symplectic",
    .summary = "Gauss-Legendre collocation of order 16 with a fixed step: the energy does not "
               "drift over millions of periods.",
    .flags = PEND_METHOD_FIXED_STEP | PEND_METHOD_TERMS | PEND_METHOD_CONSERVES | PEND_METHOD_THETA,
    .step_min = 1e-9,
    .step_max = 1e9,
    .open = symplectic_open,
    .step = symplectic_step,
    .at = symplectic_at,
    .counts = symplectic_counts,
    .carry = symplectic_carry,
    .close = symplectic_close,
};
