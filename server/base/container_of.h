/* From a pointer to a member to the structure that contains it. An object that lives inside its
 * owner's structure, such as a list's link or a question to the store, leads back to its owner.
 * Leaves to others: the structures.
 * Invariant: the compiler checks the member's name and the type of the structure. */
#pragma once

#include <stddef.h>

/* The structure of a type whose member is at `pointer`. The comparison is not evaluated: it makes
 * the compiler refuse a pointer of another type than the member's. */
#define SRV_CONTAINER_OF(pointer, type, member)                                                    \
    ((type *)((char *)(pointer)-offsetof(type, member) +                                           \
              0 * sizeof((pointer) == &((type *)0)->member)))
