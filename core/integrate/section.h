/* A Poincare section: the instants at which an arm of a motion passes a given direction, and the
 * state then.
 * Leaves to others: the steps (method_taylor), tables of what was found (api).
 * Invariant: an instant is found to rounding from the step's own series; passages that only
 * graze are found as well, unless both lie within a thirty-second of a step and less than
 * rounding apart. */
#ifndef PEND_SECTION_H
#define PEND_SECTION_H

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* Which passages are wanted: with growing, with falling angle; may be or-ed. */
enum pend_way { PEND_WAY_UP = 1, PEND_WAY_DOWN = 2 };

struct pend_section_problem {
    const struct pend_tree *tree; /* must outlive the search */
    struct pend_loads loads;      /* what acts on the tree */
    const double *phi, *rate;     /* start, n values each, stored order; copied */
    double duration;              /* s, > 0 */
    int arm;                      /* stored number */
    double angle;                 /* rad, of phi; whole turns do not matter */
    unsigned ways;
    double rtol, atol; /* as of the taylor method; 0 = its default */
    double accuracy;   /* that pend_section_held goes by, > 0; 0 = nobody asks */
    /* what rounding to doubles has left of the start, n values each, NULL = nothing; and of the
     * angle, rad */
    const double *phi_low, *rate_low;
    double angle_low;
};

/* A passage. */
struct pend_passage {
    double time;       /* s */
    enum pend_way way; /* PEND_WAY_UP or PEND_WAY_DOWN */
};

struct pend_section;

/**
 * Prepares a search from time 0; a start that lies in the section is no passage.
 *
 * section  out; NULL on failure; ends with pend_section_free.
 *
 * PEND_INVALID    the duration, arm, angle or ways make no sense.
 * PEND_NO_MEMORY, and what the method's open returns.
 */
PEND_MUST_CHECK enum pend_status pend_section_new(struct pend_section **section,
                                                  const struct pend_section_problem *problem,
                                                  struct pend_error *error);

void pend_section_free(struct pend_section **section);

enum pend_found { PEND_FOUND_NOTHING, PEND_FOUND_PASSAGE, PEND_FOUND_END };

/**
 * Looks for the next passage in time.
 *
 * steps    after which it comes back with nothing.
 * found    out: nothing yet, a passage, or that the duration is over.
 * passage  out, where there is one.
 * phi, rate  out, n values each: the state then.
 *
 * PEND_NOT_FINITE, PEND_STEP_TOO_SMALL  error says the time.
 * No allocation.
 */
PEND_MUST_CHECK enum pend_status pend_section_next(struct pend_section *section, long steps,
                                                   enum pend_found *found,
                                                   struct pend_passage *passage, double phi[],
                                                   double rate[], struct pend_error *error);

/**
 * Up to when the motion keeps the problem's accuracy (horizon.h), s, as far as it was followed:
 * what passages come later may be those of another motion. NaN where the problem names none.
 */
double pend_section_held(const struct pend_section *section);

/** Integration steps so far. */
long pend_section_steps(const struct pend_section *section);

/** The part of the duration that is over, 0 .. 1. */
double pend_section_progress(const struct pend_section *section);

#endif
