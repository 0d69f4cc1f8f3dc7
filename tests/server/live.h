/* A daemon inside the test program, and exchanges without one.
 * Leaves to others: the client (harness/server).
 * Invariant: a test ends what it starts here. */
#pragma once

#include "server/daemon.h"
#include "server/work/exchange.h"
#include "tests/harness/server.h"

/* Bodies: one that is computed for many seconds; */
#define LIVE_LONG                                                                                  \
    "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},"                            \
    "\"times\":{\"start\":0,\"stop\":100000,\"count\":5}}"
/* and one that is computed for minutes, or for hours with the thread sanitizer */
#define LIVE_ENDLESS                                                                               \
    "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},"                            \
    "\"times\":{\"start\":0,\"stop\":2e7,\"count\":5}}"
#define LIVE_SHORT "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]}}"

/** Loads a configuration from options as on a command line, ended by NULL; a free port of loopback,
 * no access log, and time limits that no test reaches. */
struct srv_config live_config(const char *const options[]);

/** Starts a daemon; NULL, with a failed check, if that fails. */
struct srv_daemon *live_start(const char *const options[]);

/** Its port. */
int live_port(const struct srv_daemon *daemon);

/** Connects and sends a text; returns 0, with a failed check, if that fails. */
int live_say(const struct srv_daemon *daemon, struct test_client *client, const char *text);

/** Connects and posts JSON to a path. */
int live_post(const struct srv_daemon *daemon, struct test_client *client, const char *path,
              const char *body);

/** The status of one request on a separate connection, 0 if there is no answer within
 * TEST_PATIENCE. */
int live_status(const struct srv_daemon *daemon, const char *text);

/** A sample of /metrics, named by the start of its line, with the space before the value; NAN, with
 * a failed check, if there is none. */
double live_metric(const struct srv_daemon *daemon, const char *sample);

/** Waits until a sample has a value; returns 0, with a failed check, if it has another one after
 * TEST_PATIENCE. */
int live_await(const struct srv_daemon *daemon, const char *sample, double value);

/** Waits until a sample is at least a value, as live_await does. */
int live_await_least(const struct srv_daemon *daemon, const char *sample, double least);

/** Initializes a service without a daemon; its queue has space for `cap` tasks. */
void live_service(struct srv_service *service, int cap);

void live_service_clear(struct srv_service *service);
