#include "core/integrate/events/section.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "core/integrate/pieces/pieces.h"
#include "core/integrate/run/horizon.h"
#include "core/integrate/run/run_check.h"
#include "core/tree/turns.h"

enum { SECTION_LOOKS = 32, SECTION_QUEUE = 4 * SECTION_LOOKS, SECTION_HALVINGS = 200 };

struct section_look {
    double time, phi, rate; /* for a small swing, phi is the angle from the vertical */
};

struct pend_section {
    struct pend_section_problem problem;
    int n;
    const struct pend_method *method;
    void *stepper;
    struct pend_horizon *horizon; /* NULL if no accuracy is given */
    double reached;               /* s, end of the last step */
    double flash;                 /* index of the next instant of a stroboscopic section */
    double *theta;       /* angles from the vertical, which have more digits than phi if the swing
                          * is small */
    double level, start; /* the arm's angle in the section, and at the start; both measured as in
                          * section_look */
    struct pend_passage queue[SECTION_QUEUE]; /* passages of the last step; entries next .. queued -
                                               * 1 were not returned yet */
    int next, queued;
    double *phi, *rate;                          /* n values at SECTION_LOOKS + 1 instants */
    double *rest, *rest_low, *turns, *turns_low; /* rad, n values each: initial angles without whole
                                                  * turns, and these turns */
};

PEND_VALIDATOR section_valid(const struct pend_section *s) {
    return s->next >= 0 && s->next <= s->queued && s->queued <= SECTION_QUEUE && s->reached >= 0 &&
           s->n == s->problem.tree->n && s->problem.duration > 0;
}

/* --- the arm inside the last step --- */

static struct section_look section_at(const struct pend_section *section, double time) {
    const struct pend_points points = {
        .phi = section->phi, .rate = section->rate, .theta = section->theta};
    const double *angle = section->theta ? section->theta : section->phi;
    section->method->at(section->stepper, &time, 1, &points);
    return (struct section_look){time, angle[section->problem.arm],
                                 section->rate[section->problem.arm]};
}

/* whole turns between an angle and the section */
static double section_turns(const struct pend_section *section, double phi) {
    return floor((phi - section->level) / (2 * M_PI));
}

/* The instant between two looks at which the angle is `target`, for an angle that is monotonic
 * between them. Newton's method inside a bracket, with bisection if a step leaves the bracket. */
static double section_solve(const struct pend_section *section, struct section_look a,
                            struct section_look b, double target) {
    assert(a.time <= b.time);
    int rises = b.phi > a.phi;
    double low = a.time, high = b.time;
    struct section_look look =
        section_at(section, low + (high - low) * ((target - a.phi) / (b.phi - a.phi)));
    for (int i = 0; i < SECTION_HALVINGS; i++) {
        if (look.phi == target) return look.time;
        if ((look.phi < target) == rises)
            low = look.time;
        else
            high = look.time;
        double next = look.time + (target - look.phi) / look.rate;
        if (!(next > low && next < high)) next = low + (high - low) / 2;
        if (!(next > low && next < high)) break;
        double moved = fabs(next - look.time);
        look = section_at(section, next);
        if (moved <= 2e-16 * fabs(next)) break;
    }
    return look.time;
}

/* the instant of rate 0 between two looks whose rates have opposite signs */
static struct section_look section_extreme(const struct pend_section *section,
                                           struct section_look a, struct section_look b) {
    struct section_look look = a;
    for (int i = 0; i < SECTION_HALVINGS; i++) {
        double middle = a.time + (b.time - a.time) / 2;
        if (!(middle > a.time && middle < b.time)) break;
        look = section_at(section, middle);
        if (look.rate == 0) break;
        if ((look.rate > 0) == (a.rate > 0))
            a = look;
        else
            b = look;
    }
    return look;
}

/* --- the passages of a step --- */

