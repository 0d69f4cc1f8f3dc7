/* From a member to the structure that it lies in: how an object that lives inside its owner's
 * structure, as a list's link or a question to the store, leads back to its owner.
 * Leaves to others: what the structures are.
 * Invariant: the member's name and the type of the structure are checked by the compiler. */
#ifndef SRV_CONTAINER_OF_H
#define SRV_CONTAINER_OF_H

#include <stddef.h>

/* The structure of a type whose member is at `pointer`. The comparison, which is not evaluated,
 * lets the compiler refuse a pointer of another type than the member's. */
#define SRV_CONTAINER_OF(pointer, type, member)                                                    \
    ((type *)((char *)(pointer)-offsetof(type, member) +                                           \
              0 * sizeof((pointer) == &((type *)0)->member)))

#endif
