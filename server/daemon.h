/* Starts and ends the parts of a server in the order of their dependencies.
 * Leaves to others: the command line and signals (main).
 * Invariant: parts are ended in the reverse order; an accepted request is answered before its
 * connection is closed. */
#pragma once

#include "server/config/config.h"

struct srv_daemon;

/**
 * Starts a server, which then answers requests.
 *
 * config  copied.
 *
 * PEND_INVALID, PEND_NO_MEMORY  error says which part could not be started, and why.
 */
PEND_MUST_CHECK enum pend_status srv_daemon_new(struct srv_daemon **daemon,
                                                const struct srv_config *config,
                                                struct pend_error *error);

/** Returns the url at which it listens: "http://127.0.0.1:8080". */
const char *srv_daemon_url(const struct srv_daemon *daemon);

/** Returns the layers of the sandbox that this kernel or build lacks; "" = none. */
const char *srv_daemon_lack(const struct srv_daemon *daemon);

/** Returns the log, for messages. */
struct srv_log *srv_daemon_log(const struct srv_daemon *daemon);

/** Returns for how many seconds there has been no part of a job to compute; 0 if there is one, or
 * if this process computes no jobs. */
double srv_daemon_idle(struct srv_daemon *daemon);

/** Applies new options without a restart, as srv_reload does. */
PEND_MUST_CHECK enum pend_status srv_daemon_reload(struct srv_daemon *daemon,
                                                   const struct srv_config *next,
                                                   struct pend_error *error);

/** Returns true if the server has API keys, whose file must be checked regularly. */
int srv_daemon_has_keys(const struct srv_daemon *daemon);

/** Reloads the keys if their file has changed. One thread at a time; may wait for the disk. */
void srv_daemon_look(struct srv_daemon *daemon);

/** Reopens the log's file, after a program that rotates logs has moved it. */
void srv_daemon_reopen(struct srv_daemon *daemon);

/** Returns the seconds that a drain may take, according to the current options. */
double srv_daemon_patience(const struct srv_daemon *daemon);

/**
 * Takes one step of the drain: stops listening, returns the parts of jobs, and answers requests
 * that are being computed or still arrive on open connections, each of which is closed after its
 * answer. To be called again every few milliseconds.
 *
 * hurry  non-zero: computations are cancelled and none is started, both are answered with 503, and
 *        idle connections are not waited for.
 *
 * Returns 1 when all answers were sent and nothing is left to wait for.
 */
int srv_daemon_drain(struct srv_daemon *daemon, int hurry);

/** Stops and frees the server; running computations are cancelled, as by srv_daemon_drain with
 * `hurry`. */
void srv_daemon_free(struct srv_daemon **daemon);
