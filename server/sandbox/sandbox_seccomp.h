/* Restricts the system calls of the server after its start: a seccomp filter.
 * Leaves to others: files and ports (sandbox_landlock), privileges (privileges).
 * Invariant: the kernel refuses calls that are not listed; calls that only an attacker would make
 * kill the process. */
#pragma once

#include "core/base/status.h"

/**
 * Installs the filter for this thread and all threads that it starts, irrevocably.
 *
 * Calls that only an attacker would make (running another program, inspecting another process,
 * changing the user) kill the process. Any other call that is not listed fails with ENOSYS, and a
 * line on standard error names its number; at most 16 such lines. Writable memory can never be
 * executed.
 *
 * Requires no_new_privs, or root's privileges. Cost: at most some ten nanoseconds per system call.
 *
 * PEND_INVALID  the kernel has no filters, or this build has a sanitizer, whose calls differ; error
 * says why, and nothing has changed.
 */
PEND_MUST_CHECK enum pend_status srv_sandbox_seccomp(struct pend_error *error);
