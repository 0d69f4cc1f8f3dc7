/* Large blocks of numbers.
 * Leaves to others: what is in them.
 * Invariant: a block ends with free. */
#ifndef PEND_HUGEPAGE_H
#define PEND_HUGEPAGE_H

#include <stddef.h>

/**
 * A block aligned to 64, on huge pages where it is large and the system has them: a matrix of
 * vectors is written once, and the page faults of small pages would cost a quarter of the whole.
 *
 * Returns NULL when memory is short. Contents are not set.
 */
void *pend_hugepage(size_t bytes);

#endif
