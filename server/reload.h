/* Options that change while the server runs: SIGHUP reads them again from the file, the
 * environment and the command line.
 * Leaves to others: reading them (config), signals (main).
 * Invariant: either all new values are in force or none is: an option that is wrong changes
 * nothing. */
#pragma once

#include "server/work/service.h"

/** True for an option that may change without a restart, by its name. */
int srv_reload_may(const char *name);

/** Opens the file of the request lines. Returns its descriptor; -1 for no lines; -2, with errno
 * set, if it cannot be opened. */
int srv_reload_log(const struct srv_config *config);

/** Opens the audit log, as srv_reload_log does. */
int srv_reload_audit(const struct srv_config *config);

/**
 * Puts new options in force and names them in the log; options that need a restart are named too
 * and keep their values. The file of the log is opened again.
 *
 * next  loaded by srv_config_load.
 *
 * PEND_INVALID, PEND_NO_MEMORY  error says why; nothing has changed.
 */
PEND_MUST_CHECK enum pend_status
srv_reload(struct srv_service *service, const struct srv_config *next, struct pend_error *error);

/** Frees the options that reloads have replaced; no thread may read options any more. */
void srv_reload_clear(struct srv_service *service);
