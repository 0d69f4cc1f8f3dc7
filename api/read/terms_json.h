/* Reading what a real pendulum has beyond the ideal one: rods, bodies, springs, friction, drives.
 * Leaves to others: the arms and how they hang together (tree_json), the layout of the list that
 * the numbers end in (core/tree/terms), what they do.
 * Invariant: what is left out, null, or says no more than its default does not become a term, so
 * that such a pendulum is the ideal one, bit for bit. */
#ifndef API_TERMS_JSON_H
#define API_TERMS_JSON_H

#include "api/read/field.h"
#include "api/read/rules_json.h"
#include "api/read/terms_fields.h"

enum {
    API_TERMS_HARMONICS = 64 /* most harmonics of a torque, or of a coordinate of the pivot */
};

/* A harmonic of the document; arms in the caller's order. */
struct api_harmonic {
    int drives; /* an arm, or PEND_DRIVE_PIVOT_X or _Y */
    double part[3];
};

/* A cart on a rail that carries the pivot. What drives it is harmonics of arm n, one beyond the
 * caller's. */
struct api_cart {
    int given;
    double mass, angle, damping, stiffness, force; /* force: its constant part */
};

/* The terms of a pendulum while it is read, in the caller's order. */
struct api_terms {
    int n;
    struct api_problem *problem;
    enum pend_status status;     /* not PEND_OK once memory was lacking */
    double *row[PEND_TERM_ROWS]; /* n numbers each; NULL = all as the default has it */
    double one[PEND_TERM_ONES];
    unsigned short *given; /* n sets of the fields that an arm has; NULL = none has any */
    struct api_cart cart;
    struct api_harmonic *harmonic;
    int harmonics, room;
    struct api_rules rules;
};

enum { API_TERMS_FAULTY = API_TERMS_FIELDS }; /* the bit of `given`: one of the fields is faulty */

/** Non-zero if arm i has field f, or a faulty one. O(1). */
static inline int api_terms_has(const struct api_terms *terms, int f, int i) {
    return terms->given && terms->given[i] >> f & 1;
}

/** Tells of a fault at a field of the caller's arm i. */
typedef void api_terms_fault_fn(void *context, const char *field, int i, const char *text);

/** Begins to read the terms of n arms; ends with api_terms_clear. */
void api_terms_init(struct api_terms *terms, int n, struct api_problem *problem);

/** Frees what was read. */
void api_terms_clear(struct api_terms *terms);

/** Reads the terms among the members of an arm's object; `arm->index` says which arm it is.
 * O(members). */
void api_terms_read_arm(struct api_terms *terms, const struct api_value *arm);

/**
 * Reads the lists of a pendulum, each with an entry an arm: null, or what an arm's field would be.
 *
 * form  NULL, or the form of the tree, to which lists do not belong: then each is a fault that says
 *       where its numbers go.
 *
 * O(entries).
 */
void api_terms_read_lists(struct api_terms *terms, const struct api_value *pendulum,
                          const char *form);

/** Reads the fields of the whole pendulum. */
void api_terms_read_whole(struct api_terms *terms, const struct api_value *pendulum);

/** Non-zero where the caller's arm i has a rod or a body, good or faulty, so that the mass at its
 * tip may be 0; for all arms once memory was lacking. O(1). */
int api_terms_bare(const struct api_terms *terms, int i);

/**
 * Faults what does not fit the other fields of its arm: a place on the pivot, a rest without a
 * spring.
 *
 * parent  n numbers; -1 = the pivot.
 */
void api_terms_check(const struct api_terms *terms, const int parent[], api_terms_fault_fn *fault,
                     void *context);

/**
 * Makes the list of terms of a tree.
 *
 * tree   whose arms were read, in the caller's order; a cart, if there is one, is one more, behind
 *        them.
 * made   out; NULL if there are none, or on failure.
 * value  out, the numbers of the list, to be freed by free(); NULL where *made is NULL.
 * rules  out, to be freed by free(), to which *made points; NULL if there are none.
 * fault  is told of arms that have no inertia; `field` is then "mass".
 *
 * PEND_INVALID    a fault was told.
 * PEND_NO_MEMORY  also if memory was lacking while they were read.
 * O(n + h log h) of h harmonics.
 */
PEND_MUST_CHECK enum pend_status api_terms_make(const struct api_terms *terms,
                                                const struct pend_tree *tree,
                                                struct pend_terms **made, double **value,
                                                struct pend_rules **rules,
                                                api_terms_fault_fn *fault, void *context);

#endif
