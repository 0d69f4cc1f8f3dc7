#include "api/op/equations_pieces.h"

#include <assert.h>

unsigned api_pieces_drives(const struct api_equations *e, const struct pend_harmonic *harmonic) {
    assert(harmonic->drives < e->tree->n);
    if (harmonic->drives < 0) return API_HAVE_PIVOT;
    return harmonic->drives == 0 && pend_terms_cart(e->loads.terms) ? API_HAVE_CART
                                                                    : API_HAVE_DRIVES;
}

int api_pieces_has(const struct api_equations *e, enum pend_term_row row) {
    const struct pend_terms *terms = e->loads.terms;
    assert(terms && terms->n == e->n + pend_terms_cart(terms));
    // those of a cart stand in the same row
    int has = terms->row[row] >= 0 && !pend_terms_cart(terms);
    for (int k = 1; k < terms->n && terms->row[row] >= 0 && !has; k++)
        has = e->loads.value[terms->row[row] + k] != 0;
    return has;
}

unsigned api_pieces_have(const struct api_equations *e) {
    static const struct {
        enum pend_term_row row;
        unsigned have;
    } rows[] = {{PEND_TERM_STIFFNESS, API_HAVE_SPRINGS}, {PEND_TERM_DAMPING, API_HAVE_DAMPING},
                {PEND_TERM_FRICTION, API_HAVE_FRICTION}, {PEND_TERM_TORQUE, API_HAVE_TORQUE},
                {PEND_TERM_DRAG, API_HAVE_AIR},          {PEND_TERM_DRAG_QUADRATIC, API_HAVE_AIR}};
    const struct pend_terms *terms = e->loads.terms;
    const int *one = terms->one;
    unsigned have = 0;
    assert(pend_terms_valid(terms));
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (api_pieces_has(e, rows[i].row)) have |= rows[i].have;
    for (int i = 0; i < terms->harmonics; i++) have |= api_pieces_drives(e, &terms->harmonic[i]);
    if (have & ~(unsigned)(API_HAVE_PIVOT | API_HAVE_CART | API_HAVE_AIR)) have |= API_HAVE_JOINTS;
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
