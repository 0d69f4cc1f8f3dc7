/* POST /v1/trajectories: integrates a pendulum and returns samples of its motion.
 * Leaves to others: reading the parts of a request (*_json, samples), the integration
 * (core/integrate/run/run), the bytes (encode).
 * Invariant: besides the answer, at most one block of samples is in memory. */
#include "api/op/op.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/op/events_json.h"
#include "api/op/form_json.h"
#include "api/op/trajectory_cost.h"
#include "api/op/trajectory_told.h"
#include "api/read/method_json.h"
#include "api/read/state_json.h"
#include "api/read/times_json.h"
#include "core/extended/trust.h"
#include "core/integrate/pieces/pieces.h"

static const char *const fields[] = {"pendulum", "initial", "times",    "method",      "rtol",
                                     "atol",     "step",    "output",   "digits",      "precision",
                                     "events",   "trust",   "accuracy", "derivatives", "rows",
                                     "number",   "none",    NULL};

/* cost of a comparison with 32 digits, relative to that of the trajectory */
static const double trust_times = API_TRAJECTORY_TRUST_TIMES;

/* arm evaluations per turn, about a millisecond */
static const double piece = 50000;

enum {
    MOST_PARTS = 1000000,
    CARRIED = 7 /* to be increased if trajectory_carry, or `carry` of core, changes */
};

struct trajectory {
    struct api_tree tree;
    struct api_states *start;
    struct api_times times;
    struct api_method method;
    struct api_outputs outputs;
    struct api_derived derived;
    struct api_events events;
    struct api_table table;
    const struct api_format *format;
    long step_cap;
    const char *step_name;  /* name of the limit on steps */
    double trust_tolerance; /* rad; 0 = no comparison */
    double until;   /* fraction of the progress at which this part of a job ends; 1 for the last or
                     * only part */
    double earlier; /* s used by the earlier parts */

    /* set while it runs */
    struct pend_run *run;
    struct pend_trust *trust; /* NULL if no comparison was requested, or once it is complete */
    struct api_samples *samples;
    struct api_writer *writer;
    long due, made; /* numbers of rows of `samples` that are not written yet, and of those with
                     * derivatives */
    int ended;      /* whether the run has ended; derivatives may still be missing */
    int computed;   /* whether all samples are computed; the comparison and the output remain */
    double trust_until;
    struct api_stats stats;
    struct api_trajectory_told told;
    char stiff_warning[API_WARNING_TEXT];
};

static void trajectory_clear(void *state) {
    struct trajectory *trajectory = state;
    api_writer_free(&trajectory->writer);
    api_samples_free(&trajectory->samples);
    api_derived_clear(&trajectory->derived);
    api_events_clear(&trajectory->events);
    pend_trust_free(&trajectory->trust);
    pend_run_free(&trajectory->run);
    api_times_clear(&trajectory->times);
    api_states_free(&trajectory->start);
    api_tree_clear(&trajectory->tree);
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
        api_value_fault(&field, problem, API_CODE_WRONG_TYPE "must be true, false, or %g to %g rad",
                        least, most);
        return;
    }
    if (value != 0 && !pend_pieces_smooth(trajectory->tree.terms))
        api_value_fault(&field, problem,
                        API_CODE_UNSUPPORTED
                        "compares with 32 digits, which dry friction and stops do not have: "
                        "compare with an rtol of 1e-15");
    trajectory->trust_tolerance = kind == API_BOOL && value != 0 ? usual : value;
}

/* reads the parameters of derivatives, which need a method that supports them */
static enum pend_status trajectory_read_derived(struct trajectory *trajectory,
                                                const struct api_value *root,
                                                struct api_problem *problem) {
    struct api_value value = api_value_member(root, "derivatives");
    enum pend_status status =
        api_derived_read(&trajectory->derived, &value, &trajectory->tree, problem);
    if (status == PEND_NO_MEMORY) return status;
    const struct pend_method *method = trajectory->method.method;
    if (trajectory->derived.count && method && method != &pend_method_taylor)
        api_value_fault(&value, problem,
                        API_CODE_UNSUPPORTED "need method taylor in double precision: leave out "
                                             "method and precision, or the derivatives");
    return PEND_OK;
}

