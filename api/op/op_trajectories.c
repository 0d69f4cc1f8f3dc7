/* POST /v1/trajectories: integrates a pendulum and answers samples of its motion.
 * Leaves to others: reading the parts of a request (*_json, samples), the integration
 * (core/integrate/run), the bytes (encode).
 * Invariant: at most one block of samples is held besides the answer. */
#include "api/op/op.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/read/method_json.h"
#include "api/op/samples.h"
#include "api/read/state_json.h"
#include "api/read/times_json.h"
#include "core/extended/trust.h"

static const char *const fields[] = {"pendulum", "initial", "times",    "method", "rtol",
                                     "atol",     "step",    "output",   "digits", "precision",
                                     "events",   "trust",   "accuracy", NULL};

/* constants of the estimated cost: s a step, s a step and arm, s a number of the answer as
 * text and as it is */
static const double step_seconds = 3e-7, arm_seconds = 6e-7, text_seconds = 4e-8,
                    binary_seconds = 1.5e-8;

/* steps for the fastest swing to go on by a radian, times what a step costs in steps of taylor's;
 * at default tolerances
 */
static const struct {
    const char *method;
    double steps;
} steps_a_radian[] = {{"taylor", 4}, {"linear", 0},   {"ode23", 6},     {"rkf45", 45},
                      {"rk8pd", 35}, {"msadams", 30}, {"symplectic", 1}};
static const double steps_of_others = 20;

/* how many times as long 32 digits take, the fixed step, and a comparison with 32 digits beside
 * the trajectory */
static const double extended_times = 25, quad_times = 2000, symplectic_times = 20, trust_times = 26;

/* arm-evaluations asked for at a time: about a millisecond */
static const double piece = 50000;

enum {
    SAMPLE_NUMBERS = 16384, /* of a block of samples */
    MOST_PARTS = 1000000,
    CARRIED = 4 /* changes with what trajectory_carry shows, or any `carry` of core */
};

struct trajectory {
    struct api_tree tree;
    struct api_states *start;
    struct api_times times;
    struct api_method method;
    struct api_outputs outputs;
    struct api_table table;
    const struct api_format *format;
    long step_cap;
    const char *step_name;  /* of the limit */
    double trust_tolerance; /* rad, 0 = not wanted */
    double until;   /* of its progress: where this part of a job ends; 1 = it is the last, or all */
    double earlier; /* s, of the parts before */

    /* once it runs */
    struct pend_run *run;
    struct pend_trust *trust; /* NULL where it is not wanted, or found out */
    struct api_samples *samples;
    struct api_writer *writer;
    int computed; /* all samples are there; what remains is to compare and to write */
    double trust_until;
    struct api_stats stats;
    char warning[API_WARNING_TEXT], energy_warning[API_WARNING_TEXT],
        loose_warning[API_WARNING_TEXT];
};

static void trajectory_free(void **state) {
    struct trajectory *trajectory = *state;
    if (!trajectory) return;
    api_writer_free(&trajectory->writer);
    api_samples_free(&trajectory->samples);
    pend_trust_free(&trajectory->trust);
    pend_run_free(&trajectory->run);
    api_times_clear(&trajectory->times);
    api_states_free(&trajectory->start);
    api_tree_clear(&trajectory->tree);
    free(trajectory);
    *state = NULL;
}

/* parts of the contract that are still to come */
static void refuse_future(const struct api_value *root, struct api_problem *problem) {
    struct api_value field = api_value_member(root, "events");
    if (api_value_kind(&field) != API_MISSING)
        api_value_fault(&field, problem, "is not served yet: leave it out");
}

/* reads true, false, or the largest error of an angle, rad */
static void read_trust(struct trajectory *trajectory, const struct api_value *root,
                       struct api_problem *problem) {
    static const double usual = 1e-6, least = 1e-12, most = 1;
    struct api_value field = api_value_member(root, "trust");
    enum api_kind kind = api_value_kind(&field);
    if (kind == API_MISSING) return;
    double value = api_value_number(&field);
    if (kind == API_BOOL && value == 0) api_value_usual(&field);
    if (kind != API_BOOL && !(kind == API_NUMBER && value >= least && value <= most)) {
        api_value_fault(&field, problem,
                        "must be true, false, or a number of radians from %g to %g", least, most);
        return;
    }
    trajectory->trust_tolerance = kind == API_BOOL && value != 0 ? usual : value;
}

