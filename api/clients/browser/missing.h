/* What the headers for WebAssembly lack; every source of the engine is compiled with it before.
 * Leaves to others: the functions (missing.c). Invariant: the same declaration as glibc's. */
#pragma once

#ifndef __cplusplus
#include <stddef.h>

/**
 * Sorts `count` items of `size` bytes in place; what is equal stays in its order.
 *
 * order  below 0, 0 or above 0, as its first item belongs before its second, with it, or behind it;
 *        gets `context` too.
 *
 * Ends the engine if there is no memory. O(count log count).
 */
void qsort_r(void *data, size_t count, size_t size,
             int (*order)(const void *, const void *, void *), void *context);
#endif
