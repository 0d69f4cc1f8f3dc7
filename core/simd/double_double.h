/* Numbers of about 32 digits: vectors of unevaluated sums of two doubles. Included after
 * vec.h, with LANES defined.
 * Leaves to others: ranges (products below 1e292 in size, above 1e-260 to keep all digits), values
 * that are not finite.
 * Invariant: high is the rounded sum and low the rest, except after _gather, whose result _settle
 * normalizes. Every error is within 2^-102 of the larger operand (for products and quotients: of
 * the result), in every instruction set. */
#ifdef __FAST_MATH__
#error "sums of two doubles need the rounding of IEEE 754: leave out -ffast-math"
#endif

#define DD_PASTE2(a, b) a##b
#define DD_PASTE(a, b) DD_PASTE2(a, b)
#define DD_TYPE DD_PASTE(pairs, LANES)
#define DD(name) DD_PASTE(DD_TYPE, _##name)
#define VEC DD_PASTE(lanes, LANES)
#define VEC_(name) DD_PASTE(VEC, _##name)
#define BITS DD_PASTE(bits, LANES)

typedef struct {
    VEC high, low;
} DD_TYPE;

/** x y as the rounded product and its rounding error. */
VEC_INLINE DD_TYPE DD(product)(VEC x, VEC y) {
    VEC p = x * y;
    // keeps the compiler from fusing the product into the sums that use it
    VEC_PIN(p);
#ifdef __FMA__
    return (DD_TYPE){p, VEC_(fma)(x, y, -p)};
#else
    // Dekker: halves of 26 bits, whose products are exact
    VEC xs = x * 0x1.0000002p27, ys = y * 0x1.0000002p27;
    VEC_PIN(xs);
    VEC_PIN(ys);
    VEC xh = xs - (xs - x), yh = ys - (ys - y), xl = x - xh, yl = y - yh;
    return (DD_TYPE){p, ((xh * yh - p) + xh * yl + xl * yh) + xl * yl};
#endif
}

/** x + y as the rounded sum and its rounding error (Knuth). */
VEC_INLINE DD_TYPE DD(total)(VEC x, VEC y) {
    VEC s = x + y, part = s - x;
    return (DD_TYPE){s, (x - (s - part)) + (y - part)};
}

/** Normalizes high + low, where |high| >= |low| (Dekker). */
VEC_INLINE DD_TYPE DD(settle)(DD_TYPE x) {
    VEC s = x.high + x.low;
    return (DD_TYPE){s, x.low - (s - x.high)};
}

VEC_INLINE DD_TYPE DD(from)(VEC x) { return (DD_TYPE){x, VEC_(of)(0)}; }

VEC_INLINE DD_TYPE DD(of)(double x) { return DD(from)(VEC_(of)(x)); }

/** A constant of two parts in every lane. */
VEC_INLINE DD_TYPE DD(of2)(double high, double low) {
    return (DD_TYPE){VEC_(of)(high), VEC_(of)(low)};
}

VEC_INLINE DD_TYPE DD(neg)(DD_TYPE x) { return (DD_TYPE){-x.high, -x.low}; }

VEC_INLINE DD_TYPE DD(add)(DD_TYPE x, DD_TYPE y) {
    DD_TYPE s = DD(total)(x.high, y.high);
    s.low += x.low + y.low;
    return DD(settle)(s);
}

VEC_INLINE DD_TYPE DD(sub)(DD_TYPE x, DD_TYPE y) { return DD(add)(x, DD(neg)(y)); }

/** x times a power of two in each lane, exact. */
VEC_INLINE DD_TYPE DD(scale)(DD_TYPE x, VEC power) {
    return (DD_TYPE){x.high * power, x.low * power};
}

VEC_INLINE DD_TYPE DD(mul)(DD_TYPE x, DD_TYPE y) {
    DD_TYPE p = DD(product)(x.high, y.high);
    p.low = VEC_(fma)(x.high, y.low, p.low);
    p.low = VEC_(fma)(x.low, y.high, p.low);
    return DD(settle)(p);
}

