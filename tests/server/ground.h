/* A separate store for a test, on each database.
 * Leaves to others: the server of PostgreSQL (harness/postgres).
 * Invariant: a test finds the store empty, and leaves only that server, which ends with the
 * program. */
#pragma once

#include "server/store/store.h"
#include "tests/harness/postgres.h"
#include "tests/harness/server.h"
#include "tests/harness/test.h"

/* in the store's microseconds */
#define SECOND 1000000

/* Rules that limit no test. */
extern const struct srv_store_rules ground_rules;

/* A database that is empty when a test begins. */
struct ground {
    char url[300], path[64];
    struct srv_store_rules rules;
    struct test_postgres *postgres; /* NULL on SQLite */
};

/** Empties the store; returns 0 if that fails. */
int ground_begin(struct ground *ground, int postgres);

void ground_clear(struct ground *ground);

/** Opens another connection; NULL, with a failed check, if that fails. */
struct srv_store *ground_open(const struct ground *ground);

/** Runs a test with one connection; skips it if PostgreSQL is not installed. */
void ground_test(int postgres, void (*test)(struct ground *ground, struct srv_store *store));

/** Defines the same test on each store. */
#define STORE_TEST(name)                                                                           \
    static void name(struct ground *ground, struct srv_store *store);                              \
    TEST(name##_on_sqlite) { ground_test(0, name); }                                               \
    TEST(name##_on_postgresql) { ground_test(1, name); }                                           \
    static void name(struct ground *ground, struct srv_store *store)

/** Defines a test on PostgreSQL alone. */
#define POSTGRES_TEST(name)                                                                        \
    static void name##_with(struct ground *ground, struct srv_store *store);                       \
    TEST(name) { ground_test(1, name##_with); }                                                    \
    static void name##_with(struct ground *ground, struct srv_store *store)

/** An order of a job with one part and the operation "ensembles"; all have the same request and
 * digest. */
struct srv_job_order ground_order(const char *id, const char *client);

/** Submits such a job. */
enum srv_stored ground_submit(struct srv_store *store, const char *id, const char *client,
                              const char *key, long parts, int chained, struct srv_job *job);

/** A page of a client's jobs of any kind, after one or from the first. */
enum srv_stored ground_list(struct srv_store *store, const char *client, const char *before,
                            int most, struct srv_job job[], int *count);

/** Claims one part, with the request that its lease holds. */
enum srv_stored ground_claim_whole(struct srv_store *store, const char *worker, int64_t lease_us,
                                   struct srv_lease *lease);

/** Claims one part and frees the request, which no worker reads here. */
enum srv_stored ground_claim(struct srv_store *store, const char *worker, int64_t lease_us,
                             struct srv_lease *lease);

void ground_pause_ms(int ms);

/** Runs a statement on a separate connection, in the store's dialect; a failure is a failed
 * check. */
void ground_run(const struct ground *ground, const char *text);

/** The integer that a statement returns, on a separate connection. */
long long ground_ask(const struct ground *ground, const char *text);

/* Columns of a table. */
struct ground_columns {
    int count;
    char name[40][32];
};

/** Reads the names of a table's columns, or of all tables if it is NULL. */
void ground_look(const struct ground *ground, const char *table, struct ground_columns *columns);

/** Allows NULL in any column of an SQLite file, as a foreign file may. */
void ground_nulls(const struct ground *ground);

/** Checks that the sums in the store equal a recount; returns 1 if they do. */
int ground_sums(const struct ground *ground);
