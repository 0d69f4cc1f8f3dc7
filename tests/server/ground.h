/* A store of a test's own, on each database.
 * Leaves to others: the server of PostgreSQL (harness/postgres).
 * Invariant: a test finds the store empty, and leaves nothing but that server, which ends with
 * the program. */
#ifndef TEST_GROUND_H
#define TEST_GROUND_H

#include "server/store/store.h"
#include "tests/harness/postgres.h"
#include "tests/harness/server.h"
#include "tests/harness/test.h"

/* in the store's microseconds */
#define SECOND 1000000

/* Rules that are in no test's way. */
extern const struct srv_store_rules ground_rules;

/* A database that is empty when a test begins. */
struct ground {
    char url[300], path[64];
    struct srv_store_rules rules;
    struct test_postgres *postgres; /* NULL on SQLite */
};

/** Empties a place; returns 0 if that does not work. */
int ground_begin(struct ground *ground, int postgres);

void ground_clear(struct ground *ground);

/** Opens another connection; NULL, with a failed check, if that does not work. */
struct srv_store *ground_open(const struct ground *ground);

/** Runs a test with one connection; skips it where PostgreSQL is not installed. */
void ground_test(int postgres, void (*test)(struct ground *ground, struct srv_store *store));

/** Defines the same test on each store. */
#define STORE_TEST(name)                                                                           \
    static void name(struct ground *ground, struct srv_store *store);                              \
    TEST(name##_on_sqlite) { ground_test(0, name); }                                               \
    TEST(name##_on_postgresql) { ground_test(1, name); }                                           \
    static void name(struct ground *ground, struct srv_store *store)

/** Submits a job of the operation "ensembles"; all have one request and one digest. */
enum srv_stored ground_submit(struct srv_store *store, const char *id, const char *client,
                              const char *key, long parts, int chained, struct srv_job *job);

/** A page of a client's jobs of any kind, after one or from the first. */
enum srv_stored ground_list(struct srv_store *store, const char *client, const char *before,
                            int most, struct srv_job job[], int *count);

/** Claims one part, with the request that its lease holds. */
enum srv_stored ground_claim_whole(struct srv_store *store, const char *worker, int64_t lease_us,
                                   struct srv_lease *lease);

/** Claims one part and frees the request, which no worker is here to read. */
enum srv_stored ground_claim(struct srv_store *store, const char *worker, int64_t lease_us,
                             struct srv_lease *lease);

void ground_pause_ms(int ms);

/** Runs a statement on a connection of its own, in the store's dialect; a failure is a failed
 * check. */
void ground_run(const struct ground *ground, const char *text);

/** The whole number that a statement answers with, on a connection of its own. */
long long ground_ask(const struct ground *ground, const char *text);

/** Checks that the sums that the store keeps equal a recount of what they count; returns 1 if
 * they do. */
int ground_sums(const struct ground *ground);

#endif
