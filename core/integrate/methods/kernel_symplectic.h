/* One step of the Gauss-Legendre collocation of 8 stages in angles and momenta, each stage in a
 * lane of a vector, compiled for each instruction set.
 * Leaves to others: memory, the length of the step, values inside it (method_symplectic).
 * Invariant: the map from (phi, p) to (phi, p) is symplectic and symmetric up to rounding. */
#pragma once

#include <stddef.h>

#include "core/base/isa.h"
#include "core/tree/loads.h"

/* Angles, rad, and their momenta p = Re M phi', kg m^2 rad/s, as sums of two doubles; n values
 * each. */
struct symplectic_state {
    double *phi, *phi_low, *p, *p_low;
};

struct symplectic_system {
    int n;
    const int *parent, *end;
    struct pend_loads loads;    /* gravity and other loads, whose terms conserve the energy */
    const double *subtree_mass; /* n values, kg */
    double length;              /* s, > 0: length of the step, in either direction of time */
    double weight[8];           /* s: the step times b_j */
    double *lanes;   /* symplectic_count doubles, aligned to 64: the tree system, eight lanes per
                      * value */
    long iterations; /* number of iterations in all steps so far */
};

struct symplectic_kernel {
    /** Returns the number of doubles in `lanes` for n arms; terms: NULL for ideal pendulums. */
    size_t (*count)(const struct pend_terms *terms, int n);
    /** Copies a tree and the values of its terms into the lanes. The first guess for the next step
     * is then that the state does not change. */
    void (*load)(struct symplectic_system *system, const double len[], const double mass[]);
    /** Computes the momenta p = Re M(phi) phi'. O(n). */
    void (*momenta)(const struct symplectic_system *system, const double phi[], const double rate[],
                    double p[]);
    /** Computes the rates phi' = (Re M(phi))^-1 p. O(n). */
    void (*rates)(const struct symplectic_system *system, const struct symplectic_state *state,
                  double rate[]);
    /**
     * Takes one step: iterates the equations of the stages until only rounding errors remain.
     *
     * Returns 1; 0 if the iteration does not converge; -1 if a number is not finite. `to` is
     * undefined unless the step returns 1.
     */
    int (*step)(struct symplectic_system *system, const struct symplectic_state *from,
                const struct symplectic_state *to);
};

PEND_ISA_EACH(struct symplectic_kernel, pend_kernel_symplectic);
