/* Tests of server/store/store_claims in addition to those of leases: what claims wait for, what
 * they leave for later, and parts that are computed alone. */
#include <stdio.h>
#include <string.h>

#include "server/store/store_call.h"
#include "tests/server/ground.h"

enum { MANY = 5 };

/* another process, in a transaction that has locked rows */
static struct srv_sql *claims_lock(const struct ground *ground, const char *text) {
    struct pend_error error;
    struct srv_sql *sql;
    if (!CHECK(srv_sql_postgres.open(&sql, ground->url, 0, &error) == PEND_OK)) return NULL;
    CHECK_INT(sql->driver->run(sql, -1, "{begin}", NULL, 0, NULL, NULL), SRV_STORED);
    CHECK_INT(sql->driver->run(sql, -1, text, NULL, 0, NULL, NULL), SRV_STORED);
    return sql;
}

/* claims everything available, as a worker that holds nothing; returns the number of parts */
static int claim_all(struct srv_store *store, struct srv_lease lease[]) {
    struct srv_claim claim = {.worker = "w",
                              .lease_us = 60 * (int64_t)SECOND,
                              .most = SRV_CLAIMS,
                              .aside = SRV_CLAIM_IDLE};
    enum srv_stored stored = srv_store_claim(store, &claim, lease);
    CHECK_SAYING(stored <= SRV_STORED_NONE, "%d: %s", stored, srv_store_complaint(store));
    return stored == SRV_STORED ? claim.count : 0;
}

static void claims_submit(struct srv_store *store, int count) {
    struct srv_job job;
    char id[16];
    for (int i = 0; i < count; i++) {
        snprintf(id, sizeof id, "j%d", i);
        CHECK_INT(ground_submit(store, id, i % 2 ? "anna" : "berta", NULL, 1, 0, &job), SRV_STORED);
    }
}

/* the row of a client is locked by a process that sleeps */
STORE_TEST(claims_and_ends_of_parts_wait_for_no_row_of_a_client) {
    struct srv_lease lease[SRV_CLAIMS];
    struct srv_sql *other;
    if (!ground->postgres) return;
    claims_submit(store, MANY);
    REQUIRE((other = claims_lock(ground, "SELECT jobs FROM clients FOR UPDATE")) != NULL);
    CHECK_INT(store->sql->driver->run(store->sql, -1, "SET lock_timeout = 50", NULL, 0, NULL, NULL),
              SRV_STORED);
    int count = claim_all(store, lease);
    CHECK_INT(count, MANY);
    for (int i = 0; i < count; i++) {
        CHECK_INT(srv_store_finish(store, &lease[i], "x", 1, NULL, 0), SRV_STORED);
        srv_lease_clear(&lease[i]);
    }
    CHECK_INT(claim_all(store, lease), 0);
    CHECK_INT(other->driver->run(other, -1, "ROLLBACK", NULL, 0, NULL, NULL), SRV_STORED);
    other->driver->close(other);
    ground_sums(ground);
    /* a sweep writes the pending changes into the clients' rows */
    struct srv_store_sweep sweep;
    CHECK(ground_ask(ground, "SELECT COUNT(*) FROM changes") > 0);
    CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
    CHECK_INT(ground_ask(ground, "SELECT COUNT(*) FROM changes"), 0);
    CHECK_INT(ground_ask(ground, "SELECT COUNT(*) FROM clients WHERE jobs <> 0 OR ready <> 0"), 0);
    ground_sums(ground);
}

/* jobs that another process has locked are no sign of damage: nothing is recounted */
STORE_TEST(a_race_for_jobs_is_not_taken_for_a_damaged_sum) {
    struct srv_lease lease;
    struct srv_sql *other;
    if (!ground->postgres) return;
    claims_submit(store, 1);
    REQUIRE((other = claims_lock(ground, "SELECT id FROM jobs FOR UPDATE")) != NULL);
    /* a recount would set it to 1 */
    ground_run(ground, "UPDATE clients SET jobs = 7");
    CHECK_INT(ground_claim(store, "w", SECOND, &lease), SRV_STORED_LOST);
    CHECK_INT(ground_ask(ground, "SELECT jobs FROM clients"), 7);
    CHECK_INT(other->driver->run(other, -1, "ROLLBACK", NULL, 0, NULL, NULL), SRV_STORED);
    other->driver->close(other);
    CHECK_INT(ground_claim(store, "w", SECOND, &lease), SRV_STORED);
}

/* impossible changes are not counted, and affect no claim */
STORE_TEST(altered_changes_of_clients_harm_no_claim) {
    struct srv_lease lease[SRV_CLAIMS];
    struct srv_store_sweep sweep;
    if (!ground->postgres) return;
    claims_submit(store, 2);
    ground_run(ground,
               "INSERT INTO changes SELECT name, 9223372036854775807, -9223372036854775808, "
               "9223372036854775807, -9223372036854775807 FROM clients, (VALUES (1), (2)) AS v");
    ground_run(ground, "INSERT INTO changes VALUES ('nobody', 1, 1, 1, 1)");
    CHECK_INT(claim_all(store, lease), 2);
    for (int i = 0; i < 2; i++) {
        CHECK_INT(srv_store_finish(store, &lease[i], "x", 1, NULL, 0), SRV_STORED);
        srv_lease_clear(&lease[i]);
    }
    CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
    CHECK_INT(ground_ask(ground, "SELECT COUNT(*) FROM changes"), 0);
    ground_sums(ground);
}

/* a worker that held several parts vanishes again and again: that counts against none of them */
STORE_TEST(parts_of_a_worker_that_ended_are_computed_alone_and_after_others) {
    struct srv_lease lease[SRV_CLAIMS];
    struct srv_store_sweep sweep;
    struct srv_job job;
    claims_submit(store, MANY);
    for (int i = 0; i <= 2 * SRV_MOST_KILLS; i++) {
        /* the vanished process held others each time */
        ground_run(ground, "UPDATE parts SET aside = 0");
        int count = claim_all(store, lease);
        CHECK_INT(count, MANY);
        for (int k = 0; k < count; k++) srv_lease_clear(&lease[k]);
        ground_run(ground, "UPDATE parts SET lease = 1 WHERE state = 1");
        CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
        CHECK_INT(sweep.released, MANY);
        CHECK_INT(sweep.given_up, 0);
    }
    /* a worker that holds a part gets none of them, one that holds nothing gets one, and new parts
     * come first */
    struct srv_claim claim = {.worker = "w", .lease_us = SECOND, .most = SRV_CLAIMS};
    CHECK_INT(srv_store_claim(store, &claim, lease), SRV_STORED_LOST);
    CHECK_INT(claim.skipped, 1);
    CHECK_INT(ground_submit(store, "new", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(claim_all(store, lease), 1);
    CHECK_TEXT(lease[0].job, "new");
    CHECK_INT(lease[0].alone, 0);
    srv_lease_clear(&lease[0]);
    for (int i = 0; i < MANY; i++) {
        CHECK_INT(claim_all(store, lease), 1);
        CHECK_INT(lease[0].alone, 1);
        CHECK_INT(srv_store_finish(store, &lease[0], "x", 1, NULL, 0), SRV_STORED);
        srv_lease_clear(&lease[0]);
    }
    ground_sums(ground);
}
