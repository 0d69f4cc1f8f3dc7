#include "core/derivatives/derivatives.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/derivatives/ideal.h"
#include "core/derivatives/kernel_derivatives.h"
#include "core/integrate/pieces/pieces.h"
#include "core/integrate/run/run_check.h"
#include "core/taylor/taylor_order.h"
#include "core/tree/turns.h"

enum { LANES = DERIVATIVES_LANES, FIRST = DERIVATIVES_FIRST, PASS = DERIVATIVES_PASS };

/* numbers of a state: phi, phi_low, rate, rate_low at the start of a step and at its end */
enum { STATE = 8 };

/* approximate cost of an order with eight derivatives, relative to an order in doubles */
static const double derivatives_times = 4;

/* a step shorter than this fraction of the remaining time would never reach the end */
static const double derivatives_least = 1e-12;

struct pend_derivatives {
    const struct derivatives_kernel *kernel;
    struct pend_problem problem;
    struct pend_terms *none; /* an empty list of terms, for an ideal pendulum */
    int quick;               /* non-zero: `ideal` computes derivatives from the known motion */
    int count, passes;       /* number of parameters; number of passes of eight parameters */
    int order;
    double log_rtol, log_atol;
    double start, end;               /* s: first instant; last instant relative to it */
    double time, reached, next_unit; /* s, relative: start and end of the step; next unit */
    double now, knot; /* s, in the time of the drives: start and end of the current piece */
    long steps, next; /* number of steps; index of the first instant that has no row yet */
    struct pend_error failure; /* the failure, if any; otherwise its code is PEND_OK */
    struct pend_parameter *parameter;
    /* For each parameter its unit, a power of two, and the inverse of that. Derivatives are
     * computed with respect to multiples of the unit. */
    double *seed, *per_seed;
    struct derivatives_pass *pass;
    struct ideal *ideal;        /* used if derivatives follow from a known motion; otherwise NULL */
    double *view[PEND_DERIVED]; /* the quantities of one pass at one instant, n numbers each */
};

PEND_VALIDATOR derivatives_valid(const struct pend_derivatives *d) {
    return d->count >= 1 && d->passes == (d->count + PASS - 1) / PASS && d->next >= 0 &&
           d->next <= d->problem.times.count && d->order >= 1 && d->pass[0].tree->n >= 1;
}

/* ---- creation and release */

/* allocates bytes in a block, aligned to 64; if base is NULL, only counts them */
static void *derivatives_take(char *base, size_t *used, size_t bytes) {
    void *part = base ? base + *used : NULL;
    *used += (bytes + 63) / 64 * 64;
    return part;
}

static double *derivatives_row(char *base, size_t *used, size_t numbers) {
    return derivatives_take(base, used, numbers * LANES * sizeof(double));
}

static void derivatives_lay_pass(const struct pend_derivatives *d, struct derivatives_pass *pass,
                                 const struct pend_terms *terms, char *base, size_t *used) {
    size_t n = (size_t)d->problem.tree->n;
    struct derivatives_pass made = {
        .tree = d->problem.tree, .terms = terms, .order = d->order, .start = d->start};
    double **array[] = {&made.len,      &made.mass,    &made.phi,     &made.phi_low,  &made.rate,
                        &made.rate_low, &made.end_phi, &made.end_low, &made.end_rate, &made.slow};
    for (size_t i = 0; i < sizeof array / sizeof *array; i++)
        *array[i] = derivatives_row(base, used, n);
    made.gravity = derivatives_row(base, used, 1);
    made.value = derivatives_row(base, used, (size_t)terms->count + 1);
    if (!d->quick)
        made.series = derivatives_row(base, used, d->kernel->count(terms, (int)n, d->order));
    made.place = derivatives_row(base, used, d->kernel->count(terms, (int)n, 1));
    made.share = derivatives_take(base, used, (size_t)(d->order + 2) * sizeof(double));
    for (int j = 0; base && j < d->order + 2; j++) made.share[j] = 1.0 / (j + 1);
    if (base) *pass = made;
}

