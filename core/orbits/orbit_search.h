/* The state of a search for orbits, and functions that its parts share.
 * Leaves to others: steps along a branch (orbit_branch), bifurcations between them (orbit_change).
 * Invariant: the equations that Newton's method solves are those of the current branch. */
#pragma once

#include "core/orbits/orbit_check.h"
#include "core/orbits/orbit_floquet.h"
#include "core/orbits/orbit_switch.h"

enum orbits_stage { SETTLE, SEARCH, CHECK, CHANGES, LEAVE, FORWARD, OVER };

/* The purpose of a search by Newton's method. */
enum orbits_aim { FIRST, STEP, LAST, LOCATE, LOOK, HALF };

/* Properties that may differ between two orbits of a branch. If two real multipliers meet away from
 * the circle and become a pair, or the reverse, none of them changes. */
enum orbits_border {
    ORBIT_TURN = ORBIT_REAL, /* the sign of the change of the energy, or of the varied number, along
                              * the branch */
    ORBIT_AROUND,            /* the number of multipliers outside the circle, real or not */
    ORBIT_BORDERS
};

/* The side of every border on which an orbit is; for +1 and -1 whether the number of real
 * multipliers beyond is odd. */
struct orbits_mark {
    double at; /* part of the way from the last orbit to the next */
    int side[ORBIT_BORDERS];
    int beyond[ORBIT_REAL], surely[ORBIT_REAL], outside; /* as in orbit_floquet */
    double test[ORBIT_TURN + 1]; /* passes 0 at a border; for ORBIT_TURN the slope */
};

/* An orbit on its branch. */
struct orbits_point {
    double *u, *along; /* unknowns; direction of the branch */
    struct orbits_mark mark;
};

/* largest number of stored orbits between the last and the next, each on other sides than its
 * neighbours */
enum { ORBITS_AHEAD = 16 };

struct pend_orbits {
    struct pend_orbit_problem problem;
    struct orbit_newton newton;
    struct orbit_floquet floquet;
    struct orbit_check check;
    enum orbits_stage stage;
    enum orbits_aim aim, came;      /* came: that of the search that found the next orbit */
    struct orbits_point last, next; /* the previous orbit, and the one being searched */
    double begin, step, before;     /* lengths of the first step, the current one, the last one */
    double swing;                   /* rad, the first swing of a branch between two states of
                                     * rest */
    double *turned;                 /* the direction at the orbit before the last one */
    double *home;                   /* 2 x unknowns: the first orbit of a branch, its direction */
    double *leaving;                /* 2 x unknowns: the direction in which the branch is left */
    double way;                     /* of the last orbit, 1 = at the end */
    int points;                     /* steps so far */
    enum pend_orbits_end end, why;  /* why: the reason for which the last step failed */
    int part;
    /* Bifurcations between the two. All up to `low` are reported; the next one is before the last
     * of the `waiting` orbits ahead; -1: none was searched yet. */
    struct orbits_mark low, ahead[ORBITS_AHEAD];
    int waiting, border, tries, side;
    int known[ORBIT_REAL];           /* multipliers cross there, instead of staying at +1 or -1 */
    int beside;                      /* orbits searched on either side of a fold */
    double at, touch, weight[2];     /* parts of the way; weights of the tests at low and ahead */
    enum pend_orbits_kind turned_at; /* as pend_orbits_turned */
    int met;                         /* bifurcations of this branch so far */
    int left, attempts; /* number of branches left; attempts to step onto the new one */
    struct pend_orbit now;
    struct pend_run *settling;
    long settled; /* its steps */

    double *amplitude, *row, *block; /* row: of the start that is integrated */
};

/** Returns true if the invariants of a search hold. For assertions. O(1). */
int pend_orbits_valid(const struct pend_orbits *orbits);

/** Starts a branch between two states of rest with its first swing, in the shape of its mode.
 * O(n). */
void pend_orbit_search_small(struct pend_orbits *o);

/** Sets the closing equation of the next search to the plane through newton.u with a given normal.
 * O(n). */
void pend_orbit_search_plane(struct pend_orbits *o, const double normal[]);

/** Starts Newton's method from newton.u, with that plane. O(n). */
void pend_orbit_search_begin(struct pend_orbits *o, enum orbits_aim aim);

/** Computes the tests of the multipliers of the orbit found, and the slope of its branch along a
 * direction; does not change sides and `at`. O(n). */
void pend_orbit_search_mark(const struct pend_orbits *o, const double along[],
                            struct orbits_mark *mark);

/** Returns the scalar product of two lists. O(count). */
double pend_orbit_search_dot(const double a[], const double b[], int count);

/** Ends the search; PEND_ORBITS_MISSING if there are branches left to switch to and the branch was
 * followed to an end. */
void pend_orbit_search_over(struct pend_orbits *o, enum pend_orbits_end end);

/**
 * Sets the reported orbit to that of a list of unknowns, to which the equations are set.
 *
 * The failures of pend_orbit_form_set.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_search_tell(struct pend_orbits *o, const double u[],
                                                        struct pend_error *error);
