/* The instruction sets that kernels are compiled for, and the best one that this processor
 * supports.
 * Leaves to others: the kernels (kernel_*), compiling them once for each set (Makefile).
 * Invariant: the result is the same for every call in a process. */
#pragma once

/* Vectors hold 2, 4 and 8 doubles. Results agree to the last bit between avx2 and avx512; base
 * has no fused multiply-add and rounds differently. */
enum pend_isa { PEND_ISA_BASE, PEND_ISA_AVX2, PEND_ISA_AVX512, PEND_ISA_COUNT };

/** Returns the widest instruction set that the processor and its operating system support. O(1),
 * safe on any thread. */
enum pend_isa pend_isa_best(void);

/* PEND_ISA_EACH declares one table per instruction set; PEND_ISA_PICK is the address of the table
 * for a given set. */
#ifdef __x86_64__
#define PEND_ISA_EACH(type, name) extern const type name##_base, name##_avx2, name##_avx512
#define PEND_ISA_PICK(name, isa)                                                                   \
    ((isa) == PEND_ISA_AVX512 ? &name##_avx512                                                     \
     : (isa) == PEND_ISA_AVX2 ? &name##_avx2                                                       \
                              : &name##_base)
#else
#define PEND_ISA_EACH(type, name) extern const type name##_base
#define PEND_ISA_PICK(name, isa) ((void)(isa), &name##_base)
#endif
