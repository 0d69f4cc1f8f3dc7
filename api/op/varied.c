#include "api/op/varied.h"

#include <assert.h>

/* in the order of enum pend_term_row, of enum pend_term_one, then of what harmonics drive */
static const char *const names[API_VARIED] = {
    "rod",
    "body_mass",
    "center_x",
    "center_y",
    "inertia",
    "at_x",
    "at_y",
    "damping",
    "stiffness",
    "rest",
    "friction_torque",
    "friction_speed",
    "torque",
    "drag",
    "drag_quadratic",
    "drag_speed",
    "drag_per_mass",
    "pivot_acceleration_x",
    "pivot_acceleration_y",
    "cart_angle",
    "torque_amplitude",
    "torque_omega",
    "torque_phase",
    "pivot_x_amplitude",
    "pivot_x_omega",
    "pivot_x_phase",
    "pivot_y_amplitude",
    "pivot_y_omega",
    "pivot_y_phase",
};

enum { ONES = PEND_TERM_ROWS, WAVES = PEND_TERM_ROWS + PEND_TERM_ONES };

const char *api_varied_name(int i) {
    assert(i >= 0 && i < API_VARIED);
    return names[i];
}

int api_varied_of_arm(int i) { return i < ONES || (i >= WAVES && i < WAVES + 3); }

int api_varied_place(const struct api_tree *tree, int i, int arm, int harmonic) {
    const struct pend_terms *terms = tree->loads.terms;
    assert(i >= 0 && i < API_VARIED && harmonic >= 1);
    if (!terms || (api_varied_of_arm(i) && arm < 0)) return -1;
    if (i == PEND_TERM_AT_X || i == PEND_TERM_AT_Y)
        if (!terms->hung[arm]) return -1;
    if (i < ONES) return pend_terms_place(terms, (enum pend_term_row)i, arm);
    if (i < WAVES) return terms->one[i - ONES];
    static const int pivots[] = {0, PEND_DRIVE_PIVOT_X, PEND_DRIVE_PIVOT_Y};
    int what = (i - WAVES) / 3, drives = what ? pivots[what] : arm;
    for (int j = 0; j < terms->harmonics; j++)
        if (terms->harmonic[j].drives == drives && !--harmonic)
            return terms->harmonic[j].at + (i - WAVES) % 3;
    return -1;
}
