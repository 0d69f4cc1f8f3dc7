/* POST /v1/lyapunov: the Lyapunov exponents of a motion, and their convergence in time.
 * Leaves to others: reading (tree_json, state_json), the exponents (core/ensemble/lyapunov), the
 * bytes (encode).
 * Invariant: row i is the estimate over the first i + 1 spans of the duration. */
#include "api/op/op.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/encode.h"
#include "api/op/derived.h"
#include "api/read/state_json.h"
#include "core/ensemble/lyapunov.h"
#include "core/integrate/run/run.h"

static const char *const fields[] = {"pendulum",  "initial", "time",  "start",  "duration",
                                     "transient", "samples", "count", "digits", NULL};

enum { SAMPLES_USUAL = 100, ROWS = 64, PIECE = 20000 };

/* longest duration; constants of the estimated cost: s per step and arm of one motion, s per
 * product */
static const double duration_most = 1e9, arm_seconds = 1e-6, product_seconds = 1e-9;

/* radians by which the fastest arm turns between two orthonormalizations */
static const double turn = 0.3;

/* the growth, as a power of e, by which the rounding error of a start reaches the usual accuracy;
 * accelerations relative to g / l below which a start at rest hardly moves */
static const double lost_growth = 23, still = 0.01;

struct lyapunov {
    struct api_tree tree;
    struct api_states *start;
    double origin, duration, transient; /* s; origin: the start in the request's time */
    int count;
    struct api_table table;
    const struct api_format *format;
    double step_cap;
    const char *step_name; /* name of the limit on steps */

    /* set while it runs */
    struct pend_lyapunov *exponents;
    struct api_writer *writer;
    double interval;
    long a_row, skip;   /* intervals per row; intervals of the transient */
    long intervals;     /* number of finished intervals, including the transient */
    double *column[3];  /* t, the exponents and their errors, for up to ROWS rows; pointers into one
                         * block */
    long rows, written; /* rows in the block, and rows written before it */
    int balanced;       /* whether the start is at rest near an equilibrium */
    double grown;       /* logarithm of the growth during the transient */
    double horizon;     /* s since the start; 0 = not reached */
    struct api_stats stats;
    char warning[API_WARNING_TEXT];
};

static void lyapunov_clear(void *state) {
    struct lyapunov *lyapunov = state;
    free(lyapunov->column[0]);
    api_writer_free(&lyapunov->writer);
    pend_lyapunov_free(&lyapunov->exponents);
    api_states_free(&lyapunov->start);
    api_tree_clear(&lyapunov->tree);
}

/* --- reading --- */

static void lyapunov_read_count(struct lyapunov *lyapunov, const struct api_value *count,
                                struct api_problem *problem) {
    const char *text = api_value_text(count);
    long most = 2L * api_tree_stored(&lyapunov->tree), wanted = 1;
    if (text && !strcmp(text, "all")) {
        wanted = most;
    } else if (text) {
        api_value_fault(count, problem,
                        API_CODE_WRONG_TYPE
                        "must be a number of exponents from 1 to %ld, or \"all\", got \"%.40s\"",
                        most, text);
    } else if (lyapunov->tree.n) {
        (void)api_field_whole(count, 1, most, &wanted, problem);
    }
    lyapunov->count = (int)(wanted > 0 ? wanted : 1);
}

static enum pend_status lyapunov_check_size(struct lyapunov *lyapunov,
                                            const struct api_reading *reading) {
    double bytes = 8.0 * 6 * api_tree_stored(&lyapunov->tree) * (lyapunov->count + 1);
    api_table_add(&lyapunov->table, "t", NULL, 0);
    api_table_add(&lyapunov->table, "exponents", NULL, lyapunov->count);
    api_table_add(&lyapunov->table, "error", NULL, lyapunov->count);
    if (bytes > reading->limits->answer_bytes)
        api_value_fault(API_MEMBER(reading->root, "count"), reading->problem,
                        API_CODE_LIMIT
                        "asks for %d directions in %d dimensions, %.0f bytes, more than the limit "
                        "max-answer-bytes of %.0f: ask for fewer",
                        lyapunov->count, 2 * api_tree_stored(&lyapunov->tree), bytes,
                        reading->limits->answer_bytes);
    api_reading_check_size(reading, &lyapunov->table, reading->root, "samples",
                           "fewer samples or exponents");
    return reading->problem->status ? PEND_INVALID : PEND_OK;
}

