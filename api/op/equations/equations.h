/* A pendulum's equations of motion: the values of the names in the templates.
 * Leaves to others: the text (equations_text), sections and loops (template).
 * Invariant: programs contain only numbers of the request, never its texts, such as arm names.
 * Terms that the pendulum lacks are left out of programs and of all formulas but that of M.
 *
 * Derivation for real pendulums. With u = e^{i phi} the joints are at z0 + C u, where C = S H, and
 * entry (k, parent of k) of H is the complex number at which k is attached to its parent; the tips
 * are at z0 + Z u, Z = C + diag(l). The masses of tips, rods and bodies are at z0 + P u. A row of P
 * is the row of C of the mass's arm, with the position of the mass on the arm added in the arm's
 * column. Then
 *     M = diag(conj u) P^H diag(m) P diag(u) + diag(J)
 * contains the inertias J of rods and bodies about their centers, and with h = P^H m
 *     Re M phi'' = Im M phi'^2 - Im(conj(u) h (z0'' + i g)) + Q.
 * Torques tau of the joints act on their arm and back on the one that carries it: B tau, and the
 * angles between arms are B^T phi. A force F on the tips gives Im(conj(u) Z^H F), and drag per mass
 * -2 gamma (Re M phi' + Im(conj(u) h z0')).
 *
 * On a cart z0 = x r, r = e^{i angle}: z0'' = r x'' is a column c = Im(conj(u) h r) of M. The force
 * along the rail that all masses exert on the pivot is Re(conj(r) sum m (z'' + i g)), and
 * Re(conj(r) conj(h) i u) is c again, so that
 *     ( Re M      c   ) (phi'')   ( the right side above, with z0'' = 0                       )
 *     ( c^T  M0+sum m ) ( x'' ) = ( F - c0 x' - k0 x - (M0 + sum m) g Im r + Re(conj(r h) u phi'^2)
 * ) and the air's forces and drag per mass on the right in the same way. */
#pragma once

#include "api/base/buffer.h"
#include "api/read/state_json.h"

enum {
    API_EQUATIONS_EXPLICIT = 8, /* maximum number of arms whose entries are written by default */
    API_EQUATIONS_MOST = 20 /* maximum number of arms for which all entries can be written out */
};

enum api_equations_form {
    API_EQUATIONS_LATEX,  /* a formula in the letters of the paper, plain amsmath */
    API_EQUATIONS_MATLAB, /* functions for M, phidd (aaa) and lambda (bbb); ode45 and two plots */
    API_EQUATIONS_PYTHON, /* these functions in Python; they need NumPy, the program SciPy and
                           * Matplotlib */
    API_EQUATIONS_CURL    /* a shell command that requests the motion from this server */
};

struct api_equations {
    const struct api_tree *tree;
    const double *phi, *rate; /* the start in stored order; finite */
    int is_explicit;          /* whether every entry is written out; only for ideal pendulums */
};

/** Returns the name of formula i, such as "aaa"; NULL beyond the last one, "loads", which only real
 * pendulums have. */
const char *api_equations_formula(const struct api_tree *tree, int i);

/**
 * Appends the text of a form.
 *
 * formula  name of the formula for LaTeX; otherwise NULL.
 *
 * Fails as api_buffer_room does. O(n + harmonics); n^3 if every entry is written out.
 */
PEND_MUST_CHECK enum pend_status api_equations_write(const struct api_equations *equations,
                                                     enum api_equations_form form,
                                                     const char *formula, struct api_buffer *out);
