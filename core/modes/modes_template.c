#include "core/modes/modes_template.h"

#include <assert.h>
#include <stddef.h>

extern const struct pend_modes_kernel pend_modes_kernel_for_base;
#ifdef __x86_64__
extern const struct pend_modes_kernel pend_modes_kernel_for_avx2, pend_modes_kernel_for_avx512;
#endif

const struct pend_modes_kernel *pend_modes_kernel_of(enum pend_isa isa) {
    assert((unsigned)isa < PEND_ISA_COUNT);
    if (isa > pend_isa_best()) return NULL;
#ifdef __x86_64__
    if (isa == PEND_ISA_AVX512) return &pend_modes_kernel_for_avx512;
    if (isa == PEND_ISA_AVX2) return &pend_modes_kernel_for_avx2;
#endif
    return &pend_modes_kernel_for_base;
}

const struct pend_modes_kernel *pend_modes_kernel(void) {
    return pend_modes_kernel_of(pend_isa_best());
}
