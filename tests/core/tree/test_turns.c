#include "core/tree/turns.h"

#include <float.h>
#include <math.h>

#include "tests/harness/quad.h"
#include "tests/harness/test.h"

/* distance of a reduced angle from the angle, on the circle, in quadruple precision */
static double circle_gap(double phi, double low) {
    struct pend_sum turns, rest = pend_turns_rest(phi, low, &turns);
    test_quad whole = (test_quad)phi, part = (test_quad)low;
    // the angle of a sum, so that the rounding of the sum of a large and a small number does not
    // matter
    test_quad sine =
        test_quad_sin(whole) * test_quad_cos(part) + test_quad_cos(whole) * test_quad_sin(part);
    test_quad cosine =
        test_quad_cos(whole) * test_quad_cos(part) - test_quad_sin(whole) * test_quad_sin(part);
    test_quad x = (test_quad)rest.high + (test_quad)rest.low;
    CHECK_SAYING(fabs(rest.high) <= 3.1415926535897936, "%g of %g", rest.high, phi);
    CHECK_SAYING(pend_turns_add(rest.high, turns.high, turns.low) == phi,
                 "%.17g came back as %.17g", phi, pend_turns_add(rest.high, turns.high, turns.low));
    return (double)test_quad_abs(sine * test_quad_cos(x) - cosine * test_quad_sin(x));
}

TEST(turns_leave_the_exact_rest_of_any_angle) {
    unsigned long long seed = 22;
    double worst = 0;
    for (int exponent = 11; exponent < 1024; exponent++)
        for (int i = 0; i < 4; i++) {
            double phi =
                ldexp(1 + test_random(&seed), exponent - (exponent == 1023)) * (i % 2 ? -1 : 1);
            double low = i < 2 ? 0 : phi * 0x1p-54 * (2 * test_random(&seed) - 1);
            worst = fmax(worst, circle_gap(phi, low));
        }
    worst = fmax(worst, fmax(circle_gap(1e22, 0), circle_gap(DBL_MAX, 0)));
    CHECK_RESIDUAL(worst, 2e-31, "sine of the difference, 1024 to the largest double");
}

/* the double that is nearest to a multiple of pi / 2: 2^-61 of a right angle, all of whose digits
 * count */
TEST(turns_keep_the_digits_of_a_rest_near_zero) {
    struct pend_sum rest = pend_turns_rest(ldexp(6381956970095103.0, 797), 0, NULL);
    test_quad exact = test_quad_read("-4.687165924254627611122582801963884e-19"),
              pi = test_quad_read("3.14159265358979323846264338327950288");
    test_quad x = (test_quad)rest.high + (test_quad)rest.low;
    // its cosine is that small: the remainder is close to a right angle
    test_quad gap = test_quad_abs(test_quad_abs(test_quad_abs(x) - pi / 2) + exact);
    CHECK_RESIDUAL((double)gap, 1e-31, "rest");
    double turn = 2 * M_PI;
    rest = pend_turns_rest(turn * 0x1p40, 0, NULL);
    // 2 pi as a double is too small by 2.4e-16
    CHECK_RESIDUAL(fabs(rest.high + 0x1p40 * 0x1.1a62633145c07p-52), 1e-15, "rest of 2^40 turns");
}

TEST(turns_are_none_of_what_is_small) {
    const double angles[] = {0, -0.0, 1, -1023.9, PEND_TURNS_FROM, -PEND_TURNS_FROM};
    for (size_t i = 0; i < sizeof angles / sizeof *angles; i++) {
        struct pend_sum turns, rest = pend_turns_rest(angles[i], 1e-17, &turns);
        CHECK(rest.high == angles[i] && signbit(rest.high) == signbit(angles[i]) &&
              rest.low == 1e-17);
        CHECK(turns.high == 0 && turns.low == 0);
        CHECK(pend_turns_add(rest.high, turns.high, turns.low) == angles[i]);
    }
}