/* adds an error for an answer that would be too large, judging by its rows and columns */
static enum pend_status trajectory_check_size(struct trajectory *trajectory,
                                              const struct api_reading *reading) {
    struct api_table *table = &trajectory->table;
    table->rows = trajectory->times.times.count;
    api_outputs_columns(&trajectory->outputs, trajectory->tree.n, table);
    api_events_columns(&trajectory->events, table);
    if (trajectory->derived.count)
        api_outputs_derived(&trajectory->outputs, API_MEMBER(reading->root, "derivatives"),
                            &trajectory->derived, table, reading->problem);
    api_reading_check_size(reading, table, API_MEMBER(reading->root, "times"), "rows",
                           "fewer instants or outputs");
    return reading->problem->status ? PEND_INVALID : PEND_OK;
}

static enum pend_status trajectory_read(void *state, const struct api_reading *reading) {
    struct trajectory *trajectory = state;
    const struct api_value *root = reading->root;
    struct api_problem *problem = reading->problem;
    struct api_value initial = api_value_member(root, "initial");
    struct api_value output = api_value_member(root, "output");
    trajectory->format = reading->format;
    trajectory->step_cap = (long)reading->limits->steps;
    trajectory->step_name = api_limits_name(reading->limits, &reading->limits->steps);
    trajectory->until = 1;
    (void)api_value_only(root, fields, problem);
    enum pend_status status = api_reading_tree(reading, &trajectory->tree);
    if (status == PEND_NO_MEMORY) return status;
    if (status == PEND_OK)
        PEND_TRY(api_states_new(&trajectory->start, 1, api_tree_stored(&trajectory->tree)));
    api_states_read(trajectory->start, 0, &initial, &trajectory->tree, reading->limits, problem);
    api_value_usual_object(&initial);
    status =
        api_times_read(&trajectory->times, API_MEMBER(root, "times"), reading->limits, problem);
    if (status == PEND_NO_MEMORY) return status;
    api_method_read(&trajectory->method, root, &trajectory->tree, reading->limits, problem);
    api_outputs_read(&trajectory->outputs, &output, problem);
    api_form_read(&trajectory->table, root, problem);
    read_trust(trajectory, root, problem);
    PEND_TRY(trajectory_read_derived(trajectory, root, problem));
    if (trajectory->tree.tree && !trajectory->tree.cart && api_outputs_cart(&trajectory->outputs))
        api_value_fault(&output, problem,
                        API_CODE_NOT_APPLICABLE
                        "has \"cart\", but the pendulum has no cart: give one in \"pivot\"");
    api_outputs_control(&trajectory->outputs, &trajectory->tree, &output, problem);
    api_events_read(&trajectory->events, reading, &trajectory->tree, trajectory->start,
                    &trajectory->method, &trajectory->times.times);
    return problem->status ? PEND_INVALID : trajectory_check_size(trajectory, reading);
}

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
    problem.accuracy = 0; // the comparison replaces the estimate
    if (trajectory->trust_tolerance > 0)
        PEND_TRY(pend_trust_new(&trajectory->trust, method->method, &problem,
                                trajectory->trust_tolerance, error));
    long rows = trajectory->table.rows;
    if (trajectory->derived.count) rows = api_derived_cap(&trajectory->derived, rows);
    PEND_TRY(api_samples_new(&trajectory->samples, &trajectory->outputs, trajectory->tree.n, rows));
    if (!trajectory->derived.count) return PEND_OK;
    return api_derived_begin(&trajectory->derived, &problem, trajectory->samples->samples.cap,
                             error);
}

static struct api_trajectory_size trajectory_size(const struct trajectory *trajectory) {
    return (struct api_trajectory_size){
        &trajectory->tree,   trajectory->start,    &trajectory->times,
        &trajectory->method, &trajectory->derived, &trajectory->events,
        &trajectory->table,  trajectory->format,   trajectory->trust_tolerance > 0,
        trajectory->step_cap};
}

