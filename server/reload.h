/* Options that change while the server runs: SIGHUP reloads them from the file, the environment and
 * the command line.
 * Leaves to others: reading them (config), signals (main).
 * Invariant: either all new values take effect or none does: an invalid option changes nothing. */
#pragma once

#include "server/work/service.h"

/** Returns true for the name of an option that can change without a restart. */
int srv_reload_may(const char *name);

/** Opens the file of the request lines. Returns its descriptor; -1 for no lines; -2, with errno
 * set, if it cannot be opened. */
int srv_reload_log(const struct srv_config *config);

/** Opens the audit log, as srv_reload_log does. */
int srv_reload_audit(const struct srv_config *config);

/**
 * Applies new options and names them in the log; options that need a restart are named too and keep
 * their values. The log's file is reopened.
 *
 * next  loaded by srv_config_load.
 *
 * PEND_INVALID, PEND_NO_MEMORY  error says why; nothing has changed.
 */
PEND_MUST_CHECK enum pend_status
srv_reload(struct srv_service *service, const struct srv_config *next, struct pend_error *error);

/** Frees the options that reloads have replaced; no thread may read options any more. */
void srv_reload_clear(struct srv_service *service);
