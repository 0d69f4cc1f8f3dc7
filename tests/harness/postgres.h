/* A real PostgreSQL of the test's own, in a new directory, heard on a Unix socket there and
 * nowhere else.
 * Leaves to others: what is asked of it.
 * Invariant: a database that a test started is gone when the test program is. */
#pragma once

struct test_postgres;

/**
 * Makes a database cluster and starts it. What it has committed survives the death of its
 * processes; it waits for no disk (fsync is off), so it would not survive the system's. A program's
 * first takes some seconds to make, the others are copies of it.
 *
 * Returns NULL where the programs are not installed (`make check` installs them) or it does not get
 * ready.
 */
struct test_postgres *test_postgres_start(void);

/** "postgresql://..." as the server's --store takes it; valid until the end. */
const char *test_postgres_url(const struct test_postgres *postgres);

/** Ends it with a signal, waits, and starts it anew on the same data: SIGINT restarts, SIGQUIT or
 * SIGKILL crashes. */
int test_postgres_restart(struct test_postgres *postgres, int number);

/** Ends it with a signal and waits; test_postgres_resume starts it anew on the same data. */
void test_postgres_halt(struct test_postgres *postgres, int number);

/** Non-zero once it is there. */
int test_postgres_resume(struct test_postgres *postgres);

/** Stops all its processes where they are, or lets them go on: its sockets stand meanwhile and
 * nothing comes from them.
 */
void test_postgres_freeze(const struct test_postgres *postgres, int frozen);

/** Runs one command on it; non-zero when it went well. */
int test_postgres_run(const struct test_postgres *postgres, const char *command);

/** Stops it and removes its directory; NULL is accepted. */
void test_postgres_stop(struct test_postgres **postgres);
