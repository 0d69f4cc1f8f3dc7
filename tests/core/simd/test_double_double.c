/* Tests of core/simd/double_double: every operation against quad precision, in the base
 * instruction set: without fused multiply-add.
 * Leaves to others: the wider sets, which test_extended runs.
 * Invariant: errors in units of 2^-104 of the larger operand or of the result. */
#pragma GCC diagnostic ignored "-Wpsabi"
#include "core/simd/vec.h"

#define LANES 2
#include "core/simd/double_double.h"

#include <math.h>

#include "core/tree/turns.h"
#include "tests/harness/quad.h"
#include "tests/harness/test.h"

/* quads are only a few bits finer than sums of two doubles */
static const double unit = 0x1p-104;

static test_quad quad_of(pairs2 x, int lane) {
    return (test_quad)x.high[lane] + (test_quad)x.low[lane];
}

/* a number of any size and sign with 106 random bits */
static double any(unsigned long long *seed, double decades) {
    return (test_random(seed) - 0.5) * pow(10, decades * (2 * test_random(seed) - 1));
}

static pairs2 any_pair(unsigned long long *seed, double decades) {
    double first = any(seed, decades), second = any(seed, decades);
    // the low part in 32 bits, so that a quad represents the sum exactly
    float rest = (float)(test_random(seed) - 0.5), other = (float)(test_random(seed) - 0.5);
    return pairs2_settle(
        (pairs2){{first, second}, {first * 0x1p-53 * rest, second * 0x1p-53 * other}});
}

static void worse(double *worst, pairs2 got, int lane, test_quad want, test_quad size) {
    double error = (double)(test_quad_abs(quad_of(got, lane) - want) / size / unit);
    if (!(error <= *worst)) *worst = error;
}

static test_quad larger(test_quad x, test_quad y) {
    x = test_quad_abs(x), y = test_quad_abs(y);
    return x > y ? x : y;
}

TEST(pairs_add_multiply_and_divide_to_their_last_digits) {
    unsigned long long seed = 1;
    double worst[4] = {0, 0, 0, 0};
    for (int i = 0; i < 20000; i++) {
        pairs2 x = any_pair(&seed, i % 9), y = any_pair(&seed, i % 9), z = any_pair(&seed, i % 9);
        if (i % 4 == 0) y = pairs2_settle((pairs2){-x.high, y.high * 0x1p-60});
        for (int lane = 0; lane < 2; lane++) {
            test_quad a = quad_of(x, lane), b = quad_of(y, lane), c = quad_of(z, lane);
            worse(&worst[0], pairs2_add(x, y), lane, a + b, larger(a, b));
            worse(&worst[1], pairs2_mul(x, y), lane, a * b, test_quad_abs(a * b));
            worse(&worst[2], pairs2_fma(x, y, z), lane, a * b + c, larger(a * b, c));
            worse(&worst[3], pairs2_div(x, y), lane, a / b, test_quad_abs(a / b));
        }
    }
    CHECK_RESIDUAL(worst[0], 2, "sum, units of 2^-104");
    CHECK_RESIDUAL(worst[1], 4, "product, units of 2^-104");
    CHECK_RESIDUAL(worst[2], 4, "fused, units of 2^-104");
    CHECK_RESIDUAL(worst[3], 8, "quotient, units of 2^-104");
}

TEST(pairs_gather_long_sums_without_losing_digits) {
    unsigned long long seed = 2;
    pairs2 sum = pairs2_of(0);
    test_quad want = 0, size = 0;
    double plain = 0, worst = 0;
    for (int i = 0; i < 1000; i++) {
        pairs2 x = any_pair(&seed, 1), y = any_pair(&seed, 1);
        test_quad term = quad_of(x, 1) * quad_of(y, 1);
        sum = pairs2_gather(x, y, sum);
        plain += x.high[1] * y.high[1];
        want += term;
        size += test_quad_abs(term);
    }
    worse(&worst, pairs2_settle(sum), 1, want, size);
    CHECK_RESIDUAL(worst, 2, "a sum of 1000 products, units of 2^-104 of the sum of their sizes");
    // without the low parts twelve digits are lost
    CHECK((double)test_quad_abs(plain - want) > 1e10 * unit * (double)size);
}

static double sincos_worst(double range, unsigned long long seed) {
    double worst = 0;
    for (int i = 0; i < 5000; i++) {
        pairs2 x = any_pair(&seed, 0), sine, cosine;
        x.high *= 2 * range, x.low *= 2 * range;
        if (i % 8 == 0) x.high = lanes2_round(x.high / M_PI_2) * M_PI_2;
        // low parts of a size that a quad represents beside the high ones
        for (int lane = 0; lane < 2; lane++) x.low[lane] = ldexp(rint(ldexp(x.low[lane], 85)), -85);
        x = pairs2_settle(x);
        pairs2_sincos(x, &sine, &cosine);
        for (int lane = 0; lane < 2; lane++) {
            worse(&worst, sine, lane, test_quad_sin(quad_of(x, lane)), 1);
            worse(&worst, cosine, lane, test_quad_cos(quad_of(x, lane)), 1);
        }
    }
    return worst;
}

TEST(pairs_sine_and_cosine_have_all_digits) {
    CHECK_RESIDUAL(sincos_worst(0.785, 3), 2, "units of 2^-104, |x| up to pi/4");
    CHECK_RESIDUAL(sincos_worst(10, 4), 2, "units of 2^-104, |x| up to 10");
    CHECK_RESIDUAL(sincos_worst(1e6, 5), 2, "units of 2^-104, |x| up to 1e6");
}

/* whole turns are subtracted by Payne and Hanek's method, which the tested code does not use */
TEST(pairs_sine_and_cosine_of_many_turns_are_those_of_the_rest) {
    unsigned long long seed = 6;
    double worst = 0;
    for (int i = 0; i < 3000; i++) {
        pairs2 x = any_pair(&seed, 0), sine, cosine, sine_of_rest, cosine_of_rest;
        double range = exp2(11 + i % 29);
        x.high *= range, x.low *= range;
        x = pairs2_settle(x);
        struct pend_sum less[2] = {pend_turns_rest(x.high[0], x.low[0], NULL),
                                   pend_turns_rest(x.high[1], x.low[1], NULL)};
        pairs2 rest = {{less[0].high, less[1].high}, {less[0].low, less[1].low}};
        pairs2_sincos(x, &sine, &cosine);
        pairs2_sincos(rest, &sine_of_rest, &cosine_of_rest);
        for (int lane = 0; lane < 2; lane++) {
            worse(&worst, sine, lane, quad_of(sine_of_rest, lane), 1);
            worse(&worst, cosine, lane, quad_of(cosine_of_rest, lane), 1);
        }
    }
    CHECK_RESIDUAL(worst, 64, "units of 2^-104, |x| from 1e3 to 1e12");
}

TEST(pairs_sine_of_small_angles_keeps_its_digits) {
    double worst = 0;
    for (double x = 1e-200; x < 0.5; x *= 3) {
        pairs2 sine, cosine, at = pairs2_of(x);
        at.low = at.high * 0x1p-55;
        pairs2_sincos(at, &sine, &cosine);
        test_quad want = test_quad_sin(quad_of(at, 0));
        worse(&worst, sine, 0, want, want);
    }
    CHECK_RESIDUAL(worst, 4, "relative error of sin x, units of 2^-104");
}