/* work and heat are known by some methods only, of pendulums that have either */
static void check_exchange(const struct trajectory *trajectory, const struct api_value *output,
                           struct api_problem *problem) {
    const struct pend_method *method = trajectory->method.method;
    const struct pend_loads *loads = &trajectory->tree.loads;
    if (!method || method->exchange || !api_outputs_exchange(&trajectory->outputs)) return;
    if (loads->terms && !pend_terms_conserve(loads->terms, loads->value))
        api_value_fault(output, problem,
                        "\"exchange\", work and heat, is known by method taylor only");
}

static enum pend_status trajectory_read_parts(struct trajectory *trajectory,
                                              const struct api_reading *reading) {
    const struct api_value *root = reading->root;
    struct api_problem *problem = reading->problem;
    struct api_value initial = api_value_member(root, "initial");
    struct api_value times = api_value_member(root, "times"),
                     output = api_value_member(root, "output");
    struct api_value digits = api_value_member(root, "digits");
    long rounded = 0;
    (void)api_value_only(root, fields, problem);
    enum pend_status status = api_reading_tree(reading, &trajectory->tree);
    if (status == PEND_NO_MEMORY) return status;
    if (status == PEND_OK) PEND_TRY(api_states_new(&trajectory->start, 1, trajectory->tree.n));
    api_states_read(trajectory->start, 0, &initial, &trajectory->tree, reading->limits, problem);
    api_value_usual_object(&initial);
    status = api_times_read(&trajectory->times, &times, reading->limits, problem);
    if (status == PEND_NO_MEMORY) return status;
    api_method_read(&trajectory->method, root, &trajectory->tree, reading->limits, problem);
    api_outputs_read(&trajectory->outputs, &output, problem);
    (void)api_field_whole(&digits, 1, 17, &rounded, problem);
    trajectory->table.digits = (int)rounded;
    read_trust(trajectory, root, problem);
    check_exchange(trajectory, &output, problem);
    refuse_future(root, problem);
    return problem->status ? PEND_INVALID : PEND_OK;
}

/* adds a fault for an answer that would be too large, judged by its rows and columns */
static enum pend_status trajectory_check_size(struct trajectory *trajectory,
                                              const struct api_reading *reading) {
    struct api_table *table = &trajectory->table;
    struct api_value times = api_value_member(reading->root, "times");
    table->rows = trajectory->times.times.count;
    api_outputs_columns(&trajectory->outputs, trajectory->tree.n, table);
    api_reading_check_size(reading, table, &times, "rows", "fewer instants or outputs");
    return reading->problem->status ? PEND_INVALID : PEND_OK;
}

static enum pend_status trajectory_read(void **state, const struct api_reading *reading) {
    struct trajectory *trajectory = calloc(1, sizeof *trajectory);
    *state = trajectory;
    if (!trajectory) return PEND_NO_MEMORY;
    trajectory->format = reading->format;
    trajectory->step_cap = (long)reading->limits->steps;
    trajectory->step_name = api_limits_name(reading->limits, &reading->limits->steps);
    trajectory->until = 1;
    enum pend_status status = trajectory_read_parts(trajectory, reading);
    if (status == PEND_OK) status = trajectory_check_size(trajectory, reading);
    if (status != PEND_OK) trajectory_free(state);
    return status;
}

/* starts the integration */
static enum pend_status trajectory_begin(struct trajectory *trajectory, struct pend_error *error) {
    const struct api_method *method = &trajectory->method;
    PEND_TRY(api_states_settle(trajectory->start, &trajectory->tree, error));
    struct pend_problem problem = {.tree = trajectory->tree.tree,
                                   .loads = trajectory->tree.loads,
                                   .phi = trajectory->start->phi,
                                   .rate = trajectory->start->rate,
                                   .phi_low = trajectory->start->phi_low,
                                   .rate_low = trajectory->start->rate_low,
                                   .times = trajectory->times.times,
                                   .rtol = method->rtol,
                                   .atol = method->atol,
                                   .atol_given = method->atol_given,
                                   .step = method->step,
                                   .step_cap = trajectory->step_cap,
                                   .accuracy = method->accuracy};
    PEND_TRY(pend_run_new(&trajectory->run, method->method, &problem, error));
    problem.accuracy = 0; // the comparison is exact
    if (trajectory->trust_tolerance > 0)
        PEND_TRY(pend_trust_new(&trajectory->trust, method->method, &problem,
                                trajectory->trust_tolerance, error));
    return api_samples_new(&trajectory->samples, &trajectory->outputs, trajectory->tree.n,
                           trajectory->table.rows);
}

