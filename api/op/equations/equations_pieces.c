#include "api/op/equations/equations_pieces.h"

#include <assert.h>

unsigned api_pieces_drives(const struct api_equations *e, const struct pend_harmonic *harmonic) {
    assert(harmonic->drives < e->tree->n);
    if (harmonic->drives < 0) return API_HAVE_PIVOT;
    return harmonic->drives == 0 && pend_terms_cart(e->loads.terms) ? API_HAVE_CART
                                                                    : API_HAVE_DRIVES;
}

unsigned api_pieces_have(const struct api_equations *e) {
    const struct pend_terms *terms = e->loads.terms;
    const int *one = terms->one;
    int angles = 0;
    unsigned have = 0;
    assert(pend_terms_valid(terms));
    if (api_equations_joints(e, &angles)) have |= API_HAVE_JOINTS;
    if (angles) have |= API_HAVE_ANGLES;
    for (int i = 0; i < terms->harmonics; i++) have |= api_pieces_drives(e, &terms->harmonic[i]);
    if (have & API_HAVE_DRIVES) have |= API_HAVE_JOINTS;
    if (api_equations_has(e, PEND_TERM_DRAG) || api_equations_has(e, PEND_TERM_DRAG_QUADRATIC))
        have |= API_HAVE_AIR;
    if (one[PEND_TERM_PIVOT_ACCELERATION_X] >= 0) have |= API_HAVE_PIVOT;
    if (one[PEND_TERM_DRAG_PER_MASS] >= 0) have |= API_HAVE_MIST;
    if (pend_terms_cart(terms)) have |= API_HAVE_CART;
    return have;
}

enum pend_status api_pieces_say(unsigned have, const struct api_piece piece[],
                                struct api_buffer *out) {
    for (; piece->text; piece++)
        if ((piece->need & have) == piece->need && !(piece->lack & have))
            PEND_TRY(api_buffer_text(out, piece->text));
    return PEND_OK;
}
