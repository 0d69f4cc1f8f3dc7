#include "core/orbits/orbit_switch.h"

#include <assert.h>
#include <math.h>

#include "core/orbits/orbit_constants.h"

int pend_orbit_switch_form(struct orbit_form *form, enum pend_orbits_kind kind) {
    assert(kind < PEND_ORBITS_KINDS);
    form->against = 0;
    switch (kind) {
    case PEND_ORBITS_BRANCH:
        return 1;
    case PEND_ORBITS_SYMMETRY:
        // orbits of a driven pendulum with and without the symmetry satisfy the same equations
        if (form->mirrored && form->kind == ORBIT_QUARTER) form->kind = ORBIT_HALF;
        form->mirrored = 0;
        return 1;
    case PEND_ORBITS_DOUBLING:
        // orbits with twice the period are near the same unknowns
        assert(form->kind == ORBIT_DRIVEN || !form->mirrored);
        if (2 * form->times > PEND_ORBIT_PERIODS) return 0;
        form->times *= 2;
        return 1;
    case PEND_ORBITS_FOLD:
    case PEND_ORBITS_TORUS:
    case PEND_ORBITS_KINDS:
        break;
    }
    return 0;
}

enum pend_status pend_orbit_switch_direction(struct orbit_newton *newton, const double branch[],
                                             int side, double out[], int *found) {
    size_t q = (size_t)newton->unknowns, most = 0;
    double size[3], part[2] = {0, 0};
    assert(q >= 2 && newton->look);
    *found = 0;
    enum pend_status status =
        pend_orbit_least(newton->algebra, newton->unknowns, newton->J, size, out);
    if (status != PEND_OK) return status == PEND_NO_MEMORY ? status : PEND_OK;
    if (!(size[1] <= change_turn * fmin(1, size[2]))) return PEND_OK;
    for (size_t i = 0; i < 2; i++)
        for (size_t j = 0; j < q; j++) part[i] += out[i * q + j] * branch[j];
    if (!(hypot(part[0], part[1]) > 0)) return PEND_OK;
    for (size_t j = 0; j < q; j++) {
        out[j] = part[1] * out[j] - part[0] * out[q + j];
        if (fabs(out[j]) > fabs(out[most])) most = j;
    }
    double unit = side < 0 ? -out[most] : out[most];
    for (size_t j = 0; j < q; j++) out[j] /= unit;
    *found = 1;
    return PEND_OK;
}
