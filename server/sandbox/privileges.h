/* What a process may do as the user that it runs as, and no more.
 * Leaves to others: files (fence), system calls (calls), when this is given up (server/walls).
 * Invariant: what was given up is so for every program that the process starts, too. */
#ifndef SRV_PRIVILEGES_H
#define SRV_PRIVILEGES_H

#include "core/base/status.h"

/**
 * Sets no_new_privs and drops all capabilities, for this thread and those that it will start, for
 * good: no program that it could start gains anything.
 *
 * PEND_INVALID  the kernel refuses; error says what.
 */
PEND_MUST_CHECK enum pend_status srv_privileges_drop(struct pend_error *error);

#endif
