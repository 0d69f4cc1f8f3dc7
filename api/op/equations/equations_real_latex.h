/* The equations of motion of a real pendulum as formulas.
 * Leaves to others: programs (equations_real), ideal pendulums (equations_latex).
 * Invariant: what a pendulum has not stands in no formula but that of M. */
#ifndef API_EQUATIONS_REAL_LATEX_H
#define API_EQUATIONS_REAL_LATEX_H

#include "api/op/equations/equations_latex.h"

/** Returns formula i of a real pendulum, or NULL behind the last: those of api_latex_at, and
 * "loads", what acts on it. */
const struct api_latex *api_real_latex_at(int i);

#endif
