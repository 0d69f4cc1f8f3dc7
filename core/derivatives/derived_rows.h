/* The quantities of a motion that have derivatives, and the rows that receive them.
 * Leaves to others: computing them (derivatives), the parameters (parameter).
 * Invariant: arms are in the caller's order, a cart does not count as an arm; the last axis of a
 * derivative is the parameter. */
#pragma once

/* The quantities. The energies and the quantities of a cart have one number per row; all others
 * have one number per arm, without a cart. FORCE is the compression at the tip. Joint forces are
 * those of struct bodies_forces. The reaction of a rail is the force across it. */
enum pend_derived {
    PEND_DERIVED_PHI,
    PEND_DERIVED_RATE,
    PEND_DERIVED_ACC,
    PEND_DERIVED_FORCE,
    PEND_DERIVED_Z_RE,
    PEND_DERIVED_Z_IM,
    PEND_DERIVED_ZD_RE,
    PEND_DERIVED_ZD_IM,
    PEND_DERIVED_ZDD_RE,
    PEND_DERIVED_ZDD_IM,
    PEND_DERIVED_JOINT_ALONG,
    PEND_DERIVED_JOINT_ACROSS,
    PEND_DERIVED_TIP_ACROSS,
    PEND_DERIVED_KINETIC,
    PEND_DERIVED_POTENTIAL,
    PEND_DERIVED_CART_PLACE, /* the following quantities exist only for a pendulum on a cart */
    PEND_DERIVED_CART_SPEED,
    PEND_DERIVED_CART_ACC,
    PEND_DERIVED_CART_REACTION,
    PEND_DERIVED
};

/* Rows of results; NULL if not needed. With n arms and P parameters a row has n values and n P
 * derivatives, [arm * P + parameter]; for the energies and a cart 1 value and P derivatives. */
struct pend_derived_rows {
    double *value[PEND_DERIVED], *derivative[PEND_DERIVED];
};

/** Returns non-zero for a quantity that has one number per row. O(1). */
static inline int pend_derived_single(int what) { return what >= PEND_DERIVED_KINETIC; }

/** For a quantity of a cart: returns the quantity of arms whose value for stored arm 0 it is.
 * Returns other quantities unchanged. O(1). */
static inline int pend_derived_from(int what) {
    static const int from[] = {PEND_DERIVED_PHI, PEND_DERIVED_RATE, PEND_DERIVED_ACC,
                               PEND_DERIVED_JOINT_ACROSS};
    return what < PEND_DERIVED_CART_PLACE ? what : from[what - PEND_DERIVED_CART_PLACE];
}
