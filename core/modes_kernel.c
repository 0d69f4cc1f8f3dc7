#include "core/modes_kernel.h"

extern const struct pend_modes_kernel pend_modes_kernel_for_base;
#ifdef __x86_64__
extern const struct pend_modes_kernel pend_modes_kernel_for_avx2, pend_modes_kernel_for_avx512;
#endif

const struct pend_modes_kernel *pend_modes_kernel_base(void) { return &pend_modes_kernel_for_base; }

const struct pend_modes_kernel *pend_modes_kernel(void) {
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd"))
        return &pend_modes_kernel_for_avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
        return &pend_modes_kernel_for_avx2;
#endif
    return &pend_modes_kernel_for_base;
}
