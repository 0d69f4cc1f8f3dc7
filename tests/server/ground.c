#include "tests/server/ground.h"

#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "server/store/store_rows.h"

const struct srv_store_rules ground_rules = {.client_jobs = 1000,
                                             .client_bytes = 1 << 28,
                                             .all_bytes = 1LL << 30,
                                             .keep_us = 3600000000LL,
                                             .client_scenes = 3,
                                             .client_scene_bytes = 1 << 20,
                                             .all_scene_bytes = 1 << 24};

static struct test_postgres *ground_postgres;

__attribute__((destructor)) static void ground_end(void) { test_postgres_stop(&ground_postgres); }

int ground_begin(struct ground *ground, int postgres) {
    *ground = (struct ground){.rules = ground_rules};
    if (!postgres) {
        snprintf(ground->path, sizeof ground->path, "/tmp/pendulumd-test-XXXXXX");
        if (!mkdtemp(ground->path)) return 0;
        snprintf(ground->url, sizeof ground->url, "sqlite:%s/store.db", ground->path);
        return 1;
    }
    if (!ground_postgres) ground_postgres = test_postgres_start();
    ground->postgres = ground_postgres;
    if (!ground->postgres) return 0;
    snprintf(ground->url, sizeof ground->url, "%s", test_postgres_url(ground->postgres));
    return test_postgres_run(ground->postgres, "DROP SCHEMA public CASCADE; CREATE SCHEMA public");
}

void ground_clear(struct ground *ground) {
    char command[128];
    if (!*ground->path) return;
    snprintf(command, sizeof command, "rm -rf '%s'", ground->path);
    CHECK(!system(command));
}

struct srv_store *ground_open(const struct ground *ground) {
    struct pend_error error;
    struct srv_store *store;
    CHECK_SAYING(srv_store_open(&store, ground->url, &ground->rules, &error) == PEND_OK, "%s: %s",
                 ground->url, error.text);
    return store;
}

void ground_test(int postgres, void (*test)(struct ground *ground, struct srv_store *store)) {
    OWN(ground, clear) ground = {0};
    if (postgres && access("/usr/lib/postgresql", F_OK)) {
        test_skip("PostgreSQL is not installed");
        return;
    }
    REQUIRE(ground_begin(&ground, postgres));
    OWN(srv_store, close) *store = ground_open(&ground);
    if (store) test(&ground, store);
}

enum srv_stored ground_claim_whole(struct srv_store *store, const char *worker, int64_t lease_us,
                                   struct srv_lease *lease) {
    struct srv_claim claim = {
        .worker = worker, .lease_us = lease_us, .most = 1, .aside = SRV_CLAIM_IDLE};
    return srv_store_claim(store, &claim, lease);
}

enum srv_stored ground_claim(struct srv_store *store, const char *worker, int64_t lease_us,
                             struct srv_lease *lease) {
    enum srv_stored stored = ground_claim_whole(store, worker, lease_us, lease);
    if (stored == SRV_STORED) free(lease->request);
    lease->request = NULL;
    return stored;
}

void ground_pause_ms(int ms) {
    nanosleep(&(struct timespec){ms / 1000, ms % 1000 * 1000000L}, NULL);
}

struct srv_job_order ground_order(const char *id, const char *client) {
    static const unsigned char digest[SRV_DIGEST_BYTES] = {1, 2, 3};
    return (struct srv_job_order){.id = id,
                                  .client = client,
                                  .operation = "ensembles",
                                  .request = "{\"a\":1}",
                                  .request_bytes = 7,
                                  .digest = digest,
                                  .parts = 1,
                                  .title = "a title",
                                  .version = "1.2.3+abc"};
}

enum srv_stored ground_submit(struct srv_store *store, const char *id, const char *client,
                              const char *key, long parts, int chained, struct srv_job *job) {
    struct srv_job_order order = ground_order(id, client);
    order.key = key;
    order.parts = parts;
    order.chained = chained;
    return srv_store_submit(store, &order, job);
}

