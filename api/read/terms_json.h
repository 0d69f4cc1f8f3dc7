/* Reads the terms of a real pendulum: rods, bodies, springs, friction, drives.
 * Leaves to others: the arms and their parents (tree_json), the layout of the list of numbers and
 * its effect (core/tree/terms).
 * Invariant: a field that is missing, null or equal to its default does not become a term, so that
 * such a pendulum is exactly the ideal one. */
#pragma once

#include "api/read/field.h"
#include "api/read/rules_json.h"
#include "api/read/terms_fields.h"

enum {
    API_TERMS_HARMONICS = 64 /* the most harmonics of a torque, or of a coordinate of the pivot */
};

/* A harmonic in the document; arms are in the caller's order. */
struct api_harmonic {
    int drives; /* an arm, or PEND_DRIVE_PIVOT_X or _Y */
    double part[3];
};

/* A cart on a rail that carries the pivot. Its drives are harmonics of arm n, after the caller's
 * arms. */
struct api_cart {
    int given;
    double mass, angle, damping, stiffness, force; /* force: its constant part */
};

/* The terms of a pendulum while it is read, in the caller's order. */
struct api_terms {
    int n;
    struct api_problem *problem;
    enum pend_status status;     /* not PEND_OK if memory ran out */
    double *row[PEND_TERM_ROWS]; /* n numbers each; NULL = all have their default */
    double one[PEND_TERM_ONES];
    unsigned short *given; /* for each arm the set of fields that it has; NULL = no arm has any */
    struct api_cart cart;
    struct api_harmonic *harmonic;
    int harmonics, room;
    struct api_rules rules;
};

enum { API_TERMS_FAULTY = API_TERMS_FIELDS }; /* the bit of `given` for an invalid field */

/** Returns non-zero if arm i has field f, or an invalid field. O(1). */
static inline int api_terms_has(const struct api_terms *terms, int f, int i) {
    return terms->given && terms->given[i] >> f & 1;
}

/** Reports an error at a field of the caller's arm i. */
typedef void api_terms_fault_fn(void *context, const char *field, int i, const char *text);

/** Prepares to read the terms of n arms; released by api_terms_clear. */
void api_terms_init(struct api_terms *terms, int n, struct api_problem *problem);
void api_terms_clear(struct api_terms *terms);

/** Reads the terms among the members of an arm's object; `arm->index` is the arm's index.
 * O(members). */
void api_terms_read_arm(struct api_terms *terms, const struct api_value *arm);

/**
 * Reads the lists of a pendulum, each with one entry per arm: null, or the value of the arm's
 * field.
 *
 * form  NULL, or a form of the tree without lists: then each list is an error, which says where its
 *       numbers belong.
 *
 * O(entries).
 */
void api_terms_read_lists(struct api_terms *terms, const struct api_value *pendulum,
                          const char *form);

/** Reads the fields of the whole pendulum. */
void api_terms_read_whole(struct api_terms *terms, const struct api_value *pendulum);

/** Returns non-zero if the caller's arm i has a rod or a body, valid or not, so that the mass at
 * its tip may be 0; true for all arms if memory ran out. O(1). */
int api_terms_bare(const struct api_terms *terms, int i);

/**
 * Adds errors for fields that contradict others of the arm: an attachment on the pivot, a rest
 * angle without a spring.
 *
 * parent  n numbers; -1 = the pivot.
 */
void api_terms_check(const struct api_terms *terms, const int parent[], api_terms_fault_fn *fault,
                     void *context);

/**
 * Creates the list of terms of a tree.
 *
 * tree   of the arms that were read, in the caller's order; a cart, if any, follows them.
 * made   out; NULL if there are no terms, or on failure.
 * value  out, the numbers of the list, to be freed by free(); NULL if *made is NULL.
 * rules  out, to be freed by free(), to which *made points; NULL if there are none.
 * fault  called for arms without inertia; `field` is then "mass".
 *
 * PEND_INVALID    an error was reported.
 * PEND_NO_MEMORY  also if memory ran out while terms were read.
 * O(n + h log h) for h harmonics.
 */
PEND_MUST_CHECK enum pend_status api_terms_make(const struct api_terms *terms,
                                                const struct pend_tree *tree,
                                                struct pend_terms **made, double **value,
                                                struct pend_rules **rules,
                                                api_terms_fault_fn *fault, void *context);