/* places all arrays; returns their bytes */
static size_t derivatives_lay(struct pend_derivatives *d, const struct pend_terms *terms,
                              char *base) {
    size_t used = 0, n = (size_t)d->problem.tree->n;
    derivatives_take(base, &used, sizeof *d);
    d->parameter = derivatives_take(base, &used, (size_t)d->count * sizeof *d->parameter);
    d->seed = derivatives_take(base, &used, (size_t)d->count * sizeof(double));
    d->per_seed = derivatives_take(base, &used, (size_t)d->count * sizeof(double));
    d->pass = derivatives_take(base, &used, (size_t)d->passes * sizeof *d->pass);
    for (int i = 0; i < PEND_DERIVED; i++)
        if (pend_derived_from(i) == i)
            d->view[i] = derivatives_row(base, &used, pend_derived_single(i) ? 1 : n);
    for (int i = 0; i < d->passes; i++)
        derivatives_lay_pass(d, base ? &d->pass[i] : NULL, terms, base, &used);
    if (d->quick)
        d->ideal = derivatives_take(base, &used,
                                    pend_ideal_bytes(d->problem.tree, terms, d->order, d->count));
    return used;
}

/* the members of the structure that are known before memory is allocated */
static struct pend_derivatives derivatives_sketch(const struct pend_problem *problem, int count) {
    return (struct pend_derivatives){.kernel = pend_kernel_derivatives(),
                                     .problem = *problem,
                                     .count = count,
                                     .passes = (count + PASS - 1) / PASS,
                                     .order = pend_taylor_order(problem->rtol, 1),
                                     .log_rtol = log2(pend_taylor_target(problem->rtol)),
                                     .log_atol = log2(pend_taylor_atol(problem->atol))};
}

double pend_derivatives_bytes(const struct pend_tree *tree, const struct pend_terms *terms,
                              int count) {
    assert(tree->n >= 1 && count >= 1);
    struct pend_problem problem = {.tree = tree, .rtol = 1e-16};
    struct pend_derivatives sketch = derivatives_sketch(&problem, count);
    struct pend_terms none = {.n = tree->n};
    for (int i = 0; i < PEND_TERM_ROWS; i++) none.row[i] = -1;
    for (int i = 0; i < PEND_TERM_ONES; i++) none.one[i] = -1;
    size_t most = 0;
    // the values of a real pendulum decide between the two kernels: count the larger one
    for (sketch.quick = !pend_ideal_terms(terms); sketch.quick < 2; sketch.quick++) {
        size_t bytes = derivatives_lay(&sketch, terms ? terms : &none, NULL);
        if (bytes > most) most = bytes;
    }
    return (double)most;
}

/* the address of a parameter in a pass */
static double *derivatives_place(const struct derivatives_pass *pass, struct pend_parameter by) {
    double *array[] = {
        [PEND_PARAMETER_PHI] = pass->end_phi,     [PEND_PARAMETER_RATE] = pass->end_rate,
        [PEND_PARAMETER_LENGTH] = pass->len,      [PEND_PARAMETER_MASS] = pass->mass,
        [PEND_PARAMETER_GRAVITY] = pass->gravity, [PEND_PARAMETER_TERM] = pass->value};
    return array[by.kind] + (size_t)by.at * LANES;
}

/* sets the initial values of a pass: the pendulum, and the start as the end of a preceding step */
static void derivatives_fill(const struct pend_derivatives *d, struct derivatives_pass *pass,
                             int first) {
    const struct pend_problem *problem = &d->problem;
    const struct pend_tree *tree = problem->tree;
    int whole = pend_terms_whole_turns(pass->terms);
    for (int k = 0; k < tree->n; k++) {
        size_t at = (size_t)k * LANES;
        double low = problem->phi_low ? problem->phi_low[k] : 0;
        // keep whole turns, which springs distinguish; a cart's position has none
        struct pend_sum phi = {problem->phi[k], low};
        if (whole) phi = pend_turns_rest(phi.high, phi.low, NULL);
        pass->len[at] = tree->len[k], pass->mass[at] = tree->mass[k];
        pass->end_phi[at] = phi.high, pass->end_low[at] = phi.low;
        pass->end_rate[at] = problem->rate[k];
        pass->slow[at] = problem->rate_low ? problem->rate_low[k] : 0;
    }
    pass->gravity[0] = problem->loads.gravity;
    for (int j = 0; j < pass->terms->count; j++)
        pass->value[(size_t)j * LANES] = problem->loads.value[j];
    for (int i = 0; i < PASS && first + i < d->count; i++)
        derivatives_place(pass, d->parameter[first + i])[FIRST + i] = d->seed[first + i];
}

