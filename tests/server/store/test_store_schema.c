/* Tests of server/store/store_schema: a store as the first version wrote it, with jobs in every
 * state, and one as version 5 did. */
#include "server/store/store_schema.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "api/call/digest.h"
#include "tests/server/ground.h"

/* the tables as version 1 made them, and what it kept: of each state a job; one with results
 * that are to be removed; one of four parts, of which one is done, one held and one given back;
 * one that is chained; and scenes */
static const char *const first_version[] = {
    "CREATE TABLE pendulumd (version BIGINT NOT NULL)",
    "INSERT INTO pendulumd (version) VALUES (1)",
    "CREATE TABLE clients (name TEXT PRIMARY KEY, turn BIGINT NOT NULL, jobs BIGINT NOT NULL, "
    "bytes BIGINT NOT NULL)",
    "CREATE TABLE jobs (id TEXT PRIMARY KEY, client TEXT NOT NULL, operation TEXT NOT NULL, "
    "request {bytes} NOT NULL, "
    "key TEXT, digest {bytes} NOT NULL, state BIGINT NOT NULL DEFAULT 0, shards BIGINT NOT NULL, "
    "begun BIGINT NOT NULL DEFAULT 0, done BIGINT NOT NULL DEFAULT 0, waiting BIGINT NOT NULL "
    "DEFAULT 0, "
    "chained BIGINT NOT NULL, carry {bytes}, ready BIGINT NOT NULL DEFAULT 1, turn BIGINT NOT "
    "NULL, "
    "created BIGINT NOT NULL, started BIGINT NOT NULL DEFAULT 0, finished BIGINT NOT NULL DEFAULT "
    "0, "
    "expires BIGINT NOT NULL DEFAULT 0, bytes BIGINT NOT NULL DEFAULT 0, message TEXT NOT NULL "
    "DEFAULT '')",
    "CREATE UNIQUE INDEX jobs_key ON jobs (client, key) WHERE key IS NOT NULL",
    "CREATE INDEX jobs_ready ON jobs (client, turn, created) WHERE ready = 1",
    "CREATE INDEX jobs_client ON jobs (client, created, id)",
    "CREATE INDEX jobs_expires ON jobs (expires) WHERE expires > 0",
    "CREATE INDEX jobs_unclean ON jobs (finished) WHERE state >= 3 AND bytes > 0",
    "CREATE TABLE shards (job TEXT NOT NULL, number BIGINT NOT NULL, state BIGINT NOT NULL, "
    "attempt BIGINT NOT NULL, "
    "kills BIGINT NOT NULL, worker TEXT NOT NULL, lease BIGINT NOT NULL, start {bytes}, bytes "
    "BIGINT NOT NULL, "
    "PRIMARY KEY (job, number))",
    "CREATE INDEX shards_lease ON shards (lease) WHERE state = 1",
    "CREATE INDEX shards_marked ON shards (job) WHERE kills > 0",
    "CREATE INDEX shards_waiting ON shards (job, number) WHERE state = 0",
    "CREATE TABLE results (job TEXT NOT NULL, shard BIGINT NOT NULL, chunk BIGINT NOT NULL, data "
    "{bytes} NOT NULL, "
    "PRIMARY KEY (job, shard, chunk))",
    "CREATE TABLE scenes (id TEXT PRIMARY KEY, client TEXT NOT NULL, body {bytes} NOT NULL, "
    "created BIGINT NOT NULL)",
    "CREATE INDEX scenes_client ON scenes (client)",
    "INSERT INTO clients VALUES ('192.0.2.1', 7, 4, 9), ('192.0.2.2', 3, 0, 4)",
    "INSERT INTO jobs (id, client, operation, request, key, digest, state, shards, begun, done, "
    "waiting, chained, "
    "ready, turn, created, finished, expires, bytes) VALUES "
    "('accepted', '192.0.2.1', 'forces', $1, 'k', $1, 0, 2, 0, 0, 0, 0, 1, 5, 100, 0, 0, 0), "
    "('running', '192.0.2.1', 'forces', $1, NULL, $1, 1, 4, 3, 1, 1, 0, 1, 5, 50, 0, 0, 4), "
    "('chained', '192.0.2.1', 'forces', $1, NULL, $1, 0, 3, 0, 0, 0, 1, 1, 5, 200, 0, 0, 0), "
    "('held', '192.0.2.1', 'forces', $1, NULL, $1, 1, 3, 1, 0, 0, 1, 0, 5, 300, 0, 0, 0), "
    "('successful', '192.0.2.1', 'forces', $1, NULL, $1, 2, 1, 1, 1, 0, 0, 0, 5, 60, 70, "
    "9000000000000000, 5), "
    "('failed', '192.0.2.2', 'forces', $1, NULL, $1, 3, 1, 1, 0, 0, 0, 0, 5, 61, 71, "
    "9000000000000000, 0), "
    "('dismissed', '192.0.2.2', 'forces', $1, NULL, $1, 4, 2, 1, 1, 0, 0, 0, 5, 62, 72, "
    "9000000000000000, 4)",
    "INSERT INTO shards VALUES ('running', 0, 2, 1, 0, '', 0, NULL, 4), ('running', 1, 1, 1, 0, "
    "'w', 9000000000000000, "
    "NULL, 0), ('running', 2, 0, 2, 1, '', 0, NULL, 0), ('held', 0, 1, 1, 0, 'w', "
    "9000000000000000, NULL, 0), "
    "('successful', 0, 2, 1, 0, '', 0, NULL, 5)",
    "INSERT INTO results VALUES ('running', 0, 0, $2), ('successful', 0, 0, $3), ('dismissed', 0, "
    "0, $2)",
    "INSERT INTO scenes VALUES ('s', '192.0.2.1', $1, 1), ('t', '192.0.2.3', $1, 2)",
};

