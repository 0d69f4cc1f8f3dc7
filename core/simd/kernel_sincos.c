#include "core/simd/kernel_sincos.h"

#include <string.h>

#include "core/simd/vec_isa.h"

enum { WIDE = KERNEL_WIDTH };
typedef KERNEL_OF(lanes, ) wide;
#define WIDE_(name) KERNEL_OF(lanes, _##name)

void KERNEL_NAME(pend_kernel_sincos_)(const double phi[], int count, double re[], double im[]) {
    for (int a = 0; a < count; a += WIDE) {
        wide x = WIDE_(of)(0), cosine, sine;
        memcpy(&x, phi + a, (size_t)(count - a < WIDE ? count - a : WIDE) * sizeof(double));
        WIDE_(sincos)(x, WIDE_(of)(0), &sine, &cosine);
        WIDE_(put)(re + a, cosine);
        WIDE_(put)(im + a, sine);
    }
}
