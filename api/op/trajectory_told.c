#include "api/op/trajectory_told.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>

#include "core/integrate/pieces/pieces.h"

/* Returns the horizon, made consistent with the exact comparison of angles. If both have the same
 * tolerance, the horizon is the comparison's result; otherwise that result replaces an estimate on
 * the wrong side of it. */
static double told_horizon(const struct api_trajectory_motion *motion, double horizon) {
    double exact = motion->trust_until, start = pend_times_at(motion->times, 0);
    double accuracy = motion->method->accuracy, tolerance = motion->tolerance;
    if (!(tolerance > 0)) return horizon;
    int later = fabs(exact - start) > fabs(horizon - start);
    if (isnan(horizon) || tolerance == accuracy) return exact;
    return later == (tolerance < accuracy) ? exact : horizon;
}

/* adds the horizon, and a warning if it or the exact comparison ends before the last instant */
static void tell_horizon(struct api_trajectory_told *told,
                         const struct api_trajectory_motion *motion,
                         const struct pend_run_stats *run, struct api_stats *stats) {
    double end = pend_times_at(motion->times, motion->times->count - 1),
           exact = motion->trust_until;
    double horizon = told_horizon(motion, run->horizon);
    const char *advice = api_method_advice(motion->method);
    const char *unknown = pend_pieces_unestimated(motion->tree->terms);
    if (!isnan(horizon)) api_stats_number(stats, "horizon", horizon);
    if (unknown) api_stats_text(stats, "no_horizon", unknown);
    if (motion->tolerance > 0 && exact != end)
        snprintf(told->horizon, sizeof told->horizon,
                 "accuracy is lost before the last instant: after t = %.6g s angles differ by more "
                 "than %.3g rad from those computed with more digits (compared). %s",
                 exact, motion->tolerance, advice);
    else if (!isnan(horizon) && horizon != end)
        snprintf(told->horizon, sizeof told->horizon,
                 "accuracy is lost before the last instant: after t = %.6g s errors may exceed "
                 "%.3g (estimated). %s The field trust compares with more digits.",
                 horizon == run->horizon ? run->held : horizon, motion->method->accuracy, advice);
    if (told->horizon[0]) api_stats_warning(stats, "warning_horizon", told->horizon);
}

/* adds a warning if a linear motion starts far from small swings; the neglected terms are of third
 * order */
static void tell_linear(struct api_trajectory_told *told,
                        const struct api_trajectory_motion *motion, struct api_stats *stats) {
    const struct pend_tree *tree = motion->tree->tree;
    double most = 0, length = 0;
    for (int k = 0; k < tree->n; k++) length += tree->len[k];
    double time = sqrt(length / fabs(motion->tree->loads.gravity));
    for (int k = 0; k < tree->n; k++) {
        double theta = remainder(motion->start->phi[k] + M_PI_2, 2 * M_PI);
        most = fmax(most, hypot(theta, motion->start->rate[k] * time));
    }
    if (most * most * most <= 6 * motion->method->accuracy) return;
    snprintf(told->linear, sizeof told->linear,
             "method linear is valid for small swings: this start is %.2g rad from equilibrium. "
             "The result differs from the pendulum's motion; use method taylor.",
             most);
    api_stats_warning(stats, "warning_linear", told->linear);
}

static void tell_energy(struct api_trajectory_told *told, const struct pend_method *method,
                        double drift, struct api_stats *stats) {
    static const double lost = 0.01;
    api_stats_number(stats, "energy_drift", isnan(drift) ? 0 : drift);
    if (isnan(drift))
        snprintf(
            told->energy, sizeof told->energy,
            "the energy exceeds the range of a double, so its conservation cannot be checked.");
    if (drift > lost)
        snprintf(told->energy, sizeof told->energy,
                 "the energy was not conserved: its error is %.2g of the tree's energy scale, so "
                 "this motion is wrong. Use a smaller %s%s.",
                 drift, method->flags & PEND_METHOD_FIXED_STEP ? "step" : "rtol",
                 method == &pend_method_taylor ? "" : " or method taylor");
    if (told->energy[0]) api_stats_warning(stats, "warning_energy", told->energy);
}

void api_trajectory_tell(struct api_trajectory_told *told,
                         const struct api_trajectory_motion *motion,
                         const struct pend_run_stats *run, struct api_stats *stats) {
    static const double loose = 1e-16;
    const struct api_method *method = motion->method;
    int linear = method->method->flags & PEND_METHOD_LINEAR;
    assert(motion->times->count >= 1 && motion->tolerance >= 0 && method->accuracy > 0);
    *told = (struct api_trajectory_told){.horizon = ""};
    if (!linear) tell_energy(told, method->method, run->energy_drift, stats);
    tell_horizon(told, motion, run, stats);
    double turned = motion->start->degrees;
    if (turned != 0) {
        snprintf(told->degrees, sizeof told->degrees,
                 "/initial has an angle of %.6g rad (%.1f turns): give unit deg if it is in "
                 "degrees and unit rad if it is not.",
                 turned, turned / (2 * M_PI));
        api_stats_warning(stats, "warning_degrees", told->degrees);
    }
    if (linear) tell_linear(told, motion, stats);
    if (run->saturated > 0) {
        snprintf(told->control, sizeof told->control,
                 "controller %d is at a limit in %.3g %% of its samples", run->controller + 1,
                 100 * run->saturated);
        api_stats_warning(stats, "warning_control", told->control);
    }
    if (method->method != pend_method_taylor.extended ||
        !(method->rtol > loose || method->atol > loose))
        return;
    snprintf(told->loose, sizeof told->loose,
             "precision extended has an %s of %.3g, which double precision reaches in less time. "
             "Leave rtol and atol out for 28 digits.",
             method->rtol > loose ? "rtol" : "atol",
             method->rtol > loose ? method->rtol : method->atol);
    api_stats_warning(stats, "warning_precision", told->loose);
}
