/* A Poincare section: the instants at which an arm passes a given direction, or instants one drive
 * period apart, and the states at these instants.
 * Leaves to others: the steps (method_taylor), tables of the passages (api).
 * Invariant: an instant is computed from the step's own series, to rounding. A pair of passages
 * where the angle barely crosses the direction is found too, unless both lie within a thirty-second
 * of a step and the angle passes the direction by less than its rounding error. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* Passages with increasing and with decreasing angle; flags. */
enum pend_way { PEND_WAY_UP = 1, PEND_WAY_DOWN = 2 };

struct pend_section_problem {
    const struct pend_tree *tree; /* must outlive the search */
    struct pend_loads loads;      /* gravity and other loads */
    const double *phi, *rate;     /* initial state, n values each, stored order; copied */
    double duration;              /* s, > 0 */
    int arm;                      /* stored number of the arm */
    double angle;                 /* rad, the section's value of phi; whole turns are ignored */
    unsigned ways;
    double rtol, atol; /* as for the taylor method; 0 = its default */
    double accuracy;   /* requested accuracy, for pend_section_held, > 0; 0 = no estimate */
    /* low-order parts: of the initial state, n values each, NULL = 0; of the angle, rad */
    const double *phi_low, *rate_low;
    double angle_low;
    double start; /* s, start in the time of the drives; passages count from it */
    /* s, > 0: the section is stroboscopic, with passages at first + k period, k any integer; arm,
     * angle and ways are ignored. 0: the section is that of the arm. */
    double period, first;
};

struct pend_passage {
    double time;       /* s */
    enum pend_way way; /* PEND_WAY_UP or PEND_WAY_DOWN; 0 in a stroboscopic section */
};

struct pend_section;

/**
 * Prepares a search from time 0; a start in the section is not a passage.
 *
 * section  out; NULL on failure; released by pend_section_free.
 *
 * PEND_INVALID    the duration is not > 0, there is no such arm, the angle is not finite, `ways`
 *                 has other flags than enum pend_way, the period is not >= 0, or there are more
 *                 than 2^53 periods. PEND_NO_MEMORY, and the failures of the method's `open`.
 */
PEND_MUST_CHECK enum pend_status pend_section_new(struct pend_section **section,
                                                  const struct pend_section_problem *problem,
                                                  struct pend_error *error);
void pend_section_free(struct pend_section **section);

enum pend_found { PEND_FOUND_NOTHING, PEND_FOUND_PASSAGE, PEND_FOUND_END };

/**
 * Searches for the next passage in time.
 *
 * steps      the largest number of integration steps of this call, >= 1.
 * found      out: nothing yet, a passage, or the end of the duration.
 * passage    out, if one was found.
 * phi, rate  out, n values each: the state at the passage.
 *
 * PEND_NOT_FINITE, PEND_STEP_TOO_SMALL  error contains the time.
 * No allocation.
 */
PEND_MUST_CHECK enum pend_status pend_section_next(struct pend_section *section, long steps,
                                                   enum pend_found *found,
                                                   struct pend_passage *passage, double phi[],
                                                   double rate[], struct pend_error *error);

/** Returns the time, s, up to which the integrated motion keeps the problem's accuracy (horizon.h);
 * later passages may be wrong. NaN if the problem has no accuracy. */
double pend_section_held(const struct pend_section *section);

/** Returns the number of integration steps so far. */
long pend_section_steps(const struct pend_section *section);

/** Returns the fraction of the duration that was integrated, 0 .. 1. */
double pend_section_progress(const struct pend_section *section);