/* starts a piece: sets its inputs in all passes */
static void derivatives_piece(struct pend_derivatives *d, double now) {
    d->now = now;
    for (int i = 0; i < d->passes; i++)
        d->knot = pend_rules_piece(d->problem.loads.terms, now, d->end < 0 ? -1 : 1,
                                   d->pass[i].value, LANES);
}

static void derivatives_begin(struct pend_derivatives *d, const struct pend_parameter parameter[]) {
    const struct pend_tree *tree = d->problem.tree;
    const struct pend_times *times = &d->problem.times;
    d->end = pend_times_at(times, times->count - 1) - d->start;
    d->next_unit = pend_taylor_first_unit(tree->n, &d->problem.loads, tree->len, d->problem.rate);
    for (int i = 0; i < d->count; i++) {
        double value = fabs(pend_parameter_value(d->problem.tree, &d->problem.loads, parameter[i]));
        d->parameter[i] = parameter[i];
        d->seed[i] = value > DBL_MIN ? exp2(floor(log2(value))) : 1;
        d->per_seed[i] = 1 / d->seed[i];
    }
    for (int i = 0; i < d->passes; i++) derivatives_fill(d, &d->pass[i], i * PASS);
    derivatives_piece(d, d->start);
    if (d->ideal) pend_ideal_init(d->ideal, &d->problem, d->order, d->count, parameter, d->seed);
}

enum pend_status pend_derivatives_new(struct pend_derivatives **derivatives,
                                      const struct pend_problem *problem, int count,
                                      const struct pend_parameter parameter[],
                                      struct pend_error *error) {
    assert(count >= 1);
    static const unsigned char no_rows[PEND_TERM_ROWS], no_ones[PEND_TERM_ONES];
    struct pend_problem checked = *problem;
    *derivatives = NULL;
    PEND_TRY(pend_run_check(&pend_method_taylor, &checked, error));
    PEND_TRY(pend_pieces_check_smooth(checked.loads.terms, "derivatives", error));
    struct pend_derivatives sketch = derivatives_sketch(&checked, count);
    const struct pend_terms *terms = checked.loads.terms;
    if (!terms &&
        pend_terms_new(&sketch.none, checked.tree->n, no_rows, no_ones, 0, NULL, NULL) != PEND_OK)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for derivatives");
    if (!terms) terms = sketch.none;
    sketch.quick = pend_ideal_suits(checked.tree, &checked.loads, count, parameter);
    sketch.start = pend_times_at(&checked.times, 0);
    size_t bytes = derivatives_lay(&sketch, terms, NULL);
    char *block = aligned_alloc(64, bytes);
    if (!block) pend_terms_free(&sketch.none);
    if (!block) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for derivatives");
    memset(block, 0, bytes);
    derivatives_lay(&sketch, terms, block);
    *derivatives = (struct pend_derivatives *)(void *)block;
    **derivatives = sketch;
    derivatives_begin(*derivatives, parameter);
    assert(derivatives_valid(*derivatives));
    return PEND_OK;
}

void pend_derivatives_free(struct pend_derivatives **derivatives) {
    if (!*derivatives) return;
    assert(derivatives_valid(*derivatives));
    pend_terms_free(&(*derivatives)->none);
    free(*derivatives);
    *derivatives = NULL;
}

/* ---- steps */

static enum pend_status derivatives_fail(struct pend_derivatives *d, enum pend_status status,
                                         const char *text, struct pend_error *error) {
    (void)pend_fail(&d->failure, status, -1, d->start + d->time, "%s at t = %.6g s", text,
                    d->start + d->time);
    if (error) *error = d->failure;
    return status;
}

static void derivatives_turn(struct derivatives_pass *pass) {
    double **pair[4][2] = {{&pass->phi, &pass->end_phi},
                           {&pass->phi_low, &pass->end_low},
                           {&pass->rate, &pass->end_rate},
                           {&pass->rate_low, &pass->slow}};
    for (int i = 0; i < 4; i++) {
        double *swap = *pair[i][0];
        *pair[i][0] = *pair[i][1];
        *pair[i][1] = swap;
    }
}

/* Expands all passes about the same start with the same unit. Returns the largest step, in units,
 * that the motion and all derivatives allow. */
