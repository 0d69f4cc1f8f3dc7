#include "core/modes.h"

#include "core/modes_gsl.h"

enum pend_status pend_modes_new(struct pend_modes **modes, const struct pend_tree *tree, double gravity, int vectors,
                                struct pend_error *error) {
    return pend_modes_gsl_new(modes, tree, gravity, vectors, error);
}