/** sum + x y, for long sums. Pass the result to _gather again, or to _settle. */
VEC_INLINE DD_TYPE DD(gather)(DD_TYPE x, DD_TYPE y, DD_TYPE sum) {
    DD_TYPE p = DD(product)(x.high, y.high), s = DD(total)(sum.high, p.high);
    p.low = VEC_(fma)(x.high, y.low, p.low);
    p.low = VEC_(fma)(x.low, y.high, p.low);
    s.low = sum.low + (p.low + s.low);
    return s;
}

/** x y + z. */
VEC_INLINE DD_TYPE DD(fma)(DD_TYPE x, DD_TYPE y, DD_TYPE z) {
    return DD(settle)(DD(gather)(x, y, z));
}

VEC_INLINE DD_TYPE DD(div)(DD_TYPE x, DD_TYPE y) {
    VEC q = x.high / y.high;
    DD_TYPE p = DD(product)(q, y.high);
    VEC rest = (x.high - p.high) - p.low + x.low;
    return DD(settle)((DD_TYPE){q, (rest - q * y.low) / y.high});
}

/** x in lanes where `which` is all ones, y in lanes where it is 0. */
VEC_INLINE DD_TYPE DD(pick)(BITS which, DD_TYPE x, DD_TYPE y) {
    return (DD_TYPE){VEC_(pick)(which, x.high, y.high), VEC_(pick)(which, x.low, y.low)};
}

/* (-1)^j / (2 j + 1)! for j >= 1 and (-1)^j / (2 j)! for j >= 2, as many terms as matter up to pi /
 * 4 */
enum { DD(SINE_TERMS) = 14, DD(SINE_LONG) = 7, DD(COSINE_TERMS) = 14, DD(COSINE_LONG) = 7 };

VEC_INLINE DD_TYPE DD(horner)(const double term[][2], int terms, int precise, DD_TYPE z) {
    // for terms this small one double suffices
    VEC tail = VEC_(of)(term[terms - 1][0]);
    for (int j = terms - 2; j >= precise; j--) tail = VEC_(fma)(z.high, tail, VEC_(of)(term[j][0]));
    DD_TYPE sum = DD(from)(tail);
    for (int j = precise - 1; j >= 0; j--) sum = DD(fma)(z, sum, DD(of2)(term[j][0], term[j][1]));
    return sum;
}

/* x - (n + many) pi / 2, |n| <= 2^20 and `many` a multiple of 2^20 up to 2^40: their products with
 * each part of pi / 2 except the last are exact */
VEC_INLINE DD_TYPE DD(less)(DD_TYPE x, VEC n, VEC many) {
    static const double whole = -0x1.921fb54400000p+0,
                        part[] = {-0x1.0b4611a600000p-34, -0x1.3198a2e000000p-69,
                                  -0x1.b839a25200000p-104, -0x1.27044533e63a0p-142};
    DD_TYPE first = DD(total)(x.high, many * whole), second = DD(total)(first.high, n * whole);
    DD_TYPE r = DD(total)(second.high, x.low);
    r.low += first.low + second.low;
    for (int i = 0; i < 4; i++) {
        DD_TYPE next = DD(total)(r.high, n * part[i]);
        next.low += r.low;
        r = DD(settle)(next);
        next = DD(total)(r.high, many * part[i]);
        next.low += r.low;
        r = DD(settle)(next);
    }
    return r;
}

/** Sine and cosine with error 2^-102, relative to x if that is small. x up to 1e12 is taken as
 * exact: beyond 1e6 the last digit of x is larger than the error. */