static double derivatives_reach(struct pend_derivatives *d, double unit) {
    double x = INFINITY;
    d->pass[0].unit = unit;
    if (d->ideal) return pend_ideal_expand(d->ideal, d->time, unit, d->log_rtol, d->log_atol);
    for (int i = 0; i < d->passes; i++) {
        d->pass[i].unit = unit, d->pass[i].time = d->time, d->pass[i].pressed = 0;
        double reach = d->kernel->expand(&d->pass[i], d->log_rtol, d->log_atol);
        if (isnan(reach)) return NAN;
        x = fmin(x, reach);
    }
    return x;
}

/* as derivatives_reach, with a unit that suits the step; returns the step, and sets *unit */
static double derivatives_expand(struct pend_derivatives *d, double *unit) {
    enum { RANGE = 16, TRIES = 64 };
    double x = NAN, left = fabs(d->end - d->time);
    for (int i = 0; i < TRIES; i++) {
        x = derivatives_reach(d, *unit);
        // a step may pass the last instant, but by no more than the time left to it
        if (left > 0) x = x > 2 * left / fabs(*unit) ? 2 * left / fabs(*unit) : x;
        if (isnan(x) || (x >= exp2(-RANGE) && x <= exp2(RANGE))) break;
        *unit *= exp2(x > 1 ? RANGE : -RANGE);
    }
    return x;
}

static enum pend_status derivatives_step(struct pend_derivatives *d, struct pend_error *error) {
    const struct pend_problem *problem = &d->problem;
    if (problem->step_cap && d->steps >= problem->step_cap)
        return derivatives_fail(d, PEND_TOO_MANY_STEPS, "derivatives reached the limit of steps",
                                error);
    for (int i = 0; i < d->passes && !d->ideal; i++) derivatives_turn(&d->pass[i]);
    if (d->ideal) pend_ideal_turn(d->ideal);
    d->time = d->reached;
    if (d->time == d->knot - d->start) derivatives_piece(d, d->knot);
    double knot = d->knot - d->start, unit = copysign(d->next_unit, d->end - d->time),
           x = derivatives_expand(d, &unit);
    if (isnan(x))
        return derivatives_fail(d, PEND_NOT_FINITE, "the derivatives ceased to be finite", error);
    d->steps++;
    if (d->end == 0) return PEND_OK; // there is only one instant, for which the series suffices
    x = fmin(x, (knot - d->time) / unit);
    d->reached = x * unit == knot - d->time ? knot : d->time + x * unit;
    if (d->reached == d->time || x * fabs(unit) < derivatives_least * fabs(d->end - d->time))
        return derivatives_fail(d, PEND_STEP_TOO_SMALL,
                                "the step of the derivatives became too small", error);
    if (d->ideal) pend_ideal_advance(d->ideal, (d->reached - d->time) / unit);
    for (int i = 0; i < d->passes && !d->ideal; i++)
        d->kernel->advance(&d->pass[i], (d->reached - d->time) / unit);
    d->next_unit = exp2(floor(log2(x * fabs(unit))));
    return PEND_OK;
}

/* ---- rows */

/* the view of a pass: the requested quantities, and those from which they are computed */
static struct derivatives_view derivatives_look(const struct pend_derivatives *d,
                                                const struct pend_derived_rows *rows, int *dynamics,
                                                int *more) {
    double *at[PEND_DERIVED] = {NULL};
    for (int i = 0, from; i < PEND_DERIVED; i++)
        if (rows->value[i] || rows->derivative[i])
            from = pend_derived_from(i), at[from] = d->view[from];
    *dynamics = at[PEND_DERIVED_ZDD_RE] || at[PEND_DERIVED_ZDD_IM] ||
                at[PEND_DERIVED_JOINT_ALONG] || at[PEND_DERIVED_JOINT_ACROSS] ||
                at[PEND_DERIVED_TIP_ACROSS];
    *more = 0;
    for (int i = PEND_DERIVED_FORCE + 1; i < PEND_DERIVED; i++) *more |= at[i] != NULL;
    if (*dynamics) at[PEND_DERIVED_ACC] = d->view[PEND_DERIVED_ACC];
    return (struct derivatives_view){.phi = d->view[PEND_DERIVED_PHI],
                                     .rate = d->view[PEND_DERIVED_RATE],
                                     .acc = at[PEND_DERIVED_ACC],
                                     .force = at[PEND_DERIVED_FORCE],
                                     .z_re = at[PEND_DERIVED_Z_RE],
                                     .z_im = at[PEND_DERIVED_Z_IM],
                                     .zd_re = at[PEND_DERIVED_ZD_RE],
                                     .zd_im = at[PEND_DERIVED_ZD_IM],
                                     .zdd_re = at[PEND_DERIVED_ZDD_RE],
                                     .zdd_im = at[PEND_DERIVED_ZDD_IM],
                                     .joint_along = at[PEND_DERIVED_JOINT_ALONG],
                                     .joint_across = at[PEND_DERIVED_JOINT_ACROSS],
                                     .tip_across = at[PEND_DERIVED_TIP_ACROSS],
                                     .kinetic = at[PEND_DERIVED_KINETIC],
                                     .potential = at[PEND_DERIVED_POTENTIAL]};
}

