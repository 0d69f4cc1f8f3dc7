/* The operation table: one row an operation, with what it needs and how it is read, run and freed.
 * Leaves to others: the order of things in a request (call), the operations themselves (op_*).
 * Invariant: an operation's state points at nothing of the request once it was read. */
#ifndef API_OP_H
#define API_OP_H

#include "api/base/buffer.h"
#include "api/base/limits.h"
#include "api/base/problem.h"
#include "core/base/checkpoint.h"

/* The operations that a route can name. */
enum api_op_id {
    API_OP_TREES,
    API_OP_TRAJECTORIES,
    API_OP_FORCES,
    API_OP_MODES,
    API_OP_ENSEMBLES,
    API_OP_EQUATIONS,
    API_OP_LYAPUNOV,
    API_OP_SECTIONS,
    API_OP_PRESETS,
    API_OP_PRESET,
    API_OP_COUNT
};

enum { API_OP_SMALL_BYTES = 1 << 16 }; /* memory of an operation that does not tell what it takes */

struct api_format;
struct api_stats;
struct api_table;
struct api_value;

/* What an operation is read from. */
struct api_reading {
    const struct api_value *root; /* the body's JSON object; NULL for an operation without a body */
    const char *argument;         /* the variable part of the path, or NULL */
    const struct api_format *format; /* the representation that was negotiated */
    const struct api_limits *limits; /* outlives the operation */
    struct api_problem *problem;     /* receives every fault */
};

/* One turn of a running operation. */
struct api_turn {
    struct api_buffer *out;
    double (*now)(void *context); /* s; NULL without a clock */
    void *context;
    int (*hurry)(
        void *company); /* does somebody wait who should not wait long?; NULL = nobody does */
    void *company;
    double begun;   /* s, by the clock, when this turn began */
    double earlier; /* s, spent in the turns before */
    size_t before;  /* bytes of out when this turn began */
};

/** Seconds of computation so far, all turns together; -1 without a clock. */
double api_turn_seconds(const struct api_turn *turn);

/**
 * True once the turn has lasted about a millisecond, a quarter of one where there is hurry, or
 * appended 256 KiB; without a clock always, so that a turn is one piece of work.
 */
int api_turn_over(const struct api_turn *turn);

struct api_op {
    const char *name; /* as in the route: "trajectories" */
    int body;         /* needs a JSON body */
    int samples; /* 1: returns samples, in every representation and not JSON alone; 2: may be drawn,
                    too */

    /**
     * Reads and checks the request.
     *
     * state  out; NULL on failure. Frees with the row's free.
     *
     * PEND_INVALID   every fault found is in reading->problem.
     * PEND_NO_MEMORY
     */
    enum pend_status (*read)(void **state, const struct api_reading *reading);
    /**
     * Computes on until the turn is over or all is done, and appends to the answer.
     *
     * done   set non-zero once the answer is complete.
     * error  says why a turn failed.
     */
    enum pend_status (*run)(void *state, const struct api_turn *turn, int *done,
                            struct pend_error *error);
    /** Integration steps so far; NULL for an operation that takes none. */
    long (*steps)(const void *state);
    /**
     * How much of the integration steps, and of all the work, is done: 0 .. 1, or < 0 where that
     * cannot be told. NULL:
     * it never can. O(1).
     */
    void (*progress)(const void *state, double *steps, double *work);
    /** The table that the answer is; NULL for an operation without samples. */
    const struct api_table *(*table)(const void *state);
    /** An estimate of the computation, s; NULL where it does not matter. */
    double (*cost)(const void *state);
    /**
     * Bytes of memory that the state holds and will hold until the next turn is over: an upper
     * bound, within a factor of about two for what is large. Called before the first turn and
     * between turns, so that memory is counted before it is taken. NULL: never more than
     * API_OP_SMALL_BYTES. O(1).
     */
    double (*bytes)(const void *state);
    /** The most parts that its rows can be computed in, each by itself; NULL: it is one piece. */
    long (*parts)(const void *state);
    /** Leaves all but part `number` of `parts` out; before the first run. */
    void (*part)(void *state, long number, long parts);
    int rows_later; /* its table's rows are known only once it runs: until then they are the most
                       that there can be */
    /**
     * Shows a checkpoint all that the next part needs of this one, once this one is complete; where
     * the checkpoint puts it back, after `part` and before the first run. NULL: parts need not know
     * of each other.
     */
    enum pend_status (*carry)(void *state, struct pend_checkpoint *checkpoint,
                              struct pend_error *error);
    /** What is told of the computation beside its rows, once it is complete; NULL: nothing is. */
    const struct api_stats *(*told)(const void *state);
    /** True where that is to be known before the answer's first byte in representations that have
     * no place for it. */
    int (*told_first)(const void *state);
    /**
     * Has a state whose raw answer is complete answer once more, as JSON, which says more than its
     * table does; nothing is computed again. NULL: the table says all.
     */
    void (*json)(void *state);
    void (*free)(void **state);
};

extern const struct api_op api_op_trees, api_op_trajectories, api_op_forces, api_op_modes,
    api_op_ensembles, api_op_equations, api_op_lyapunov, api_op_sections, api_op_presets,
    api_op_preset;

/**
 * Faults an answer that is held in memory and would be larger than max-answer-bytes.
 *
 * value  what asks for so much.
 * what   "instants", and how to ask for less: "fewer instants or outputs".
 */
void api_reading_check_size(const struct api_reading *reading, const struct api_table *table,
                            const struct api_value *value, const char *what, const char *fewer);

/** The row of an operation. */
const struct api_op *api_op_at(enum api_op_id id);

#endif