static enum pend_status lyapunov_read(void *state, const struct api_reading *reading) {
    struct lyapunov *lyapunov = state;
    const struct api_value *root = reading->root;
    struct api_problem *problem = reading->problem;
    struct api_value duration = api_value_member(root, "duration"),
                     start = api_field_renamed(root, "time", "start", problem);
    long rounded = 0, rows = SAMPLES_USUAL;
    lyapunov->format = reading->format;
    lyapunov->step_cap = reading->limits->steps;
    lyapunov->step_name = api_limits_name(reading->limits, &reading->limits->steps);
    (void)api_value_only(root, fields, problem);
    enum pend_status status = api_reading_tree(reading, &lyapunov->tree);
    if (status == PEND_NO_MEMORY) return status;
    if (status == PEND_OK)
        PEND_TRY(api_states_new(&lyapunov->start, 1, api_tree_stored(&lyapunov->tree)));
    api_states_read(lyapunov->start, 0, API_MEMBER(root, "initial"), &lyapunov->tree,
                    reading->limits, problem);
    (void)api_value_read_number(&start, -duration_most, duration_most, "s", &lyapunov->origin,
                                problem);
    api_value_usual_number(&start, 0);
    if (api_field_needed(&duration, problem))
        (void)api_value_read_number(&duration, 1e-9, duration_most, "s", &lyapunov->duration,
                                    problem);
    (void)api_value_read_number(API_MEMBER(root, "transient"), 0, duration_most, "s",
                                &lyapunov->transient, problem);
    (void)api_field_whole(API_MEMBER(root, "samples"), 1, (long)reading->limits->samples, &rows,
                          problem);
    lyapunov_read_count(lyapunov, API_MEMBER(root, "count"), problem);
    (void)api_field_whole(API_MEMBER(root, "digits"), 1, 17, &rounded, problem);
    lyapunov->table.digits = (int)rounded;
    lyapunov->table.rows = rows;
    return problem->status ? PEND_INVALID : lyapunov_check_size(lyapunov, reading);
}

/* --- running --- */

/* intervals per row, so that in none the fastest arm turns by more than `turn` */
static double lyapunov_intervals(const struct lyapunov *lyapunov) {
    double row = lyapunov->duration / (double)lyapunov->table.rows;
    return fmax(1, ceil(row * api_swing(&lyapunov->tree, lyapunov->start) / turn));
}

/* determines whether the start is at rest with almost no acceleration and without a drive */
static enum pend_status lyapunov_balance(struct lyapunov *lyapunov,
                                         const struct pend_lyapunov_problem *start,
                                         struct pend_error *error) {
    const struct pend_terms *terms = start->loads.terms;
    struct pend_problem problem = {.tree = start->tree,
                                   .loads = start->loads,
                                   .phi = start->phi,
                                   .rate = start->rate,
                                   .phi_low = start->phi_low,
                                   .times = {.count = 1, .start = start->start, .divisor = 1}};
    double t, least = api_swing(&lyapunov->tree, lyapunov->start), most = 0;
    size_t n = (size_t)start->tree->n;
    double *acc = calloc(n, sizeof *acc);
    struct pend_samples samples = {.cap = 1, .t = &t, .acc = acc};
    struct pend_run *run = NULL;
    int done = 0;
    enum pend_status status = acc ? PEND_OK : PEND_NO_MEMORY;
    if (status == PEND_OK) status = pend_run_new(&run, &pend_method_taylor, &problem, error);
    if (status == PEND_OK) status = pend_run_next(run, &samples, INFINITY, &done, error);
    for (size_t k = 0; k < n && status == PEND_OK; k++)
        most = fmax(most, fmax(fabs(acc[k]) / least, fabs(start->rate[k])));
    lyapunov->balanced = most <= still * least && !(terms && terms->harmonics);
    pend_run_free(&run);
    free(acc);
    return status;
}

