/* The running server: its parts in the order they need each other, and its end.
 * Leaves to others: the command line and signals (main).
 * Invariant: what was started is ended in reverse; an accepted request is answered before its
 * connection is closed. */
#ifndef SRV_DAEMON_H
#define SRV_DAEMON_H

#include "server/base/config.h"

struct srv_daemon;

/**
 * Starts everything; afterwards requests are answered.
 *
 * config  copied.
 *
 * PEND_INVALID, PEND_NO_MEMORY  error says what could not be started and why.
 */
PEND_MUST_CHECK enum pend_status srv_daemon_new(struct srv_daemon **daemon,
                                                const struct srv_config *config,
                                                struct pend_error *error);

/** Where it listens: "http://127.0.0.1:8080". */
const char *srv_daemon_url(const struct srv_daemon *daemon);

/** The log, for messages. */
struct srv_log *srv_daemon_log(const struct srv_daemon *daemon);

/** Seconds since when it found no part of a job to compute; 0 while it has one, or computes none
 * at all. */
double srv_daemon_idle(struct srv_daemon *daemon);

/** Puts options in force without a restart, as srv_reload does. */
PEND_MUST_CHECK enum pend_status srv_daemon_reload(struct srv_daemon *daemon,
                                                   const struct srv_config *next,
                                                   struct pend_error *error);

/** Opens the log's file anew, as whoever moved it away wants it. */
void srv_daemon_reopen(struct srv_daemon *daemon);

/** Seconds that a drain may take, as they are in force. */
double srv_daemon_patience(const struct srv_daemon *daemon);

/**
 * Goes one step towards the end, and says how far it is: stops listening at once, gives back the
 * parts of jobs, answers what runs and what still comes on open connections, each of which ends
 * with its answer, and sees every answer off. To be called again every few milliseconds.
 *
 * hurry  non-zero: what runs is ended now, what comes is not begun, and both are answered 503; idle
 *        connections are not waited for.
 *
 * Returns 1 when nothing is left to wait for.
 */
int srv_daemon_drain(struct srv_daemon *daemon, int hurry);

/** Ends everything; what is still running is ended as srv_daemon_drain does in a hurry. */
void srv_daemon_free(struct srv_daemon **daemon);

#endif
