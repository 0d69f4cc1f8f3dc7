/* Elementary functions of vectors; vec.h includes this file once for each number of LANES.
 * Leaves to others: arguments that are not finite (the callers check their results).
 * Invariant: the same operations in every lane, no branch. */
#define VEC_PASTE2(a, b) a##b
#define VEC_PASTE(a, b) VEC_PASTE2(a, b)
#define VEC VEC_PASTE(lanes, LANES)
#define BITS VEC_PASTE(bits, LANES)
#define OF(name) VEC_PASTE(VEC_PASTE(lanes, LANES), _##name)

typedef long long BITS __attribute__((vector_size(8 * LANES)));

VEC_INLINE VEC OF(get)(const double *at) { return *(const VEC *)(const void *)at; }

VEC_INLINE void OF(put)(double *at, VEC x) { *(VEC *)(void *)at = x; }

/** x where the mask is all ones, y where it is 0. */
VEC_INLINE VEC OF(pick)(BITS mask, VEC x, VEC y) {
    return (VEC)((mask & (BITS)x) | (~mask & (BITS)y));
}

/** The larger and the smaller of two; y if one of them is not a number. */
#if LANES == 8 && defined(__AVX512F__)
VEC_INLINE VEC OF(max)(VEC x, VEC y) { return (VEC)_mm512_max_pd((__m512d)x, (__m512d)y); }
VEC_INLINE VEC OF(min)(VEC x, VEC y) { return (VEC)_mm512_min_pd((__m512d)x, (__m512d)y); }
#elif LANES == 4 && defined(__AVX2__)
VEC_INLINE VEC OF(max)(VEC x, VEC y) { return (VEC)_mm256_max_pd((__m256d)x, (__m256d)y); }
VEC_INLINE VEC OF(min)(VEC x, VEC y) { return (VEC)_mm256_min_pd((__m256d)x, (__m256d)y); }
#elif LANES == 2 && defined(__x86_64__)
VEC_INLINE VEC OF(max)(VEC x, VEC y) { return (VEC)_mm_max_pd((__m128d)x, (__m128d)y); }
VEC_INLINE VEC OF(min)(VEC x, VEC y) { return (VEC)_mm_min_pd((__m128d)x, (__m128d)y); }
#else
VEC_INLINE VEC OF(max)(VEC x, VEC y) { return OF(pick)((BITS)(x > y), x, y); }
VEC_INLINE VEC OF(min)(VEC x, VEC y) { return OF(pick)((BITS)(x < y), x, y); }
#endif

VEC_INLINE VEC OF(abs)(VEC x) { return (VEC)((BITS)x & 0x7fffffffffffffffLL); }

/** The larger of |x| and y >= 0; y if x is not a number. */
#if LANES == 8 && defined(__AVX512DQ__)
VEC_INLINE VEC OF(peak)(VEC x, VEC y) { return (VEC)_mm512_range_pd((__m512d)x, (__m512d)y, 0x0b); }
#else
VEC_INLINE VEC OF(peak)(VEC x, VEC y) { return OF(max)(OF(abs)(x), y); }
#endif

/** The nearest integer, |x| < 2^51. */
VEC_INLINE VEC OF(round)(VEC x) {
    VEC magic = OF(of)(0x1.8p52);
    return (x + magic) - magic;
}

/** The largest integer not above x, |x| < 2^51. */
VEC_INLINE VEC OF(floor)(VEC x) {
    VEC near = OF(round)(x);
    return near - (VEC)((BITS)(near > x) & (BITS)OF(of)(1));
}

/* x + low = turn pi / 2 + r + rest, |r| at most slightly above pi / 4, rest below an ulp of r;
 * returns r. */
VEC_INLINE VEC OF(reduce)(VEC x, VEC low, VEC *rest, BITS *turn) {
    VEC magic = OF(of)(0x1.8p52), shifted = OF(fma)(x, OF(of)(0x1.45f306dc9c883p-1), magic),
        n = shifted - magic;
#ifdef __FMA__
    // the difference to the leading 53 bits of pi / 2 is a multiple of 2^-53 below 1, so it is
    // exact
    VEC near = OF(fma)(n, OF(of)(-0x1.921fb54442d18p+0), x),
        tail = OF(fma)(n, OF(of)(-0x1.1a62633145c07p-54), low);
#else
    // n times each of the first two parts of pi / 2 is exact up to n = 2^20
    VEC far = x - n * 0x1.921fb54400000p+0, second = n * 0x1.0b4611a600000p-34, near = far - second;
    // the tail contains the rounding error of that difference (0 if far is the smaller one) and the
    // rest of pi / 2
    VEC tail = ((far - near) - second) + low - n * 0x1.3198a2e037073p-69;
#endif
    VEC r = near + tail;
    *rest = (near - r) + tail;
    *turn = (BITS)shifted;
    return r;
}

