/* What is wanted of periodic orbits, the pendulum, which orbits, how far they are followed; and
 * what is told of one.
 * Leaves to others: finding them (orbits), names and JSON (api).
 * Invariant: stored order. */
#ifndef PEND_ORBIT_PROBLEM_H
#define PEND_ORBIT_PROBLEM_H

#include "core/derivatives/derivatives.h"

/* Up to where orbits between two rests are followed, from small swings on. */
enum pend_orbit_target {
    PEND_ORBIT_AMPLITUDE, /* rad: the largest angle of any arm from the rest, where all turn back */
    PEND_ORBIT_ENERGY     /* J above the rest */
};

/* In what orbits of a driven pendulum are followed. */
enum pend_orbit_vary {
    PEND_ORBIT_ALONE,    /* in nothing: one orbit */
    PEND_ORBIT_OMEGA,    /* the frequency of the drive; harmonics keep their ratios */
    PEND_ORBIT_PARAMETER /* a length, a mass, gravity, or a number of the list of terms */
};

/* most periods of a drive that an orbit may take, most branches that are changed for another */
enum { PEND_ORBIT_PERIODS = 8, PEND_ORBIT_SWITCHES = 8 };

struct pend_orbit_problem {
    const struct pend_tree *tree; /* outlives the search, as loads and starts do */
    struct pend_loads loads;
    int driven;  /* non-zero: orbits of a driven pendulum, else between two rests */
    int branch;  /* non-zero: every orbit on the way is wanted, else the last alone */
    int points;  /* most steps along a branch, >= 1 */
    double step; /* the longest one, rad or as long in other unknowns; > 0 */
    /* between two rests */
    int mode; /* from 0, among the modes that swing, slowest first */
    enum pend_orbit_target target;
    double until; /* > 0 */
    /* driven */
    int periods; /* of the drive, 1 .. PEND_ORBIT_PERIODS */
    int settle;  /* periods of the drive that the start is moved on before the search */
    const double *phi, *rate; /* n: near an orbit at the time 0 */
    enum pend_orbit_vary vary;
    struct pend_parameter by; /* for PEND_ORBIT_PARAMETER */
    double to;                /* where it is followed to, in the unit of what varies */
    /* At which bifurcations, from 1, the branch is left for the one that begins there, one after
     * the other; < 0: to its other side. The orbits of the last branch alone are told. With a
     * branch. */
    int switches, leave[PEND_ORBIT_SWITCHES];
};

/** Returns the most unknowns of an orbit of such a problem. O(1). */
static inline int pend_orbit_unknowns(const struct pend_orbit_problem *problem) {
    return (problem->driven || problem->switches ? 2 : 1) * problem->tree->n + 1;
}

/* What a call has found. */
enum pend_orbits_found {
    PEND_ORBITS_NOTHING,     /* go on */
    PEND_ORBITS_ORBIT,       /* the next orbit of the branch, or the one that is wanted */
    PEND_ORBITS_BIFURCATION, /* between the last two orbits */
    PEND_ORBITS_END          /* the search is over */
};

/* How a search ended. */
enum pend_orbits_end {
    PEND_ORBITS_REACHED, /* where it was wanted to */
    PEND_ORBITS_POINTS,  /* after as many steps as were allowed */
    PEND_ORBITS_LOST,    /* no orbit was found beyond the last one, however short the step */
    PEND_ORBITS_MEETS,   /* beyond the last one are orbits that take a part of the period */
    PEND_ORBITS_WILD,    /* beyond the last one doubles do not tell whether an orbit comes back */
    PEND_ORBITS_BACK,    /* the branch of a driven pendulum came back to where it began */
    PEND_ORBITS_CLOSED,  /* the branch is closed: it came back to its first orbit */
    PEND_ORBITS_NONE,    /* there is no orbit near the start */
    PEND_ORBITS_MISSING, /* the branch has no such bifurcation at which it was to be left */
    PEND_ORBITS_APART,   /* no branch was found there of orbits that are looked for */
    PEND_ORBITS_ENDS
};

/* What happens at a bifurcation, where multipliers of the orbit pass a border. */
enum pend_orbits_kind {
    PEND_ORBITS_FOLD,     /* +1: the branch turns back, in energy or in what varies */
    PEND_ORBITS_BRANCH,   /* +1: another branch crosses */
    PEND_ORBITS_SYMMETRY, /* +1, -1 of the half period: orbits without the mirror symmetry meet
                             those that have it */
    PEND_ORBITS_DOUBLING, /* -1: orbits of twice the period */
    PEND_ORBITS_TORUS,    /* a complex pair begins or ceases to grow */
    PEND_ORBITS_KINDS
};

/* An orbit; arrays of n numbers in stored order, valid until the next call. */
struct pend_orbit {
    const double *phi, *phi_low, *rate; /* where it begins: at rest, or at the time 0 */
    const double *amplitude;    /* rad: from the rest; of driven ones half of the way between the
                                   extremes, seen at 841 instants */
    const double *re, *im;      /* 2 n multipliers */
    double period;              /* s */
    double energy;              /* J above the rest; of driven ones 0 */
    double value;               /* of what varies; 0 where nothing does */
    double closure;             /* how far the motion over the period misses its start: rad, and
                                   rates in parts of the mode's or the drive's frequency */
    int stable;                 /* no small disturbance grows exponentially */
    enum pend_orbits_kind kind; /* of a bifurcation */
    int turns;                  /* of a bifurcation: the branch turns back there */
};

#endif
