/* Separate stores for a test, daemons on them, and jobs as a client handles them.
 * Leaves to others: requests and expected answers (each test).
 * Invariant: a store that a test began ends with the test. */
#pragma once

#include "tests/harness/postgres.h"
#include "tests/wire/ask.h"

enum { ID = 26, WORDS = 24 };

#define ASYNC "Prefer: respond-async\r\n"

/* A separate store for the test. */
struct place {
    struct test_postgres *postgres; /* NULL: SQLite */
    char directory[64], url[256];
    const char *lease; /* s, for daemons that are started from now on; a minute, so that a busy
                        * machine does not lose one */
};

/** A new store; returns 0 with a failed check. */
int place_begin(struct place *place, int postgres);

void place_end(struct place *place);

/** Runs a drill on both stores; without PostgreSQL it prints a message. */
void place_on_both(void (*drill)(struct place *place));

/** A daemon on the store, without a cache so that nothing is answered from memory; one more option
 * may follow. */
struct test_server *place_serve(const struct place *place, const char *role, const char *part,
                                const char *option, const char *value);

/** Ends a daemon that may have reported that another one, or the store, did not respond. */
void stop_after_deaths(struct test_server **server);

/** Submits; returns the status, and the new job's id, "" if there is none. */
int submit(const struct test_server *server, const char *path, const char *headers,
           const char *body, char id[ID + 1]);

/** Requests a job, or the path after its id: "/results". */
int job_get(const struct test_server *server, struct test_reply *reply, const char *id,
            const char *what, const char *headers);

/** Waits until a job has ended; returns its final state. */
void job_wait(const struct test_server *server, const char *id, char word[WORDS]);
