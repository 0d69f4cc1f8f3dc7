/* Power series in time of a moving tree: rates and arm forces about one instant, to any order, O(n)
 * per order.
 * Leaves to others: step sizes, sums over steps, dense output (method_taylor).
 * Invariant: no allocation; coefficients in tiles of 8 arms, all orders of a tile together; one
 * thread at a time, because advance and values use scratch in the same memory. */
#pragma once

#include <stddef.h>

#include "core/base/isa.h"
#include "core/bodies/bodies.h"
#include "core/taylor/large/blocks.h"
#include "core/taylor/jets_loads.h"
#include "core/taylor/jets/kernel_jets.h"
#include "core/taylor/large/chain.h"
#include "core/taylor/large/rods.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

enum { PEND_JETS_ORDER_MIN = 3, PEND_JETS_ORDER_MAX = 40, PEND_JETS_PAD = 8 };

/* Coefficient j of arm k is array[pend_jets_place(jets, k, j)], in powers of x = t / unit: unit
 * phi' = sum_j rate_j x^j, j = 0 .. order, and unit^2 lambda = sum_j force_j x^j, j = 0 .. order -
 * 1. The other members are the series of e^{i (phi - phi_0)} and the tree system of order 0. */
struct pend_jets {
    const struct pend_tree *tree;
    int order_cap;
    enum pend_isa isa; /* the best instruction set of this processor, unless changed to a lower
                        * one */
    double *rate, *force;
    double *share;               /* 1 / (j + 1) of order j */
    struct jets_system system;   /* the order-0 tree system, in the same memory */
    struct blocks blocks;        /* for a tree of more than PEND_JETS_PAD arms */
    struct chain chain;          /* instead of blocks, for a suitable chain */
    struct rods rods;            /* in addition to `chain`, for a chain of rods */
    struct jets_loads loads;     /* for a real pendulum that the fast kernels support */
    struct bodies_system bodies; /* for any other real pendulum, instead of all the above */
    int real;                    /* non-zero for a real pendulum, which has terms */
    int general;                 /* non-zero if the general kernel is used */
};

/**
 * Returns the bytes of memory, a multiple of 64, for the series of a tree up to order_cap. O(n).
 *
 * terms  of a real pendulum, or NULL.
 */
size_t pend_jets_bytes(const struct pend_tree *tree, const struct pend_terms *terms, int order_cap);

/** Returns the length of an array with one value per arm, including padding. */
size_t pend_jets_stride(int n);

/** Returns the index of coefficient j of arm k in each series. */
static inline size_t pend_jets_place(const struct pend_jets *jets, int k, int j) {
    return jets_row(&jets->system, k) + (size_t)j * PEND_JETS_PAD;
}

/**
 * Prepares series in the caller's memory.
 *
 * jets       must not be moved: it contains pointers into itself.
 * tree       must outlive the series.
 * loads      their terms must outlive the series. Values that set the positions of masses are read
 *            only here, all others by pend_jets_expand.
 * order_cap  PEND_JETS_ORDER_MIN .. PEND_JETS_ORDER_MAX.
 * memory     pend_jets_bytes(tree, loads->terms, order_cap) bytes, aligned to 64; not owned.
 */
void pend_jets_init(struct pend_jets *jets, const struct pend_tree *tree,
                    const struct pend_loads *loads, int order_cap, void *memory);

/**
 * Expands the motion about a state. For a real pendulum only order 0 of the forces is computed;
 * pend_jets_forces computes the others.
 *
 * The order-0 system is factorized once; each order then costs four real convolutions per arm and
 * two sweeps.
 *
 * loads    gravity and other loads; gravity of any finite value.
 * unit     s, a power of two, of either sign: the unit of time. If it is near the next step, no
 *          order overflows.
 * state    n angles, rad, and angular velocities, rad/s, as sums of two doubles; arrays aligned to
 *          64 bytes and padded to PEND_JETS_PAD.
 * order    PEND_JETS_ORDER_MIN .. order_cap: the highest coefficient of phi' that is computed.
 *
 * Cannot fail; overflow shows as coefficients that are not finite. O(n order^2), no allocation.
 */