/* writes the horizon, and a warning if it is before the last instant */
static void trajectory_tell_horizon(struct trajectory *trajectory, double horizon) {
    const struct pend_times *times = &trajectory->times.times;
    api_stats_number(&trajectory->stats, "horizon", horizon);
    if (horizon == pend_times_at(times, times->count - 1)) return;
    snprintf(trajectory->warning, sizeof trajectory->warning,
             "digits are lost before the last instant: beyond t = %.6g s errors may be larger than "
             "%.3g (estimated). A "
             "smaller rtol or precision extended or quad carries them further. The field trust "
             "compares exactly.",
             horizon, trajectory->method.accuracy);
    api_stats_warning(&trajectory->stats, "warning_horizon", trajectory->warning);
}

/* adds warnings about an energy that has drifted, and about a precision that was not needed */
static void trajectory_tell_doubts(struct trajectory *trajectory, double drift) {
    static const double lost = 0.01, loose = 1e-16;
    const struct api_method *method = &trajectory->method;
    if (drift > lost) {
        snprintf(trajectory->energy_warning, sizeof trajectory->energy_warning,
                 "the energy was not kept: it is off by %.2g of what the tree can hold. The motion "
                 "told is another one. A "
                 "smaller rtol or method taylor or symplectic keeps it.",
                 drift);
        api_stats_warning(&trajectory->stats, "warning_energy", trajectory->energy_warning);
    }
    if (method->method == pend_method_taylor.extended &&
        (method->rtol > loose || method->atol > loose)) {
        snprintf(trajectory->loose_warning, sizeof trajectory->loose_warning,
                 "precision extended was asked for with an %s of %.3g: such digits doubles have "
                 "too and in less time. Leave "
                 "rtol and atol out to have 28.",
                 method->rtol > loose ? "rtol" : "atol",
                 method->rtol > loose ? method->rtol : method->atol);
        api_stats_warning(&trajectory->stats, "warning_precision", trajectory->loose_warning);
    }
}

/* writes the figures once, so that they are the same in every piece of the answer */
static void trajectory_tell(struct trajectory *trajectory, const struct api_turn *turn) {
    struct pend_run_stats stats = pend_run_stats(trajectory->run);
    struct api_stats *figures = &trajectory->stats;
    double seconds = api_turn_seconds(turn);
    api_stats_text(figures, "method", stats.method);
    api_stats_whole(figures, "steps", stats.steps);
    api_stats_whole(figures, "rejected", stats.rejected);
    api_stats_whole(figures, "evaluations", stats.evaluations);
    // not a number where the method does not know what drives and friction change
    if (!isnan(stats.energy_drift)) api_stats_number(figures, "energy_drift", stats.energy_drift);
    trajectory_tell_horizon(trajectory, stats.horizon);
    trajectory_tell_doubts(trajectory, stats.energy_drift);
    if (trajectory->trust_tolerance > 0)
        api_stats_number(figures, "trust_until", trajectory->trust_until);
    api_stats_origin(figures);
    if (seconds >= 0)
        api_stats_number(figures, "compute_seconds",
                         rint((seconds + trajectory->earlier) * 1e6) / 1e6);
}

/* how much of the computation is done, 0 .. 1 */
static double trajectory_progress(const struct trajectory *trajectory) {
    double sampled = pend_run_stats(trajectory->run).progress;
    if (trajectory->trust_tolerance <= 0) return sampled;
    double compared = trajectory->trust ? pend_trust_progress(trajectory->trust) : 1;
    return (sampled + trust_times * compared) / (1 + trust_times);
}

/* continues the comparison with 32 digits, once all samples are written */
static enum pend_status trajectory_compare(struct trajectory *trajectory,
                                           struct pend_error *error) {
    int done = 0;
    // an evaluation in 32 digits takes some ten times as long
    enum pend_status status = pend_trust_next(trajectory->trust, piece / 10, &done, error);
    if (status != PEND_OK || !done) return status;
    trajectory->trust_until = pend_trust_until(trajectory->trust);
    pend_trust_free(&trajectory->trust);
    return PEND_OK;
}

/* names the limit behind a failure, and the way out */
static void name_limit(const struct trajectory *trajectory, enum pend_status status,
                       struct pend_error *error) {
    size_t used = strlen(error->text);
    if (status == PEND_TOO_MANY_STEPS)
        snprintf(error->text + used, sizeof error->text - used,
                 " (%s): ask for a shorter time or a looser tolerance", trajectory->step_name);
}

