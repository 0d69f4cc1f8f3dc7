/* Drops all privileges beyond those of the process's user.
 * Leaves to others: files (sandbox_landlock), system calls (sandbox_seccomp), when to drop
 * (server/sandbox_setup).
 * Invariant: dropped privileges are lost for every program that the process starts, too. */
#pragma once

#include "core/base/status.h"

/**
 * Sets no_new_privs and drops all capabilities, irrevocably, for this thread and all threads that
 * it starts. No program that it starts gains privileges.
 *
 * PEND_INVALID  the kernel refuses; error says which call.
 */
PEND_MUST_CHECK enum pend_status srv_privileges_drop(struct pend_error *error);
