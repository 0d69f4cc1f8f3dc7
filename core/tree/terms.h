/* The terms that a real pendulum has beyond the ideal one, bodies, springs, friction, drives, and
 * where the numbers of each stand in one list.
 * Leaves to others: what they do in the equations of motion (bodies), their JSON (api).
 * Invariant: immutable once made; every term's numbers stand in the list once, so that an entry of
 * the list is a parameter of the pendulum: what members of an ensemble differ in. */
#ifndef PEND_TERMS_H
#define PEND_TERMS_H

#include "core/base/status.h"
#include "core/tree/tree.h"

/* Terms with one number for each arm, in the tree's stored order. x and y are in the frame of the
 * body concerned: from its own joint along the arm, and across it, counterclockwise. A torque on
 * an arm acts with the opposite sign on the arm that carries it. */
enum pend_term_row {
    PEND_TERM_ROD,            /* kg, a uniform bar from joint to tip */
    PEND_TERM_BODY,           /* kg, of a body fixed to the arm */
    PEND_TERM_CENTER_X,       /* m, its center of mass */
    PEND_TERM_CENTER_Y,       /* m */
    PEND_TERM_INERTIA,        /* kg m^2, about its center of mass */
    PEND_TERM_AT_X,           /* m, where the arm's joint is on its parent, of arms that say so */
    PEND_TERM_AT_Y,           /* m */
    PEND_TERM_DAMPING,        /* N m s/rad: torque -c r, r the rate relative to the parent */
    PEND_TERM_STIFFNESS,      /* N m/rad: torque -k (q - a), q the angle to the parent; the first
                                 arm's is theta */
    PEND_TERM_REST,           /* rad, a */
    PEND_TERM_FRICTION,       /* N m: torque -f tanh(r / s) */
    PEND_TERM_FRICTION_SPEED, /* rad/s, s > 0 */
    PEND_TERM_TORQUE,         /* N m, constant */
    PEND_TERM_DRAG,           /* N s/m: force -(b + d sqrt(|v|^2 + e^2)) v on the tip */
    PEND_TERM_DRAG_QUADRATIC, /* N s^2/m^2, d */
    PEND_TERM_DRAG_SPEED,     /* m/s, e > 0 */
    PEND_TERM_INPUT,          /* N m, of a piece (rules.h): torque i + j (t - T) */
    PEND_TERM_INPUT_RATE,     /* N m/s, j */
    PEND_TERM_SLIDE,          /* N m, of a piece: a constant torque whose work is heat */
    PEND_TERM_ROWS,
    PEND_TERM_OWN_ROWS = PEND_TERM_INPUT /* those before are the pendulum's own, not a piece's */
};

/* Terms with one number for the pendulum. */
enum pend_term_one {
    PEND_TERM_DRAG_PER_MASS,        /* 1/s, gamma: force -2 gamma m v on every mass m */
    PEND_TERM_PIVOT_ACCELERATION_X, /* m/s^2, of the pivot, from t = 0 at rest on */
    PEND_TERM_PIVOT_ACCELERATION_Y, /* m/s^2 */
    PEND_TERM_RAIL,                 /* rad, the direction of the cart's rail: there is a cart */
    PEND_TERM_PIECE,                /* s, T: when the piece began whose inputs the list has */
    PEND_TERM_ONES,
    PEND_TERM_OWN_ONES = PEND_TERM_PIECE
};

/* A cart carries the pivot along a straight rail through 0. It is stored arm 0, of length 1 m and
 * with the cart's mass, on which all arms at the pivot hang; its phi is its place along the rail,
 * m, and its rate its speed, m/s. Its damping, stiffness, rest, friction and torque are forces
 * along the rail, N s/m, N/m and so on, and it has no other terms. The arms that it carries turn
 * against the ground, as those at a fixed pivot do. The rail does not move. */

/* What a harmonic drives, if it is not an arm's torque. */
enum { PEND_DRIVE_PIVOT_X = -1, PEND_DRIVE_PIVOT_Y = -2 };

/* amplitude cos(omega t + phase), added to a torque, N m, or to a coordinate of the pivot, m. */
struct pend_harmonic {
    int drives; /* a stored arm, or PEND_DRIVE_PIVOT_X or _Y */
    int at;     /* of amplitude; omega, rad/s, and phase, rad, are the next two of the list */
};

struct pend_rules;

struct pend_terms {
    int n;                   /* arms */
    int count;               /* numbers of the list */
    int row[PEND_TERM_ROWS]; /* the first of n numbers of a term, -1 = the pendulum has it not */
    int one[PEND_TERM_ONES]; /* the number of a term, -1 = the pendulum has it not */
    int harmonics;           /* grouped by what they drive: the pivot first, then arms */
    struct pend_harmonic *harmonic;
    unsigned char *hung; /* n: non-zero where the arm hangs at AT_X, AT_Y; else at its parent's tip.
                          */
    const struct pend_rules *rules; /* by which pieces of a motion differ; NULL = it is one; not
                                       owned */
};

