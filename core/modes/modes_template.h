/* The sweeps over a tree with many shifts side by side, one a vector lane, and the choice of
 * instruction set.
 * Leaves to others: which shifts (modes_values), orthogonality (modes_vectors).
 * Invariant: a lane's bits depend on its shift alone, not on the lanes beside it, nor on their
 * number. */
#ifndef PEND_MODES_TEMPLATE_H
#define PEND_MODES_TEMPLATE_H

#include "core/base/isa.h"
#include "core/modes/laplacian.h"

/* What the characteristic polynomial p tells at a shift. */
struct pend_modes_probe {
    double shift;    /* in, 1/s^2 */
    int below;       /* the number of eigenvalues below it */
    double log_rate; /* p'/p = sum 1 / (shift - lambda_i), s^2 */
    double log_bend; /* (p'/p)^2 - p''/p = sum 1 / (shift - lambda_i)^2, s^4; not finite when a
                        pivot vanished */
};

struct pend_modes_kernel {
    int lanes; /* vectors that `vectors` makes at a time */

    /** Fills count probes from their shifts. O(count n). */
    void (*probe)(const struct pend_laplacian *laplacian, int count,
                  struct pend_modes_probe probe[]);

    /**
     * Eigenvectors by twisted factorization, of mass norm 1.
     *
     * value   `lanes` eigenvalues to full precision.
     * lead    the node whose angle is to be positive.
     * work    3 * lanes * n doubles, aligned to 64.
     * vector  out, `lanes` pointers to n angles each; lanes of no interest may share one.
     * tip     out, the same for the tip displacements; NULL to skip.
     */
    void (*vectors)(const struct pend_laplacian *laplacian, const double value[], int lead,
                    double work[], double *vector[], double *tip[]);

    /**
     * The same in sums of two doubles, about ten times as slow, for eigenvalues that are near each
     * other: those are refined too, so that vectors whose eigenvalues agree to 1e-11 are still
     * orthogonal to round-off.
     *
     * work    6 * lanes * n doubles, aligned to 64.
     */
    void (*fine)(const struct pend_laplacian *laplacian, const double value[], int lead,
                 double work[], double *vector[], double *tip[]);
};

/** The kernel of this processor. */
const struct pend_modes_kernel *pend_modes_kernel(void);

/** The kernel compiled for an instruction set, NULL where this processor does not run it. */
const struct pend_modes_kernel *pend_modes_kernel_of(enum pend_isa isa);

#endif
