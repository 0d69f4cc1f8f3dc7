/* Tests of core/fit/fit_told: which directions are identifiable, for slopes with known singular
 * values.
 * Leaves to others: directions of pendulums (test_fit).
 * Invariant: none. */
#include "core/fit/fit_told.h"

#include <math.h>
#include <string.h>

#include "core/fit/fit_state.h"
#include "tests/harness/test.h"

/* slopes of 3 measurements for 2 unknowns, with these singular values and rotated directions */
static void told_of(struct fit_told *told, double first, double second) {
    static const double residual[3] = {1, 2, 3}, size[2] = {1, 1};
    static const unsigned char fixed[2];
    const double c = 0.6, s = 0.8;
    const double slope[6] = {first * c, first * s, -second * s, second * c, 0, 0};
    REQUIRE(pend_fit_told_init(told, 3, 2, slope, residual, fixed, size) == PEND_OK);
    CHECK(fabs(told->value[0] / first - 1) < 1e-12 && fabs(told->value[1] / second - 1) < 1e-3);
}

TEST(directions_beside_a_steep_one_are_found) {
    static const struct {
        double first, second, variance;
        int at_first, sure;
    } row[] = {
        {1e3, 1, 1, 1, 1},         {1e3, 1e-5, 1, 1, 1}, // the same as without the steep direction
        {1e10, 2, 1, 0, 1},                              // a chaotic motion
        {1e10, 2, 1e8, 0, 0},                            // with errors of 10^4 times the value
        {1e10, 1e-3 / 2, 1, 0, 0}, {1e15, 10, 1, 0, 0},  // near rounding
        {1e13, 2, 1, 0, 1},        {1e13, 0.5, 1, 0, 0}, // fit_rounding
        {1e8, 2e-3, 1, 0, 1},      {1e8, 5e-4, 1, 0, 0}, // fit_unsure
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct fit_told told;
        told_of(&told, row[i].first, row[i].second);
        CHECK_INT(pend_fit_told_is(&told, 1), row[i].at_first);
        pend_fit_told_sure(&told, row[i].variance);
        CHECK(pend_fit_told_is(&told, 0));
        CHECK_SAYING(pend_fit_told_is(&told, 1) == row[i].sure, "slopes of %g and %g", row[i].first,
                     row[i].second);
        double covariance[4], own = row[i].sure ? pow(0.8 / row[i].second, 2) : 0;
        pend_fit_told_covariance(&told, covariance);
        double want = own + pow(0.6 / row[i].first, 2);
        CHECK_SAYING(fabs(covariance[0] / want - 1) < 1e-3, "variance %g, not %g", covariance[0],
                     want);
        pend_fit_told_clear(&told);
    }
}

/* the data do not depend on the second and the fourth unknown; of the first and the third they
 * determine the sum only */
TEST(unknowns_that_the_data_do_not_depend_on_are_named_one_by_one) {
    static const double slope[] = {1, 0, 1, 0, 2, 0, 2, 0, 3, 0, 3, 0, 4, 0, 4, 0, 5, 0, 5, 0};
    static const double residual[5] = {1, 2, 3, 4, 5}, size[4] = {1, 1, 1, 1};
    unsigned char fixed[4] = {0};
    struct fit_told told;
    double to[4 * 4];
    REQUIRE(pend_fit_told_init(&told, 5, 4, slope, residual, fixed, size) == PEND_OK);
    CHECK_INT(pend_fit_told_blind(&told, fixed, 4, to), 3);
    for (int j = 0; j < 4; j++) CHECK(to[j] == (j == 1) && to[4 + j] == (j == 3));
    CHECK(fabs(to[8] + to[10]) < 1e-12 && fabs(fabs(to[8]) - 1) < 1e-12);
    CHECK(fabs(to[9]) < 1e-12 && fabs(to[11]) < 1e-12);
    CHECK_INT(pend_fit_told_blind(&told, fixed, 1, to), 1);
    // an unknown at its bound is no direction
    fixed[3] = 1;
    pend_fit_told_clear(&told);
    REQUIRE(pend_fit_told_init(&told, 5, 4, slope, residual, fixed, size) == PEND_OK);
    CHECK_INT(pend_fit_told_blind(&told, fixed, 4, to), 2);
    CHECK(to[1] == 1 && fabs(to[4] + to[6]) < 1e-12);
    pend_fit_told_clear(&told);
}

TEST(slopes_that_are_no_numbers_are_no_lack_of_memory) {
    static const double bad[] = {NAN, INFINITY, 1e200};
    static const double residual[2] = {1, 2}, size[2] = {1, 1};
    static const unsigned char fixed[2];
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const double slope[4] = {1, 2, bad[i], 3};
        struct fit_told told;
        CHECK(pend_fit_told_init(&told, 2, 2, slope, residual, fixed, size) == PEND_NOT_FINITE);
        pend_fit_told_clear(&told);
    }
    struct pend_error error;
    CHECK(pend_fit_state_lost(PEND_NOT_FINITE, &error) == PEND_NOT_FINITE);
    CHECK(strstr(error.text, "too large") && !strstr(error.text, "memory"));
}
