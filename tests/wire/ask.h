/* Requests that several wire tests send, and reading their answers.
 * Leaves to others: the wire (harness/server), expected answers (each test).
 * Invariant: a text that does not parse fails the test that requested it. */
#pragma once

#include <cjson/cJSON.h>

#include "tests/harness/server.h"
#include "tests/harness/test.h"

/** The paper's four arms; a JSON object. */
#define ASK_FOUR_ARMS                                                                              \
    "{\"L\":[2,1.5,0.75,1.25],\"m\":[1,1,1,0.1],\"S\":[[1,0,0,0],[1,1,0,0],[1,1,1,0],[1,1,0,1]]}"

/** A double pendulum; a JSON object. */
#define ASK_DOUBLE "{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]}"

/** The paper's example: released from the horizontal, 501 instants to 5 s. */
#define ASK_EXAMPLE                                                                                \
    "{\"pendulum\":" ASK_FOUR_ARMS                                                                 \
    ",\"times\":{\"start\":0,\"stop\":5,\"step\":0.01},\"method\":\"taylor\","                     \
    "\"rtol\":1e-12,\"output\":[\"phi\",\"phid\",\"lambda\"]}"

/** A request that is answered at once. */
#define ASK_LITTLE "{\"pendulum\":" ASK_DOUBLE "}"

/**
 * A long computation with a short answer: 5 instants of a chain of 60 arms, released from the
 * horizontal.
 *
 * span  s of the pendulum's time; on one core 10 take some tenths of a second, more under a
 *       sanitizer.
 * Returns a static text.
 */
const char *ask_long(double span);

/** A POST of JSON; returns the status. */
int ask(struct test_server *server, struct test_reply *reply, const char *path, const char *body);

/** The body as JSON, or NULL with a failed check; released by cJSON_Delete. */
cJSON *ask_json(const struct test_reply *reply);

/**
 * Checks that a reply is a problem of that status: media type, type, title, status and detail.
 *
 * pointer  one that must be among its errors, or NULL.
 */
void ask_problem(const struct test_reply *reply, int status, const char *pointer);

/** Item `column` of row `row` of an array of arrays; NaN if there is none. */
double ask_at(const cJSON *rows, int row, int column);

/** The number after a name in /metrics; -1 if there is none. */
double ask_metric(const struct test_server *server, const char *name);

/** Waits until that number is from `least` to `most`; returns 0, with a failed check, if that does
 * not happen. */
int ask_await(const struct test_server *server, const char *name, double least, double most);

/** A line of /proc/PID/status, as a number to some base; -1 if it does not exist. */
long long ask_process(int pid, const char *name, int base);