/* writes the next samples, as many as one piece of work yields */
static enum pend_status trajectory_block(struct trajectory *trajectory, struct api_buffer *out,
                                         int *computed, struct pend_error *error) {
    struct api_samples *samples = trajectory->samples;
    enum pend_status status =
        pend_run_next(trajectory->run, &samples->samples, piece, computed, error);
    name_limit(trajectory, status, error);
    PEND_TRY(status);
    api_samples_derive(samples);
    // what a run hands out is finite; the sum of two energies need not be
    if (!samples->total)
        return api_writer_finite_block(trajectory->writer, samples->samples.count, samples->column,
                                       out);
    return api_writer_block(trajectory->writer, samples->samples.count, samples->column, out,
                            error);
}

static enum pend_status trajectory_finish(struct trajectory *trajectory,
                                          const struct api_turn *turn, int *done) {
    if (!trajectory->stats.count) trajectory_tell(trajectory, turn);
    return api_writer_finish(trajectory->writer, &trajectory->stats, turn->out, done);
}

static enum pend_status trajectory_run(void *state, const struct api_turn *turn, int *done,
                                       struct pend_error *error) {
    struct trajectory *trajectory = state;
    if (!trajectory->run) PEND_TRY(trajectory_begin(trajectory, error));
    if (!trajectory->writer)
        PEND_TRY(
            api_writer_new(&trajectory->writer, trajectory->format, &trajectory->table, turn->out));
    while (
        !(*done |= trajectory->until < 1 && trajectory_progress(trajectory) >= trajectory->until)) {
        if (trajectory->computed && trajectory->trust)
            PEND_TRY(trajectory_compare(trajectory, error));
        else if (trajectory->computed)
            PEND_TRY(trajectory_finish(trajectory, turn, done));
        else
            PEND_TRY(trajectory_block(trajectory, turn->out, &trajectory->computed, error));
        if (*done || api_turn_over(turn)) break;
    }
    if (*done && api_turn_seconds(turn) > 0) trajectory->earlier += api_turn_seconds(turn);
    return PEND_OK;
}

/* --- as a job */

static long trajectory_parts(const void *state) {
    const struct trajectory *trajectory = state;
    return pend_run_carries(trajectory->method.method) ? MOST_PARTS : 1;
}

static void trajectory_part(void *state, long number, long parts) {
    struct trajectory *trajectory = state;
    trajectory->until = (double)(number + 1) / (double)parts;
}

static enum pend_status trajectory_carry(void *state, struct pend_checkpoint *checkpoint,
                                         struct pend_error *error) {
    struct trajectory *trajectory = state;
    int version = CARRIED, trusts = trajectory->trust != NULL;
    if (!trajectory->run) PEND_TRY(trajectory_begin(trajectory, error));
    pend_checkpoint_part(checkpoint, &version, sizeof version);
    pend_checkpoint_part(checkpoint, &trusts, sizeof trusts);
    pend_checkpoint_part(checkpoint, &trajectory->computed, sizeof trajectory->computed);
    pend_checkpoint_row(checkpoint, &trajectory->earlier, 1);
    pend_checkpoint_row(checkpoint, &trajectory->trust_until, 1);
    if (version != CARRIED || (trusts && !trajectory->trust)) return PEND_INVALID;
    if (!trusts) pend_trust_free(&trajectory->trust);
    PEND_TRY(pend_run_carry(trajectory->run, checkpoint));
    return trusts ? pend_trust_carry(trajectory->trust, checkpoint) : PEND_OK;
}

static long trajectory_steps(const void *state) {
    const struct trajectory *trajectory = state;
    return trajectory->run ? pend_run_stats(trajectory->run).steps : 0;
}

/* a comparison with 32 digits may end long before its time, where the digits do: only the
 * samples are foreseen */
static void trajectory_done(const void *state, double *steps, double *work) {
    const struct trajectory *trajectory = state;
    int known = trajectory->run && !trajectory->computed;
    *steps = *work = known ? pend_run_stats(trajectory->run).progress : -1;
}

/* rad/s at which the fastest arm turns, about: as fast as the shortest arm swings, faster where
 * many hang on each other, and as the start has it */
static double trajectory_rate(const struct trajectory *trajectory) {
    const struct pend_tree *tree = trajectory->tree.tree;
    double shortest = INFINITY, rate = 0;
    for (int k = 0; k < tree->n; k++) {
        shortest = fmin(shortest, tree->len[k]);
        rate = fmax(rate, fabs(trajectory->start->rate[k]));
    }
    return rate + pend_loads_rate(&trajectory->tree.loads, tree) +
           sqrt(fabs(trajectory->tree.loads.gravity) / shortest * sqrt(tree->n));
}

