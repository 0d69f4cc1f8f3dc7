/* A pendulum's equations of motion as programs that run as they are, and as a request.
 * Leaves to others: the same as formulas (equations_latex).
 * Invariant: nothing of what a client called things gets into a program: numbers alone. */
#ifndef API_EQUATIONS_CODE_H
#define API_EQUATIONS_CODE_H

#include "api/op/equations.h"

/**
 * A script for MATLAB and Octave: `M`, `phidd` (aaa), `lambda` (bbb) as functions, then ode45 and
 * two plots.
 *
 * Fails as api_buffer_room does.
 */
PEND_MUST_CHECK enum pend_status api_code_matlab(const struct api_equations *equations,
                                                 struct api_buffer *out);

/** The same for Python: M, phidd and lambda_ need NumPy, the main program SciPy and Matplotlib. */
PEND_MUST_CHECK enum pend_status api_code_python(const struct api_equations *equations,
                                                 struct api_buffer *out);

/** A line for a shell that asks a server on this machine for the motion. */
PEND_MUST_CHECK enum pend_status api_code_curl(const struct api_equations *equations,
                                               struct api_buffer *out);

#endif
