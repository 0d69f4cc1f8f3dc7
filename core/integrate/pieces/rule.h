/* The interface of rules, which change a motion between two pieces.
 * Leaves to others: the loop over pieces (pieces), the parameters of rules (core/tree/rules).
 * Invariant: a rule changes nothing during a piece. */
#ifndef PEND_RULE_H
#define PEND_RULE_H

#include "core/integrate/methods/method.h"
#include "core/tree/rules.h"

/* A motion in pieces as its rules see it. */
struct pend_piece {
    const struct pend_problem *problem; /* the problem, whose list of numbers is `value` */
    const struct pend_rules *rules;
    double *value; /* the numbers of the current piece */
    int way;       /* +1 or -1: the direction of time */
    double start;  /* start of the run, s, in the time of the drives */
    double now;    /* s, in the time of the drives: start of the piece; at an instant known in
                    * advance it is exact, not a sum */
    double *phi,
        *rate; /* the state at `now`, n values each, stored order; `change` may change rates */
};

struct pend_rule {
    /** Non-zero if a pendulum has such rules. */
    int (*has)(const struct pend_rules *rules);
    /** Returns the bytes of the rule's state, initially zero, a multiple of 8. NULL = no state. */
    size_t (*bytes)(const struct pend_problem *problem);
    /** Returns the first instant after piece->now at which a piece must end, s, in the time of the
     * drives; infinity if there is none. NULL = never. */
    double (*next)(const struct pend_piece *piece, const void *own);
    /** Changes the rule's state, or the rates, at the beginning of a piece: at the motion's start,
     * at the instants `next` of all rules, and at events. NULL = nothing. */
    enum pend_status (*change)(struct pend_piece *piece, void *own, struct pend_error *error);
    /** Adds the rule's torques to PEND_TERM_INPUT and PEND_TERM_INPUT_RATE, which already contain
     * the tables; called after all changes. NULL = none. */
    void (*input)(const struct pend_piece *piece, const void *own);
    /** Saves the rule's state to a checkpoint, or loads it. NULL = no state. */
    void (*carry)(const struct pend_piece *piece, void *own, struct pend_checkpoint *checkpoint);
};

extern const struct pend_rule pend_rule_control;

#endif
