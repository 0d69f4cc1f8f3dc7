/* POST /v1/ensembles: many trajectories of one pendulum, reduced to the requested observables, or
 * whole.
 * Leaves to others: the request (ensemble), the ranges of members (member_range), the bytes
 * (encode).
 * Invariant: besides the answer, the raw rows of one range of members are in memory; rows are in
 * the order of the members. */
#include "api/op/op.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include "api/encode/encode.h"
#include "api/op/ensemble/member_range.h"

/* numbers and members per range: some megabytes, and enough members to keep the lanes busy */
enum {
    RANGE_NUMBERS = 1 << 20,
    RANGE_MEMBERS = API_ENSEMBLE_RANGE,
    RANGE_MEMBERS_LEAST = 8,
    PIECE_NUMBERS = 4096
};

struct ensembles {
    struct api_ensemble *ensemble;
    struct api_table table;
    const struct api_format *format;

    /* set once it runs */
    struct api_writer *writer;
    struct api_member_range *range; /* the range that is being computed, or NULL */
    double *raw;                    /* raw rows of the range */
    long range_most, first, count;  /* members per range; first member and number of members of the
                                     * current range */
    long begin, end;                /* members to compute: all, or those of a part */
    long written, rows;             /* rows of the range: written, and available */
    long failed, steps, lost;
    struct api_stats stats;
};

static void ensembles_clear(void *state) {
    struct ensembles *op = state;
    api_member_range_free(&op->range);
    api_writer_free(&op->writer);
    free(op->raw);
    api_ensemble_free(&op->ensemble);
}

static enum pend_status ensembles_read(void *state, const struct api_reading *reading) {
    struct ensembles *op = state;
    op->format = reading->format;
    enum pend_status status = api_ensemble_new(&op->ensemble, reading);
    if (status != PEND_OK) return status;
    op->end = api_ensemble_count(op->ensemble);
    op->table = op->ensemble->seen.table;
    return PEND_OK;
}

static long ensembles_parts(const void *state) {
    const struct ensembles *op = state;
    return 1 + (op->end - op->begin - 1) / RANGE_MEMBERS_LEAST;
}

static void ensembles_part(void *state, long number, long parts) {
    struct ensembles *op = state;
    long count = api_ensemble_count(op->ensemble), rows = op->table.rows / count;
    op->begin = op->first = (long)((double)count * (double)number / (double)parts);
    op->end = (long)((double)count * (double)(number + 1) / (double)parts);
    op->table.rows = rows * (op->end - op->begin);
}

/* numbers per member and members per range */
static double ensembles_numbers(const struct ensembles *op) {
    return (double)api_ensemble_rows(op->ensemble) * (double)api_ensemble_numbers(op->ensemble);
}

static double ensembles_range(const struct ensembles *op) {
    double most = fmin(fmax(floor(RANGE_NUMBERS / ensembles_numbers(op)), RANGE_MEMBERS_LEAST),
                       RANGE_MEMBERS);
    return fmin(most, (double)(op->end - op->begin));
}

static enum pend_status ensembles_begin(struct ensembles *op, struct api_buffer *out,
                                        struct pend_error *error) {
    double numbers = ensembles_numbers(op);
    op->range_most = (long)ensembles_range(op);
    PEND_TRY(api_ensemble_prepare(op->ensemble, error));
    op->raw = malloc((size_t)op->range_most * (size_t)numbers * sizeof *op->raw);
    if (!op->raw) return PEND_NO_MEMORY;
    return api_writer_new(&op->writer, op->format, &op->table, out);
}

static enum pend_status ensembles_compute(struct ensembles *op, struct pend_error *error) {
    int done = 0;
    if (!op->range) {
        long left = op->end - op->first;
        op->count = left < op->range_most ? left : op->range_most;
        op->written = op->rows = 0;
        PEND_TRY(
            api_member_range_new(&op->range, op->ensemble, op->first, op->count, op->raw, error));
    }
    PEND_TRY(api_member_range_go(op->range, &done, error));
    if (!done) return PEND_OK;
    struct api_member_range_stats stats = api_member_range_stats(op->range);
    op->failed += stats.failed;
    op->steps += stats.steps;
    op->lost += stats.lost;
    op->first += op->count;
    op->rows = stats.rows;
    api_member_range_free(&op->range);
    return PEND_OK;
}

static enum pend_status ensembles_write(struct ensembles *op, struct api_buffer *out,
                                        struct pend_error *error) {
    long numbers = api_ensemble_numbers(op->ensemble), rows = 1 + PIECE_NUMBERS / numbers;
    if (rows > op->rows - op->written) rows = op->rows - op->written;
    PEND_TRY(api_ensemble_write(op->ensemble, op->writer, rows, op->raw + op->written * numbers,
                                out, error));
    op->written += rows;
    return PEND_OK;
}

/* writes the statistics once, so that they are the same in every piece of the answer */
static void ensembles_tell(struct ensembles *op, const struct api_turn *turn) {
    api_stats_text(&op->stats, "method", "taylor");
    api_stats_whole(&op->stats, "members", op->end - op->begin);
    api_stats_whole(&op->stats, "failed", op->failed);
    api_stats_whole(&op->stats, "lost", op->lost);
    api_stats_whole(&op->stats, "steps", op->steps);
    // without the number, because that would count only this part
    if (op->lost)
        api_stats_warning(
            &op->stats, "warning_horizon",
            "some members lose their accuracy before their end (estimated): stats.lost counts "
            "them, and the observable horizon is the time up to which each is accurate");
    api_turn_tell(turn, 0, &op->stats);
}

static enum pend_status ensembles_run(void *state, const struct api_turn *turn, int *done,
                                      struct pend_error *error) {
    struct ensembles *op = state;
    if (!op->writer) PEND_TRY(ensembles_begin(op, turn->out, error));
    do {
        if (op->written < op->rows) {
            PEND_TRY(ensembles_write(op, turn->out, error));
        } else if (op->first < op->end) {
            PEND_TRY(ensembles_compute(op, error));
        } else {
            if (!op->stats.count) ensembles_tell(op, turn);
            PEND_TRY(api_writer_finish(op->writer, &op->stats, turn->out, done));
        }
    } while (!*done && !api_turn_over(turn));
    return PEND_OK;
}

static long ensembles_steps(const void *state) {
    const struct ensembles *op = state;
    return op->steps + (op->range ? api_member_range_stats(op->range).steps : 0);
}

static double ensembles_cost(const void *state) {
    const struct api_ensemble *ensemble = ((const struct ensembles *)state)->ensemble;
    return api_ensemble_cost(ensemble, api_ensemble_count(ensemble));
}

static double ensembles_bytes(const void *state) {
    const struct ensembles *op = state;
    const struct api_ensemble *ensemble = op->ensemble;
    double raw = ensembles_range(op) * ensembles_numbers(op) + PIECE_NUMBERS +
                 (double)api_ensemble_numbers(ensemble);
    return api_ensemble_bytes(ensemble) + raw * sizeof(double) +
           api_writer_bytes(op->format, &op->table);
}

const struct api_op api_op_ensembles = {
    .name = "ensembles",
    .size = sizeof(struct ensembles),
    .body = 1,
    .terms = 1,
    .pieces = 1,
    .cart = 1,
    .samples = 2,
    .read = ensembles_read,
    .run = ensembles_run,
    .steps = ensembles_steps,
    .table = offsetof(struct ensembles, table),
    .cost = ensembles_cost,
    .bytes = ensembles_bytes,
    .parts = ensembles_parts,
    .part = ensembles_part,
    .stats = offsetof(struct ensembles, stats),
    .clear = ensembles_clear,
};
