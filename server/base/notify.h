/* Messages about the server's state to a supervisor (systemd and compatible ones).
 * Leaves to others: the time of each message.
 * Invariant: without a supervisor nothing happens; a supervisor that does not read delays
 * nothing. */
#pragma once

/**
 * Sends a state to the socket that the environment names in NOTIFY_SOCKET (sd_notify(3)).
 *
 * state  "READY=1", "STOPPING=1", ...
 *
 * Returns 1 if the message was sent, 0 if there is no supervisor or sending failed.
 */
int srv_notify(const char *state);
