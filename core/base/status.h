/* Result codes, error detail and fault reports of the whole project.
 * Leaves to others: how a code is shown to a user (api/base/problem).
 * Invariant: 0 is success; codes and texts come from the one list below. */
#pragma once

/* The version of the library, the programs and their answers. */
#define PEND_VERSION "0.1.0"

/* columns: name, text */
#define PEND_STATUS_LIST(X)                                                                        \
    X(PEND_OK, "success")                                                                          \
    X(PEND_INVALID, "the input is well-formed but meaningless")                                    \
    X(PEND_LIMIT, "a limit would be exceeded")                                                     \
    X(PEND_NO_MEMORY, "out of memory")                                                             \
    X(PEND_CANCELLED, "the computation was cancelled")                                             \
    X(PEND_DEADLINE, "the computation exceeded its time limit")                                    \
    X(PEND_NOT_FINITE, "a number ceased to be finite")                                             \
    X(PEND_STEP_TOO_SMALL, "the step size fell below the resolution of the numbers")               \
    X(PEND_TOO_MANY_STEPS, "the step limit was reached before the last instant")                   \
    X(PEND_NO_CONVERGENCE, "an iteration did not converge")                                        \
    X(PEND_BUG, "an internal check failed")

enum pend_status {
#define X(name, text) name,
    PEND_STATUS_LIST(X)
#undef X
        PEND_STATUS_COUNT
};

#define PEND_MUST_CHECK __attribute__((warn_unused_result))

/* Marks a static validator, which is unused in release builds without assertions. */
#define PEND_VALIDATOR __attribute__((unused)) static int

/** Returns a failure of `call` to the caller; only for functions that own nothing at this point. */
#define PEND_TRY(call)                                                                             \
    do {                                                                                           \
        enum pend_status pend_try_status_ = (call);                                                \
        if (pend_try_status_ != PEND_OK) return pend_try_status_;                                  \
    } while (0)

/** Detail of a failure, owned by the caller. `arm` is the caller's arm number from 0, or -1; `time`
 * is in s. */
struct pend_error {
    enum pend_status code;
    int arm;
    double time;
    char text[240];
};

/**
 * Returns the text of a code, a static string.
 *
 * code  any value; an unknown one gives "unknown status".
 */
const char *pend_status_text(enum pend_status code);

/** Returns the name of a code as written in the source ("PEND_OK"), a static string; "unknown" for
 * an unknown code. */
const char *pend_status_name(enum pend_status code);

/**
 * Fills an error and returns its code, so that a failing function can end with `return
 * pend_fail(...)`.
 *
 * error   may be NULL: then only the code is returned.
 * code    not PEND_OK.
 * arm     the caller's arm number from 0, or -1 if the failure concerns no single arm.
 * time    s, 0 if the failure concerns no instant.
 * format  printf format of a sentence: the fault, its place, and a valid value.
 *         With PEND_NO_MEMORY a sentence without the word "memory" is replaced by the status's own.
 */
enum pend_status pend_fail(struct pend_error *error, enum pend_status code, int arm, double time,
                           const char *format, ...) __attribute__((format(printf, 5, 6)));

/* The fields of an input that a fault can name. */
enum pend_field {
    PEND_FIELD_NONE,
    PEND_FIELD_COUNT,  /* the number of arms */
    PEND_FIELD_LENGTH, /* length[i] */
    PEND_FIELD_MASS,   /* mass[i] */
    PEND_FIELD_PARENT, /* parent[i] */
    PEND_FIELD_PATH    /* S[i][j] */
};

/** Receives the faults of an input, one call each; i and j are indices from 0, or -1 if the fault
 * concerns no index. */
typedef void pend_fault_fn(void *context, enum pend_field field, int i, int j, const char *text);

/* The receiver of faults. Composing texts takes time, and a hostile input can have millions of
 * faults: text is NULL for all faults after the first `worded`. */
struct pend_fault_sink {
    pend_fault_fn *report;
    void *context;
    long worded; /* 0 = all faults have a text */
};