static void derivatives_keep(const struct pend_derivatives *d, int pass, long row,
                             const struct pend_derived_rows *rows) {
    int cart = pend_terms_cart(d->problem.loads.terms), n = d->problem.tree->n - cart;
    int first = pass * PASS; // a cart is stored first, but has rows of its own
    const int *order = d->problem.tree->order;
    for (int i = 0; i < PEND_DERIVED; i++) {
        int one = pend_derived_single(i), width = one ? 1 : n;
        double *value = pass ? NULL : rows->value[i], *derivative = rows->derivative[i];
        for (int k = 0; (value || derivative) && k < width; k++) {
            int arm = one ? 0 : k + cart, place = order[arm] - (cart && order[arm] > order[0]);
            const double *from = d->view[pend_derived_from(i)] + (size_t)arm * LANES;
            size_t to = (size_t)row * (size_t)width + (size_t)(one ? 0 : place);
            if (value) value[to] = from[0];
            if (!derivative) continue;
            double *own = derivative + to * (size_t)d->count + (size_t)first;
            for (int j = 0; j < PASS && first + j < d->count; j++)
                own[j] = from[FIRST + j] * d->per_seed[first + j];
        }
    }
}

static void derivatives_sample(struct pend_derivatives *d, const struct pend_derived_rows *rows,
                               long row, double t) {
    int dynamics, more;
    struct derivatives_view view = derivatives_look(d, rows, &dynamics, &more);
    // forces at the tips of bodies follow from the state, not from the series
    if (d->ideal && d->ideal->loads.terms && view.force) dynamics = more = 1;
    if (d->ideal)
        pend_ideal_values(d->ideal, (t - d->time) / d->pass[0].unit, view.acc || view.force);
    for (int i = 0; i < d->passes; i++) {
        struct derivatives_pass *pass = &d->pass[i];
        if (view.force && !pass->pressed && !d->ideal) d->kernel->press(pass), pass->pressed = 1;
        if (d->ideal)
            pend_ideal_view(d->ideal, i * PASS, &view);
        else
            d->kernel->values(pass, (t - d->time) / pass->unit, &view);
        if (more) d->kernel->observe(pass, d->start + t, dynamics, &view);
        derivatives_keep(d, i, row, rows);
    }
}

static int derivatives_finite(const struct pend_derivatives *d,
                              const struct pend_derived_rows *rows, long row) {
    int good = 1, arms = d->problem.tree->n - pend_terms_cart(d->problem.loads.terms);
    for (int i = 0; i < PEND_DERIVED; i++) {
        long width = pend_derived_single(i) ? 1 : arms;
        if (rows->value[i]) good &= pend_run_finite(rows->value[i] + row * width, width);
        width *= d->count;
        if (rows->derivative[i]) good &= pend_run_finite(rows->derivative[i] + row * width, width);
    }
    return good;
}

enum pend_status pend_derivatives_next(struct pend_derivatives *derivatives,
                                       const struct pend_derived_rows *rows, long cap, double work,
                                       long *made, struct pend_error *error) {
    struct pend_derivatives *d = derivatives;
    assert(derivatives_valid(d) && cap >= 1);
    const struct pend_times *times = &d->problem.times;
    double spent = 0, pass = derivatives_times * d->passes * d->problem.tree->n;
    *made = 0;
    if (d->failure.code != PEND_OK) {
        if (error) *error = d->failure;
        return d->failure.code;
    }
    while (*made < cap && d->next < times->count && spent < work) {
        double t = pend_times_at(times, d->next) - d->start;
        if (!d->steps || (d->end < 0 ? t < d->reached : t > d->reached)) {
            PEND_TRY(derivatives_step(d, error));
            spent += pass * d->order;
            continue;
        }
        derivatives_sample(d, rows, *made, t);
        if (!derivatives_finite(d, rows, *made))
            return derivatives_fail(d, PEND_NOT_FINITE, "a derivative is too large a number",
                                    error);
        d->next++, ++*made;
        spent += pass;
    }
    return PEND_OK;
}

