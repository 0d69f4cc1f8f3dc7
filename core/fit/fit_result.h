/* The result of a fit.
 * Leaves to others: the search (fit).
 * Invariant: all arrays belong to the fit. */
#pragma once

/* How a fit ended. */
enum pend_fit_end {
    PEND_FIT_CONVERGED,
    PEND_FIT_STRANGE, /* a minimum, but its motion does not follow the data */
    PEND_FIT_STOPPED, /* no minimum: the iterations were used up, or no step decreased the sum of
                       * squares */
    PEND_FIT_AWAY,    /* no minimum: an unknown diverged and is not identifiable */
};

/* Whether the model fits the data. */
enum pend_fit_model {
    PEND_FIT_ACCEPTED,
    PEND_FIT_UNDECIDED, /* no minimum, or no test could reject the model */
    PEND_FIT_REJECTED
};

enum { PEND_FIT_BLIND = 8 };

/* The outcome; all arrays belong to the fit. */
struct pend_fit_result {
    enum pend_fit_end end;
    long iterations, evaluations;
    const double *value; /* values of the unknowns */
    const double *error; /* Standard errors, infinite if not identifiable. At a bound: the error
                          * that the unknown would have without the bound, or NaN if it cannot be
                          * distinguished from others. NaN too if no sigma is given and no degree of
                          * freedom is left. */
    const double *correlation;    /* unknowns x unknowns; 0 if an error is not finite */
    const unsigned char *bounded; /* non-zero: at a bound */
    /* (model - data) / sigma, or in the data's unit if no sigma is given; [row * columns + column],
     * NaN if not measured */
    const double *residual;
    double chi_squared;
    long freedom;          /* number of measurements minus number of unknowns found */
    const double *follows; /* s, per run: the time of the last row up to which the motion follows
                            * the data; NaN = none */
    int away;              /* the unknown that diverged, -1 = none */
    double explained;      /* fraction explained: 1 - sum of squares over the sum of squares of the
                            * data about their mean */
    enum pend_fit_model model;
    double p_value;       /* p-value of chi-squared; NaN without sigmas or degrees of freedom */
    double watson;        /* Durbin-Watson statistic of the residuals; NaN without adjacent rows */
    double alike;         /* p-value of the residuals' autocorrelation; NaN with few rows */
    double widened;       /* factor by which standard errors grew; infinite: withheld */
    double effective;     /* the number of independent measurements with the same information */
    const double *spread; /* for each column, the robust standard deviation of its residuals */
    double beyond;        /* a residual beyond this many spreads is an outlier; may be infinite */
    long outliers;        /* number of outliers */
    /* Directions that are not identifiable: relative changes of all unknowns together, the largest
     * of which is 1; [direction * unknowns + unknown]. */
    int blind;
    const double *direction;
};
