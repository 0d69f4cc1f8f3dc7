/* A pendulum's equations of motion as LaTeX, in the letters of the paper.
 * Leaves to others: programs (equations_code), rendering (the client).
 * Invariant: plain amsmath that KaTeX can render; the length is bounded for every tree, except in
 * the explicit form. */
#ifndef API_EQUATIONS_LATEX_H
#define API_EQUATIONS_LATEX_H

#include "api/op/equations/equations.h"

/* One formula of the answer. */
struct api_latex {
    const char *name; /* "M" */
    /** Appends it; fails as api_buffer_room does. */
    enum pend_status (*write)(const struct api_equations *equations, struct api_buffer *out);
};

/** Returns formula i, NULL beyond the last: parameters, S, B, z, M, aaa, bbb. */
const struct api_latex *api_latex_at(int i);

/** Appends a number as a formula has it, 1.5\cdot10^{-9}. Fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_latex_number(double number, struct api_buffer *out);

#endif
