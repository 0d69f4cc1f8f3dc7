/* A pendulum's equations of motion as LaTeX, in the letters of the paper.
 * Leaves to others: the same as programs (equations_code), rendering.
 * Invariant: plain amsmath that KaTeX reads as well; whatever the tree, of bounded length but
 * for the explicit form. */
#ifndef API_EQUATIONS_LATEX_H
#define API_EQUATIONS_LATEX_H

#include "api/op/equations.h"

/* One formula of the answer. */
struct api_latex {
    const char *name; /* "M" */
    /** Appends it; fails as api_buffer_room does. */
    enum pend_status (*write)(const struct api_equations *equations, struct api_buffer *out);
};

/** Formula i, or NULL beyond the last: parameters, S, B, z, M, aaa, bbb. */
const struct api_latex *api_latex_at(int i);

#endif
