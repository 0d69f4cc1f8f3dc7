#include "core/base/rng.h"

#include <assert.h>
#include <math.h>

void pend_rng_philox(uint32_t c[4], const uint32_t key[2]) {
    uint32_t k0 = key[0], k1 = key[1];
    for (int round = 0; round < 10; round++) {
        uint64_t p = (uint64_t)0xd2511f53 * c[0], q = (uint64_t)0xcd9e8d57 * c[2];
        uint32_t next[4] = {(uint32_t)(q >> 32) ^ c[1] ^ k0, (uint32_t)q,
                            (uint32_t)(p >> 32) ^ c[3] ^ k1, (uint32_t)p};
        for (int i = 0; i < 4; i++) c[i] = next[i];
        k0 += 0x9e3779b9;
        k1 += 0xbb67ae85;
    }
}

/* 53 random bits */
static uint64_t rng_bits(uint64_t seed, uint64_t i, uint32_t place) {
    const uint32_t key[2] = {(uint32_t)seed, (uint32_t)(seed >> 32)};
    uint32_t counter[4] = {(uint32_t)i, (uint32_t)(i >> 32), place, 0};
    pend_rng_philox(counter, key);
    return ((uint64_t)counter[1] << 32 | counter[0]) >> 11;
}

double pend_rng_uniform(uint64_t seed, uint64_t i, uint32_t place) {
    return (double)rng_bits(seed, i, place) * 0x1p-53;
}

/* natural logarithm of 0 < x <= 1, from sums, products and quotients alone, because the C library's
 * logarithms differ between machines */
static double rng_log(double x) {
    assert(x > 0 && x <= 1);
    int exponent;
    double m = frexp(x, &exponent);
    if (m < 0.70710678118654752) {
        m *= 2;
        exponent--;
    }
    double s = (m - 1) / (m + 1), z = s * s, sum = 0;
    for (int j = 23; j >= 1; j -= 2) sum = sum * z + 1.0 / j;
    return exponent * 0.69314718055994530942 + 2 * s * sum;
}

/* (num[0] + num[1] x + ...) / (den[0] + den[1] x + ...) */
static double rng_ratio(const double num[8], const double den[8], double x) {
    double above = 0, below = 0;
    for (int j = 7; j >= 0; j--) {
        above = above * x + num[j];
        below = below * x + den[j];
    }
    return above / below;
}

double pend_rng_normal(uint64_t seed, uint64_t i, uint32_t place) {
    static const double a[8] = {3.3871328727963666080e0,  1.3314166789178437745e+2,
                                1.9715909503065514427e+3, 1.3731693765509461125e+4,
                                4.5921953931549871457e+4, 6.7265770927008700853e+4,
                                3.3430575583588128105e+4, 2.5090809287301226727e+3};
    static const double b[8] = {1,
                                4.2313330701600911252e+1,
                                6.8718700749205790830e+2,
                                5.3941960214247511077e+3,
                                2.1213794301586595867e+4,
                                3.9307895800092710610e+4,
                                2.8729085735721942674e+4,
                                5.2264952788528545610e+3};
    static const double c[8] = {1.42343711074968357734e0,  4.63033784615654529590e0,
                                5.76949722146069140550e0,  3.64784832476320460504e0,
                                1.27045825245236838258e0,  2.41780725177450611770e-1,
                                2.27238449892691845833e-2, 7.74545014278341407640e-4};
    static const double d[8] = {1,
                                2.05319162663775882187e0,
                                1.67638483018380384940e0,
                                6.89767334985100004550e-1,
                                1.48103976427480074590e-1,
                                1.51986665636164571966e-2,
                                5.47593808499534494600e-4,
                                1.05075007164441684324e-9};
    static const double e[8] = {6.65790464350110377720e0,  5.46378491116411436990e0,
                                1.78482653991729133580e0,  2.96560571828504891230e-1,
                                2.65321895265761230930e-2, 1.24266094738807843860e-3,
                                2.71155556874348757815e-5, 2.01033439929228813265e-7};
    static const double f[8] = {1,
                                5.99832206555887937690e-1,
                                1.36929880922735805310e-1,
                                1.48753612908506148525e-2,
                                7.86869131145613259100e-4,
                                1.84631831751005468180e-5,
                                1.42151175831644588870e-7,
                                2.04426310338993978564e-15};
    // p is the middle of one of 2^53 equal intervals: never 0 or 1
    uint64_t bits = rng_bits(seed, i, place);
    double p = ((double)bits + 0.5) * 0x1p-53, q = ((double)bits - 0x1p52 + 0.5) * 0x1p-53;
    if (fabs(q) <= 0.425) return q * rng_ratio(a, b, 0.180625 - q * q);
    double tail = q < 0 ? p : ((double)((1ull << 53) - 1 - bits) + 0.5) * 0x1p-53,
           r = sqrt(-rng_log(tail));
    assert(tail > 0 && tail < 0.075 && r > 1.6);
    double x = r <= 5 ? rng_ratio(c, d, r - 1.6) : rng_ratio(e, f, r - 5);
    return q < 0 ? -x : x;
}