void pend_jets_expand(struct pend_jets *jets, const struct pend_loads *loads, double unit,
                      const struct jets_state *state, int order);

/** Computes the forces of orders 1 .. order - 1 of a real pendulum, after pend_jets_expand to at
 * least `order`; no effect for an ideal pendulum. Call it before reading `force` beyond order 0.
 * pend_jets_values calls it if forces are requested. O(n order^2). */
void pend_jets_forces(const struct pend_jets *jets, int order);

/**
 * Computes the power of drives, and of friction and drag, of a real pendulum as series in the same
 * variable, after pend_jets_expand to at least `order`.
 *
 * count       order, or up to 2 order - 1 with the general kernel: from `order` on, the products of
 *             the factors' known orders.
 * work, heat  out, coefficients 0 .. count - 1: J times unit^2 per unit of time.
 *
 * O(n order count), no allocation.
 */
void pend_jets_power(const struct pend_jets *jets, double unit, int order, int count, double work[],
                     double heat[]);

/** Computes the state x units of time after the state of the expansion; both are sums of two
 * doubles, arrays padded to PEND_JETS_PAD. O(n order). */
void pend_jets_advance(const struct pend_jets *jets, int order, double x, double unit,
                       const struct jets_state *from, const struct jets_state *to);

/** Computes the values x[i] units of time after the state of the expansion, i = 0 .. count - 1, in
 * rows of n. values->acc and values->force may be NULL. A row's bits do not depend on the other
 * rows. O(n order) per instant. */
void pend_jets_values(const struct pend_jets *jets, int order, const double x[], int count,
                      double unit, const struct jets_state *from, const struct jets_values *values);

/** Returns the bytes of memory for the responses of a tree, a multiple of 64; 0 for a tree of more
 * than PEND_JETS_PAD arms and for a real pendulum, whose responses are not stored. O(1). */
size_t pend_jets_answers_bytes(const struct pend_tree *tree, const struct pend_terms *terms);

/**
 * Makes all later expansions store the responses of the tree system, which pend_jets_spread needs.
 *
 * memory  pend_jets_answers_bytes(tree) bytes, not 0, aligned to 64; not owned.
 */
void pend_jets_answers(struct pend_jets *jets, void *memory);

/** Returns non-zero if expansions store the responses. O(1). */
int pend_jets_spreads(const struct pend_jets *jets);

/**
 * Propagates small errors of the expansion's state over a step, to first order. Requires
 * pend_jets_answers.
 *
 * loads, how->unit  those of the expansion.
 * phi, rate      in and out: the errors, rad and rad/s, aligned to 64 and padded with zeros to
 *                PEND_JETS_PAD.
 *
 * Returns the largest error of a force at the start, N. O(n^2), no allocation.
 */
double pend_jets_spread(const struct pend_jets *jets, const struct pend_loads *loads,
                        const struct jets_spread *how, double phi[], double rate[]);

/**
 * Computes the truncation error of a step of x units to `order`: the sum of all later terms. The
 * series contains `beyond` of them; JETS_FORETOLD more are extrapolated from the last terms.
 *
 * beyond     0 .. JETS_FITTED - 2.
 * rate, phi  out, pend_jets_stride values each, aligned to 64: the sums of terms of the rates, in
 *            units, and of the angles, divided by x.
 *
 * O(n).
 */
void pend_jets_left(const struct pend_jets *jets, int order, int beyond, double x, double rate[],
                    double phi[]);

/**
 * Returns the step in units, as the kernel's `reach`. O(n).
 *
 * order  >= PEND_TAYLOR_ORDER_MIN.
 */
double pend_jets_reach(const struct pend_jets *jets, int order, double log_rtol, double log_atol);