/* writes the statistics once, so that they are the same in every piece of the answer */
static void trajectory_tell(struct trajectory *trajectory, const struct api_turn *turn) {
    struct pend_run_stats stats = pend_run_stats(trajectory->run);
    struct api_stats *figures = &trajectory->stats;
    double seconds = api_turn_seconds(turn);
    api_stats_text(figures, "method", stats.method);
    api_stats_whole(figures, "steps", stats.steps);
    api_stats_whole(figures, "rejected", stats.rejected);
    api_stats_whole(figures, "evaluations", stats.evaluations);
    const struct api_trajectory_motion motion = {.tree = &trajectory->tree,
                                                 .start = trajectory->start,
                                                 .times = &trajectory->times.times,
                                                 .method = &trajectory->method,
                                                 .tolerance = trajectory->trust_tolerance,
                                                 .trust_until = trajectory->trust_until};
    api_trajectory_tell(&trajectory->told, &motion, &stats, figures);
    if (api_trajectory_stiff(trajectory_size(trajectory), stats.steps, trajectory->stiff_warning))
        api_stats_warning(figures, "warning_stiff", trajectory->stiff_warning);
    if (trajectory->trust_tolerance > 0)
        api_stats_number(figures, "trust_until", trajectory->trust_until);
    if (trajectory->events.count)
        api_events_tell(&trajectory->events, &trajectory->times.times, figures);
    api_stats_origin(figures);
    if (seconds >= 0)
        api_stats_number(figures, "compute_seconds",
                         rint((seconds + trajectory->earlier) * 1e6) / 1e6);
}

/* the fraction of the samples and their derivatives that is computed, 0 .. 1 */
static double trajectory_sampled(const struct trajectory *trajectory) {
    double sampled = pend_run_stats(trajectory->run).progress;
    if (!trajectory->derived.motion) return sampled;
    return fmin(sampled, pend_derivatives_progress(trajectory->derived.motion));
}

static double trajectory_progress(const struct trajectory *trajectory) {
    double sampled = trajectory_sampled(trajectory);
    if (trajectory->trust_tolerance <= 0) return sampled;
    double compared = trajectory->trust ? pend_trust_progress(trajectory->trust) : 1;
    return (sampled + trust_times * compared) / (1 + trust_times);
}

/* continues the comparison with 32 digits, once all samples are written */
static enum pend_status trajectory_compare(struct trajectory *trajectory,
                                           struct pend_error *error) {
    int done = 0;
    // an evaluation in 32 digits takes about ten times as long
    enum pend_status status = pend_trust_next(trajectory->trust, piece / 10, &done, error);
    if (status != PEND_OK || !done) return status;
    trajectory->trust_until = pend_trust_until(trajectory->trust);
    pend_trust_free(&trajectory->trust);
    return PEND_OK;
}

static void name_limit(const struct trajectory *trajectory, enum pend_status status,
                       struct pend_error *error) {
    size_t used = strlen(error->text);
    if (status == PEND_TOO_MANY_STEPS)
        snprintf(error->text + used, sizeof error->text - used,
                 " (%s): ask for a shorter time or a looser tolerance", trajectory->step_name);
}

static enum pend_status trajectory_differentiate(struct trajectory *trajectory,
                                                 struct pend_error *error) {
    long more = 0, due = trajectory->due, made = trajectory->made;
    if (due == made) return PEND_OK;
    enum pend_status status =
        api_derived_next(&trajectory->derived, made, due - made, piece, &more, error);
    trajectory->made += more;
    name_limit(trajectory, status, error);
    return status;
}

/* writes the rows with their derivatives, once all derivatives are complete */
static enum pend_status trajectory_write_derived(struct trajectory *trajectory,
                                                 struct api_buffer *out, int *computed,
                                                 struct pend_error *error) {
    PEND_TRY(trajectory_differentiate(trajectory, error));
    if (trajectory->made < trajectory->due) return PEND_OK;
    const double *column[API_COLUMNS];
    int own = trajectory->table.count - trajectory->derived.columns;
    memcpy(column, trajectory->samples->column, (size_t)own * sizeof *column);
    api_derived_columns(&trajectory->derived, column + own);
    long rows = trajectory->due;
    trajectory->due = trajectory->made = 0;
    *computed = trajectory->ended;
    return api_writer_block(trajectory->writer, rows, column, out, error);
}

static enum pend_status trajectory_block(struct trajectory *trajectory, struct api_buffer *out,
                                         int *computed, struct pend_error *error) {
    struct api_samples *samples = trajectory->samples;
    if (trajectory->due) return trajectory_write_derived(trajectory, out, computed, error);
    int ended = 0;
    enum pend_status status =
        pend_run_next(trajectory->run, &samples->samples, piece, &ended, error);
    name_limit(trajectory, status, error);
    PEND_TRY(status);
    api_samples_derive(samples);
    if (trajectory->derived.count) {
        trajectory->due = samples->samples.count;
        trajectory->ended = ended;
        return PEND_OK;
    }
    *computed = ended;
    // samples of a run are finite, but the sum of two energies or a conversion to float may
    // overflow
    if (!samples->total && !trajectory->table.float32)
        return api_writer_finite_block(trajectory->writer, samples->samples.count, samples->column,
                                       out);
    return api_writer_block(trajectory->writer, samples->samples.count, samples->column, out,
                            error);
}

