/* Powers of ten to 128 bits, computed by the compiler.
 * Leaves to others: the conversions (number_write).
 * Invariant: 10^p = (significand + e) * 2^exponent with 2^127 <= significand < 2^128 and 0 <= e
 * < 1; e = 0 for 0 <= p <= 55. C++17. */
#pragma once

#include <stdint.h>

namespace api {

constexpr int POWER_LEAST = -308, POWER_MOST = 324, POWER_EXACT_MOST = 55;

struct uint128 {
    uint64_t high, low;
};

/* the binary exponent that belongs to the significand of 10^p: floor(log2 10^p) - 127 */
constexpr int power_exponent(int p) { return (p * 217706 >> 16) - 127; }

/* floor(log10 2^q) for |q| <= 1650 */
constexpr int log10_of_power2(int q) { return q * 1262611 >> 22; }

class power_table {
  public:
    constexpr power_table() : entries() {
        wide up = {}, down = {};
        up.limb[0] = 1;
        down.limb[LIMBS - 1] = 1;
        for (int p = 0; p <= POWER_MOST; p++, up.times_ten()) entries[p - POWER_LEAST] = up.top();
        for (int p = 0; p >= POWER_LEAST; p--, down.over_ten())
            entries[p - POWER_LEAST] = down.top();
    }
    constexpr uint128 operator[](int p) const { return entries[p - POWER_LEAST]; }

  private:
    static constexpr int LIMBS = 38;

    /* a large natural number in limbs of 32 bits, the lowest first */
    struct wide {
        uint32_t limb[LIMBS];

        constexpr void times_ten() {
            uint64_t carry = 0;
            for (int i = 0; i < LIMBS; i++, carry >>= 32) {
                carry += (uint64_t)10 * limb[i];
                limb[i] = (uint32_t)carry;
            }
        }
        constexpr void over_ten() {
            uint64_t rest = 0;
            for (int i = LIMBS - 1; i >= 0; i--) {
                rest = rest << 32 | limb[i];
                limb[i] = (uint32_t)(rest / 10);
                rest %= 10;
            }
        }
        constexpr uint64_t at(int i) const { return i < 0 ? 0 : limb[i]; }
        /* the 128 bits from the highest set bit on */
        constexpr uint128 top() const {
            int i = LIMBS - 1;
            while (!limb[i]) i--;
            int shift = __builtin_clz(limb[i]);
            uint64_t a = at(i) << 32 | at(i - 1), b = at(i - 2) << 32 | at(i - 3), c = at(i - 4);
            if (!shift) return {a, b};
            return {a << shift | b >> (64 - shift), b << shift | c >> (32 - shift)};
        }
    };

    uint128 entries[POWER_MOST - POWER_LEAST + 1];
};

constexpr power_table powers_of_ten{};

/* the bits of the least double that is not below 10^p, for p from -307 to 308; positive doubles
 * have the order of their bits */
class threshold_table {
  public:
    constexpr threshold_table() : entries() {
        for (int p = LEAST; p <= MOST; p++) entries[p - LEAST] = bits(p);
    }
    constexpr uint64_t operator[](int p) const { return entries[p - LEAST]; }

  private:
    static constexpr int LEAST = -307, MOST = 308;

    static constexpr uint64_t bits(int p) {
        uint128 power = powers_of_ten[p];
        uint64_t significand = power.high >> 11,
                 biased = (uint64_t)(power_exponent(p) + 64 + 11 + 1075);
        bool more = power.high << 53 || power.low || p < 0 || p > POWER_EXACT_MOST;
        return (biased << 52) + (significand - ((uint64_t)1 << 52)) + more;
    }
    uint64_t entries[MOST - LEAST + 1];
};

constexpr threshold_table thresholds{};

} // namespace api