static enum pend_status lyapunov_begin(struct lyapunov *lyapunov, struct api_buffer *out,
                                       struct pend_error *error) {
    size_t count = (size_t)lyapunov->count, width = 1 + 2 * count;
    PEND_TRY(api_states_settle(lyapunov->start, &lyapunov->tree, error));
    double a_row = lyapunov_intervals(lyapunov);
    lyapunov->interval = lyapunov->duration / (double)lyapunov->table.rows / a_row;
    double skip = ceil(lyapunov->transient / lyapunov->interval);
    if (!(a_row * (double)lyapunov->table.rows + skip < lyapunov->step_cap))
        return pend_fail(error, PEND_TOO_MANY_STEPS, -1, 0,
                         "this takes at least %.3g steps, more than the limit %s of %.0f: ask for "
                         "a shorter time",
                         a_row * (double)lyapunov->table.rows + skip, lyapunov->step_name,
                         lyapunov->step_cap);
    lyapunov->a_row = (long)a_row;
    lyapunov->skip = (long)skip;
    lyapunov->column[0] = malloc(ROWS * width * sizeof(double));
    if (!lyapunov->column[0])
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "no memory for %zu exponents", count);
    lyapunov->column[1] = lyapunov->column[0] + ROWS;
    lyapunov->column[2] = lyapunov->column[1] + ROWS * count;
    const struct pend_lyapunov_problem problem = {.tree = lyapunov->tree.tree,
                                                  .loads = lyapunov->tree.loads,
                                                  .phi = lyapunov->start->phi,
                                                  .phi_low = lyapunov->start->phi_low,
                                                  .rate = lyapunov->start->rate,
                                                  .count = lyapunov->count,
                                                  .interval = lyapunov->interval,
                                                  .start = lyapunov->origin};
    PEND_TRY(lyapunov_balance(lyapunov, &problem, error));
    PEND_TRY(pend_lyapunov_new(&lyapunov->exponents, &problem, error));
    return api_writer_new(&lyapunov->writer, lyapunov->format, &lyapunov->table, out);
}

/* notes when the initial rounding error has grown to the usual accuracy */
static void lyapunov_watch(struct lyapunov *lyapunov) {
    // the row that is not filled yet
    double *exponent = lyapunov->column[1] + lyapunov->rows * lyapunov->count;
    long over = lyapunov->intervals - lyapunov->skip, since = over > 0 ? over : lyapunov->intervals;
    if (lyapunov->horizon > 0) return;
    pend_lyapunov_exponents(lyapunov->exponents, exponent);
    double grown = lyapunov->grown + exponent[0] * (double)since * lyapunov->interval;
    if (over == 0) lyapunov->grown = grown;
    if (grown >= lost_growth) lyapunov->horizon = (double)lyapunov->intervals * lyapunov->interval;
}

static enum pend_status lyapunov_step(struct lyapunov *lyapunov, struct api_buffer *out,
                                      struct pend_error *error) {
    long over = ++lyapunov->intervals - lyapunov->skip;
    lyapunov_watch(lyapunov);
    if (over == 0) pend_lyapunov_forget(lyapunov->exponents);
    if (over <= 0 || over % lyapunov->a_row) return PEND_OK;
    long row = over / lyapunov->a_row;
    lyapunov->column[0][lyapunov->rows] =
        (double)row * lyapunov->duration / (double)lyapunov->table.rows;
    pend_lyapunov_exponents(lyapunov->exponents,
                            lyapunov->column[1] + lyapunov->rows * lyapunov->count);
    pend_lyapunov_errors(lyapunov->exponents,
                         lyapunov->column[2] + lyapunov->rows * lyapunov->count);
    long rows = ++lyapunov->rows;
    if (rows < ROWS && row < lyapunov->table.rows) return PEND_OK;
    lyapunov->written += rows;
    lyapunov->rows = 0;
    return api_writer_block(lyapunov->writer, rows, (const double *const *)lyapunov->column, out,
                            error);
}

static enum pend_status lyapunov_piece(struct lyapunov *lyapunov, struct api_buffer *out,
                                       struct pend_error *error) {
    long steps = PIECE / (api_tree_stored(&lyapunov->tree) * 8L);
    int over = 0;
    PEND_TRY(pend_lyapunov_go(lyapunov->exponents, steps > 0 ? steps : 1, &over, error));
    if ((double)pend_lyapunov_steps(lyapunov->exponents) > lyapunov->step_cap)
        return pend_fail(
            error, PEND_TOO_MANY_STEPS, -1, 0,
            "more steps than the limit %s of %.0f: ask for a shorter time or fewer exponents",
            lyapunov->step_name, lyapunov->step_cap);
    return over ? lyapunov_step(lyapunov, out, error) : PEND_OK;
}

