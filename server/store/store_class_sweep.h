/* The end of rooms: at their time, or at their teacher's word.
 * Leaves to others: who may end one (store_classes), when to sweep (store_sweep).
 * Invariant: of a room that has ended nothing is left. */
#ifndef SRV_STORE_CLASS_SWEEP_H
#define SRV_STORE_CLASS_SWEEP_H

#include "server/store/store_call.h"

/** Removes a room with all that is kept of it, in the transaction that runs; processes are woken.
 * O(items) */
enum srv_stored srv_store_class_erase(struct srv_store *store, const char *code);

/** Removes one room whose time is over; *more becomes 1 if there was one. */
enum srv_stored srv_store_class_sweep(struct srv_store *store, int64_t now, int *more);

#endif
