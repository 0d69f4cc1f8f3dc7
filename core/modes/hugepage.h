/* Memory for large arrays of numbers.
 * Leaves to others: the contents.
 * Invariant: a block is released with free. */
#pragma once

#include <stddef.h>

/**
 * Allocates a block aligned to 64 bytes; blocks of 4 MiB or more use huge pages if the system has
 * them. A matrix of eigenvectors is written once, and page faults of small pages would take a
 * quarter of the time of writing it.
 *
 * Returns NULL if memory is short. The contents are not initialized.
 */
void *pend_hugepage(size_t bytes);
