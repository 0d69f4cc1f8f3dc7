/* One step of the Gauss-Legendre collocation of 8 stages in angles and momenta, a stage a lane,
 * by instruction set.
 * Leaves to others: memory, the length of the step, values inside it (method_symplectic).
 * Invariant: the map from (phi, p) to (phi, p) is symplectic and symmetric but for rounding. */
#ifndef PEND_KERNEL_SYMPLECTIC_H
#define PEND_KERNEL_SYMPLECTIC_H

#include <stddef.h>

#include "core/tree/loads.h"

/* Angles, rad, and their momenta p = Re M phi', kg m^2 rad/s, as sums of two: n values each. */
struct symplectic_state {
    double *phi, *phi_low, *p, *p_low;
};

struct symplectic_system {
    int n;
    const int *parent, *end;
    struct pend_loads loads;    /* what acts on the tree */
    const double *subtree_mass; /* n values, kg */
    double length;              /* s, > 0, of the step, whatever its direction */
    double weight[8];           /* s: the step times b_j */
    double *lanes;   /* symplectic_count(n) doubles, aligned to 64: the tree system, eight lanes a
                        value */
    long iterations; /* in all steps so far */
};

struct symplectic_kernel {
    /** Doubles that `lanes` needs. */
    size_t (*count)(int n);
    /** Lays a tree out in the lanes; the first guess of the next step is that nothing moves. */
    void (*load)(struct symplectic_system *system, const double len[], const double mass[]);
    /** Momenta of rates: p = Re M(phi) phi'. */
    void (*momenta)(const struct symplectic_system *system, const double phi[], const double rate[],
                    double p[]);
    /** Rates of momenta: phi' = (Re M(phi))^-1 p. */
    void (*rates)(const struct symplectic_system *system, const struct symplectic_state *state,
                  double rate[]);
    /**
     * One step; the stages' equations are iterated until rounding ends their convergence.
     *
     * Returns 1, 0 when they do not converge, -1 when a number is not finite; `to` then holds
     * nothing of use.
     */
    int (*step)(struct symplectic_system *system, const struct symplectic_state *from,
                const struct symplectic_state *to);
};

extern const struct symplectic_kernel pend_kernel_symplectic_base;
#ifdef __x86_64__
extern const struct symplectic_kernel pend_kernel_symplectic_avx2, pend_kernel_symplectic_avx512;
#endif

#endif
