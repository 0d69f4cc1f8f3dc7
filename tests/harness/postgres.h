/* A real PostgreSQL for a test, in a new directory, which listens on a Unix socket there and
 * nowhere else.
 * Leaves to others: the queries.
 * Invariant: a database that a test started ends with the test program. */
#pragma once

struct test_postgres;

/**
 * Creates a database cluster and starts it. Committed data survive the death of its processes; it
 * waits for no disk (fsync is off), so they would not survive a crash of the system. The first one
 * of a program takes some seconds, the others are copies of it.
 *
 * Returns NULL if the programs are not installed (`make check` installs them) or it does not get
 * ready.
 */
struct test_postgres *test_postgres_start(void);

/** "postgresql://..." for the server's --store; valid until the end. */
const char *test_postgres_url(const struct test_postgres *postgres);

/** Ends it with a signal, waits, and restarts it on the same data: SIGINT restarts, SIGQUIT or
 * SIGKILL crashes. */
int test_postgres_restart(struct test_postgres *postgres, int number);

/** Ends it with a signal and waits; test_postgres_resume restarts it on the same data. */
void test_postgres_halt(struct test_postgres *postgres, int number);

/** Returns non-zero once it is running. */
int test_postgres_resume(struct test_postgres *postgres);

/** Stops all its processes, or lets them continue: its sockets stay open meanwhile and send
 * nothing. */
void test_postgres_freeze(const struct test_postgres *postgres, int frozen);

/** Runs one command on it; returns non-zero on success. */
int test_postgres_run(const struct test_postgres *postgres, const char *command);

/** Stops it and removes its directory; NULL is accepted. */
void test_postgres_stop(struct test_postgres **postgres);