enum srv_stored ground_list(struct srv_store *store, const char *client, const char *before,
                            int most, struct srv_job job[], int *count) {
    struct srv_job_wish wish = {.state = SRV_JOB_STATES, .before = before, .most = most};
    char last[SRV_ID_BYTES];
    return srv_store_list(store, client, &wish, job, count, last);
}

static struct srv_sql *ground_connect(const struct ground *ground) {
    const struct srv_sql_driver *driver = ground->postgres ? &srv_sql_postgres : &srv_sql_sqlite;
    struct pend_error error;
    struct srv_sql *sql = NULL;
    CHECK_SAYING(driver->open(&sql, ground->url, 0, &error) == PEND_OK, "%s", error.text);
    return sql;
}

void ground_run(const struct ground *ground, const char *text) {
    struct srv_sql *sql = ground_connect(ground);
    if (!sql) return;
    CHECK_SAYING(sql->driver->run(sql, -1, text, NULL, 0, NULL, NULL) == SRV_STORED, "%s: %s", text,
                 sql->complaint);
    sql->driver->close(sql);
}

long long ground_ask(const struct ground *ground, const char *text) {
    struct srv_row_wholes row = {.count = 1};
    struct srv_sql *sql = ground_connect(ground);
    if (!sql) return -1;
    CHECK_SAYING(sql->driver->run(sql, -1, text, NULL, 0, srv_row_wholes, &row) == SRV_STORED,
                 "%s: %s", text, sql->complaint);
    sql->driver->close(sql);
    return row.rows ? row.whole[0] : -1;
}

static enum srv_stored ground_name(void *context, const struct srv_value field[]) {
    struct ground_columns *columns = context;
    if (CHECK(columns->count < 40))
        snprintf(columns->name[columns->count++], 32, "%s", (const char *)field[0].data);
    return SRV_STORED;
}

void ground_look(const struct ground *ground, const char *table, struct ground_columns *columns) {
    struct srv_sql *sql = ground_connect(ground);
    char text[256];
    columns->count = 0;
    REQUIRE(sql);
    if (!table)
        snprintf(text, sizeof text,
                 ground->postgres ? "SELECT table_name::text FROM information_schema.tables WHERE "
                                    "table_schema = 'public'"
                                  : "SELECT name FROM sqlite_master WHERE type = 'table'");
    else
        snprintf(text, sizeof text,
                 ground->postgres
                     ? "SELECT column_name::text FROM information_schema.columns WHERE "
                       "table_schema = 'public' AND table_name = '%s'"
                     : "SELECT name FROM pragma_table_info('%s')",
                 table);
    CHECK(sql->driver->run(sql, -1, text, NULL, 0, ground_name, columns) == SRV_STORED);
    CHECK(columns->count > 1);
    sql->driver->close(sql);
}

void ground_nulls(const struct ground *ground) {
    sqlite3 *db;
    if (ground->postgres) return;
    REQUIRE(sqlite3_open(ground->url + strlen("sqlite:"), &db) == SQLITE_OK);
    CHECK_INT(sqlite3_exec(db,
                           "PRAGMA writable_schema = ON; UPDATE sqlite_master SET sql = "
                           "replace(sql, ' NOT NULL', '') WHERE type = 'table'; PRAGMA "
                           "schema_version = 1000",
                           NULL, NULL, NULL),
              SQLITE_OK);
    sqlite3_close(db);
}

#define SUM(what, table) "COALESCE((SELECT CAST(SUM(" what ") AS BIGINT) FROM " table "), 0)"
/* for a client, including the changes that are not in its row yet */
#define LATE(what) what " + " SUM("changes." what, "changes WHERE changes.name = clients.name")
#define TOTAL(what) SUM(what, "totals")

