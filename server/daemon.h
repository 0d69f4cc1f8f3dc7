/* Starts and ends the parts of a server in the order in which they need each other.
 * Leaves to others: the command line and signals (main).
 * Invariant: parts are ended in the reverse order; an accepted request is answered before its
 * connection is closed. */
#pragma once

#include "server/config/config.h"

struct srv_daemon;

/**
 * Starts everything; afterwards requests are answered.
 *
 * config  copied.
 *
 * PEND_INVALID, PEND_NO_MEMORY  error says which part could not be started, and why.
 */
PEND_MUST_CHECK enum pend_status srv_daemon_new(struct srv_daemon **daemon,
                                                const struct srv_config *config,
                                                struct pend_error *error);

/** The url at which it listens: "http://127.0.0.1:8080". */
const char *srv_daemon_url(const struct srv_daemon *daemon);

/** The layers of the sandbox that this kernel or build lacks; "" = none. */
const char *srv_daemon_lack(const struct srv_daemon *daemon);

/** The log, for messages. */
struct srv_log *srv_daemon_log(const struct srv_daemon *daemon);

/** Returns for how many seconds it has found no part of a job to compute; 0 if it has one, or
 * computes no jobs. */
double srv_daemon_idle(struct srv_daemon *daemon);

/** Puts options in force without a restart, as srv_reload does. */
PEND_MUST_CHECK enum pend_status srv_daemon_reload(struct srv_daemon *daemon,
                                                   const struct srv_config *next,
                                                   struct pend_error *error);

/** True if the server has API keys, whose file must be checked regularly. */
int srv_daemon_has_keys(const struct srv_daemon *daemon);

/** Reads the keys again if their file has changed. One thread at a time; may wait for the disk. */
void srv_daemon_look(struct srv_daemon *daemon);

/** Opens the log's file again, after a program that rotates logs has moved it. */
void srv_daemon_reopen(struct srv_daemon *daemon);

/** Seconds that a drain may take, of the options in force. */
double srv_daemon_patience(const struct srv_daemon *daemon);

/**
 * Goes one step towards the end: stops listening, gives back the parts of jobs, and answers
 * requests that are being computed or still arrive on open connections, each of which is closed
 * after its answer. To be called again every few milliseconds.
 *
 * hurry  non-zero: computations are ended, new ones are not begun, both are answered 503, and idle
 *        connections are not waited for.
 *
 * Returns 1 when all answers were sent and nothing is left to wait for.
 */
int srv_daemon_drain(struct srv_daemon *daemon, int hurry);

/** Ends the server; computations that still run are ended as by srv_daemon_drain in a hurry. */
void srv_daemon_free(struct srv_daemon **daemon);
