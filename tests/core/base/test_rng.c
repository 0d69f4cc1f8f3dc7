/* Tests of core/base/rng: the published vectors, the distributions, independence of draws and
 * members.
 * Leaves to others: what is drawn (test_op_ensembles). Invariant: seeds are fixed, so that
 * statistics are too. */
#include "core/base/rng.h"

#include <math.h>
#include <string.h>

#include "tests/harness/test.h"

TEST(rng_gives_the_published_vectors_of_philox) {
    static const struct {
        uint32_t counter[4], key[2], want[4];
    } known[] = {
        {{0, 0, 0, 0}, {0, 0}, {0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}},
        {{0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff},
         {0xffffffff, 0xffffffff},
         {0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}},
        {{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344},
         {0xa4093822, 0x299f31d0},
         {0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}},
    };
    for (int i = 0; i < 3; i++) {
        uint32_t counter[4];
        memcpy(counter, known[i].counter, sizeof counter);
        pend_rng_philox(counter, known[i].key);
        CHECK(!memcmp(counter, known[i].want, sizeof counter));
    }
}

TEST(rng_numbers_have_the_moments_of_their_distributions) {
    enum { COUNT = 200000 };
    double uniform[3] = {0}, normal[5] = {0}, cross = 0;
    for (int i = 0; i < COUNT; i++) {
        double u = pend_rng_uniform(7, (uint64_t)i, 0), x = pend_rng_normal(7, (uint64_t)i, 1);
        CHECK(u >= 0 && u < 1);
        for (int j = 0; j < 3; j++) uniform[j] += pow(u, j) / COUNT;
        for (int j = 0; j < 5; j++) normal[j] += pow(x, j) / COUNT;
        cross += (u - 0.5) * x / COUNT;
    }
    // four standard deviations of each mean
    CHECK(fabs(uniform[1] - 0.5) < 4 * sqrt(1.0 / 12 / COUNT) &&
          fabs(uniform[2] - 1.0 / 3) < 4 * sqrt(0.089 / COUNT));
    CHECK(fabs(normal[1]) < 4 / sqrt(COUNT) && fabs(normal[2] - 1) < 4 * sqrt(2.0 / COUNT));
    CHECK(fabs(normal[3]) < 4 * sqrt(15.0 / COUNT) && fabs(normal[4] - 3) < 4 * sqrt(96.0 / COUNT));
    CHECK(fabs(cross) < 4 * sqrt(1.0 / 12 / COUNT));
}

TEST(rng_normal_is_the_inverse_of_the_error_function) {
    double worst = 0;
    for (uint64_t i = 0; i < 20000; i++) {
        double u = pend_rng_uniform(3, i, 0), x = pend_rng_normal(3, i, 0);
        // the smaller tail, with relative error; its derivative converts the error to x
        double tail = u < 0.5 ? u : 1 - u, got = 0.5 * erfc(fabs(x) / sqrt(2));
        double slope = exp(-x * x / 2) / sqrt(2 * M_PI);
        worst =
            fmax(worst, fabs(got - tail - 0x1p-54 * (u < 0.5 ? 1 : -1)) / slope / (1 + fabs(x)));
    }
    CHECK_RESIDUAL(worst, 5e-15, "error of a normal number");
}

TEST(rng_depends_on_seed_member_and_place) {
    double x = pend_rng_uniform(1, 2, 3);
    CHECK(x == pend_rng_uniform(1, 2, 3));
    CHECK(x != pend_rng_uniform(2, 2, 3) && x != pend_rng_uniform(1, 3, 3) &&
          x != pend_rng_uniform(1, 2, 4));
    CHECK(x != pend_rng_uniform(1ull << 32 | 1, 2, 3) &&
          x != pend_rng_uniform(1, 1ull << 32 | 2, 3));
}
