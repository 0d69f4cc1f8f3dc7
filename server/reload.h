/* Options that change while the server runs: at SIGHUP they are read again, from the file, the
 * environment and the command line.
 * Leaves to others: reading them (config), signals (main).
 * Invariant: all that is new is in force, or nothing is: what cannot be read, or cannot be,
 * changes nothing. */
#ifndef SRV_RELOAD_H
#define SRV_RELOAD_H

#include "server/work/service.h"

/** True for an option that may change without a restart, by its name. */
int srv_reload_may(const char *name);

/** Opens where request lines go; -1 for no lines; -2, with errno set, where it cannot be opened. */
int srv_reload_log(const struct srv_config *config);

/**
 * Puts options in force, and tells the log which; those that want a restart are named and stay as
 * they were. The file of the log is opened anew.
 *
 * next  loaded by srv_config_load.
 *
 * PEND_INVALID, PEND_NO_MEMORY  error says why; nothing has changed.
 */
PEND_MUST_CHECK enum pend_status
srv_reload(struct srv_service *service, const struct srv_config *next, struct pend_error *error);

/** Frees what reloads have kept; nobody reads options any more. */
void srv_reload_clear(struct srv_service *service);

#endif
