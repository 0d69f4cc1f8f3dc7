/* Takes from the process, once it listens, what it does not need to serve: privileges, files and
 * system calls.
 * Leaves to others: how the kernel is told (sandbox/fence, sandbox/calls).
 * Invariant: what is taken cannot be had again, by this process or any that it starts. */
#ifndef SRV_WALLS_H
#define SRV_WALLS_H

#include "server/config/config.h"

/** Fails with PEND_INVALID, and says why, where the process is root's and the options do not allow
 * that. */
PEND_MUST_CHECK enum pend_status srv_walls_root(const struct srv_config *config,
                                                struct pend_error *error);

/**
 * Puts up the walls, as far as `walls` asks: no new privileges and no capabilities; files that the
 * options name and those that libraries read (Landlock); the list of system calls (seccomp).
 *
 * To be called once, when the listening socket and the logs are open and before there is a second
 * thread.
 *
 * lack  out: with `walls auto`, which of them this kernel or build does not have; "" where all are
 *       up, or walls is off.
 *
 * PEND_INVALID  with `walls on`: one of them cannot be put up; error says which.
 */
PEND_MUST_CHECK enum pend_status srv_walls_raise(const struct srv_config *config,
                                                 char lack[SRV_CONFIG_TEXT],
                                                 struct pend_error *error);

#endif