static void section_add(struct pend_section *section, double time, enum pend_way way) {
    if (!(section->problem.ways & way) || time <= 0 || section->queued == SECTION_QUEUE) return;
    section->queue[section->queued++] = (struct pend_passage){time, way};
}

/* adds the passages between two looks, between which the angle is monotonic */
static void section_between(struct pend_section *section, struct section_look a,
                            struct section_look b) {
    double from = section_turns(section, a.phi), to = section_turns(section, b.phi);
    for (; from < to; from++)
        section_add(section, section_solve(section, a, b, section->level + 2 * M_PI * (from + 1)),
                    PEND_WAY_UP);
    for (; from > to; from--)
        section_add(section, section_solve(section, a, b, section->level + 2 * M_PI * from),
                    PEND_WAY_DOWN);
}

/* true if the angle can reach the section between two looks, judging by the rates there */
static int section_near(const struct pend_section *section, struct section_look a,
                        struct section_look b) {
    double far = (fabs(a.rate) + fabs(b.rate)) * (b.time - a.time);
    return section_turns(section, fmin(a.phi, b.phi) - far) !=
           section_turns(section, fmax(a.phi, b.phi) + far);
}

static void section_scan(struct pend_section *section, double from, double to) {
    assert(from <= to);
    double time[SECTION_LOOKS + 1];
    struct section_look look[SECTION_LOOKS + 1];
    const struct pend_points points = {
        .phi = section->phi, .rate = section->rate, .theta = section->theta};
    const double *angle = section->theta ? section->theta : section->phi;
    for (int i = 0; i <= SECTION_LOOKS; i++) time[i] = from + (to - from) * i / SECTION_LOOKS;
    time[SECTION_LOOKS] = to;
    section->method->at(section->stepper, time, SECTION_LOOKS + 1, &points);
    for (int i = 0; i <= SECTION_LOOKS; i++) {
        size_t place = (size_t)i * (size_t)section->n + (size_t)section->problem.arm;
        look[i] = (struct section_look){time[i], angle[place], section->rate[place]};
    }
    if (from == 0) look[0].phi = section->start;
    for (int i = 0; i < SECTION_LOOKS; i++) {
        if (!section_near(section, look[i], look[i + 1])) continue;
        if (look[i].rate * look[i + 1].rate >= 0) {
            section_between(section, look[i], look[i + 1]);
            continue;
        }
        struct section_look turn = section_extreme(section, look[i], look[i + 1]);
        section_between(section, look[i], turn);
        section_between(section, turn, look[i + 1]);
    }
}

/* --- the search --- */

static enum pend_status section_step(struct pend_section *section, struct pend_error *error) {
    double from = section->reached, duration = section->problem.duration;
    enum pend_status status =
        section->method->step(section->stepper, duration, &section->reached, error);
    if (status != PEND_OK) {
        double time = error ? error->time : from;
        return pend_fail(error, status, -1, time, "at t = %.6g s: %s", time,
                         pend_status_text(status));
    }
    if (section->horizon) {
        const struct pend_points end = {.phi = section->phi, .rate = section->rate};
        section->method->at(section->stepper, &section->reached, 1, &end);
        pend_horizon_step(section->horizon, section->stepper, section->reached, end.phi, end.rate);
    }
    section->next = section->queued = 0;
    if (section->problem.period > 0) return PEND_OK;
    section_scan(section, from, fmin(section->reached, duration));
    return PEND_OK;
}

static void section_give(struct pend_section *section, const struct pend_passage *passage,
                         double phi[], double rate[]) {
    const struct pend_points points = {.phi = phi, .rate = rate};
    section->method->at(section->stepper, &passage->time, 1, &points);
    for (int k = 0; k < section->n; k++)
        phi[k] = pend_turns_add(phi[k], section->turns[k], section->turns_low[k]);
}

