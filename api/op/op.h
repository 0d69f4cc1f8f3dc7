/* The table of operations: each with its properties and the functions that read, run and free it.
 * Leaves to others: the sequence of a request (call), the operations themselves (op_*).
 * Invariant: after reading, an operation's state contains no pointer into the request. */
#pragma once

#include "api/base/buffer.h"
#include "api/base/limits.h"
#include "api/base/problem.h"
#include "api/read/tree_json.h"
#include "core/base/checkpoint.h"

/* The operations, each of which has a route. */
enum api_op_id {
    API_OP_TREES,
    API_OP_TRAJECTORIES,
    API_OP_FORCES,
    API_OP_MODES,
    API_OP_ENSEMBLES,
    API_OP_EQUATIONS,
    API_OP_LYAPUNOV,
    API_OP_SECTIONS,
    API_OP_RESPONSE,
    API_OP_CONTROLLERS,
    API_OP_FITS,
    API_OP_TABLES,
    API_OP_TRIALS,
    API_OP_ORBITS,
    API_OP_PRESETS,
    API_OP_PRESET,
    API_OP_COUNT
};

enum { API_OP_SMALL_BYTES = 1 << 16 }; /* memory of an operation without a `bytes` function */

struct api_format;
struct api_op;
struct api_stats;
struct api_table;

/* The input from which an operation is read. */
struct api_reading {
    const struct api_op *op;      /* the operation that reads it */
    const struct api_value *root; /* the body's JSON object; NULL for an operation without a body */
    const char *argument;         /* the variable part of the path, or NULL */
    const struct api_format *format; /* the negotiated representation */
    const struct api_limits *limits; /* outlives the operation */
    struct api_problem *problem;     /* receives every error */
};

/* One turn of a running operation. */
struct api_turn {
    struct api_buffer *out;
    double (*now)(void *context); /* s; NULL without a clock */
    void *context;
    int (*hurry)(void *company); /* returns true if other work is urgent; NULL = no other work is */
    void *company;
    struct api_problem *problem; /* receives errors that concern a field of the request; NULL = none
                                  * can be reported */
    double begun;                /* s, time by the clock at which this turn began */
    double earlier;              /* s, duration of the earlier turns */
    size_t before;               /* bytes in `out` when this turn began */
};

/** Returns the seconds of computation so far, all turns together; -1 without a clock. */
double api_turn_seconds(const struct api_turn *turn);

/** Returns true once the turn has lasted about a millisecond (a quarter of that if other work is
 * urgent) or has appended 256 KiB. Without a clock always true, so that a turn is one piece of
 * work. */
int api_turn_over(const struct api_turn *turn);

/** Adds the version, the engine and the seconds of computation: those of the turns plus `more`; no
 * seconds without a clock. */
void api_turn_tell(const struct api_turn *turn, double more, struct api_stats *stats);

/** Ends an answer that is one JSON object: appends `stats` with these values, and the brace. */
PEND_MUST_CHECK enum pend_status api_turn_close(const struct api_turn *turn);

struct api_op {
    const char *name; /* name in the route: "trajectories" */
    size_t size;      /* bytes of the operation's state */
    int body;         /* whether the operation needs a JSON body */
    int form;         /* whether a form with files is accepted too: JSON, and tables for `data` */
    int terms;        /* whether terms of real pendulums are supported */
    int pieces;       /* whether motions in pieces, due to tables and other rules, are supported */
    int cart;    /* whether a cart is supported, whose position is one more number of a state */
    int samples; /* 0: only JSON; 1: a table of samples, in every representation except pictures; 2:
                  * a table that can also be drawn */

