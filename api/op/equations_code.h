/* A pendulum's equations of motion as programs that run unchanged, and as a request.
 * Leaves to others: formulas (equations_latex).
 * Invariant: programs contain numbers of the request only, never its texts, such as arm names. */
#ifndef API_EQUATIONS_CODE_H
#define API_EQUATIONS_CODE_H

#include "api/op/equations.h"

/**
 * Appends a script for MATLAB and Octave: `M`, `phidd` (aaa), `lambda` (bbb) as functions, then
 * ode45 and two plots.
 *
 * Fails as api_buffer_room does.
 */
PEND_MUST_CHECK enum pend_status api_code_matlab(const struct api_equations *equations,
                                                 struct api_buffer *out);

/** Appends the same for Python: M, phidd and lambda_ need NumPy, the main program SciPy and
 * Matplotlib. */
PEND_MUST_CHECK enum pend_status api_code_python(const struct api_equations *equations,
                                                 struct api_buffer *out);

/** Appends a shell command that requests the motion from a server on the same machine. */
PEND_MUST_CHECK enum pend_status api_code_curl(const struct api_equations *equations,
                                               struct api_buffer *out);

#endif
