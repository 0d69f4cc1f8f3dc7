/* The equations of motion of a real pendulum: the paper's (aaa) and (bbb) with bodies, springs,
 * friction, the air and drives, as formulas and as programs.
 * Leaves to others: ideal pendulums (equations_latex, equations_code).
 * Invariant: what a pendulum has not stands in neither formulas nor programs.
 *
 * Derivation. With u = e^{i phi} the joints are at z0 + C u, where C = S H and H has at (k, the arm
 * that carries k) the complex number at which k hangs there; the tips are at z0 + Z u, Z = C +
 * diag(l). Every mass, at tips, rods and bodies alike, is at z0 + P u, its row of P the row of C of
 * its arm, and its own place on the arm added there. Then
 *     M = diag(conj u) P^H diag(m) P diag(u) + diag(J)
 * has the inertias J of rods and bodies about their centers beside the masses, and with h = P^H m
 *     Re M phi'' = Im M phi'^2 - Im(conj(u) h (z0'' + i g)) + Q.
 * Torques tau of the joints act on their arm and back on the one that carries it: B tau, and the
 * angles between arms are B^T phi. A force F on the tips gives Im(conj(u) Z^H F), and drag per mass
 * -2 gamma (Re M phi' + Im(conj(u) h z0')). */
#ifndef API_EQUATIONS_REAL_H
#define API_EQUATIONS_REAL_H

#include "api/op/equations/equations_code.h"

/** Appends a script for MATLAB and Octave. Fails as api_buffer_text does. */
PEND_MUST_CHECK enum pend_status api_real_matlab(const struct api_equations *equations,
                                                 struct api_buffer *out);

/** Appends a Python program. */
PEND_MUST_CHECK enum pend_status api_real_python(const struct api_equations *equations,
                                                 struct api_buffer *out);

/** Appends a line for a shell that asks a server for the motion. */
PEND_MUST_CHECK enum pend_status api_real_curl(const struct api_equations *equations,
                                               struct api_buffer *out);

#endif
