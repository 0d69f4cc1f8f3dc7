/* Telling a supervisor (systemd and those that do like it) how the server is.
 * Leaves to others: when to tell.
 * Invariant: without a supervisor nothing happens; a supervisor that does not listen delays
 * nothing. */
#ifndef SRV_NOTIFY_H
#define SRV_NOTIFY_H

/**
 * Sends a state to the socket that the environment names in NOTIFY_SOCKET (sd_notify(3)).
 *
 * state  "READY=1", "STOPPING=1", ...
 *
 * Returns 1 when it was sent, 0 when there is no supervisor or it could not be told.
 */
int srv_notify(const char *state);

#endif
