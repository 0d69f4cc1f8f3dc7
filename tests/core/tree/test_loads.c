#include "core/tree/loads.h"

#include <math.h>
#include <string.h>

#include "tests/harness/test.h"

TEST(loads_of_any_finite_gravity_can_be_integrated) {
    static const double fit[] = {9.81, 0, -1.62, 1e300, -1e-300};
    static const double unfit[] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < sizeof fit / sizeof *fit; i++) {
        struct pend_loads loads = {.gravity = fit[i]};
        CHECK_INT(pend_loads_check(&loads, NULL), PEND_OK);
        CHECK_INT(pend_loads_check_series(&loads, NULL), PEND_OK);
    }
    for (size_t i = 0; i < sizeof unfit / sizeof *unfit; i++) {
        struct pend_loads loads = {.gravity = unfit[i]};
        struct pend_error error;
        CHECK_INT(pend_loads_check_series(&loads, &error), PEND_INVALID);
        CHECK_INT(pend_loads_check(&loads, &error), PEND_INVALID);
        CHECK(error.code == PEND_INVALID && strstr(error.text, "gravity must be finite"));
    }
}

TEST(loads_of_the_linearization_pull_downwards) {
    static const double fit[] = {9.81, 1e-300, 1e300};
    static const double unfit[] = {0, -0.0, -9.81, NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < sizeof fit / sizeof *fit; i++) {
        struct pend_loads loads = {.gravity = fit[i]};
        CHECK(pend_loads_pull_down(&loads));
        CHECK_INT(pend_loads_check_linear(&loads, NULL), PEND_OK);
    }
    for (size_t i = 0; i < sizeof unfit / sizeof *unfit; i++) {
        struct pend_loads loads = {.gravity = unfit[i]};
        struct pend_error error;
        CHECK(!pend_loads_pull_down(&loads));
        CHECK_INT(pend_loads_check_linear(&loads, &error), PEND_INVALID);
        CHECK(error.code == PEND_INVALID && strstr(error.text, "greater than 0"));
    }
}
