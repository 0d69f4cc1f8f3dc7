/* Tests of core/simd/vec: the elementary functions of vectors against quad precision, in the
 * base instruction set.
 * Leaves to others: the wider sets, which run the same operations (test_jets and test_ensemble
 * run all of them).
 * Invariant: errors in units of the last place. */
#pragma GCC diagnostic ignored "-Wpsabi"
#include "core/simd/vec.h"

#include <math.h>

#include "tests/harness/quad.h"
#include "tests/harness/test.h"

/* distance in ulps of 1: the allowed error of a sine or cosine */
static double ulps(double got, test_quad want) {
    return (double)test_quad_abs(((test_quad)got - want) * 0x1p53);
}

static double sincos_worst(double range, unsigned long long seed) {
    double worst = 0;
    for (int i = 0; i < 20000; i++) {
        double x = range * (2 * test_random(&seed) - 1),
               low = x * 0x1p-53 * (2 * test_random(&seed) - 1);
        if (i % 8 == 0) x = M_PI_2 * round(x / M_PI_2);
        lanes2 sine, cosine;
        lanes2_sincos(lanes2_of(x), lanes2_of(low), &sine, &cosine);
        test_quad exact = (test_quad)x + (test_quad)low;
        worst = fmax(worst, fmax(ulps(sine[0], test_quad_sin(exact)),
                                 ulps(cosine[1], test_quad_cos(exact))));
    }
    return worst;
}

TEST(lanes_sine_and_cosine_are_within_an_ulp) {
    CHECK_RESIDUAL(sincos_worst(4, 1), 0.8, "ulps of 1, |x| up to 4");
    CHECK_RESIDUAL(sincos_worst(1e6, 2), 0.8, "ulps of 1, |x| up to 1e6");
}

TEST(lanes_sine_of_small_angles_keeps_its_digits) {
    double worst = 0;
    for (double x = 1e-300; x < 0.5; x *= 3) {
        lanes2 sine, cosine;
        lanes2_sincos(lanes2_of(x), lanes2_of(0), &sine, &cosine);
        double exact = (double)test_quad_sin(x);
        worst = fmax(worst, fabs(sine[0] / exact - 1));
    }
    CHECK_RESIDUAL(worst, 3e-16, "relative error of sin x");
}

static double between_worst(double range, double apart, unsigned long long seed) {
    double worst = 0;
    for (int i = 0; i < 20000; i++) {
        double x = range * (2 * test_random(&seed) - 1),
               base = range * (2 * test_random(&seed) - 1);
        if (i % 4 == 0) base = x + M_PI_2 * (i / 4 % 5 - 2) + apart * (test_random(&seed) - 0.5);
        lanes2 sine, cosine;
        lanes2_between(lanes2_of(x), lanes2_of(base), &sine, &cosine);
        test_quad exact = (test_quad)x - (test_quad)base;
        worst = fmax(worst, fmax(ulps(sine[0], test_quad_sin(exact)),
                                 ulps(cosine[1], test_quad_cos(exact))));
    }
    return worst;
}

TEST(lanes_sine_and_cosine_of_a_difference_are_within_an_ulp_and_a_half) {
    CHECK_RESIDUAL(between_worst(4, 1, 4), 1.5, "ulps of 1, angles up to 4");
    CHECK_RESIDUAL(between_worst(1e6, 1e-6, 5), 1.5, "ulps of 1, angles up to 1e6");
}

TEST(lanes_sine_of_a_difference_keeps_its_digits_near_multiples_of_a_half_turn) {
    double worst = 0;
    unsigned long long seed = 6;
    for (int i = 0; i < 20000; i++) {
        double x = 8 * test_random(&seed),
               base = x + M_PI * (i % 5 - 2) + pow(10, -15 * test_random(&seed));
        lanes2 sine, cosine;
        lanes2_between(lanes2_of(x), lanes2_of(base), &sine, &cosine);
        test_quad exact = test_quad_sin((test_quad)x - (test_quad)base);
        if (exact != 0)
            worst = fmax(worst, (double)test_quad_abs(((test_quad)sine[0] - exact) / exact));
    }
    CHECK_RESIDUAL(worst, 5e-16, "relative error of sin(x - base)");
}

TEST(lanes_logarithm_and_power_are_good_enough_for_step_sizes) {
    double worst[2] = {0, 0};
    unsigned long long seed = 3;
    for (int i = 0; i < 10000; i++) {
        double x = 2000 * test_random(&seed) - 1000;
        worst[0] = fmax(worst[0], fabs(lanes2_exp2(lanes2_of(x))[0] / exp2(x) - 1));
        worst[1] = fmax(worst[1], fabs(lanes2_log2(lanes2_of(exp2(x)))[0] - x));
    }
    CHECK_RESIDUAL(worst[0], 2e-7, "exp2, relative");
    CHECK_RESIDUAL(worst[1], 1e-5, "log2");
}

TEST(lanes_floor_rounds_down) {
    double x[] = {-2, -1.5, -0.25, 0, 0.25, 1, 1.75, 1e9 + 0.5};
    for (int i = 0; i < 8; i++) CHECK(lanes2_floor(lanes2_of(x[i]))[0] == floor(x[i]));
}