static enum pend_status trajectory_finish(struct trajectory *trajectory,
                                          const struct api_turn *turn, int *done) {
    if (!trajectory->stats.count) trajectory_tell(trajectory, turn);
    PEND_TRY(api_writer_finish(trajectory->writer, &trajectory->stats, turn->out, done));
    return *done ? api_events_append(&trajectory->events, trajectory->table.digits, turn->out)
                 : PEND_OK;
}

/* searches for events, then starts the answer; there is no writer yet if the turn ends first */
static enum pend_status trajectory_open(struct trajectory *trajectory, const struct api_turn *turn,
                                        struct pend_error *error) {
    struct api_events *events = &trajectory->events;
    struct pend_times *times = &trajectory->times.times;
    if (events->count && !events->searched) {
        PEND_TRY(api_states_settle(trajectory->start, &trajectory->tree, error));
        PEND_TRY(
            api_events_look(events, trajectory->start, &trajectory->method, times, turn, error));
        if (!events->searched) return PEND_OK;
        trajectory->table.rows = events->rows ? events->found : times->count;
    }
    if (!trajectory->run && !events->rows) PEND_TRY(trajectory_begin(trajectory, error));
    if (trajectory->writer) return PEND_OK;
    return api_writer_new(&trajectory->writer, trajectory->format, &trajectory->table, turn->out);
}

static enum pend_status trajectory_run(void *state, const struct api_turn *turn, int *done,
                                       struct pend_error *error) {
    struct trajectory *trajectory = state;
    PEND_TRY(trajectory_open(trajectory, turn, error));
    if (!trajectory->writer) return PEND_OK;
    if (trajectory->events.rows)
        return api_events_write(&trajectory->events, &trajectory->times.times, trajectory->writer,
                                &trajectory->stats, turn, done, error);
    while (!(*done |= trajectory->until < 1 && !trajectory->due &&
                      trajectory_progress(trajectory) >= trajectory->until)) {
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
    if (trajectory->events.count) return 1; // a part does not pass on its events
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
    if (trajectory->derived.motion)
        PEND_TRY(pend_derivatives_carry(trajectory->derived.motion, checkpoint));
    return trusts ? pend_trust_carry(trajectory->trust, checkpoint) : PEND_OK;
}

static long trajectory_steps(const void *state) {
    const struct trajectory *trajectory = state;
    const struct pend_events *search = trajectory->events.search;
    return (search ? pend_events_steps(search) : 0) +
           (trajectory->run ? pend_run_stats(trajectory->run).steps : 0);
}

/* a comparison with 32 digits may end early, when its accuracy is exhausted, so only the samples
 * are forecast */
static void trajectory_done(const void *state, double *steps, double *work) {
    const struct trajectory *trajectory = state;
    int known = trajectory->run && !trajectory->computed;
    *steps = *work = known ? trajectory_sampled(trajectory) : -1;
    if (trajectory->events.search && trajectory->events.rows)
        *steps = *work = pend_events_progress(trajectory->events.search);
}

static double trajectory_cost(const void *state) {
    return api_trajectory_cost_seconds(trajectory_size(state));
}

static const char *trajectory_way_out(const void *state) {
    return api_trajectory_way_out(trajectory_size(state));
}

static double trajectory_bytes(const void *state) {
    return api_trajectory_cost_bytes(trajectory_size(state));
}

/* a client that requests `trust` gets it or a refusal, in every representation */
static int trajectory_stats_first(const void *state) {
    return ((const struct trajectory *)state)->trust_tolerance > 0;
}

const struct api_op api_op_trajectories = {
    .name = "trajectories",
    .size = sizeof(struct trajectory),
    .body = 1,
    .terms = 1,
    .pieces = 1,
    .cart = 1,
    .samples = 1,
    .read = trajectory_read,
    .run = trajectory_run,
    .steps = trajectory_steps,
    .progress = trajectory_done,
    .table = offsetof(struct trajectory, table),
    .cost = trajectory_cost,
    .doubt = 3,
    .way_out = trajectory_way_out,
    .bytes = trajectory_bytes,
    .parts = trajectory_parts,
    .part = trajectory_part,
    .carry = trajectory_carry,
    .stats = offsetof(struct trajectory, stats),
    .stats_first = trajectory_stats_first,
    .clear = trajectory_clear,
};
