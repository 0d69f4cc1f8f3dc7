/* The rows of trajectories of an ensemble's members: outputs, columns, and the computation of
 * outputs from angles and rates.
 * Leaves to others: the motion (core/ensemble), members and their numbers (members_fill).
 * Invariant: a row's outputs are those of a trajectory of the member's own pendulum. */
#pragma once

#include "api/encode/encode.h"
#include "api/op/derived.h"
#include "api/read/field.h"
#include "api/read/tree_json.h"
#include "core/ensemble/member.h"

/** Reads the names of outputs as bits; the default is phi, phid, lambda. Every error is added to
 * the problem. */
unsigned api_member_outputs_read(const struct api_value *list, struct api_problem *problem);

/** Returns non-zero if the position of a cart is one of the outputs. O(1). */
int api_member_outputs_cart(unsigned outputs);

/** Returns non-zero if an output depends on more than angles, rates and forces, so that
 * api_member_samples_pendulum must be called. O(1). */
int api_member_outputs_derived(unsigned outputs);

/** Adds the columns of the outputs for n arms, after the columns member, status and t. */
void api_member_outputs_columns(unsigned outputs, int n, struct api_table *table);

/** Adds the columns of the derivatives of all outputs, after all other columns. */
void api_member_outputs_differ(unsigned outputs, struct api_derived *derived,
                               struct api_table *table);

/** Returns the estimated time to compute the outputs of one row, s. O(1). */
double api_member_outputs_cost(unsigned outputs, const struct api_tree *tree);

/* Scratch for computing rows, for one thread. */
struct api_member_samples;

/**
 * Allocates the scratch for a tree, which must outlive it.
 *
 * samples  out; NULL on failure; released by api_member_samples_free. PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_member_samples_new(struct api_member_samples **samples,
                                                        const struct api_tree *tree,
                                                        unsigned outputs);
void api_member_samples_free(struct api_member_samples **samples);

/** Returns the bytes of memory of the scratch. O(harmonics). */
double api_member_samples_bytes(const struct api_tree *tree);

/** Sets the pendulum of the rows that follow: its lengths, masses and loads, which must outlive
 * them. O(n). */
void api_member_samples_pendulum(struct api_member_samples *samples,
                                 const struct pend_member *member);

enum { API_MEMBER_ROWS = 8 };

/* A member at consecutive instants; values in stored order, n per instant. */
struct api_member_states {
    int count;       /* at most API_MEMBER_ROWS */
    const double *t; /* s, in the request's time */
    const double *phi, *rate, *force, *theta;
};

/**
 * Writes rows: member, status 0, t, and the outputs.
 *
 * row     out: the first row; each further one begins `stride` numbers later.
 *
 * Numbers that are not finite become 0, and the row's status becomes 1. O(n) per row.
 */
void api_member_samples_rows(struct api_member_samples *samples, double member,
                             const struct api_member_states *states, double row[], long stride);
