/* The system calls that the server may make once it has started: a seccomp filter.
 * Leaves to others: which files and ports these calls reach (fence), privileges (server/walls).
 * Invariant: what is not listed is refused by the kernel; what only an intruder would call ends the
 * process. */
#ifndef SRV_CALLS_H
#define SRV_CALLS_H

#include "core/base/status.h"

/**
 * Puts the filter in force for this thread and those that it will start, for good.
 *
 * A call that is neither listed nor on the list of what only an intruder calls (to run another
 * program, to look into another process, to become another user) fails with ENOSYS, as on a kernel
 * that does not have it, and one line on standard error tells its number; of 16 such calls at most.
 * Memory that may be written can be run by none.
 *
 * Requires no_new_privs, or root's privileges. Cost: a call takes some ten nanoseconds more at
 * most.
 *
 * PEND_INVALID  the kernel, or this build (one with a sanitizer, whose own calls are others), has
 * no filters; error says why, and nothing has changed.
 */
PEND_MUST_CHECK enum pend_status srv_calls_restrict(struct pend_error *error);

#endif
