/* The terms that a real pendulum adds to the ideal one (bodies, springs, friction, drives), and the
 * index of each term's values in one list.
 * Leaves to others: their effect in the equations of motion (bodies), their JSON (api).
 * Invariant: immutable after creation; each value occurs in the list once, so that an entry of the
 * list is a parameter of the pendulum. Members of an ensemble differ in entries. */
#pragma once

#include "core/base/status.h"
#include "core/tree/tree.h"

/* Terms with one number for each arm, in the tree's stored order. x and y are in the frame of the
 * term's body: from its own joint along the arm, and across it, counterclockwise. A torque on an
 * arm acts with the opposite sign on the arm that carries it. */
enum pend_term_row {
    PEND_TERM_ROD,            /* kg, a uniform bar from joint to tip */
    PEND_TERM_BODY,           /* kg, mass of a body fixed to the arm */
    PEND_TERM_CENTER_X,       /* m, center of mass of the body */
    PEND_TERM_CENTER_Y,       /* m */
    PEND_TERM_INERTIA,        /* kg m^2, moment of inertia of the body about its center of mass */
    PEND_TERM_AT_X,           /* m, position of the arm's joint in the frame of its parent, if it is
                               * not at the parent's tip */
    PEND_TERM_AT_Y,           /* m */
    PEND_TERM_DAMPING,        /* N m s/rad: torque -c r, r the rate relative to the parent */
    PEND_TERM_STIFFNESS,      /* N m/rad: torque -k (q - a), q the angle to the parent; for the
                               * first arm q is theta */
    PEND_TERM_REST,           /* rad: a of the spring's torque */
    PEND_TERM_FRICTION,       /* N m: torque -f tanh(r / s) */
    PEND_TERM_FRICTION_SPEED, /* rad/s: s of the friction torque, > 0 */
    PEND_TERM_TORQUE,         /* N m, constant */
    PEND_TERM_DRAG,           /* N s/m: force -(b + d sqrt(|v|^2 + e^2)) v on the tip */
    PEND_TERM_DRAG_QUADRATIC, /* N s^2/m^2: d of the drag force */
    PEND_TERM_DRAG_SPEED,     /* m/s: e of the drag force, > 0 */
    PEND_TERM_INPUT,          /* N m: i of the input of a piece (rules.h), a torque i + j (t - T) */
    PEND_TERM_INPUT_RATE,     /* N m/s: j of this input */
    PEND_TERM_SLIDE,          /* N m, of a piece: a constant torque whose work becomes heat */
    PEND_TERM_ROWS,
    PEND_TERM_OWN_ROWS = PEND_TERM_INPUT /* the preceding terms belong to the pendulum, not to a
                                          * piece */
};

/* Terms with one number for the pendulum. */
enum pend_term_one {
    PEND_TERM_DRAG_PER_MASS,        /* 1/s, gamma: force -2 gamma m v on every mass m */
    PEND_TERM_PIVOT_ACCELERATION_X, /* m/s^2, of the pivot, which is at rest at t = 0 */
    PEND_TERM_PIVOT_ACCELERATION_Y, /* m/s^2 */
    PEND_TERM_RAIL,                 /* rad, direction of the cart's rail; present if there is a
                                     * cart */
    PEND_TERM_PIECE,                /* s: T, the start of the piece whose inputs are in the list */
    PEND_TERM_PIVOT_TRACK, /* of a piece (rules.h): the pivot's position, m, and its first three
                              derivatives at T, x and y of each */
    PEND_TERM_PIVOT_TRACK_END = PEND_TERM_PIVOT_TRACK + 7,
    PEND_TERM_ONES,
    PEND_TERM_OWN_ONES = PEND_TERM_PIECE
};

/* A cart carries the pivot along a straight, fixed rail through 0. It is stored arm 0, with length
 * 1 m and the cart's mass; all arms at the pivot are its children. Its phi is its position along
 * the rail, m, and its rate its speed, m/s. Its damping, stiffness, rest, friction and torque are
 * forces along the rail, N s/m, N/m and so on; it has no other terms. The angles of its children
 * are measured against the ground, as at a fixed pivot. */

/* The targets of a harmonic besides an arm's torque. */
enum { PEND_DRIVE_PIVOT_X = -1, PEND_DRIVE_PIVOT_Y = -2 };

/* amplitude cos(omega t + phase), added to a torque, N m, or to a coordinate of the pivot, m. */
struct pend_harmonic {
    int drives; /* a stored arm, or PEND_DRIVE_PIVOT_X or _Y */
    int at;     /* index of the amplitude; omega, rad/s, and phase, rad, follow it in the list */
};

struct pend_rules;

struct pend_terms {
    int n;                   /* arms */
    int count;               /* number of values in the list */
    int row[PEND_TERM_ROWS]; /* index of the first of n values of a term; -1 = the pendulum does not
                              * have it */
    int one[PEND_TERM_ONES]; /* index of the value of a term; -1 = the pendulum does not have it */
    int harmonics;           /* number of harmonics, grouped by target: the pivot first, then
                              * arms */
    struct pend_harmonic *harmonic;
    unsigned char *hung; /* n flags: non-zero if the arm is attached at AT_X, AT_Y; otherwise at the
                          * tip of its parent */
    const struct pend_rules *rules; /* differences between pieces of a motion; NULL = one piece; not
                                     * owned */
};

