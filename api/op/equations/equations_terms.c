#include "api/op/equations/equations_terms.h"

#include <assert.h>

static const struct api_equations_term table[] = {
    {.row = PEND_TERM_ROD, .of = PEND_TERM_ROD, .letter = "\\mu", .unit = "kg"},
    {.row = PEND_TERM_BODY, .of = PEND_TERM_BODY, .letter = "m^{\\mathrm{b}}", .unit = "kg"},
    {.row = PEND_TERM_CENTER_X, .of = PEND_TERM_CENTER_X, .letter = "x", .unit = "m"},
    {.row = PEND_TERM_CENTER_Y, .of = PEND_TERM_CENTER_Y, .letter = "y", .unit = "m"},
    {.row = PEND_TERM_INERTIA, .of = PEND_TERM_INERTIA, .letter = "I", .unit = "kg\\,m^{2}"},
    {.row = PEND_TERM_DAMPING,
     .of = PEND_TERM_DAMPING,
     .name = "c",
     .comment = "damping of the joints, N m s/rad",
     .letter = "c",
     .unit = "N\\,m\\,s",
     .python = "    tau -= c * r\n",
     .matlab = " ...\n    - c .* r(w)",
     .latex = "-c\\,\\dot{q}"},
    {.row = PEND_TERM_STIFFNESS,
     .of = PEND_TERM_STIFFNESS,
     .name = "k",
     .comment = "stiffness of their springs, N m/rad",
     .letter = "k",
     .unit = "N\\,m",
     .python = "    tau -= k * (q - rest)\n",
     .matlab = " ...\n    - k .* (q(phi) - rest)",
     .latex = "-k\\,(q-a)",
     .angles = 1},
    {.row = PEND_TERM_REST,
     .of = PEND_TERM_STIFFNESS,
     .name = "rest",
     .comment = "the angles at which these are slack",
     .letter = "a",
     .unit = "rad"},
    {.row = PEND_TERM_FRICTION,
     .of = PEND_TERM_FRICTION,
     .name = "f",
     .comment = "dry friction, N m",
     .letter = "f",
     .unit = "N\\,m",
     .python = "    tau -= f * np.tanh(r / s)\n",
     .matlab = " ...\n    - f .* tanh(r(w) ./ s)",
     .latex = "-f\\tanh(\\dot{q}/s)"},
    {.row = PEND_TERM_FRICTION_SPEED,
     .of = PEND_TERM_FRICTION,
     .name = "s",
     .comment = "and the speeds that smooth it, rad/s",
     .letter = "s",
     .unit = "rad/s"},
    // formulas write the constant and the harmonics of each arm in a line of its own
    {.row = PEND_TERM_TORQUE,
     .of = PEND_TERM_TORQUE,
     .name = "T0",
     .comment = "constant torques, N m",
     .python = "    tau += T0\n",
     .matlab = " ...\n    + T0"},
    {.row = PEND_TERM_DRAG,
     .of = PEND_TERM_DRAG,
     .name = "b",
     .comment = "linear drag of the tips, N s/m",
     .letter = "b",
     .unit = "N\\,s/m"},
    {.row = PEND_TERM_DRAG_QUADRATIC,
     .of = PEND_TERM_DRAG,
     .name = "d",
     .comment = "quadratic drag, N s^2/m^2",
     .letter = "d",
     .unit = "N\\,s^{2}/m^{2}"},
    {.row = PEND_TERM_DRAG_SPEED,
     .of = PEND_TERM_DRAG,
     .name = "e",
     .comment = "below this speed it is linear, m/s",
     .letter = "e",
     .unit = "m/s"},
};
enum { TERMS = sizeof table / sizeof *table };

const struct api_equations_term *api_equations_term(int i) {
    assert(i >= 0);
    return i < TERMS ? &table[i] : NULL;
}

int api_equations_has(const struct api_equations *e, enum pend_term_row row) {
    const struct pend_terms *terms = e->loads.terms;
    assert(terms && terms->n == e->n + pend_terms_cart(terms));
    // those of a cart stand in the same row
    int has = terms->row[row] >= 0 && !pend_terms_cart(terms);
    for (int k = 1; k < terms->n && terms->row[row] >= 0 && !has; k++)
        has = e->loads.value[terms->row[row] + k] != 0;
    return has;
}

int api_equations_has_term(const struct api_equations *e, const struct api_equations_term *term) {
    if (term->of == PEND_TERM_DRAG && api_equations_has(e, PEND_TERM_DRAG_QUADRATIC)) return 1;
    return api_equations_has(e, term->of);
}

int api_equations_joints(const struct api_equations *e, int *angles) {
    int there = 0;
    *angles = 0;
    for (int i = 0; i < TERMS; i++) {
        if (!table[i].python || !api_equations_has(e, table[i].row)) continue;
        there = 1;
        *angles |= table[i].angles;
    }
    return there;
}
