/* The terms of an arm of a real pendulum as equations and programs write them, in one table: the
 * letters of their numbers, and the torque on a joint that each is.
 * Leaves to others: everything that is not a number an arm: harmonics, the pivot, the cart, masses
 * and the air's forces (equations_real, equations_real_latex, equations_cart).
 * Invariant: immutable; a term that acts in a joint has its torque in all languages. */
#ifndef API_EQUATIONS_TERMS_H
#define API_EQUATIONS_TERMS_H

#include "api/op/equations/equations.h"

/* A number an arm, and its torque. */
struct api_equations_term {
    enum pend_term_row row, of;  /* it is written where the pendulum has `of` */
    const char *name, *comment;  /* its list in programs; NULL where it has none of its own */
    const char *letter, *unit;   /* its list in formulas, LaTeX; NULL where it has none */
    const char *python, *matlab; /* what it does to tau of the joints in programs, or NULL: r, q,
                                    B and w are there */
    const char *latex;           /* and in formulas */
    int angles;                  /* the torque depends on q */
};

/** Returns term number i, from 0 on, in the order in which they are written; NULL behind the last
 * one. O(1). */
const struct api_equations_term *api_equations_term(int i);

/** Non-zero if a real pendulum has a number of its arms that is not 0; a cart's own is none of
 * theirs. O(n). */
int api_equations_has(const struct api_equations *e, enum pend_term_row row);

/** Non-zero if a real pendulum has a term of the table: those of the air stand together. O(n). */
int api_equations_has_term(const struct api_equations *e, const struct api_equations_term *term);

/** Non-zero if a term acts in the joints of a real pendulum, and in `angles` whether one depends on
 * their angles; harmonics of torques are not looked at. O(n). */
int api_equations_joints(const struct api_equations *e, int *angles);

#endif