static double trajectory_cost(const void *state) {
    const struct trajectory *trajectory = state;
    const struct api_table *table = &trajectory->table;
    const struct pend_times *times = &trajectory->times.times;
    double span = fabs(pend_times_at(times, times->count - 1) - pend_times_at(times, 0)),
           steps = steps_of_others;
    double numbers = (double)table->rows * api_table_numbers(table, 0);
    for (size_t i = 0; i < sizeof steps_a_radian / sizeof *steps_a_radian; i++)
        if (!strcmp(trajectory->method.method->name, steps_a_radian[i].method))
            steps = steps_a_radian[i].steps;
    steps *= span * trajectory_rate(trajectory);
    if (trajectory->method.step > 0) steps = span / trajectory->method.step;
    double times_as_long = trajectory->trust_tolerance > 0 ? 1 + trust_times : 1;
    if (trajectory->method.method == pend_method_taylor.extended)
        times_as_long = trajectory->trust_tolerance > 0 ? 2 * extended_times : extended_times;
    if (trajectory->method.method == &pend_method_taylor_quad)
        times_as_long = trajectory->trust_tolerance > 0 ? 2 * quad_times : quad_times;
    if (trajectory->method.method == &pend_method_symplectic) times_as_long = symplectic_times;
    return times_as_long * fmin(steps, (double)trajectory->step_cap) *
               (step_seconds + trajectory->tree.n * arm_seconds) +
           numbers * (trajectory->format->digits ? text_seconds : binary_seconds);
}

/* bytes that a method takes for each arm: its series, stages and scratch; small trees are filled
 * up to whole lanes */
static const struct {
    const char *method;
    double bytes;
} bytes_an_arm[] = {{"taylor", 9000}, {"symplectic", 16000}, {"linear", 6000}};
static const double bytes_of_others = 8000, bytes_of_extended = 30000, lane_arms = 16,
                    method_bytes = 32768;

/* numbers that `linear` takes for each pair of arms: its modes, and what they are made
 * orthogonal to */
static const double linear_numbers = 2.2;

static double trajectory_bytes(const void *state) {
    const struct trajectory *trajectory = state;
    double n = trajectory->tree.n, an_arm = bytes_of_others,
           row = api_table_numbers(&trajectory->table, 0);
    for (size_t i = 0; i < sizeof bytes_an_arm / sizeof *bytes_an_arm; i++)
        if (!strcmp(trajectory->method.method->name, bytes_an_arm[i].method))
            an_arm = bytes_an_arm[i].bytes;
    if (trajectory->method.method == pend_method_taylor.extended) an_arm = bytes_of_extended;
    if (trajectory->tree.loads.terms) an_arm *= 3; // more series, and a neighbour's of small trees
    if (trajectory->trust_tolerance > 0) an_arm = 2 * an_arm + bytes_of_extended;
    double square = trajectory->method.method == &pend_method_linear
                        ? linear_numbers * sizeof(double) * n * n
                        : 0;
    double list =
        trajectory->times.list ? (double)trajectory->times.times.count * sizeof(double) : 0;
    double block = fmin(SAMPLE_NUMBERS, (double)trajectory->table.rows * (row + 8)) + row + 8;
    return method_bytes + (n + lane_arms) * an_arm + square + list + 2 * sizeof(double) * block +
           api_tree_bytes(&trajectory->tree) + api_states_bytes(trajectory->start) +
           api_writer_bytes(trajectory->format, &trajectory->table);
}

static const struct api_table *trajectory_table(const void *state) {
    return &((const struct trajectory *)state)->table;
}

static const struct api_stats *trajectory_stats(const void *state) {
    return &((const struct trajectory *)state)->stats;
}

/* a client that asks for trust gets it or a refusal, in every representation */
static int trajectory_stats_first(const void *state) {
    return ((const struct trajectory *)state)->trust_tolerance > 0;
}

const struct api_op api_op_trajectories = {
    .name = "trajectories",
    .body = 1,
    .terms = 1,
    .samples = 1,
    .read = trajectory_read,
    .run = trajectory_run,
    .steps = trajectory_steps,
    .progress = trajectory_done,
    .table = trajectory_table,
    .cost = trajectory_cost,
    .bytes = trajectory_bytes,
    .parts = trajectory_parts,
    .part = trajectory_part,
    .carry = trajectory_carry,
    .stats = trajectory_stats,
    .stats_first = trajectory_stats_first,
    .free = trajectory_free,
};