int ground_sums(const struct ground *ground) {
    static const char *const wrong[][2] = {
        {"open jobs", "SELECT CAST(COUNT(*) AS BIGINT) FROM clients WHERE " LATE(
                          "jobs") " <> (SELECT COUNT(*) FROM jobs WHERE client = name AND state < "
                                  "2)"},
        {"ready jobs", "SELECT CAST(COUNT(*) AS BIGINT) FROM clients WHERE " LATE(
                           "ready") " <> (SELECT COUNT(*) FROM jobs WHERE client = name AND ready "
                                    "= 1)"},
        {"bytes", "SELECT CAST(COUNT(*) AS BIGINT) FROM clients WHERE " LATE("bytes") " <> " SUM(
                      "jobs.bytes + held",
                      "jobs WHERE client = name") " + " SUM("removals.bytes",
                                                            "removals WHERE client = name")},
        {"scenes", "SELECT CAST(COUNT(*) AS BIGINT) FROM clients WHERE scenes <> (SELECT COUNT(*) "
                   "FROM keepers WHERE "
                   "client = name) OR scene_bytes <> " SUM("keepers.bytes + 1024",
                                                           "keepers WHERE client = name")},
        {"clients of jobs", "SELECT CAST(COUNT(*) AS BIGINT) FROM jobs WHERE client NOT IN (SELECT "
                            "name FROM clients)"},
        {"clients of nothing",
         "SELECT CAST(COUNT(*) AS BIGINT) FROM clients WHERE jobs = 0 AND bytes = 0 AND scenes = 0 "
         "AND name NOT IN (SELECT name FROM changes)"},
        {"jobs' rows",
         "SELECT CAST(COUNT(*) AS BIGINT) FROM jobs WHERE held <> 1024 + LENGTH(request) + CASE "
         "WHEN "
         "state < 3 THEN 256 * (parts - 1) ELSE 0 END OR (state >= 3 AND LENGTH(request) > 0)"},
        {"jobs' results",
         "SELECT CAST(COUNT(*) AS BIGINT) FROM jobs WHERE bytes <> CASE WHEN state >= 3 THEN 0 "
         "ELSE " SUM("LENGTH(data)", "results WHERE job = id") " END"},
        {"all bytes", "SELECT CAST(" TOTAL("bytes") " - " SUM("bytes + held", "jobs") " - " SUM(
                          "bytes", "removals") " AS BIGINT)"},
        {"all scenes", "SELECT CAST(" TOTAL("scenes") " - (SELECT COUNT(*) FROM scenes) + " TOTAL(
                           "scene_bytes") " - " SUM("LENGTH(body) + 1024", "scenes") " AS BIGINT)"},
        {"parts that wait",
         "SELECT " TOTAL("waiting") " - " SUM("CASE WHEN ready = 0 THEN 0 WHEN chained = 1 THEN 1 "
                                              "ELSE jobs.waiting + parts - begun END",
                                              "jobs")},
        {"accepted jobs",
         "SELECT " TOTAL("accepted") " - (SELECT COUNT(*) FROM jobs WHERE state = 0)"},
        {"running jobs",
         "SELECT " TOTAL("running") " - (SELECT COUNT(*) FROM jobs WHERE state = 1)"},
        {"successful jobs",
         "SELECT " TOTAL("successful") " - (SELECT COUNT(*) FROM jobs WHERE state = 2)"},
        {"failed jobs", "SELECT " TOTAL("failed") " - (SELECT COUNT(*) FROM jobs WHERE state = 3)"},
        {"dismissed jobs",
         "SELECT " TOTAL("dismissed") " - (SELECT COUNT(*) FROM jobs WHERE state = 4)"},
    };
    struct srv_sql *sql = ground_connect(ground);
    int good = sql != NULL;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong && sql; i++) {
        struct srv_row_wholes row = {.count = 1};
        enum srv_stored stored =
            sql->driver->run(sql, -1, wrong[i][1], NULL, 0, srv_row_wholes, &row);
        good &= CHECK_SAYING(stored == SRV_STORED && row.whole[0] == 0,
                             "the sum of %s is wrong by %lld %s", wrong[i][0],
                             (long long)row.whole[0], sql->complaint);
    }
    if (sql) sql->driver->close(sql);
    return good;
}
