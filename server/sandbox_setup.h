/* Enters the sandbox once the server listens: drops privileges, and restricts files and system
 * calls. Leaves to others: the kernel's interfaces (sandbox/sandbox_landlock,
 * sandbox/sandbox_seccomp). Invariant: neither this process nor any that it starts can leave the
 * sandbox. */
#pragma once

#include "server/config/config.h"

/** Fails with PEND_INVALID if the process runs as root and the options do not allow that. */
PEND_MUST_CHECK enum pend_status srv_sandbox_root(const struct srv_config *config,
                                                  struct pend_error *error);

/**
 * Enters the sandbox unless the option `sandbox` is off: no new privileges and no capabilities;
 * only files that the options name or libraries read (Landlock); only listed system calls
 * (seccomp).
 *
 * Call once, after the listening socket and the logs are open and before a second thread exists.
 *
 * lack  out: with `sandbox auto`, the layers that this kernel or build lacks; "" if it lacks none,
 * or the option is off.
 *
 * PEND_INVALID  with `sandbox on`: a layer is not available; error names it.
 */
PEND_MUST_CHECK enum pend_status srv_sandbox_enter(const struct srv_config *config,
                                                   char lack[SRV_CONFIG_TEXT],
                                                   struct pend_error *error);
