/* The state of a search for orbits, and what its parts have in common.
 * Leaves to others: steps along a branch (orbit_branch), bifurcations between them (orbit_change).
 * Invariant: the equations that Newton's method solves are those of the branch under way. */
#ifndef PEND_ORBIT_SEARCH_H
#define PEND_ORBIT_SEARCH_H

#include "core/orbits/orbit_check.h"
#include "core/orbits/orbit_floquet.h"
#include "core/orbits/orbit_switch.h"

enum orbits_stage { SETTLE, SEARCH, CHECK, CHANGES, LEAVE, FORWARD, OVER };

/* What a search of Newton's method is for. */
enum orbits_aim { FIRST, STEP, LAST, LOCATE, LOOK, HALF };

/* What may differ between two orbits of a branch. Two real multipliers that meet away from the
 * circle and become a pair, or the reverse, change none of it. */
enum orbits_border {
    ORBIT_TURN = ORBIT_REAL, /* whether the energy, or what varies, grows along the branch */
    ORBIT_AROUND,            /* how many multipliers are outside the circle, real or not */
    ORBIT_BORDERS
};

/* On which side of every border an orbit is: of +1 and -1 whether an odd number of real multipliers
 * is beyond it. */
struct orbits_mark {
    double at; /* part of the way from the last orbit to the next */
    int side[ORBIT_BORDERS];
    int beyond[ORBIT_REAL], surely[ORBIT_REAL], outside; /* as in orbit_floquet */
    double test[ORBIT_TURN + 1]; /* passes 0 at a border; of ORBIT_TURN the slope */
};

/* An orbit on its branch. */
struct orbits_point {
    double *u, *along; /* unknowns; direction of the branch */
    struct orbits_mark mark;
};

/* most orbits between the last and the next that are kept, each on other sides than its neighbours
 */
enum { ORBITS_AHEAD = 16 };

struct pend_orbits {
    struct pend_orbit_problem problem;
    struct orbit_newton newton;
    struct orbit_floquet floquet;
    struct orbit_check check;
    enum orbits_stage stage;
    enum orbits_aim aim, came;      /* came: that of the search which has found the next orbit */
    struct orbits_point last, next; /* the orbit before, and the one looked for */
    double begin, step, before;     /* lengths of the first step, the one under way, the last one */
    double swing;                   /* rad, the first swing of a branch between two rests */
    double *turned;                 /* the direction at the orbit before the last */
    double *home;                   /* 2 x unknowns: the first orbit of a branch, its direction */
    double *leaving;                /* 2 x unknowns: the direction in which a branch is left */
    double way;                     /* of the last orbit, 1 = at the end */
    int points;                     /* steps so far */
    enum pend_orbits_end end, why;  /* why: the last step failed */
    int part;
    /* bifurcations between the two: all up to `low` were answered; the next one is before the last
     * of the orbits ahead, of which there are `waiting`, -1: none was looked for yet */
    struct orbits_mark low, ahead[ORBITS_AHEAD];
    int waiting, border, tries, side;
    int known[ORBIT_REAL];       /* multipliers pass there: they are not at +1, or -1, all along */
    int beside;                  /* orbits on either side of a turn that were looked for */
    double at, touch, weight[2]; /* parts of the way; weights of the tests at low and ahead */
    enum pend_orbits_kind turned_at; /* as pend_orbits_turned */
    int met;                         /* bifurcations of this branch so far */
    int left, attempts; /* branches that were left; tries to step onto the one that begins there */
    struct pend_orbit now;
    struct pend_run *settling;
    long settled; /* its steps */

    double *amplitude, *row, *block; /* row: of the start that is moved on */
};

/** True if the invariants of a search hold. For assertions. O(1). */
int pend_orbits_valid(const struct pend_orbits *orbits);

/** Begins a branch between two rests with its first swing, in the shape of its mode. O(n). */
void pend_orbit_search_small(struct pend_orbits *o);

/** Asks the next search for the plane through newton.u across a direction. O(n). */
void pend_orbit_search_plane(struct pend_orbits *o, const double normal[]);

/** Begins a search of Newton's method from newton.u, across the plane that was set. O(n). */
void pend_orbit_search_begin(struct pend_orbits *o, enum orbits_aim aim);

/** Fills in what the multipliers of the orbit found say, and the slope of its branch along a
 * direction; sides and `at` are kept. O(n). */
void pend_orbit_search_mark(const struct pend_orbits *o, const double along[],
                            struct orbits_mark *mark);

/** Returns the scalar product of two lists. O(count). */
double pend_orbit_search_dot(const double a[], const double b[], int count);

/** Ends the search; with branches yet to be left it ends as PEND_ORBITS_MISSING where the branch
 * was followed to an end. */
void pend_orbit_search_over(struct pend_orbits *o, enum pend_orbits_end end);

/**
 * Sets what is answered to the orbit of a list of unknowns, to which the equations are set.
 *
 * The failures of pend_orbit_form_set.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_search_tell(struct pend_orbits *o, const double u[],
                                                        struct pend_error *error);

#endif
