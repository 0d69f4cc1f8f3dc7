/* Declarations that the headers for WebAssembly lack; every source of the engine includes this file
 * first.
 * Leaves to others: the functions (missing.c).
 * Invariant: the declarations are those of glibc. */
#pragma once

#ifndef __cplusplus
#include <stddef.h>

/**
 * Sorts `count` items of `size` bytes in place; equal items keep their order.
 *
 * order  returns < 0, 0 or > 0 if the first item sorts before, equal to, or after the second;
 *        receives `context` too.
 *
 * Ends the engine if memory is short. O(count log count).
 */
void qsort_r(void *data, size_t count, size_t size,
             int (*order)(const void *, const void *, void *), void *context);
#endif
