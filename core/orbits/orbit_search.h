/* The state of a search for orbits, and functions that its parts share.
 * Leaves to others: steps along a branch (orbit_branch), bifurcations between them (orbit_change).
 * Invariant: the equations that Newton's method solves are those of the current branch. */
#pragma once

#include "core/orbits/orbit_check.h"
#include "core/orbits/orbit_floquet.h"
#include "core/orbits/orbit_switch.h"

enum orbits_stage { SETTLE, SEARCH, CHECK, CHANGES, LEAVE, FORWARD, OVER };

enum orbits_aim { FIRST, STEP, LAST, LOCATE, LOOK, HALF };

/* Boundaries that may lie between two orbits of a branch. If two real multipliers meet away from
 * the unit circle and become a complex pair, or the reverse, no boundary is crossed. */
enum orbits_border {
    ORBIT_TURN = ORBIT_REAL, /* the sign of the derivative of the energy, or of the varied number,
                              * along the branch */
    ORBIT_AROUND,            /* number of multipliers outside the unit circle */
    ORBIT_BORDERS
};

/* The side of each boundary on which an orbit lies. For +1 and -1, `beyond` is odd or even by the
 * number of real multipliers beyond the boundary. */
struct orbits_mark {
    double at; /* fraction of the path from the last orbit to the next */
    int side[ORBIT_BORDERS];
    int beyond[ORBIT_REAL], surely[ORBIT_REAL], outside; /* as in orbit_floquet */
    double test[ORBIT_TURN + 1]; /* changes sign at a boundary; for ORBIT_TURN it is the slope */
};

/* An orbit on its branch. */
struct orbits_point {
    double *u, *along; /* unknowns; direction of the branch */
    struct orbits_mark mark;
};

/* largest number of stored orbits between the last and the next; neighbours differ in at least one
 * side */
enum { ORBITS_AHEAD = 16 };

struct pend_orbits {
    struct pend_orbit_problem problem;
    struct orbit_newton newton;
    struct orbit_floquet floquet;
    struct orbit_check check;
    enum orbits_stage stage;
    enum orbits_aim aim, came;      /* aims of the current search, and of the one that found the
                                     * next orbit */
    struct orbits_point last, next; /* the previous orbit, and the one being searched */
    double begin, step, before;     /* lengths of the first step, of the current one, of the last */
    double swing;                   /* rad, first swing of orbits between two states of rest */
    double *turned;                 /* direction at the orbit before the last one */
    double *home;                   /* 2 x unknowns: the first orbit of the branch, and its
                                     * direction there */
    double *leaving;                /* 2 x unknowns: direction of leaving the branch */
    double way;                     /* progress at the last orbit; 1 = end of the branch */
    int points;                     /* number of steps so far */
    enum pend_orbits_end end, why;  /* why: the reason why the last step failed */
    int part;
    /* Search for bifurcations between the two orbits. All bifurcations up to `low` are reported;
     * the next one lies before the last of the `waiting` orbits in `ahead`. waiting is -1 until an
     * orbit was searched for. */
    struct orbits_mark low, ahead[ORBITS_AHEAD];
    int waiting, border, tries, side;
    int known[ORBIT_REAL];           /* how many multipliers cross or stay at +1 or -1 */
    int beside;                      /* number of orbits searched for on either side of a fold */
    double at, touch, weight[2];     /* fractions of the path; weights of the tests at `low` and at
                                      * the nearest orbit ahead */
    enum pend_orbits_kind turned_at; /* the kind that pend_orbits_turned returns */
    int met;                         /* number of bifurcations of this branch so far */
    int left, attempts; /* branches left so far; attempts to find a new branch's first orbit */
    struct pend_orbit now;
    struct pend_run *settling;
    long settled; /* number of steps taken while integrating drive periods before the search */

    double *amplitude, *row, *block; /* row: the state of that integration */
};

/** Returns true if the invariants of a search hold. For assertions. O(1). */
int pend_orbits_valid(const struct pend_orbits *orbits);

/** Starts a branch between two states of rest with its first swing, in the shape of its mode.
 * O(n). */
void pend_orbit_search_small(struct pend_orbits *o);

/** Sets the closing equation of the next search to the plane through newton.u with the given normal
 * vector. O(n). */
void pend_orbit_search_plane(struct pend_orbits *o, const double normal[]);

/** Starts Newton's method from newton.u with the closing equation that was set. O(n). */
void pend_orbit_search_begin(struct pend_orbits *o, enum orbits_aim aim);

/** Computes the tests of the multipliers of the orbit found, and the slope of its branch along a
 * direction. Leaves the sides and `at` of the mark unchanged. O(n). */
void pend_orbit_search_mark(const struct pend_orbits *o, const double along[],
                            struct orbits_mark *mark);

/** Returns the scalar product of two lists. O(count). */
double pend_orbit_search_dot(const double a[], const double b[], int count);

/** Ends the search. The reason becomes PEND_ORBITS_MISSING if the branch was followed to its end
 * without the requested bifurcation. */
void pend_orbit_search_over(struct pend_orbits *o, enum pend_orbits_end end);

/**
 * Sets the reported orbit from a list of unknowns that pend_orbit_form_set has set before.
 *
 * Fails as pend_orbit_form_set does.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_search_tell(struct pend_orbits *o, const double u[],
                                                        struct pend_error *error);
