/* The interface of rules by which a motion changes between two of its pieces.
 * Leaves to others: the loop over pieces (pieces), what the rules are (core/tree/rules).
 * Invariant: a rule changes nothing during a piece. */
#ifndef PEND_RULE_H
#define PEND_RULE_H

#include "core/integrate/methods/method.h"
#include "core/tree/rules.h"

/* A motion in pieces as its rules see it. */
struct pend_piece {
    const struct pend_problem *problem; /* its list of numbers is `value` */
    const struct pend_rules *rules;
    double *value; /* the numbers of the piece at hand */
    int way;       /* +1 or -1: the direction of time */
    double start;  /* s, of the run, in the time of the drives */
    double now;    /* s, in the same time: when the piece began. At instants known beforehand it is
                      that instant itself, not a sum. */
    double *phi, *rate; /* the state then, n values each, stored order; `change` may change rates */
};

struct pend_rule {
    /** Non-zero if a pendulum has such rules. */
    int (*has)(const struct pend_rules *rules);
    /** Bytes of what the rule keeps from piece to piece, a multiple of 8; zeros at the start. NULL
     * = 0. */
    size_t (*bytes)(const struct pend_problem *problem);
    /** Returns the first instant beyond piece->now, s, in the time of the drives, at which a piece
     * has to end; an infinity if there is none. NULL = none ever. */
    double (*next)(const struct pend_piece *piece, const void *own);
    /**
     * Changes what the rule keeps, or the rates, where a piece begins: at the motion's start, at
     * instants of `next`, of other rules too, and at events. NULL = nothing.
     */
    enum pend_status (*change)(struct pend_piece *piece, void *own, struct pend_error *error);
    /** Adds its torques of the piece to PEND_TERM_INPUT and PEND_TERM_INPUT_RATE, in which the
     * tables' are already; after all rules have changed. NULL = none. */
    void (*input)(const struct pend_piece *piece, const void *own);
    /** Shows a checkpoint what the rule keeps. NULL = nothing. */
    void (*carry)(const struct pend_piece *piece, void *own, struct pend_checkpoint *checkpoint);
};

extern const struct pend_rule pend_rule_control;

#endif