/* (sin r - r) / r^3 and (cos r - 1 + r^2 / 2) / r^4 as functions of z = r^2, |r| below pi / 4 */
VEC_INLINE VEC OF(sine_terms)(VEC z) {
    VEC s = OF(fma)(z, OF(of)(0x1.5d92470eeb08bp-33), OF(of)(-0x1.ae5e63cec97aap-26));
    s = OF(fma)(z, s, OF(of)(0x1.71de3574bc93ap-19));
    s = OF(fma)(z, s, OF(of)(-0x1.a01a019c0e4f8p-13));
    s = OF(fma)(z, s, OF(of)(0x1.111111110f861p-7));
    return OF(fma)(z, s, OF(of)(-0x1.5555555555549p-3));
}

VEC_INLINE VEC OF(cosine_terms)(VEC z) {
    VEC c = OF(fma)(z, OF(of)(-0x1.8fadd061d64a6p-37), OF(of)(0x1.1ee9ea6cd0900p-29));
    c = OF(fma)(z, c, OF(of)(-0x1.27e4f807d689ep-22));
    c = OF(fma)(z, c, OF(of)(0x1.a01a019caef49p-16));
    c = OF(fma)(z, c, OF(of)(-0x1.6c16c16c15162p-10));
    return OF(fma)(z, c, OF(of)(0x1.555555555554cp-5));
}

/* sine and cosine of r + turn pi / 2 from those of r */
VEC_INLINE void OF(quadrant)(BITS turn, VEC sin_r, VEC cos_r, VEC *sine, VEC *cosine) {
#if LANES == 8 && defined(__AVX512F__)
    __m512i sign = _mm512_set1_epi64((long long)0x8000000000000000ULL), one = _mm512_set1_epi64(1);
    __m512i first = _mm512_slli_epi64((__m512i)turn, 62),
            next = _mm512_add_epi64(first, _mm512_set1_epi64(1LL << 62));
    __mmask8 swap = _mm512_test_epi64_mask((__m512i)turn, one);
    __m512i s = (__m512i)_mm512_mask_blend_pd(swap, (__m512d)sin_r, (__m512d)cos_r);
    __m512i c = (__m512i)_mm512_mask_blend_pd(swap, (__m512d)cos_r, (__m512d)sin_r);
    // s ^ (first & sign)
    *sine = (VEC)_mm512_ternarylogic_epi64(s, first, sign, 0x78);
    *cosine = (VEC)_mm512_ternarylogic_epi64(c, next, sign, 0x78);
#else
    BITS swap = -(turn & 1), sine_sign = (turn & 2) << 62, cosine_sign = ((turn ^ swap) & 2) << 62;
    *sine = (VEC)((BITS)OF(pick)(swap, cos_r, sin_r) ^ sine_sign);
    *cosine = (VEC)((BITS)OF(pick)(swap, sin_r, cos_r) ^ cosine_sign);
#endif
}

/** Sine and cosine of x + low, |low| below about an ulp of x. They are within 1 ulp of the larger
 * one up to |x| = 1e6, and as exact as x itself up to 1e12. */
VEC_INLINE void OF(sincos)(VEC x, VEC low, VEC *sine, VEC *cosine) {
    BITS turn;
    VEC tail, r = OF(reduce)(x, low, &tail, &turn), z = r * r;
    VEC s = OF(sine_terms)(z), c = OF(cosine_terms)(z);
    VEC half = 0.5 * z, one = OF(of)(1), rest = one - half;
    VEC sin_r = r + OF(fma)(r * z, s, tail * rest);
    VEC cos_r = rest + (((one - rest) - half) + OF(fma)(z * z, c, -(r * tail)));
    OF(quadrant)(turn, sin_r, cos_r, sine, cosine);
}

/* the sine and cosine of `turn` sixteenths of the circle */
VEC_INLINE void OF(sixteenths)(BITS turn, VEC *sine, VEC *cosine) {
#if LANES == 8 && defined(__AVX512F__)
    // the lowest four bits are the index
    const double *at = lanes_sixteenths;
    *sine =
        (VEC)_mm512_permutex2var_pd(_mm512_loadu_pd(at), (__m512i)turn, _mm512_loadu_pd(at + 8));
    *cosine = (VEC)_mm512_permutex2var_pd(_mm512_loadu_pd(at + 4), (__m512i)turn,
                                          _mm512_loadu_pd(at + 12));
#else
    for (int i = 0; i < LANES; i++) {
        (*sine)[i] = lanes_sixteenths[turn[i] & 15];
        (*cosine)[i] = lanes_sixteenths[(turn[i] & 15) + 4];
    }
#endif
}

