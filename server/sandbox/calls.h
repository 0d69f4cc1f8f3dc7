/* The system calls that the server, and a process that computes for it, may make once it has
 * started: seccomp filters.
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

struct srv_calls_filter;

/**
 * Prepares the filter of processes that only compute (server/work/zygote): memory, reading and
 * writing what is open, the clock, and the end. Any other call ends such a process with SIGSYS.
 *
 * filter  out, for the rest of the process' life; NULL after a failure.
 *
 * PEND_INVALID  as srv_calls_restrict.
 */
PEND_MUST_CHECK enum pend_status srv_calls_computing_new(struct srv_calls_filter **filter,
                                                         struct pend_error *error);

/** Puts that filter in force for this process, for good; requires no_new_privs. Returns 0 where the
 * kernel refuses. */
int srv_calls_computing_close(const struct srv_calls_filter *filter);

/** True in builds with a sanitizer, which needs system calls, files and memory of its own. */
int srv_calls_sanitized(void);

#endif
