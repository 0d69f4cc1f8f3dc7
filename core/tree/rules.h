/* The rules that divide a motion into pieces, and the changes between two pieces.
 * Leaves to others: the loop over pieces (core/integrate/pieces), their JSON (api).
 * Invariant: immutable while a motion is computed; a motion without rules is one piece. */
#pragma once

#include <stddef.h>

#include "core/base/status.h"
#include "core/tree/terms.h"

/* The value of a table before its first and after its last instant. */
enum pend_outside { PEND_OUTSIDE_REFUSE, PEND_OUTSIDE_HOLD, PEND_OUTSIDE_ZERO };

/* A torque, N m, or a force on a cart, N, given at instants, or a coordinate of the pivot, m, as a
 * natural cubic spline. It is added to the other inputs. */
struct pend_table {
    int drives; /* a stored arm; 0 for a pendulum on a cart is the cart; or PEND_DRIVE_PIVOT_X, _Y
                 */
    int count;  /* instants, >= 1 */
    int linear; /* 0 = a value holds until the next instant; 1 = linear between two instants */
    enum pend_outside outside;
    const double *t, *value; /* s, ascending, in the time of the drives; not owned */
    const double *bend;      /* of a pivot: second derivatives, m/s^2; not owned */
};

/* Rows of numbers over time, linear between instants and constant outside; without instants, one
 * row for all times. The numbers are in the list of the rules, from index t and from index value
 * on. */
struct pend_schedule {
    int count, width; /* number of instants, 0 = one row; numbers per row */
    size_t t, value;
};

enum pend_law_kind { PEND_LAW_FEEDBACK, PEND_LAW_PID, PEND_LAW_SWING_UP };

/* How a controller computes its output from the state x: all angles theta, then all rates, stored
 * order; for a cart its position, m, and speed, m/s. */
struct pend_law {
    enum pend_law_kind kind;
    /* feedback: u = -gains (x - reference); after the 2 n gains there may be gains of delayed
     * outputs (computed, not yet acting) of all controllers, newest first.
     * pid: u = p e + i (sum of e period) + d e', e = reference - the joint's angle, or the cart's
     * position; gains p, i, d; the sum is kept constant while the output is at a limit. swing_up: u
     * = g (E* - E) r - p x - d v, gains g, p, d. E is the energy, r the joint's rate. On a cart E
     * is that of the arms as the cart sees them, r less their momentum along the rail, x and v the
     * cart's place and speed; p and d are 0 in a joint. */
    struct pend_schedule gains, reference;
    double energy; /* J, E*; NAN = the potential energy at the reference of the next law */
    /* swing_up: the law `next` takes over at the first sample at which each angle, reduced by whole
     * turns, and each rate is within a bound of its reference; rad, rad/s */
    double within[2];
    int next;
};

/* A sampling controller: at start + k period it computes its output, which acts `delay` samples
 * later for one period. */
struct pend_controller {
    int drives, law, delay;
    double period;    /* s */
    double low, high; /* N m or N: limits of the output */
    double quantum;   /* the output is a multiple of it; 0 = any value */
};

/* Arrays of n values in stored order, not owned. */
struct pend_rules {
    int tables, controllers;
    const struct pend_table *table;
    const struct pend_controller *controller;
    const struct pend_law *law;
    const double *number;
    size_t numbers; /* size of `number`, and of all tables */
    /* Coulomb friction of joints, N m, 0 = none: when sliding, and the largest when holding, which
     * is not smaller; both NULL = no joint has any. */
    const double *sliding, *holding;
    /* Stops of joints: limits of the angle to the parent (for a root and for arms on a cart, of
     * theta; for a cart, of its position, m); infinity = no stop; restitution 0 .. 1. All NULL = no
     * joint has any. */
    const double *least, *most, *restitution;
};

/** Returns non-zero if joints may hold, stick or hit a stop. O(1). */
static inline int pend_rules_joints(const struct pend_rules *rules) {
    return rules->sliding || rules->least;
}

/**
 * Computes the second derivatives of a natural cubic spline at its instants.
 *
 * bend  out, count values, the first and the last 0.
 * work  count values.
 *
 * The tridiagonal system of continuous first derivatives, by elimination. O(count).
 */
void pend_rules_spline(int count, const double t[], const double value[], double bend[],
                       double work[]);

/** Returns the first instant, s, at which an input changes after `now`, or before it if way < 0;
 * infinite if there is none. O(tables log(instants)). */
double pend_rules_next(const struct pend_rules *rules, double now, int way);

/** Writes a pivot's position, m, and its first three derivatives at `now`, x and y of each, in the
 * piece that starts there, or ends there if way < 0; coordinates without a table keep theirs.
 * O(tables log(instants)). */
void pend_rules_track(const struct pend_rules *rules, double now, int way, double track[8]);

/**
 * Writes the inputs of the piece that starts at an instant, or that ends there if way < 0.
 *
 * now    s, the instant; becomes PEND_TERM_PIECE.
 * value  in and out: the list of the terms; number j at value[j * stride].
 *
 * O(n + tables log(instants)).
 */
void pend_rules_inputs(const struct pend_rules *rules, const struct pend_terms *terms, double now,
                       int way, double value[], size_t stride);

/** Writes the inputs as pend_rules_inputs does, and returns the end of the piece as pend_rules_next
 * does. For a pendulum without rules it writes nothing and returns infinity. */
double pend_rules_piece(const struct pend_terms *terms, double now, int way, double value[],
                        size_t stride);

/**
 * Estimates the number of pieces of a motion, beyond one; rules may be NULL.
 *
 * span  s, length of the motion.
 * rate  rad/s, of the fastest swing; determines how fast joints reach their stops.
 * Samples and instants of tables are counted, impacts are those of flights that a restitution
 * lengthens between two stops and shortens at one. O(n + tables + controllers).
 */
double pend_rules_pieces(const struct pend_rules *rules, int n, double span, double rate);

/**
 * Checks that the tables cover the times of a motion, and that time increases if there are
 * controllers.
 *
 * PEND_INVALID  the motion leaves a table without outside values; error->arm is the caller's arm
 *               number by `order`.
 */
PEND_MUST_CHECK enum pend_status pend_rules_check(const struct pend_rules *rules, const int order[],
                                                  double first, double last,
                                                  struct pend_error *error);
