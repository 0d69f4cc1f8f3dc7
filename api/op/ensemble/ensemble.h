/* A checked request for an ensemble: its members, the columns, the estimated cost, and the rows of
 * the answer.
 * Leaves to others: the computation of the rows (member_range), the bytes of the answer (encode).
 * Invariant: it does not change after it is prepared. */
#pragma once

#include "api/op/events_json.h"
#include "api/op/ensemble/member_derived.h"
#include "api/op/ensemble/members_json.h"
#include "api/op/ensemble/observables.h"
#include "api/op/op.h"
#include "api/read/times_json.h"

/* the most members of a range (member_range) */
enum { API_ENSEMBLE_RANGE = 16384 };

/* A request as it was read. */
struct api_ensemble {
    struct api_tree tree;
    struct api_members members;
    struct api_observables seen;
    struct api_times times;
    struct api_events events;
    struct api_derived derived;
    long events_at, derived_at; /* columns of a member's row at which its passages and its
                                 * derivatives begin */
    double *instants;           /* s, the instants relative to the first; NULL without a
                                 * trajectory */
    double origin, duration, rtol, atol, accuracy; /* s, start and duration of members */
    long step_cap, numbers;                        /* numbers: how many a raw row has */
    long offset[API_COLUMNS];                      /* starts of the answer's columns in a raw row */
};

/**
 * Reads and checks a request.
 *
 * ensemble  out; NULL on failure; released by api_ensemble_free.
 *
 * PEND_INVALID   every error was added to the problem.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_ensemble_new(struct api_ensemble **ensemble,
                                                  const struct api_reading *reading);

/** Frees an ensemble; NULL is accepted. No range of it may be in use. */
void api_ensemble_free(struct api_ensemble **ensemble);

/**
 * Computes the states that were given as modes. Call it once, before the first range. Afterwards
 * ranges may be computed on any number of threads.
 *
 * Fails as api_states_settle does.
 */
PEND_MUST_CHECK enum pend_status api_ensemble_prepare(struct api_ensemble *ensemble,
                                                      struct pend_error *error);

/** Returns the number of members. */
long api_ensemble_count(const struct api_ensemble *ensemble);

/** Returns the number of rows of a member: 1, or the instants of a trajectory; if the rows are
 * passages, the largest possible number. */
long api_ensemble_rows(const struct api_ensemble *ensemble);

/** Returns the number of doubles in a raw row. */
long api_ensemble_numbers(const struct api_ensemble *ensemble);

/** Returns the estimated time of `members` members, s. */
double api_ensemble_cost(const struct api_ensemble *ensemble, long members);

/** Returns the bytes of memory of the ensemble and of computing a range, without the raw rows.
 * O(1). */
double api_ensemble_bytes(const struct api_ensemble *ensemble);

/**
 * Writes raw rows to an answer, column by column; call it with pieces of a few hundred rows.
 *
 * Fails as api_writer_block does.
 */
PEND_MUST_CHECK enum pend_status api_ensemble_write(const struct api_ensemble *ensemble,
                                                    struct api_writer *writer, long rows,
                                                    const double raw[], struct api_buffer *out,
                                                    struct pend_error *error);
