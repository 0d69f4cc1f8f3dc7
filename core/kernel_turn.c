#include "core/kernel_turn.h"

#include <string.h>

#include "core/lanes.h"

#if defined(__AVX512F__)
enum { WIDE = 8 };
typedef lanes8 wide;
#define WIDE_(name) lanes8_##name
#elif defined(__AVX2__)
enum { WIDE = 4 };
typedef lanes4 wide;
#define WIDE_(name) lanes4_##name
#else
enum { WIDE = 2 };
typedef lanes2 wide;
#define WIDE_(name) lanes2_##name
#endif

#define KERNEL_PASTE2(a, b) a##b
#define KERNEL_PASTE(a, b) KERNEL_PASTE2(a, b)

void KERNEL_PASTE(pend_kernel_turn_, PEND_ISA)(const double phi[], int count, double re[], double im[]) {
    for (int a = 0; a < count; a += WIDE) {
        wide x = WIDE_(of)(0), cosine, sine;
        memcpy(&x, phi + a, (size_t)(count - a < WIDE ? count - a : WIDE) * sizeof(double));
        WIDE_(sincos)(x, WIDE_(of)(0), &sine, &cosine);
        WIDE_(put)(re + a, cosine);
        WIDE_(put)(im + a, sine);
    }
}
