/* Payne and Hanek's reduction: the fraction of x / (2 pi) is computed from those binary digits of 1
 * / (2 pi) that affect it. */
#include "core/tree/turns.h"

#include <assert.h>
#include <stdint.h>

enum { WORD = 64, FRACTION = 4, TABLE = 24 };

/* 1 / (2 pi), 64 binary digits per word, starting after the point */
static const uint64_t turns_inverse[TABLE] = {
    UINT64_C(0x28be60db9391054a), UINT64_C(0x7f09d5f47d4d3770), UINT64_C(0x36d8a5664f10e410),
    UINT64_C(0x7f9458eaf7aef158), UINT64_C(0x6dc91b8e909374b8), UINT64_C(0x01924bba82746487),
    UINT64_C(0x3f877ac72c4a69cf), UINT64_C(0xba208d7d4baed121), UINT64_C(0x3a671c09ad17df90),
    UINT64_C(0x4e64758e60d4ce7d), UINT64_C(0x272117e2ef7e4a0e), UINT64_C(0xc7fe25fff7816603),
    UINT64_C(0xfbcbc462d6829b47), UINT64_C(0xdb4d9fb3c9f2c26d), UINT64_C(0xd3d18fd9a797fa8b),
    UINT64_C(0x5d49eeb1faf97c5e), UINT64_C(0xcf41ce7de294a4ba), UINT64_C(0x9afed7ec47e35742),
    UINT64_C(0x1580cc11bf1edaea), UINT64_C(0xfc33ef0826bd0d87), UINT64_C(0x6a78e45857b986c2),
    UINT64_C(0x19666157c5281a10), UINT64_C(0x237ff620135cc9cc), UINT64_C(0x41818555b29cea32)};

static struct pend_sum sum_of(double x, double y) {
    double high = x + y, part = high - x;
    return (struct pend_sum){high, (x - (high - part)) + (y - part)};
}

static struct pend_sum sum_add(struct pend_sum a, struct pend_sum b) {
    struct pend_sum high = sum_of(a.high, b.high), low = sum_of(a.low, b.low);
    high = sum_of(high.high, high.low + low.high);
    return sum_of(high.high, high.low + low.low);
}

static struct pend_sum sum_mul(struct pend_sum a, struct pend_sum b) {
    double product = a.high * b.high, low = fma(a.high, b.high, -product);
    return sum_of(product, low + (a.high * b.low + a.low * b.high));
}

/* fraction of m 2^e / (2 pi), as FRACTION words; m < 2^53, 0 <= e <= 971 */
static void turns_fraction(uint64_t m, int e, uint64_t fraction[FRACTION]) {
    uint64_t place[FRACTION], carry = 0;
    int word = e / WORD, bit = e % WORD;
    assert(m <= UINT64_C(1) << 53 && e >= 0 && word + FRACTION < TABLE);
    for (int i = 0; i < FRACTION; i++)
        place[i] =
            bit ? turns_inverse[word + i] << bit | turns_inverse[word + i + 1] >> (WORD - bit)
                : turns_inverse[word + i];
    for (int i = FRACTION - 1; i >= 0; i--) {
        // the product of two halves of a word is exact
        uint64_t low = (m & UINT32_MAX) * (place[i] & UINT32_MAX),
                 high = (m >> 32) * (place[i] >> 32);
        uint64_t cross = (m >> 32) * (place[i] & UINT32_MAX),
                 other = (m & UINT32_MAX) * (place[i] >> 32);
        uint64_t middle = (low >> 32) + (cross & UINT32_MAX) + (other & UINT32_MAX);
        uint64_t whole = (middle << 32) | (low & UINT32_MAX);
        high += (middle >> 32) + (cross >> 32) + (other >> 32);
        fraction[i] = whole + carry;
        carry = high + (fraction[i] < whole);
    }
}

/* 2 pi */
static const struct pend_sum turns_whole = {2 * M_PI, 4 * PEND_QUARTER_LOW};

/* 2 pi times a fraction, which is first moved to the range from -1/2 to 1/2 */
static struct pend_sum turns_angle(uint64_t fraction[FRACTION]) {
    struct pend_sum sum = {0, 0};
    int negative = fraction[0] >> (WORD - 1) != 0;
    for (int i = FRACTION - 1, carry = negative; negative && i >= 0; i--) {
        fraction[i] = ~fraction[i] + (uint64_t)carry;
        carry = carry && fraction[i] == 0;
    }
    for (int i = FRACTION - 1; i >= 0; i--) {
        double scale = ldexp(1, -WORD * (i + 1));
        sum = sum_add(sum, sum_of((double)(fraction[i] & UINT32_MAX) * scale, 0));
        sum = sum_add(sum, sum_of((double)(fraction[i] >> 32) * 0x1p32 * scale, 0));
    }
    sum = sum_mul(sum, turns_whole);
    return negative ? (struct pend_sum){-sum.high, -sum.low} : sum;
}

/* the remainder of one double, rad */
static struct pend_sum turns_reduce(double x) {
    uint64_t fraction[FRACTION];
    int e = 0;
    double size = fabs(x), m = size;
    if (size >= 0x1p53) {
        m = ldexp(frexp(size, &e), 53);
        e -= 53;
    }
    double whole = floor(m);
    turns_fraction((uint64_t)whole, e, fraction);
    struct pend_sum rest = sum_add(turns_angle(fraction), sum_of(m - whole, 0));
    return x < 0 ? (struct pend_sum){-rest.high, -rest.low} : rest;
}

struct pend_sum pend_turns_rest(double phi, double low, struct pend_sum *turns) {
    static const struct pend_sum none = {0, 0};
    struct pend_sum rest = {phi, low};
    assert(isfinite(phi) && isfinite(low));
    if (turns) *turns = none;
    if (fabs(phi) <= PEND_TURNS_FROM) return rest;
    rest = sum_add(turns_reduce(phi), turns_reduce(low));
    double around = rint(rest.high / turns_whole.high);
    if (around != 0)
        rest =
            sum_add(rest, (struct pend_sum){-around * turns_whole.high, -around * turns_whole.low});
    assert(fabs(rest.high) <= turns_whole.high / 2 * (1 + 0x1p-50));
    // the difference as a sum of two doubles, so that remainder + turns equals phi to its last bit
    if (turns) {
        *turns = sum_of(phi, -rest.high);
        turns->low += low - rest.low;
        if (low == 0) turns->low = phi - turns->high - rest.high;
    }
    return rest;
}