void pend_derivatives_state(struct pend_derivatives *derivatives, const double phi[],
                            const double phi_low[], const double rate[], double time,
                            const struct pend_derived_rows *rows, long row) {
    struct pend_derivatives *d = derivatives;
    assert(derivatives_valid(d) && row >= 0);
    int dynamics, more, n = d->problem.tree->n;
    struct derivatives_view view = derivatives_look(d, rows, &dynamics, &more);
    for (int i = 0; i < d->passes; i++) {
        memset(view.phi, 0, (size_t)n * LANES * sizeof(double));
        memset(view.rate, 0, (size_t)n * LANES * sizeof(double));
        for (int k = 0; k < n; k++) {
            view.phi[(size_t)k * LANES] = phi[k] + (phi_low ? phi_low[k] : 0);
            view.rate[(size_t)k * LANES] = rate[k];
        }
        for (int j = 0; j < PASS && i * PASS + j < d->count; j++) {
            struct pend_parameter by = d->parameter[i * PASS + j];
            double *to = by.kind == PEND_PARAMETER_PHI ? view.phi : view.rate;
            if (by.kind == PEND_PARAMETER_PHI || by.kind == PEND_PARAMETER_RATE)
                to[(size_t)by.at * LANES + FIRST + (size_t)j] = d->seed[i * PASS + j];
        }
        d->kernel->observe(&d->pass[i], time, 1, &view);
        derivatives_keep(d, i, row, rows);
    }
}

double pend_derivatives_progress(const struct pend_derivatives *derivatives) {
    const struct pend_times *times = &derivatives->problem.times;
    double end = derivatives->end;
    if (derivatives->next == times->count || end == 0) return 1;
    double next = pend_times_at(times, derivatives->next) - derivatives->start;
    return fmin(next / end, derivatives->reached / end);
}

long pend_derivatives_steps(const struct pend_derivatives *derivatives) {
    return derivatives->steps;
}

/* ---- checkpoints */

enum pend_status pend_derivatives_carry(struct pend_derivatives *derivatives,
                                        struct pend_checkpoint *checkpoint) {
    struct pend_derivatives *d = derivatives;
    assert(derivatives_valid(d) && d->failure.code == PEND_OK);
    double *numbers[] = {&d->time, &d->reached, &d->next_unit, &d->pass[0].unit};
    pend_checkpoint_counts(checkpoint, &d->steps, 1);
    pend_checkpoint_counts(checkpoint, &d->next, 1);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        pend_checkpoint_row(checkpoint, numbers[i], 1);
    if (d->ideal) pend_ideal_carry(d->ideal, checkpoint);
    for (int i = 0; i < d->passes && !d->ideal; i++) {
        struct derivatives_pass *pass = &d->pass[i];
        double *state[STATE] = {pass->phi,     pass->phi_low, pass->rate,     pass->rate_low,
                                pass->end_phi, pass->end_low, pass->end_rate, pass->slow};
        for (int j = 0; j < STATE * d->problem.tree->n; j++) {
            double *number = state[j % STATE] + (size_t)(j / STATE) * LANES;
            pend_checkpoint_row(checkpoint, number, 1);
            pend_checkpoint_row(checkpoint, number + FIRST, PASS);
        }
    }
    pend_checkpoint_row(checkpoint, &d->now, 1);
    if (!pend_checkpoint_puts(checkpoint)) return PEND_OK;
    derivatives_piece(d, d->now);
    if (d->next > d->problem.times.count || !isfinite(d->time) || !isfinite(d->reached) ||
        !isfinite(d->next_unit) || d->next_unit <= 0 || !isfinite(d->pass[0].unit))
        return PEND_INVALID;
    // the series of the last step is recomputed from its start
    if (d->steps) (void)derivatives_reach(d, d->pass[0].unit);
    return PEND_OK;
}
