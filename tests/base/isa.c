/* The instruction set of a processor without AVX2, on any: this object stands before the library
 * in a test program.
 * Leaves to others: the choice in earnest (core/base/isa). Invariant: no part of the library or
 * of the server. */
#include "core/base/isa.h"

enum pend_isa pend_isa_best(void) { return PEND_ISA_BASE; }