static void lyapunov_tell(struct lyapunov *lyapunov, const struct api_turn *turn_) {
    struct api_stats *stats = &lyapunov->stats;
    api_stats_whole(stats, "steps", pend_lyapunov_steps(lyapunov->exponents));
    api_stats_number(stats, "interval", lyapunov->interval);
    api_stats_number(stats, "frequency", pend_lyapunov_frequency(lyapunov->exponents));
    double end = lyapunov->duration + lyapunov->transient, held = lyapunov->horizon;
    api_stats_number(stats, "horizon", lyapunov->origin + (held > 0 ? fmin(held, end) : end));
    if (lyapunov->balanced && held > 0) {
        snprintf(lyapunov->warning, sizeof lyapunov->warning,
                 "the start is at rest near an unstable equilibrium: the exponents are first those "
                 "of the equilibrium, then those of the motion that leaves it. Rounding determines "
                 "that motion after t = %.3g s.",
                 lyapunov->origin + held);
        api_stats_warning(stats, "warning_equilibrium", lyapunov->warning);
    }
    api_turn_tell(turn_, 0, stats);
}

static enum pend_status lyapunov_run(void *state, const struct api_turn *turn_, int *done,
                                     struct pend_error *error) {
    struct lyapunov *lyapunov = state;
    if (!lyapunov->writer) PEND_TRY(lyapunov_begin(lyapunov, turn_->out, error));
    do {
        if (lyapunov->written < lyapunov->table.rows) {
            PEND_TRY(lyapunov_piece(lyapunov, turn_->out, error));
            continue;
        }
        if (!lyapunov->stats.count) lyapunov_tell(lyapunov, turn_);
        PEND_TRY(api_writer_finish(lyapunov->writer, &lyapunov->stats, turn_->out, done));
    } while (!*done && !api_turn_over(turn_));
    return PEND_OK;
}

static long lyapunov_steps(const void *state) {
    const struct lyapunov *lyapunov = state;
    return lyapunov->exponents ? pend_lyapunov_steps(lyapunov->exponents) : 0;
}

static void lyapunov_progress(const void *state, double *steps, double *work) {
    const struct lyapunov *lyapunov = state;
    double all = (double)lyapunov->a_row * (double)lyapunov->table.rows + (double)lyapunov->skip;
    *steps = *work = all > 0 ? (double)lyapunov->intervals / all : -1;
}

static double lyapunov_cost(const void *state) {
    const struct lyapunov *lyapunov = state;
    double n = api_tree_stored(&lyapunov->tree), count = lyapunov->count;
    double intervals = lyapunov_intervals(lyapunov) * (double)lyapunov->table.rows;
    // springs and drives take more steps in intervals of the same length
    double spring = 2 * api_terms_pace(&lyapunov->tree);
    intervals = fmax(intervals, lyapunov->duration * spring);
    intervals *= 1 + lyapunov->transient / lyapunov->duration;
    return intervals *
           (2 * (2 * count + 1) * (n + 4) * arm_seconds + 4 * count * count * n * product_seconds);
}

static double lyapunov_bytes(const void *state) {
    const struct lyapunov *lyapunov = state;
    double n = api_tree_stored(&lyapunov->tree), count = lyapunov->count;
    // real pendulums have more series
    double an_arm = lyapunov->tree.loads.terms ? 54000 : 16000;
    return 32768 + (n + 16) * an_arm +
           sizeof(double) * (8 * n * (count + 1) + (2 + 32) * count + ROWS * (1 + 2 * count)) +
           api_tree_bytes(&lyapunov->tree) + api_states_bytes(lyapunov->start) +
           api_writer_bytes(lyapunov->format, &lyapunov->table);
}

const struct api_op api_op_lyapunov = {.name = "lyapunov",
                                       .size = sizeof(struct lyapunov),
                                       .body = 1,
                                       .terms = 1,
                                       .cart = 1,
                                       .samples = 1,
                                       .read = lyapunov_read,
                                       .run = lyapunov_run,
                                       .steps = lyapunov_steps,
                                       .progress = lyapunov_progress,
                                       .table = offsetof(struct lyapunov, table),
                                       .cost = lyapunov_cost,
                                       .doubt = 5,
                                       .stats = offsetof(struct lyapunov, stats),
                                       .bytes = lyapunov_bytes,
                                       .clear = lyapunov_clear};