VEC_INLINE void DD(sincos)(DD_TYPE x, DD_TYPE *sine, DD_TYPE *cosine) {
    static const double sine_term[DD(SINE_TERMS)][2] = {
        {-0x1.5555555555555p-3, -0x1.5555555555555p-57},
        {0x1.1111111111111p-7, 0x1.1111111111111p-63},
        {-0x1.a01a01a01a01ap-13, -0x1.a01a01a01a01ap-73},
        {0x1.71de3a556c734p-19, -0x1.c154f8ddc6c00p-73},
        {-0x1.ae64567f544e4p-26, 0x1.c062e06d1f209p-80},
        {0x1.6124613a86d09p-33, 0x1.f28e0cc748ebep-87},
        {-0x1.ae7f3e733b81fp-41, -0x1.1d8656b0ee8cbp-97},
        {0x1.952c77030ad4ap-49, 0x1.ac981465ddc6cp-103},
        {-0x1.2f49b46814157p-57, -0x1.2650f61dbdcb4p-112},
        {0x1.71b8ef6dcf572p-66, -0x1.d043ae40c4647p-120},
        {-0x1.761b41316381ap-75, 0x1.3423c7d91404fp-130},
        {0x1.3f3ccdd165fa9p-84, -0x1.58ddadf344487p-139},
        {-0x1.d1ab1c2dccea3p-94, -0x1.054d0c78aea14p-149},
        {0x1.259f98b4358adp-103, 0x1.eaf8c39dd9bc5p-157}};
    static const double cosine_term[DD(COSINE_TERMS)][2] = {
        {0x1.5555555555555p-5, 0x1.5555555555555p-59},
        {-0x1.6c16c16c16c17p-10, 0x1.f49f49f49f49fp-65},
        {0x1.a01a01a01a01ap-16, 0x1.a01a01a01a01ap-76},
        {-0x1.27e4fb7789f5cp-22, -0x1.cbbc05b4fa99ap-76},
        {0x1.1eed8eff8d898p-29, -0x1.2aec959e14c06p-83},
        {-0x1.93974a8c07c9dp-37, -0x1.05d6f8a2efd1fp-92},
        {0x1.ae7f3e733b81fp-45, 0x1.1d8656b0ee8cbp-101},
        {-0x1.6827863b97d97p-53, -0x1.eec01221a8b0bp-107},
        {0x1.e542ba4020225p-62, 0x1.ea72b4afe3c2fp-120},
        {-0x1.0ce396db7f853p-70, 0x1.aebcdbd20331cp-124},
        {0x1.f2cf01972f578p-80, -0x1.9ada5fcc1ab14p-135},
        {-0x1.88e85fc6a4e5ap-89, 0x1.71c37ebd16540p-143},
        {0x1.0a18a2635085dp-98, 0x1.b9e2e28e1aa54p-153},
        {-0x1.3932c5047d60ep-108, -0x1.832b7b530a627p-162}};
    // number of right angles, and its part that is a multiple of 2^20 (0 for angles below 8e5)
    VEC magic = VEC_(of)(0x1.8p52), shifted = x.high * 0x1.45f306dc9c883p-21 + magic;
    VEC many = (shifted - magic) * 0x1p20;
    shifted = (x.high + many * -0x1.921fb54400000p+0 - many * 0x1.0b4611a600000p-34) *
                  0x1.45f306dc9c883p-1 +
              magic;
    BITS turn = (BITS)shifted;
    DD_TYPE r = DD(less)(x, shifted - magic, many);
    DD_TYPE z = DD(mul)(r, r);
    DD_TYPE s = DD(horner)(sine_term, DD(SINE_TERMS), DD(SINE_LONG), z);
    DD_TYPE c = DD(horner)(cosine_term, DD(COSINE_TERMS), DD(COSINE_LONG), z);
    s = DD(fma)(DD(mul)(r, z), s, r);
    c = DD(fma)(DD(mul)(z, z), c, DD(sub)(DD(of)(1), DD(scale)(z, VEC_(of)(0.5))));
    // by quadrant: whether sine and cosine are exchanged, and their signs
    BITS swap = -(turn & 1), sine_sign = (turn & 2) << 62,
         cosine_sign = ((turn ^ turn << 1) & 2) << 62;
    DD_TYPE a = DD(pick)(swap, c, s), b = DD(pick)(swap, s, c);
    *sine = (DD_TYPE){(VEC)((BITS)a.high ^ sine_sign), (VEC)((BITS)a.low ^ sine_sign)};
    *cosine = (DD_TYPE){(VEC)((BITS)b.high ^ cosine_sign), (VEC)((BITS)b.low ^ cosine_sign)};
}

#undef DD_PASTE2
#undef DD_PASTE
#undef DD_TYPE
#undef DD
#undef VEC
#undef VEC_
#undef BITS
#undef LANES
