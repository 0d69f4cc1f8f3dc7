/* Every limit of a request in one table: name, default, allowed range, unit and meaning.
 * Leaves to others: setting them (server/config/config), enforcing them (op_*,
 * server/work/admission).
 * Invariant: the help, the OpenAPI document and the error texts call a limit by its name in this
 * table, or by the name of the option that widens it for jobs. */
#pragma once

/* columns: field, option name, default, least, greatest, unit, what it bounds */
#define API_LIMITS_LIST(X)                                                                         \
    X(arms, "max-arms", 5000, 1, 10000000, "arms", "arms of a pendulum")                           \
    X(samples, "max-samples", 10000000, 1, 1000000000, "samples",                                  \
      "instants of a trajectory, or states of a request")                                          \
    X(members, "max-members", 4194304, 1, 1000000000, "members", "members of an ensemble")         \
    X(body_bytes, "max-body-bytes", 8388608, 1024, 1073741824, "bytes", "a request's body")        \
    X(answer_bytes, "max-answer-bytes", 268435456, 65536, 17179869184, "bytes",                    \
      "an answer that is held in memory")                                                          \
    X(compute_seconds, "max-compute-seconds", 60, 1, 86400, "s", "the computation of one request") \
    X(steps, "max-steps", 100000000, 100, 1000000000000, "steps",                                  \
      "integration steps of one request")                                                          \
    X(matrix_arms, "max-matrix-arms", 1000, 1, 20000, "arms",                                      \
      "arms of a pendulum in requests for n x n matrices")                                         \
    X(mode_arms, "max-mode-arms", 5000, 1, 20000, "arms",                                          \
      "arms of a pendulum in requests for all modes")                                              \
    X(depth, "max-json-depth", 16, 4, 64, "levels", "nesting of a request's JSON")

struct api_limits {
#define X(field, name, start, least, most, unit, meaning) double field;
    API_LIMITS_LIST(X)
#undef X
    int of_jobs; /* non-zero: limits of jobs, some of which have their own option names */
    int stored;  /* non-zero: the answer is read from stored parts, which is repeatable */
};

struct api_limit_row {
    const char *name;
    double start, least, most;
    const char *unit, *meaning;
};

/** Sets all limits to the defaults of the table. */
void api_limits_init(struct api_limits *limits);

/** Returns row i of the table, NULL beyond its end. */
const struct api_limit_row *api_limits_row(int i);

/** Returns the name of the limit in a field of `limits`: "max-members", or for jobs
 * "max-job-members". */
const char *api_limits_name(const struct api_limits *limits, const double *field);

/** Returns the address of the value of row i in `limits`, for reading and for setting. */
double *api_limits_value(struct api_limits *limits, int i);