static enum pend_status section_flash(struct pend_section *section, long steps,
                                      enum pend_found *found, struct pend_passage *passage,
                                      double phi[], double rate[], struct pend_error *error) {
    double period = section->problem.period,
           time = fma(section->flash, period, section->problem.first);
    for (; section->reached < fmin(time, section->problem.duration); steps--) {
        if (steps <= 0) return PEND_OK;
        PEND_TRY(section_step(section, error));
    }
    *found = time > section->problem.duration ? PEND_FOUND_END : PEND_FOUND_PASSAGE;
    if (*found == PEND_FOUND_END) return PEND_OK;
    *passage = (struct pend_passage){.time = time};
    section_give(section, passage, phi, rate);
    section->flash++;
    return PEND_OK;
}

enum pend_status pend_section_next(struct pend_section *section, long steps, enum pend_found *found,
                                   struct pend_passage *passage, double phi[], double rate[],
                                   struct pend_error *error) {
    assert(section_valid(section));
    *found = PEND_FOUND_NOTHING;
    if (section->problem.period > 0)
        return section_flash(section, steps, found, passage, phi, rate, error);
    for (; section->next == section->queued && steps > 0; steps--) {
        if (section->reached >= section->problem.duration) {
            *found = PEND_FOUND_END;
            return PEND_OK;
        }
        PEND_TRY(section_step(section, error));
    }
    if (section->next == section->queued) return PEND_OK;
    *passage = section->queue[section->next++];
    *found = PEND_FOUND_PASSAGE;
    section_give(section, passage, phi, rate);
    return PEND_OK;
}

/* Subtracts whole turns from the initial angles. Sections do not depend on them, but springs do.
 * `memory` has 4 n values. */
static void section_turn(struct pend_section *section, double memory[]) {
    const struct pend_terms *terms = section->problem.loads.terms;
    size_t n = (size_t)section->n;
    int whole = pend_terms_whole_turns(terms);
    section->rest = memory, section->rest_low = memory + n;
    section->turns = memory + 2 * n, section->turns_low = memory + 3 * n;
    for (size_t k = 0; k < n; k++) {
        double low = section->problem.phi_low ? section->problem.phi_low[k] : 0;
        struct pend_sum turns = {0, 0}, rest = {section->problem.phi[k], low};
        if (whole) rest = pend_turns_rest(section->problem.phi[k], low, &turns);
        section->rest[k] = rest.high, section->rest_low[k] = rest.low;
        section->turns[k] = turns.high, section->turns_low[k] = turns.low;
    }
}

/* Sets the section's level and the arm's start. For a small swing whose start has more digits than
 * phi, both are angles from the vertical. `theta` has n values for each look at a step. */
static void section_aim(struct pend_section *section, double theta[]) {
    const struct pend_section_problem *problem = &section->problem;
    double level = pend_turns_theta(problem->angle, problem->angle_low), largest = fabs(level),
           low = 0;
    // the position of a cart, which is stored first, is not an angle
    for (int k = pend_terms_cart(problem->loads.terms); k < section->n; k++) {
        largest = fmax(largest, fabs(pend_turns_theta(section->rest[k], section->rest_low[k])));
        low = fmax(low, fabs(section->rest_low[k]));
    }
    int fine = low > 0 && largest <= PEND_TURNS_SMALL, arm = problem->arm;
    section->theta = fine ? theta : NULL;
    section->level = fine ? level : problem->angle;
    section->start =
        fine ? pend_turns_theta(section->rest[arm], section->rest_low[arm]) : section->rest[arm];
}

