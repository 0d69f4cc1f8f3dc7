/* Programs of real pendulums as pieces of text, each there where the pendulum has what it is about.
 * Leaves to others: the pieces themselves (equations_cart, equations_real), the torques of joints
 * (equations_terms).
 * Invariant: the order of the pieces is that of the text. */
#ifndef API_EQUATIONS_PIECES_H
#define API_EQUATIONS_PIECES_H

#include "api/op/equations/equations_terms.h"

/* What a pendulum has, as bits. */
enum api_have {
    API_HAVE_JOINTS = 1, /* torques of springs, friction or motors */
    API_HAVE_ANGLES = 2, /* torques that depend on the joints' angles */
    API_HAVE_DRIVES = 4, /* harmonics of torques */
    API_HAVE_PIVOT = 8,  /* a pivot that moves as it is told */
    API_HAVE_AIR = 16,
    API_HAVE_MIST = 32, /* drag per mass */
    API_HAVE_CART = 64
};

/* A piece of text where the pendulum has all of `need` and none of `lack`. */
struct api_piece {
    unsigned need, lack;
    const char *text; /* NULL behind the last piece */
};

/** Returns what a real pendulum has, as bits of enum api_have. O(n + harmonics). */
unsigned api_pieces_have(const struct api_equations *e);

/** Returns what a harmonic drives: API_HAVE_DRIVES, API_HAVE_PIVOT or API_HAVE_CART. O(1). */
unsigned api_pieces_drives(const struct api_equations *e, const struct pend_harmonic *harmonic);

/** Appends the pieces for a pendulum that has `have`. Fails as api_buffer_text does. */
PEND_MUST_CHECK enum pend_status api_pieces_say(unsigned have, const struct api_piece piece[],
                                                struct api_buffer *out);

#endif
