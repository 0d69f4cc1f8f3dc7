/* What the programs of a pendulum on a cart have in place of those of others: the accelerations,
 * the forces and the run.
 * Leaves to others: all that comes before (equations_real).
 * Invariant: the place and the speed of the cart are the last entries of the vectors phi and w.
 *
 * Derivation. With z0 = x r, r = e^{i angle}, the equations of equations_real have z0'' = r x'', a
 * column c = Im(conj(u) h r) of what a unit of x'' asks of the arms. The force along the rail that
 * all masses ask of the pivot is Re(conj(r) sum m (z'' + i g)), and Re(conj(r) conj(h) i u) is c
 * again, so that
 *     ( Re M      c   ) (phi'')   ( those of the arms, with z0'' = 0                            )
 *     ( c^T  M0+sum m ) ( x'' ) = ( F - c0 x' - k0 x - (M0 + sum m) g Im r + Re(conj(r h) u phi'^2)
 * ) and the air's forces and drag per mass on the right in the same way. */
#ifndef API_EQUATIONS_CART_H
#define API_EQUATIONS_CART_H

#include "api/op/equations/equations_code.h"
#include "api/op/equations/equations_pieces.h"

extern const struct api_piece api_cart_python[], api_cart_matlab[];

/** Appends the lines of the cart's numbers but its harmonics: mass, rail, damping, stiffness,
 * constant force, and its start. */
PEND_MUST_CHECK enum pend_status api_cart_list(const struct code_language *language,
                                               const struct api_equations *e,
                                               struct api_buffer *out);

#endif