static enum pend_status section_check(const struct pend_section_problem *problem,
                                      struct pend_error *error) {
    if (!(problem->duration > 0 && isfinite(problem->duration)))
        return pend_fail(error, PEND_INVALID, -1, 0, "the duration must be greater than 0, got %g",
                         problem->duration);
    if (!(problem->period >= 0 && isfinite(problem->period) && isfinite(problem->first)))
        return pend_fail(error, PEND_INVALID, -1, 0, "the period must be 0 or more, got %g",
                         problem->period);
    if (problem->period > 0 &&
        !(fmax(problem->duration, fabs(problem->first)) / problem->period < 0x1p53))
        return pend_fail(error, PEND_INVALID, -1, 0, "a duration of %g s has too many periods",
                         problem->duration);
    if (!isfinite(problem->start))
        return pend_fail(error, PEND_INVALID, -1, 0, "the start must be a finite time");
    if (problem->period > 0) return PEND_OK;
    if (problem->arm < 0 || problem->arm >= problem->tree->n || !isfinite(problem->angle))
        return pend_fail(error, PEND_INVALID, problem->arm, 0,
                         "the section's arm or angle is invalid");
    if (problem->ways & ~(unsigned)(PEND_WAY_UP | PEND_WAY_DOWN) || !problem->ways)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "a section's direction must be up, down or both");
    return PEND_OK;
}

enum pend_status pend_section_new(struct pend_section **section,
                                  const struct pend_section_problem *problem,
                                  struct pend_error *error) {
    *section = NULL;
    PEND_TRY(section_check(problem, error));
    PEND_TRY(pend_loads_check_series(&problem->loads, error));
    PEND_TRY(pend_run_check_tree(problem->tree, error));
    const struct pend_method *method =
        pend_pieces_method(&pend_method_taylor, problem->loads.terms);
    size_t n = (size_t)problem->tree->n, looks = SECTION_LOOKS + 1;
    struct pend_section *made = calloc(1, sizeof *made + n * (3 * looks + 4) * sizeof(double));
    if (!made)
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for a section of %zu arms", n);
    made->problem = *problem;
    made->method = method;
    made->n = problem->tree->n;
    if (problem->period > 0) {
        made->problem.arm = 0; // not used in a stroboscopic section
        // index of the first instant after the start
        made->flash = floor(-problem->first / problem->period) + 1;
    }
    made->phi = (double *)(made + 1);
    made->rate = made->phi + n * looks;
    section_turn(made, made->rate + n * looks);
    section_aim(made, made->rest + 4 * n);
    struct pend_problem motion = {
        .tree = problem->tree,
        .loads = problem->loads,
        .phi = made->rest,
        .phi_low = made->rest_low,
        .rate = problem->rate,
        .rate_low = problem->rate_low,
        .times = {.count = 2, .start = problem->start, .span = problem->duration, .divisor = 1},
        .rtol = problem->rtol > 0 ? problem->rtol : pend_method_taylor.rtol_default,
        .atol = problem->atol,
        .accuracy = problem->accuracy};
    enum pend_status status = method->open(&made->stepper, &motion, error);
    if (status == PEND_OK) motion.loads = pend_pieces_loads(method, made->stepper, &problem->loads);
    if (status == PEND_OK && motion.accuracy > 0 && !pend_pieces_unestimated(motion.loads.terms))
        status = pend_horizon_new(&made->horizon, method, &motion, error);
    made->problem.phi = made->problem.rate = made->problem.phi_low = made->problem.rate_low = NULL;
    if (status == PEND_OK)
        *section = made;
    else
        pend_section_free(&made);
    assert(status != PEND_OK || section_valid(*section));
    return status;
}

void pend_section_free(struct pend_section **section) {
    if (!*section) return;
    pend_horizon_free(&(*section)->horizon);
    if ((*section)->stepper) (*section)->method->close(&(*section)->stepper);
    free(*section);
    *section = NULL;
}

double pend_section_held(const struct pend_section *section) {
    assert(section_valid(section));
    double reached = fmin(section->reached, section->problem.duration);
    return section->horizon ? fmin(pend_horizon_held(section->horizon, reached), reached) : NAN;
}

long pend_section_steps(const struct pend_section *section) {
    return section->method->counts(section->stepper).steps;
}

double pend_section_progress(const struct pend_section *section) {
    return fmin(1, section->reached / section->problem.duration);
}