/**
 * Lays out the list of a pendulum's terms.
 *
 * terms      out; NULL on failure; released by pend_terms_free.
 * n          number of arms, >= 1.
 * rows       PEND_TERM_ROWS flags: which terms of an arm are present. Terms that belong together
 *            are stored together: one of BODY, CENTER_X, CENTER_Y, INERTIA implies all four, and so
 *            on for AT, for STIFFNESS and REST, for FRICTION and for DRAG_QUADRATIC with a speed.
 * ones       PEND_TERM_ONES flags; the two components of the pivot's acceleration belong together.
 * harmonics  number of harmonics, >= 0.
 * drives     the target of each harmonic, in any order; harmonic i of the list is number place[i]
 *            of the caller.
 * place      out, `harmonics` numbers; may be NULL if there are none.
 *
 * PEND_NO_MEMORY  O(n + h log h) of h harmonics.
 */
PEND_MUST_CHECK enum pend_status pend_terms_new(struct pend_terms **terms, int n,
                                                const unsigned char rows[],
                                                const unsigned char ones[], int harmonics,
                                                const int drives[], int place[]);
void pend_terms_free(struct pend_terms **terms);
int pend_terms_valid(const struct pend_terms *terms);

/** Returns the index in the list of a term's value for stored arm k, or -1 if the pendulum does not
 * have the term. O(1). */
static inline int pend_terms_place(const struct pend_terms *terms, enum pend_term_row row, int k) {
    return terms->row[row] < 0 ? -1 : terms->row[row] + k;
}

/** Returns a term's value for stored arm k, 0 if the pendulum does not have the term. O(1). */
static inline double pend_terms_get(const struct pend_terms *terms, const double value[],
                                    enum pend_term_row row, int k) {
    return terms->row[row] < 0 ? 0 : value[terms->row[row] + k];
}

/** Returns non-zero if stored arm 0 is a cart. O(1). */
static inline int pend_terms_cart(const struct pend_terms *terms) {
    return terms && terms->one[PEND_TERM_RAIL] >= 0;
}

/** Returns the stored arm relative to which arm k turns: its parent, or -1 for the ground, at a
 * pivot or on a cart. O(1). */
static inline int pend_terms_holder(const struct pend_terms *terms, const int parent[], int k) {
    return parent[k] == 0 && pend_terms_cart(terms) ? -1 : parent[k];
}

/** Returns non-zero if adding whole turns to the initial angles changes only the angles. Springs
 * and rules (such as stops) distinguish turns, and a cart's position is not an angle. O(1). */
static inline int pend_terms_whole_turns(const struct pend_terms *terms) {
    return !terms ||
           (terms->row[PEND_TERM_STIFFNESS] < 0 && !terms->rules && !pend_terms_cart(terms));
}

/**
 * Fills a list with values that make all terms ineffective: 0 everywhere, speeds 1, joints at the
 * tips.
 *
 * value  out, terms->count numbers.
 */
void pend_terms_clear(const struct pend_terms *terms, const struct pend_tree *tree, double value[]);

/* The fault of a value in the list. */
struct pend_terms_fault {
    int row, one;     /* the term: one is its index, the other -1; if both are -1, a harmonic */
    int arm;          /* stored arm; -1 for a term of the pendulum; for a harmonic its index in the
                       * list */
    int part;         /* for a harmonic: 0 amplitude, 1 omega, 2 phase */
    const char *text; /* the requirement: "must be 0 or more" */
};

/**
 * Checks the values of a list.
 *
 * tree   the arms; a mass may be 0 if a rod or a body gives the arm an inertia about its own joint.
 * value  terms->count numbers.
 * found  called for every fault, `context` first.
 *
 * Returns the number of faults. O(count).
 */
int pend_terms_check(const struct pend_terms *terms, const struct pend_tree *tree,
                     const double value[],
                     void (*found)(void *context, const struct pend_terms_fault *fault),
                     void *context);

/** Returns true if x is a valid value at an index of the list: finite, and >= 0 or > 0 if the term
 * requires this. O(1). */
int pend_terms_fits(const struct pend_terms *terms, int place, double x);

/** Returns non-zero if the energy (kinetic, of gravity and of springs) is conserved: no friction,
 * no drag, no torque, and a fixed pivot. O(n). */
int pend_terms_conserve(const struct pend_terms *terms, const double value[]);

/** Returns the inertia of stored arm k alone about its joint, kg m^2, from its tip mass, rod and
 * body. O(1). */
double pend_terms_inertia(const struct pend_terms *terms, double length, double mass,
                          const double value[], int k);

/**
 * Returns an estimate of how fast terms make a pendulum near rest move, rad/s: springs, torques,
 * friction and drag act on each arm's own inertia. 0 if there are none.
 *
 * mass   n masses at the tips, kg; further inertia of an arm is in the terms.
 * decay  out, 1/s: contribution of friction and drag; NULL if not needed.
 * O(n + harmonics).
 */
double pend_terms_rate(const struct pend_terms *terms, const int parent[], const double length[],
                       const double mass[], const double value[], double *decay);

/** Returns the largest angular frequency of the drives, rad/s; 0 without drives. O(harmonics). */
double pend_terms_drive_rate(const struct pend_terms *terms, const double value[]);