/* x + low = turn pi / 8 + r, |r| at most slightly above pi / 16; returns r */
VEC_INLINE VEC OF(reduce_eighths)(VEC x, VEC low, BITS *turn) {
    VEC magic = OF(of)(0x1.8p52), shifted = OF(fma)(x, OF(of)(0x1.45f306dc9c883p+1), magic),
        n = shifted - magic;
    *turn = (BITS)shifted;
#ifdef __FMA__
    // the difference to the leading 53 bits of pi / 8 is a multiple of 2^-54 below 1/4, so it is
    // exact
    return OF(fma)(n, OF(of)(-0x1.921fb54442d18p-2), x) +
           OF(fma)(n, OF(of)(-0x1.1a62633145c07p-56), low);
#else
    // n times each of the first two parts of pi / 8 is exact up to n = 2^23
    VEC far = x - n * 0x1.921fb54800000p-2, second = n * -0x1.de973dc800000p-33,
        near = far - second;
    return near + (((far - near) - second) + low - n * -0x1.9d9cceba3f91fp-64);
#endif
}

/** Sine and cosine of the exact x - base. The error is at most half an ulp of 1 larger than that of
 * sincos, and a sine near 0 is exact to its own last digits. It takes two thirds of the time of
 * sincos: after subtracting a multiple of a sixteenth of the circle, the angle is so small that
 * short polynomials suffice. */
VEC_INLINE void OF(between)(VEC x, VEC base, VEC *sine, VEC *cosine) {
    // the difference is rounded; near a half turn only its rounding error distinguishes aligned
    // arms from arms that are almost aligned
    VEC angle = x - base, back = x - angle, low = (x - (angle + back)) + (back - base), far_sine,
        far_cosine;
    BITS turn;
    VEC r = OF(reduce_eighths)(angle, low, &turn), z = r * r;
    VEC s = OF(fma)(z, OF(of)(0x1.718d60897d040p-19), OF(of)(-0x1.a019f726ba98ap-13));
    s = OF(fma)(z, s, OF(of)(0x1.1111111088287p-7));
    s = OF(fma)(z, s, OF(of)(-0x1.55555555554cap-3));
    VEC c = OF(fma)(z, OF(of)(-0x1.27a90416b84c3p-22), OF(of)(0x1.a019f8adc163dp-16));
    c = OF(fma)(z, c, OF(of)(-0x1.6c16c16b885edp-10));
    c = OF(fma)(z, c, OF(of)(0x1.55555555554f4p-5));
    // sin r, cos r - 1
    VEC u = OF(fma)(r * z, s, r), v = z * OF(fma)(z, c, OF(of)(-0.5));
    OF(sixteenths)(turn, &far_sine, &far_cosine);
    *sine = far_sine + OF(fma)(far_cosine, u, far_sine * v);
    *cosine = far_cosine + OF(fma)(-far_sine, u, far_cosine * v);
}

/** The binary logarithm within 1e-5, for normal x > 0; zero gives -1023. */
VEC_INLINE VEC OF(log2)(VEC x) {
    BITS bits = (BITS)x;
    VEC exponent = (VEC)(((bits >> 52) & 0x7ff) | 0x4330000000000000LL) - (0x1p52 + 1023);
    VEC m = (VEC)((bits & 0xfffffffffffffLL) | 0x3ff0000000000000LL) - 1;
    VEC p = OF(fma)(m, OF(of)(-0.02645722400377554), OF(of)(0.1234506284500257));
    p = OF(fma)(m, p, OF(of)(-0.2795369132916203));
    p = OF(fma)(m, p, OF(of)(0.4582699984536986));
    p = OF(fma)(m, p, OF(of)(-0.718281677822792));
    p = OF(fma)(m, p, OF(of)(1.4425531199127515));
    return OF(fma)(m, p, exponent);
}

/** 2 to the nearest integer of x, -1022 <= x <= 1023. */
VEC_INLINE VEC OF(power)(VEC x) { return (VEC)(((BITS)(x + (0x1.8p52 + 1023))) << 52); }

/** 2 to the x within 2e-7, -1022 <= x <= 1023. */
VEC_INLINE VEC OF(exp2)(VEC x) {
    VEC n = OF(round)(x), f = x - n;
    VEC p = OF(fma)(f, OF(of)(0.0013409983027996987), OF(of)(0.009676036102295737));
    p = OF(fma)(f, p, OF(of)(0.05550297367938582));
    p = OF(fma)(f, p, OF(of)(0.24022107383747435));
    p = OF(fma)(f, p, OF(of)(0.6931472253727761));
    p = OF(fma)(f, p, OF(of)(1.0000000754879643));
    return p * OF(power)(n);
}

#undef VEC_PASTE2
#undef VEC_PASTE
#undef VEC
#undef BITS
#undef OF
#undef LANES
