/* A pendulum's equations of motion as programs that run unchanged, and as a request.
 * Leaves to others: formulas (equations_latex).
 * Invariant: programs contain numbers of the request only, never its texts, such as arm names. */
#ifndef API_EQUATIONS_CODE_H
#define API_EQUATIONS_CODE_H

#include "api/op/equations/equations.h"

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

/* --- for programs of real pendulums (equations_real) --- */

struct code_language;
extern const struct code_language api_code_in_matlab, api_code_in_python;

/** Appends a number as all three languages write it. */
PEND_MUST_CHECK enum pend_status api_code_number(double number, struct api_buffer *out);

/** Appends "[a, b, ...]" in the language's form, a number or a whole number each. */
PEND_MUST_CHECK enum pend_status api_code_numbers(const struct code_language *language, int n,
                                                  const double number[], struct api_buffer *out);

/** Appends a line that gives a list a name; comment: NULL = none. */
PEND_MUST_CHECK enum pend_status api_code_list(const struct code_language *language,
                                               const char *name, const char *comment, int n,
                                               const double number[], struct api_buffer *out);

/** Appends the lines of lengths, masses, gravity, S and the start. */
PEND_MUST_CHECK enum pend_status api_code_givens(const struct code_language *language,
                                                 const struct api_equations *equations,
                                                 struct api_buffer *out);

#endif