/**
 * Lays out the list of a pendulum's terms.
 *
 * terms      out; NULL on failure; released by pend_terms_free.
 * n          number of arms, >= 1.
 * rows       PEND_TERM_ROWS flags: which terms of an arm there are. Terms that belong together
 *            are laid out together: one of BODY, CENTER_X, CENTER_Y, INERTIA makes all four, and so
 *            on for AT, for STIFFNESS and REST, for FRICTION and for DRAG_QUADRATIC with a speed.
 * ones       PEND_TERM_ONES flags; the two of the pivot's acceleration belong together.
 * harmonics  number of harmonics, >= 0.
 * drives     what each harmonic drives, in any order; harmonic i of the list is the caller's
 *            place[i].
 * place      out, `harmonics` numbers; may be NULL if there are none.
 *
 * PEND_NO_MEMORY  O(n + h log h) of h harmonics.
 */
PEND_MUST_CHECK enum pend_status pend_terms_new(struct pend_terms **terms, int n,
                                                const unsigned char rows[],
                                                const unsigned char ones[], int harmonics,
                                                const int drives[], int place[]);

/** Frees terms and clears the pointer; NULL is accepted. */
void pend_terms_free(struct pend_terms **terms);

/** Returns where the number of a term of stored arm k is in the list, -1 if nowhere. O(1). */
static inline int pend_terms_place(const struct pend_terms *terms, enum pend_term_row row, int k) {
    return terms->row[row] < 0 ? -1 : terms->row[row] + k;
}

/** Returns a term's number of stored arm k, 0 where the pendulum has no such term. O(1). */
static inline double pend_terms_get(const struct pend_terms *terms, const double value[],
                                    enum pend_term_row row, int k) {
    return terms->row[row] < 0 ? 0 : value[terms->row[row] + k];
}

/** Non-zero if stored arm 0 is a cart. O(1). */
static inline int pend_terms_cart(const struct pend_terms *terms) {
    return terms && terms->one[PEND_TERM_RAIL] >= 0;
}

/** Returns the stored arm against which arm k turns: its parent, or -1 for the ground, at a pivot
 * or on a cart. O(1). */
static inline int pend_terms_holder(const struct pend_terms *terms, const int parent[], int k) {
    return parent[k] == 0 && pend_terms_cart(terms) ? -1 : parent[k];
}

/** Non-zero if whole turns of the angles of a start change nothing but the angles: springs and
 * rules (stops, say) tell them apart, and a cart's place is no angle. O(1). */
static inline int pend_terms_whole_turns(const struct pend_terms *terms) {
    return !terms ||
           (terms->row[PEND_TERM_STIFFNESS] < 0 && !terms->rules && !pend_terms_cart(terms));
}

/**
 * Fills a list with the numbers of a pendulum whose terms do nothing: 0 everywhere, speeds 1,
 * joints at the tips.
 *
 * value  out, terms->count numbers.
 */
void pend_terms_clear(const struct pend_terms *terms, const struct pend_tree *tree, double value[]);

/* What is wrong with a list of numbers. */
struct pend_terms_fault {
    int row, one; /* the term, the other one -1; both -1: a harmonic */
    int arm;      /* stored; of a term of the pendulum -1; of a harmonic its place in the list */
    int part;     /* of a harmonic: 0 amplitude, 1 omega, 2 phase */
    const char *text; /* what it must be: "must be 0 or more" */
};

/**
 * Checks the numbers of a list.
 *
 * tree   the arms, whose masses may be 0 where a rod or a body makes up for them: every arm needs
 *        an inertia about its own joint.
 * value  terms->count numbers.
 * found  called for every fault, `context` first.
 *
 * Returns the number of faults. O(count).
 */
int pend_terms_check(const struct pend_terms *terms, const struct pend_tree *tree,
                     const double value[],
                     void (*found)(void *context, const struct pend_terms_fault *fault),
                     void *context);

/**
 * Returns true if the number at a place of the list may be x: finite, and 0 or more or greater than
 * 0 where the term asks for it. O(1).
 */
int pend_terms_fits(const struct pend_terms *terms, int place, double x);

/** Non-zero if the sum of kinetic energy and that of gravity and springs is kept: no friction, no
 * drag, no torque, and a pivot that does not move. O(n). */
int pend_terms_conserve(const struct pend_terms *terms, const double value[]);

/** Returns the inertia of stored arm k alone about its joint, kg m^2: of the mass at its tip, its
 * rod and its body. O(1). */
double pend_terms_inertia(const struct pend_terms *terms, double length, double mass,
                          const double value[], int k);

/**
 * Returns how fast the terms make a motion near rest, rad/s, about: what springs and torques make
 * of the arms' own inertias, what friction and the air take in a second; 0 where terms do neither.
 *
 * mass   n masses at the tips, kg; which inertia an arm has beyond them is in the terms.
 * decay  out, 1/s: the part of friction and the air; NULL = not wanted.
 * O(n + harmonics).
 */
double pend_terms_rate(const struct pend_terms *terms, const int parent[], const double length[],
                       const double mass[], const double value[], double *decay);

/** Returns the largest angular frequency of the drives, rad/s; 0 without drives. O(harmonics). */
double pend_terms_drive_rate(const struct pend_terms *terms, const double value[]);

/** Returns true if the layout holds together. O(n). For assertions and tests. */
int pend_terms_valid(const struct pend_terms *terms);

#endif
