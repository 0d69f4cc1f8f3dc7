/* The sweeps over a tree with many shifts side by side, one shift in each lane of a vector, and
 * the choice of the instruction set.
 * Leaves to others: the choice of shifts (modes_values), orthogonality (modes_vectors).
 * Invariant: a lane's bits depend only on its shift, not on other lanes or their number. */
#pragma once

#include "core/base/isa.h"
#include "core/modes/laplacian.h"

/* The eigenvalue count and the logarithmic derivatives of the characteristic polynomial p at a
 * shift. */
struct pend_modes_probe {
    double shift;    /* in, 1/s^2 */
    int below;       /* number of eigenvalues below the shift */
    double log_rate; /* sum 1 / (shift - lambda_i), which is p'/p, s^2 */
    double log_bend; /* sum 1 / (shift - lambda_i)^2, which is (p'/p)^2 - p''/p, s^4; not finite if
                      * a pivot is zero */
};

struct pend_modes_kernel {
    int lanes; /* number of eigenvectors that one call of `vectors` or `fine` computes */

    /** Computes count probes from their shifts. O(count n). */
    void (*probe)(const struct pend_laplacian *laplacian, int count,
                  struct pend_modes_probe probe[]);

    /**
     * Computes eigenvectors of mass norm 1 by twisted factorization.
     *
     * value   `lanes` eigenvalues to full precision.
     * lead    the node whose angle is to be positive.
     * work    3 * lanes * n doubles, aligned to 64.
     * vector  out, `lanes` pointers to n angles each; unused lanes may share one.
     * tip     out, the same for the tip displacements; NULL if not needed.
     */
    void (*vectors)(const struct pend_laplacian *laplacian, const double value[], int lead,
                    double work[], double *vector[], double *tip[]);

    /**
     * Computes the same in double-double, in about ten times the time, for close eigenvalues. It
     * refines the eigenvalues too, so that vectors whose eigenvalues agree to 1e-11 are still
     * orthogonal to round-off.
     *
     * work    6 * lanes * n doubles, aligned to 64.
     */
    void (*fine)(const struct pend_laplacian *laplacian, const double value[], int lead,
                 double work[], double *vector[], double *tip[]);
};

PEND_ISA_EACH(struct pend_modes_kernel, pend_modes_kernel);