static void write_first_version(const struct ground *ground) {
    const struct srv_sql_driver *driver = ground->postgres ? &srv_sql_postgres : &srv_sql_sqlite;
    const struct srv_value value[] = {{.kind = SRV_SQL_BYTES, .data = "{\"a\":1}", .bytes = 7},
                                      {.kind = SRV_SQL_BYTES, .data = "part", .bytes = 4},
                                      {.kind = SRV_SQL_BYTES, .data = "whole", .bytes = 5}};
    struct pend_error error;
    struct srv_sql *sql;
    REQUIRE(driver->open(&sql, ground->url, 0, &error) == PEND_OK);
    for (size_t i = 0; i < sizeof first_version / sizeof *first_version; i++) {
        int values = strstr(first_version[i], "$3") ? 3 : strstr(first_version[i], "$1") ? 1 : 0;
        CHECK_SAYING(driver->run(sql, -1, first_version[i], value, values, NULL, NULL) ==
                         SRV_STORED,
                     "%s: %s", first_version[i], sql->complaint);
    }
    driver->close(sql);
}

static void finish_what_waits(struct srv_store *store) {
    struct srv_lease lease;
    struct srv_job job;
    enum srv_stored stored;
    int claims = 0;
    while ((stored = ground_claim(store, "w2", 60 * SECOND, &lease)) == SRV_STORED &&
           ++claims < 20) {
        CHECK_INT(
            srv_store_finish(store, &lease, "new", 3, lease.part + 1 < lease.parts ? "c" : NULL, 1),
            SRV_STORED);
        srv_lease_clear(&lease);
    }
    CHECK_INT(stored, SRV_STORED_NONE);
    CHECK_INT(claims, 2 + 2 + 3);
    CHECK_INT(srv_store_job(store, "accepted", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_SUCCESSFUL);
    CHECK_INT(srv_store_job(store, "chained", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_SUCCESSFUL);
    /* the leases of before hold */
    struct srv_lease held = {.job = "running", .part = 1, .parts = 4, .attempt = 1};
    CHECK_INT(srv_store_finish(store, &held, "new", 3, NULL, 0), SRV_STORED);
    CHECK_INT(srv_store_job(store, "running", &job), SRV_STORED);
    CHECK(job.state == SRV_JOB_SUCCESSFUL && job.bytes == 4 + 3 * 3);
}

static void find_what_was_kept(struct srv_store *store) {
    char data[SRV_CHUNK_BYTES];
    struct srv_job job, page[10];
    void *body;
    size_t bytes;
    int count;
    CHECK_INT(ground_list(store, "192.0.2.1", NULL, 10, page, &count), SRV_STORED);
    CHECK_INT(count, 5);
    CHECK_INT(srv_store_chunk(store, "successful", 0, 0, data, &bytes), SRV_STORED);
    CHECK(bytes == 5 && !memcmp(data, "whole", 5));
    CHECK_INT(srv_store_job_request(store, "successful", &body, &bytes), SRV_STORED);
    CHECK_INT((long long)bytes, 7);
    free(body);
    CHECK_INT(srv_store_job(store, "failed", &job), SRV_STORED);
    CHECK(job.state == SRV_JOB_FAILED && job.expires == 9000000000000000);
    CHECK_INT(srv_store_job_request(store, "failed", &body, &bytes), SRV_STORED);
    CHECK_INT((long long)bytes, 0);
    free(body);
    CHECK_INT(srv_store_scene(store, "s", &body, &bytes), SRV_STORED);
    CHECK_INT((long long)bytes, 7);
    free(body);
    /* scenes of then are nobody's, and stay */
    CHECK_INT(srv_store_scene_drop(store, "s", "192.0.2.1"), SRV_STORED_CLASH);
    CHECK_INT(srv_store_scene_keep(store, "s", "anna", NULL), SRV_STORED);
    CHECK_INT(srv_store_scene_drop(store, "s", "anna"), SRV_STORED);
    CHECK_INT(srv_store_scene(store, "s", &body, &bytes), SRV_STORED);
    free(body);
}

static void on_first_version(struct ground ground) {
    struct srv_store_sweep sweep;
    struct srv_job job;
    write_first_version(&ground);
    struct srv_store *store = ground_open(&ground);
    if (!store) return;
    ground_sums(&ground);
    find_what_was_kept(store);
    finish_what_waits(store);
    do CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
    while (sweep.more);
    CHECK_INT(
        ground_ask(&ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM results WHERE job = 'dismissed'"),
        0);
    CHECK_INT(ground_submit(store, "new", "192.0.2.1", "k", 1, 0, &job), SRV_STORED_CLASH);
    ground_sums(&ground);
    /* a second time nothing is left to do */
    srv_store_close(&store);
    if (!(store = ground_open(&ground))) return;
    CHECK_INT(srv_store_job(store, "successful", &job), SRV_STORED);
    ground_sums(&ground);
    srv_store_close(&store);
}

TEST(a_store_of_the_first_version_is_brought_up_to_date_on_sqlite) {
    struct ground ground;
    REQUIRE(ground_begin(&ground, 0));
    on_first_version(ground);
    ground_clear(&ground);
}

TEST(a_store_of_the_first_version_is_brought_up_to_date_on_postgresql) {
    struct ground ground;
    if (access("/usr/lib/postgresql", F_OK)) {
        test_skip("PostgreSQL is not installed");
        return;
    }
    REQUIRE(ground_begin(&ground, 1));
    on_first_version(ground);
    ground_clear(&ground);
}

/* --- version 5: chunks of results have seals that do not know their job, jobs and scenes have
 * none --- */

static const char *const fifth_version[] = {
    "ALTER TABLE results DROP COLUMN sealed",
    "ALTER TABLE jobs DROP COLUMN seal",
    "ALTER TABLE jobs DROP COLUMN sealed",
    "ALTER TABLE jobs DROP COLUMN title",
    "ALTER TABLE jobs DROP COLUMN version",
    "ALTER TABLE jobs DROP COLUMN notify",
    "ALTER TABLE jobs DROP COLUMN notify_attempts",
    "ALTER TABLE jobs DROP COLUMN notify_status",
    "DROP TABLE hooks",
    "DROP TABLE changes",
    "ALTER TABLE shards DROP COLUMN aside",
    "ALTER TABLE scenes DROP COLUMN seal",
    "ALTER TABLE scenes DROP COLUMN sealed",
    "UPDATE pendulumd SET version = 5",
    "DROP TABLE classes",
    "DROP TABLE class_pupils",
    "DROP TABLE class_items",
};

static void seal_of_version_five(const struct ground *ground, const char *data) {
    unsigned char seal[API_SEAL_BYTES];
    char hex[2 * API_SEAL_BYTES + 1], text[160];
    api_seal(seal, "results of part 0", 0, data, strlen(data));
    for (int i = 0; i < API_SEAL_BYTES; i++)
        snprintf(hex + (size_t)2 * (size_t)i, 3, "%02x", seal[i]);
    snprintf(text, sizeof text,
             ground->postgres ? "UPDATE results SET seal = '\\x%s'::bytea"
                              : "UPDATE results SET seal = X'%s'",
             hex);
    ground_run(ground, text);
}

STORE_TEST(a_store_of_version_five_keeps_what_it_can_tell) {
    struct srv_lease lease;
    struct srv_job job;
    char back[SRV_CHUNK_BYTES];
    void *body;
    size_t bytes;
    CHECK_INT(ground_submit(store, "done", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(store, &lease, "data", 4, NULL, 0), SRV_STORED);
    srv_lease_clear(&lease);
    CHECK_INT(ground_submit(store, "waits", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "scene", "anna", NULL, "{}", 2), SRV_STORED);
    struct srv_store_sweep sweep;
    CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
    /* the seals of rows that are written without a title are those of version 7 */
    for (size_t i = 0; i < sizeof fifth_version / sizeof *fifth_version; i++)
        ground_run(ground, fifth_version[i]);
    seal_of_version_five(ground, "data");
    struct srv_store *now = ground_open(ground);
    REQUIRE(now);
    /* what was whole is whole */
    CHECK_INT(srv_store_job(now, "done", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_SUCCESSFUL);
    CHECK_INT(srv_store_chunk(now, "done", 0, 0, back, &bytes), SRV_STORED);
    CHECK(bytes == 4 && !memcmp(back, "data", 4));
    CHECK_INT(srv_store_scene(now, "scene", &body, &bytes), SRV_STORED);
    free(body);
    CHECK_INT(ground_claim_whole(now, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_TEXT(lease.job, "waits");
    CHECK_INT(srv_store_finish(now, &lease, "new", 3, NULL, 0), SRV_STORED);
    srv_lease_clear(&lease);
    /* what its seal told then it tells now; what is written now has one that must not go */
    ground_run(ground, ground->postgres
                           ? "UPDATE results SET data = '\\x64617462'::bytea WHERE job = 'done'"
                           : "UPDATE results SET data = X'64617462' WHERE job = 'done'");
    CHECK_INT(srv_store_chunk(now, "done", 0, 0, back, &bytes), SRV_STORED_DAMAGED);
    CHECK_INT(srv_store_chunk(now, "waits", 0, 0, back, &bytes), SRV_STORED);
    ground_run(ground, "UPDATE results SET seal = NULL");
    CHECK_INT(srv_store_chunk(now, "waits", 0, 0, back, &bytes), SRV_STORED_DAMAGED);
    /* chunks of before version 5 never had one */
    CHECK_INT(srv_store_chunk(now, "done", 0, 0, back, &bytes), SRV_STORED);
    ground_sums(ground);
    srv_store_close(&now);
}
