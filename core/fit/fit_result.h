/* What a fit answers.
 * Leaves to others: how it is found (fit).
 * Invariant: all arrays belong to the fit. */
#ifndef PEND_FIT_RESULT_H
#define PEND_FIT_RESULT_H

/* How a fit ended. */
enum pend_fit_end {
    PEND_FIT_CONVERGED,
    PEND_FIT_STRANGE, /* a minimum whose motion does not follow the data */
    PEND_FIT_STOPPED, /* the iterations were used up, or no step led down: no minimum */
    PEND_FIT_AWAY,    /* one went away without end, and the data do not tell it: no minimum */
};

/* Whether the model fits the data. */
enum pend_fit_model {
    PEND_FIT_ACCEPTED,
    PEND_FIT_UNDECIDED, /* no minimum, or nothing that could reject it */
    PEND_FIT_REJECTED
};

enum { PEND_FIT_BLIND = 8 };

/* The outcome; all arrays belong to the fit. */
struct pend_fit_result {
    enum pend_fit_end end;
    long iterations, evaluations;
    const double *value; /* of the unknowns */
    const double *error; /* standard errors; infinite where the data do not tell; of what is at a
                            bound as without it; NaN where neither a sigma nor a measurement more
                            than there are unknowns tells how large they are, and of what is at a
                            bound and is not told apart from others */
    const double *correlation;    /* unknowns x unknowns; 0 where an error is not finite */
    const unsigned char *bounded; /* non-zero: at a bound */
    /* (model - data) / sigma, or in the data's unit where no sigma is known; [row * columns +
     * column], NaN where nothing was measured */
    const double *residual;
    double chi_squared;
    long freedom;          /* measurements less unknowns that were found */
    const double *follows; /* s, of each run: the last row up to which the motion follows the data;
                              NaN = none */
    int away;              /* the unknown that did, -1 = none */
    double explained;      /* 1 - sum of squares over that of the data about their mean */
    enum pend_fit_model model;
    double p_value;   /* of chi-squared; NaN where a sigma is not known, or no freedom is left */
    double watson;    /* Durbin and Watson's number of the residuals' run; NaN = no neighbours */
    double alike;     /* the p-value of their autocorrelation, NaN of few neighbours */
    double widened;   /* how many times the standard errors were; infinite: they are withheld */
    double effective; /* so many independent measurements would tell as much */
    const double *spread; /* of each column, robust standard deviation of its residuals */
    double beyond;        /* a residual of more spreads is an outlier; may be infinite */
    long outliers;        /* how many there are */
    /* Directions that the data do not tell: relative changes of all unknowns together, the largest
     * of which is 1; [direction * unknowns + unknown]. */
    int blind;
    const double *direction;
};

#endif
