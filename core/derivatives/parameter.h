/* What a motion is differentiated by.
 * Leaves to others: names of parameters (api), derivatives (derivatives).
 * Invariant: arms are counted in stored order. */
#ifndef PEND_PARAMETER_H
#define PEND_PARAMETER_H

/* What a derivative is with respect to. */
enum pend_parameter_kind {
    PEND_PARAMETER_PHI,     /* the start's angle of an arm, rad */
    PEND_PARAMETER_RATE,    /* the start's rate of an arm, rad/s */
    PEND_PARAMETER_LENGTH,  /* of an arm, m; its rod and the joints at its tip go with it */
    PEND_PARAMETER_MASS,    /* at the tip of an arm, kg */
    PEND_PARAMETER_GRAVITY, /* m/s^2 */
    PEND_PARAMETER_TERM     /* a number of the list of terms, in its unit */
};

struct pend_parameter {
    enum pend_parameter_kind kind;
    int at; /* the stored arm, or the place in the list of terms; of gravity 0 */
};

#endif