    /**
     * Reads and checks the request.
     *
     * state  `size` bytes of 0.
     *
     * PEND_INVALID   every error that was found is in reading->problem.
     * PEND_NO_MEMORY
     */
    enum pend_status (*read)(void *state, const struct api_reading *reading);
    /**
     * Continues the computation until the turn is over or the answer is complete, and appends to
     * it.
     *
     * done   set non-zero once the answer is complete.
     * error  the reason of a failure.
     */
    enum pend_status (*run)(void *state, const struct api_turn *turn, int *done,
                            struct pend_error *error);
    /** Returns the integration steps so far; NULL if the operation does not integrate. */
    long (*steps)(const void *state);
    /** Estimates the completed fractions of the integration steps and of all the work: 0 .. 1, or <
     * 0 if unknown. NULL if always unknown. O(1). */
    void (*progress)(const void *state, double *steps, double *work);
    size_t
        table; /* offset of the answer's table in the state; 0 for an operation without samples */
    size_t stats; /* offset of the statistics, which are valid once the computation is complete; 0
                   * if there are none */
    /** Estimates the time of the computation, s; NULL if it is short. */
    double (*cost)(const void *state);
    /** The factor by which the estimate may be too long. A request that exceeds the limit by more
     * is refused before it starts. 0 = never refuse. */
    double doubt;
    /** Returns advice on how to shorten this computation, "ask for ..."; NULL if that is a shorter
     * time or a looser tolerance. O(n). */
    const char *(*way_out)(const void *state);
    /** Returns an upper bound of the bytes of memory that the state has or will have until the next
     * turn ends, within a factor of about two if it is large. Called before the first turn and
     * between turns, so that memory is counted before it is allocated. NULL if it is never more
     * than API_OP_SMALL_BYTES. O(1). */
    double (*bytes)(const void *state);
    /** Returns the largest number of parts into which its rows can be divided; NULL if there is
     * only one. */
    long (*parts)(const void *state);
    /** Restricts the state to part `number` of `parts`; called before the first run. */
    void (*part)(void *state, long number, long parts);
    /** Passes all values that the next part needs through a checkpoint: either saves them, once
     * this part is complete, or restores them, after `part` and before the first run. NULL if the
     * parts are independent. */
    enum pend_status (*carry)(void *state, struct pend_checkpoint *checkpoint,
                              struct pend_error *error);
    /** Returns true if a representation without statistics must be sent after they are known,
     * because the client needs them in the header. */
    int (*stats_first)(const void *state);
    /** Makes a state whose raw answer is complete write its answer once more, as JSON that contains
     * more than its table, without computing it again. NULL if JSON contains nothing more. */
    void (*json)(void *state);
    /** Releases the state's memory, also if reading failed; NULL if it has none. */
    void (*clear)(void *state);
};

extern const struct api_op api_op_trees, api_op_trajectories, api_op_forces, api_op_modes,
    api_op_ensembles, api_op_equations, api_op_lyapunov, api_op_sections, api_op_response,
    api_op_controllers, api_op_fits, api_op_tables, api_op_trials, api_op_orbits, api_op_presets,
    api_op_preset;

/**
 * Reads and checks a request by its operation.
 *
 * state  out; NULL on failure; released by api_op_free.
 *
 * Fails as the operation's `read` does.
 */
PEND_MUST_CHECK enum pend_status api_op_read(void **state, const struct api_reading *reading);
void api_op_free(const struct api_op *op, void **state);

/** Return the table and the statistics of an answer, from the state of an operation that has
 * them. */
const struct api_table *api_op_table(const struct api_op *op, const void *state);
const struct api_stats *api_op_stats(const struct api_op *op, const void *state);

/** Reads the member `pendulum`, as api_tree_read does; adds errors for terms that the operation
 * does not support. */
PEND_MUST_CHECK enum pend_status api_reading_tree(const struct api_reading *reading,
                                                  struct api_tree *tree);

/** Adds an error unless the representation is JSON or that of a job's parts. what: "poles are";
 * instead: another way out, "leave it out". */
void api_reading_check_json(const struct api_reading *reading, const struct api_value *value,
                            const char *what, const char *instead);

/**
 * Adds an error for an answer that has to be stored and would be larger than max-answer-bytes.
 *
 * value  the field that requests it.
 * what   the rows, for the message: "instants".
 * fewer  how to request less: "fewer instants or outputs".
 */
void api_reading_check_size(const struct api_reading *reading, const struct api_table *table,
                            const struct api_value *value, const char *what, const char *fewer);

/**
 * Does the same for rows that are stored while they are found, in every representation; then calls
 * api_reading_check_size.
 *
 * arms  number of arms in each row, for the message.
 */
void api_reading_check_kept(const struct api_reading *reading, const struct api_table *table,
                            const struct api_value *value, int arms, const char *what,
                            const char *fewer);

/**
 * Doubles the memory of a table's columns if all of it is used, up to the table's rows.
 *
 * used   number of rows in use.
 * first  number of rows for which memory is allocated at first.
 * room   in and out: number of rows for which there is memory.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_table_grow(const struct api_table *table, long used,
                                                long first, long *room, double *column[],
                                                struct pend_error *error);

/** Returns the row of an operation, NULL if there is none; or the first operation with a name,
 * API_OP_COUNT if there is none. */
const struct api_op *api_op_at(enum api_op_id id);
enum api_op_id api_op_find(const char *name);
