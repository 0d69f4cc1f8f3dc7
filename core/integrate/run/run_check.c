#include "core/integrate/run/run_check.h"

#include <assert.h>
#include <float.h>
#include <math.h>

#include "core/integrate/pieces/pieces.h"

/* The instants of a grid are monotonic, but neighbours can be equal if its step is of the size of
 * the rounding errors at its ends; returns whether the step is larger. */
static int run_grid_is_wide(const struct pend_times *times) {
    double largest = fmax(fabs(times->start), fabs(times->start + times->span));
    return fabs(times->span) / times->divisor > 8 * DBL_EPSILON * largest;
}

static enum pend_status run_check_order(const struct pend_times *times, struct pend_error *error) {
    int rises = pend_times_at(times, times->count - 1) > pend_times_at(times, 0);
    for (long i = 1; i < times->count; i++) {
        double before = pend_times_at(times, i - 1), now = pend_times_at(times, i);
        if (rises ? now > before : now < before) continue;
        return pend_fail(error, PEND_INVALID, -1, now,
                         "the instants must be strictly increasing or strictly decreasing: instant "
                         "%ld (%.17g s) does not follow instant %ld (%.17g s)",
                         i + 1, now, i, before);
    }
    return PEND_OK;
}

static enum pend_status run_check_times(const struct pend_times *times, struct pend_error *error) {
    if (times->count < 1)
        return pend_fail(error, PEND_INVALID, -1, 0, "there must be at least one instant");
    if (!times->list &&
        !(isfinite(times->start) && isfinite(times->span) && isfinite(times->divisor)))
        return pend_fail(error, PEND_INVALID, -1, 0, "the instants must be finite");
    if (!times->list && !(times->divisor > 0))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "the divisor of a grid of instants must be > 0");
    double first = pend_times_at(times, 0), last = pend_times_at(times, times->count - 1);
    if (times->list ? !pend_run_finite(times->list, times->count) : !isfinite(last))
        return pend_fail(error, PEND_INVALID, -1, 0, "the instants must be finite");
    if (!isfinite(last - first))
        return pend_fail(error, PEND_INVALID, -1, 0, "the instants span too long a time");
    if (!times->list && run_grid_is_wide(times)) return PEND_OK;
    return run_check_order(times, error);
}

static enum pend_status run_check_range(const char *method, const char *name, double value,
                                        double min, double max, struct pend_error *error) {
    assert(min <= max);
    if (value >= min && value <= max) return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0, "%s of method %s must be from %g to %g, got %g",
                     name, method, min, max, value);
}

static enum pend_status run_check_state(const struct pend_problem *problem,
                                        struct pend_error *error) {
    const struct pend_tree *tree = problem->tree;
    for (int k = 0; k < tree->n; k++) {
        double low = (problem->phi_low ? problem->phi_low[k] : 0) +
                     (problem->rate_low ? problem->rate_low[k] : 0);
        if (isfinite(problem->phi[k]) && isfinite(problem->rate[k]) && isfinite(low)) continue;
        return pend_fail(error, PEND_INVALID, tree->order[k], 0,
                         "the start of arm %d must be finite", tree->order[k] + 1);
    }
    return PEND_OK;
}

enum pend_status pend_run_check_tree(const struct pend_tree *tree, struct pend_error *error) {
    for (int k = 0; k < tree->n; k++) {
        // a mass of 0 is allowed if terms add inertia
        int light = tree->mass[k] != 0 && tree->mass[k] < DBL_MIN, arm = tree->order[k];
        if (!light && tree->len[k] >= DBL_MIN) continue;
        return pend_fail(
            error, PEND_INVALID, arm, 0,
            "the %s of arm %d is %.15g %s, too small to compute a motion: it must be at least %.3g",
            light ? "mass" : "length", arm + 1, light ? tree->mass[k] : tree->len[k],
            light ? "kg" : "m", DBL_MIN);
    }
    return PEND_OK;
}

static enum pend_status run_check_terms(const struct pend_method *method,
                                        const struct pend_loads *loads, struct pend_error *error) {
    if (!loads->terms) return PEND_OK;
    if (!(method->flags & PEND_METHOD_TERMS))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "method %s does not support friction, drives, springs, rods or bodies: "
                         "use method taylor, or rkf45, rk8pd, msadams or ode23",
                         method->name);
    if (!pend_pieces_method(method, loads->terms)) {
        int extended = method->flags & PEND_METHOD_EXTENDED;
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "method %s does not support %sdry friction or stops: use method taylor in "
                         "double precision",
                         extended ? "taylor in 32 digits" : method->name,
                         extended ? "" : "input tables, controllers, ");
    }
    if (method->flags & PEND_METHOD_CONSERVES && !pend_terms_conserve(loads->terms, loads->value))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "method %s conserves the energy, also of springs, rods and bodies, so it "
                         "does not support friction, drag, torques or a moving pivot: use method "
                         "taylor, or rkf45, rk8pd, msadams or ode23",
                         method->name);
    return PEND_OK;
}

/* checks that a method which integrates dissipation only forwards is not used backwards */
static enum pend_status run_check_direction(const struct pend_method *method,
                                            const struct pend_problem *problem,
                                            struct pend_error *error) {
    const struct pend_times *times = &problem->times;
    int back = pend_times_at(times, times->count - 1) < pend_times_at(times, 0);
    if (back && !pend_pieces_smooth(problem->loads.terms))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "dry friction without a speed, and stops, can be computed only forwards "
                         "in time: a pendulum at rest does not determine when it stopped");
    if (!back || !(method->flags & PEND_METHOD_FORWARD) || !pend_loads_lose(&problem->loads))
        return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "method %s computes friction and drag only forwards in time: to go backwards, "
                     "use method taylor",
                     method->name);
}

enum pend_status pend_run_check(const struct pend_method *method, struct pend_problem *problem,
                                struct pend_error *error) {
    PEND_TRY(pend_loads_check(&problem->loads, error));
    PEND_TRY(run_check_terms(method, &problem->loads, error));
    PEND_TRY(run_check_times(&problem->times, error));
    PEND_TRY(run_check_direction(method, problem, error));
    if (problem->loads.terms && problem->loads.terms->rules)
        PEND_TRY(pend_rules_check(problem->loads.terms->rules, problem->tree->order,
                                  pend_times_at(&problem->times, 0),
                                  pend_times_at(&problem->times, problem->times.count - 1), error));
    PEND_TRY(pend_run_check_tree(problem->tree, error));
    PEND_TRY(run_check_state(problem, error));
    if (problem->step_cap < 0)
        return pend_fail(error, PEND_INVALID, -1, 0, "the step limit must not be negative");
    if (method->flags & PEND_METHOD_FIXED_STEP && problem->step != 0)
        PEND_TRY(run_check_range(method->name, "step", problem->step, method->step_min,
                                 method->step_max, error));
    if (!(method->flags & PEND_METHOD_TOLERANCES)) return PEND_OK;
    if (problem->rtol == 0) problem->rtol = method->rtol_default;
    if (problem->atol == 0 && !problem->atol_given)
        problem->atol = pend_method_atol(method, problem->rtol);
    PEND_TRY(run_check_range(method->name, "rtol", problem->rtol, method->rtol_min,
                             method->rtol_max, error));
    return run_check_range(method->name, "atol", problem->atol, method->atol_min, method->atol_max,
                           error);
}
