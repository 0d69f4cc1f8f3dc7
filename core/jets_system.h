/* The arrays that the power-series kernels work on, for every kind of number.
 * Leaves to others: the numbers and the arithmetic (jets_kernel), memory (jets).
 * Invariant: one block, every array `stride` numbers long or a whole number of strides. */
#ifndef PEND_JETS_SYSTEM_H
#define PEND_JETS_SYSTEM_H

#include <stddef.h>

#ifndef JETS_NUM
#define JETS_NUM double
#endif
typedef JETS_NUM num;

/* name, what it holds for an arm; k is the arm, sums go over its children */
#define JETS_ARRAYS(X)                                                                                                 \
    X(len)                                                                                                             \
    X(inv_len) X(mass) X(angle) X(angle_low) /* to the parent, as a sum of two */                                      \
        X(cosine) X(sine)                    /* of the angle to the parent */                                          \
        X(eff) X(inv_eff)                    /* S, 1 / S */                                                            \
        X(inv)                               /* 1 / (m + q) */                                                         \
        X(lean)                              /* r / (m + q) */                                                         \
        X(kappa) X(nu) X(tau)                /* how an arm's share reaches its parent, and the two of tension first */ \
        X(stiff) X(weight)                   /* S kappa, S l */                                                        \
        X(sum_p) X(sum_r) X(sum_q) X(sum_d) X(late_q) X(late_r) X(late) /* sums over the later siblings of an arm */   \
        X(early)                                                        /* sum over the children met so far */         \
        X(wind_re) X(wind_im)                                           /* T, the known part of u' */                  \
        X(drag_re) X(drag_im)                                           /* c, the known part of lambda u */            \
        X(heave)                                                        /* S l (k + 1) Im T */                         \
        X(push) X(bias) X(side)                                         /* h, f, and the known force across the arm */ \
        X(sum_push) X(sum_side) X(sum_cos) X(sum_sin) X(tension) X(radial) X(tangential) /* acceleration of the tip */ \
        X(from_radial) X(from_tangential)                                                /* the same of the parent */

struct jets_system {
    int n;
    size_t stride;
    const int *parent, *end;
    const double *share;                   /* 1 / (j + 1) of order j */
    num *rate, *force, *turn_re, *turn_im; /* order-major series */
#define X(name) num *name;
    JETS_ARRAYS(X)
#undef X
};

#endif
