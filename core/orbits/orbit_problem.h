/* The request for periodic orbits (the pendulum, the orbits, the end of the branch), and the
 * reported properties of an orbit.
 * Leaves to others: finding them (orbits), names and JSON (api).
 * Invariant: stored order. */
#pragma once

#include "core/derivatives/derivatives.h"

/* The end of a branch of orbits between two states of rest, which starts with small swings. */
enum pend_orbit_target {
    PEND_ORBIT_AMPLITUDE, /* rad: the largest angle of any arm at rest, from the equilibrium */
    PEND_ORBIT_ENERGY     /* J above the equilibrium */
};

/* The parameter in which orbits of a driven pendulum are continued. */
enum pend_orbit_vary {
    PEND_ORBIT_ALONE,    /* none: one orbit */
    PEND_ORBIT_OMEGA,    /* the frequency of the drive; harmonics keep their ratios */
    PEND_ORBIT_PARAMETER /* a length, a mass, gravity, or a number of the list of terms */
};

/* largest number of drive periods in an orbit; largest number of branch switches */
enum { PEND_ORBIT_PERIODS = 8, PEND_ORBIT_SWITCHES = 8 };

struct pend_orbit_problem {
    const struct pend_tree *tree; /* must outlive the search, as must loads and starts */
    struct pend_loads loads;
    int driven;  /* non-zero: orbits of a driven pendulum; 0: orbits between two states of rest */
    int branch;  /* non-zero: report every orbit of the branch, otherwise only the last */
    int points;  /* largest number of steps along a branch, >= 1 */
    double step; /* longest step, rad, or of that length in other unknowns; > 0 */
    /* for orbits between two states of rest */
    int mode; /* index, from 0, among the modes that swing, slowest first */
    enum pend_orbit_target target;
    double until; /* > 0, the end of the branch */
    /* for orbits of driven pendulums */
    int periods; /* number of drive periods, 1 .. PEND_ORBIT_PERIODS */
    int settle;  /* periods of the drive that are integrated from the start before the search */
    const double *phi, *rate; /* n: the state at time 0, near an orbit */
    enum pend_orbit_vary vary;
    struct pend_parameter by; /* the varied parameter, for PEND_ORBIT_PARAMETER */
    double to;                /* end value of the varied number, in its unit */
    /* The bifurcations, numbered from 1, at which the search switches in turn to the branch that
     * begins there; < 0: to its other side. Only orbits of the last branch are reported. Requires
     * `branch`. */
    int switches, leave[PEND_ORBIT_SWITCHES];
};

/** Returns the largest number of unknowns that an orbit of such a problem can have. O(1). */
static inline int pend_orbit_unknowns(const struct pend_orbit_problem *problem) {
    return (problem->driven || problem->switches ? 2 : 1) * problem->tree->n + 1;
}

/* The result of a call. */
enum pend_orbits_found {
    PEND_ORBITS_NOTHING,     /* continue */
    PEND_ORBITS_ORBIT,       /* the next orbit of the branch, or the requested one */
    PEND_ORBITS_BIFURCATION, /* a bifurcation between the last two orbits */
    PEND_ORBITS_END          /* the search has ended */
};

/* How a search ended. */
enum pend_orbits_end {
    PEND_ORBITS_REACHED, /* the requested end was reached */
    PEND_ORBITS_POINTS,  /* the largest allowed number of steps was used */
    PEND_ORBITS_LOST,    /* no orbit was found beyond the last one, even with the shortest step */
    PEND_ORBITS_MEETS,   /* beyond the last one, the orbits have a fraction of the period */
    PEND_ORBITS_WILD,    /* beyond the last one, doubles cannot decide whether an orbit returns */
    PEND_ORBITS_BACK,    /* the branch of a driven pendulum returned to its start */
    PEND_ORBITS_CLOSED,  /* the branch is closed: it returned to its first orbit */
    PEND_ORBITS_NONE,    /* there is no orbit near the start */
    PEND_ORBITS_MISSING, /* the branch has no bifurcation of the requested number */
    PEND_ORBITS_APART,   /* no supported branch was found at that bifurcation */
    PEND_ORBITS_ENDS
};

/* The kind of a bifurcation, where multipliers of the orbit cross the unit circle. */
enum pend_orbits_kind {
    PEND_ORBITS_FOLD,     /* at +1: the branch turns back, in energy or in the varied number */
    PEND_ORBITS_BRANCH,   /* at +1: another branch crosses */
    PEND_ORBITS_SYMMETRY, /* at +1, or -1 of the half period: orbits with and without the mirror
                           * symmetry meet */
    PEND_ORBITS_DOUBLING, /* at -1: orbits of twice the period begin */
    PEND_ORBITS_TORUS,    /* a complex pair crosses the circle: quasi-periodic motion */
    PEND_ORBITS_KINDS
};

/* An orbit; arrays of n numbers in stored order, valid until the next call. */
struct pend_orbit {
    const double *phi, *phi_low, *rate; /* the start of the orbit: at rest, or at time 0 */
    const double *amplitude;            /* rad, from the equilibrium; for driven orbits, half of the
                                         * difference between the extremes at 841 instants */
    const double *re, *im;              /* 2 n multipliers */
    double period;                      /* s */
    double energy;                      /* J above the equilibrium; 0 for driven orbits */
    double value;                       /* value of the varied number; 0 if none */
    double closure;             /* distance of the motion's end from its start: rad, and rates
                                 * relative to the mode's or the drive's frequency */
    int stable;                 /* whether no small disturbance grows exponentially */
    enum pend_orbits_kind kind; /* kind of a bifurcation */
    int turns;                  /* for a bifurcation: whether the branch turns back there */
};
