#include "core/base/isa.h"

enum pend_isa pend_isa_best(void) {
#ifdef __x86_64__
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma") ||
        !__builtin_cpu_supports("bmi2")) {
        return PEND_ISA_BASE;
    }
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512cd")) {
        return PEND_ISA_AVX512;
    }
    return PEND_ISA_AVX2;
#else
    return PEND_ISA_BASE;
#endif
}
