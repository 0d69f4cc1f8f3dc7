#include "core/simd/kernel_sincos.h"

#include <string.h>

#include "core/simd/vec_isa.h"

void KERNEL_NAME(pend_kernel_sincos_)(const double phi[], int count, double re[], double im[]) {
    for (int a = 0; a < count; a += WIDE) {
        wide x = wide_of(0), cosine, sine;
        memcpy(&x, phi + a, (size_t)(count - a < WIDE ? count - a : WIDE) * sizeof(double));
        WIDE_(sincos)(x, wide_of(0), &sine, &cosine);
        wide_put(re + a, cosine);
        wide_put(im + a, sine);
    }
}
