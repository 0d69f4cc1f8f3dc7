/* Laws of cost: the cost of a call does not depend on the number of stored or waiting jobs. On
 * SQLite the steps of its virtual machine are counted, on PostgreSQL the plan of every statement is
 * checked, with and without statistics. */
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/store/store_statements.h"
#include "tests/server/ground.h"

enum { FEW = 1000, MANY = 50000, CALLS = 7 };

/* steps of all connections since a measurement began */
static long cost_steps;

static int cost_count(void *context) {
    (void)context;
    cost_steps++;
    return 0;
}

static int cost_watch(sqlite3 *db, const char **error, const struct sqlite3_api_routines *api) {
    (void)error, (void)api;
    sqlite3_progress_handler(db, 1, cost_count, NULL);
    return SQLITE_OK;
}

/* copies of the job "one" that have ended and are kept, and of the job "two" that wait, with the
 * sums that count them
 */
static void cost_fill(const struct ground *ground, int count) {
    static const char *const text[][2] = {
        {"INSERT INTO jobs (id, client, operation, request, digest, state, parts, begun, done, "
         "chained, ready, rank, created, started, finished, expires, bytes, part_us, held, seal, "
         "title, version) SELECT 'k' || n.i, client, operation, request, digest, 2, 1, 1, 1, 0, 0, "
         "rank + n.i, created + n.i, started, finished, expires + n.i, 1, part_us, held, seal, "
         "title, version FROM jobs, ",
         "WHERE id = 'one'"},
        {"INSERT INTO parts (job, number, state, attempt, kills, worker, lease, start, bytes) "
         "SELECT 'k' || n.i, number, state, attempt, kills, worker, lease, start, bytes FROM parts,"
         " ",
         "WHERE job = 'one'"},
        {"INSERT INTO results (job, part, chunk, data, seal) SELECT 'k' || n.i, part, chunk, data, "
         "seal FROM results, ",
         "WHERE job = 'one'"},
        {"INSERT INTO jobs (id, client, operation, request, digest, parts, chained, rank, created, "
         "part_us, held, seal, title, version) SELECT 'w' || n.i, client, operation, request, "
         "digest, 1, 0, rank + n.i, created + n.i, part_us, held, seal, title, version FROM jobs, ",
         "WHERE id = 'two'"},
    };
    char numbers[200], command[1000];
    if (ground->postgres)
        snprintf(numbers, sizeof numbers, "generate_series(1, %d) AS n(i)", count);
    else
        snprintf(numbers, sizeof numbers,
                 "(WITH RECURSIVE m(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM m WHERE i < %d) "
                 "SELECT i FROM m) AS n",
                 count);
    for (size_t i = 0; i < sizeof text / sizeof *text; i++) {
        snprintf(command, sizeof command, "%s%s %s", text[i][0], numbers, text[i][1]);
        ground_run(ground, command);
    }
    snprintf(command, sizeof command,
             "UPDATE clients SET jobs = jobs + %d, ready = ready + %d, bytes = bytes + %lld WHERE "
             "name = 'anna'",
             count, count, count * (2LL * (SRV_ROW_BYTES + 7) + 1));
    ground_run(ground, command);
    snprintf(command, sizeof command,
             "UPDATE totals SET successful = successful + %d, accepted = accepted + %d, waiting = "
             "waiting + %d, bytes = bytes + %lld WHERE place = (SELECT MIN(place) FROM totals)",
             count, count, count, count * (2LL * (SRV_ROW_BYTES + 7) + 1));
    ground_run(ground, command);
}

static void cost_begin(struct ground *ground) {
    ground->rules.client_jobs = 1000000;
    ground->rules.client_bytes = ground->rules.all_bytes = 1LL << 40;
}

/* a job that ended, and one that waits */
static void cost_seed(struct srv_store *store) {
    struct srv_lease lease;
    struct srv_job job;
    CHECK_INT(ground_submit(store, "one", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(store, &lease, "x", 1, NULL, 0), SRV_STORED);
    srv_lease_clear(&lease);
    CHECK_INT(ground_submit(store, "two", "anna", NULL, 1, 0, &job), SRV_STORED);
}

/* the steps of each call on a store with this many stored jobs and as many waiting ones */
static void cost_measure(int count, long steps[CALLS]) {
    OWN(ground, clear) ground;
    struct srv_store_figures figures;
    struct srv_store_sweep sweep;
    struct srv_lease lease;
    struct srv_job job, page[20];
    int listed;
    REQUIRE(ground_begin(&ground, 0));
    cost_begin(&ground);
    OWN(srv_store, close) *store = ground_open(&ground);
    REQUIRE(store);
    cost_seed(store);
    cost_fill(&ground, count);
    ground_sums(&ground);
    CHECK_INT(ground_submit(store, "warm", "anna", NULL, 1, 0, &job), SRV_STORED);
    for (int call = 0; call < CALLS; call++) {
        cost_steps = 0;
        switch (call) {
        case 0:
            CHECK_INT(ground_submit(store, "new", "anna", "key", 1, 0, &job), SRV_STORED);
            break;
        case 1:
            CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
            break;
        case 2:
            CHECK_INT(srv_store_finish(store, &lease, "x", 1, NULL, 0), SRV_STORED);
            srv_lease_clear(&lease);
            break;
        case 3:
            CHECK_INT(ground_list(store, "anna", NULL, 20, page, &listed), SRV_STORED);
            CHECK_INT(listed, 20);
            break;
        case 4:
            CHECK_INT(ground_list(store, "anna", page[19].id, 20, page, &listed), SRV_STORED);
            CHECK_INT(listed, 20);
            break;
        case 5:
            CHECK_INT(srv_store_figures(store, &figures), SRV_STORED);
            break;
        case 6:
            CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
            CHECK(!sweep.more);
            break;
        }
        steps[call] = cost_steps;
    }
}

TEST(what_a_call_costs_does_not_depend_on_what_is_kept) {
    static const char *const name[CALLS] = {"submit",  "claim",   "finish", "list",
                                            "list on", "figures", "sweep"};
    long few[CALLS], many[CALLS];
    sqlite3_auto_extension((void (*)(void))cost_watch);
    cost_measure(FEW, few);
    cost_measure(MANY, many);
    sqlite3_cancel_auto_extension((void (*)(void))cost_watch);
    for (int i = 0; i < CALLS; i++)
        CHECK_SAYING(few[i] > 10 && many[i] < 2 * few[i] && few[i] < 2 * many[i],
                     "%s: %ld steps among %d, %ld among %d", name[i], few[i], FEW, many[i], MANY);
}

/* what a plan must not contain for tables that grow; figures and the version are read whole, since
 * they have few rows */
struct cost_plan {
    const char *statement;
    int scans;
};

static enum srv_stored cost_row(void *context, const struct srv_value field[]) {
    struct cost_plan *plan = context;
    const char *line = field[0].data;
    int scan =
        strstr(line, "Seq Scan") && !strstr(line, "on totals") && !strstr(line, "on pendulumd");
    int sort = strstr(line, "Sort") != NULL || strstr(line, "Bitmap") != NULL;
    plan->scans += scan || sort;
    CHECK_SAYING(!scan && !sort, "%s: %s", plan->statement, line);
    return SRV_STORED;
}

/* statements that only repair damage, and may read all rows */
static int cost_mends(const char *text) {
    return strstr(text, "BETWEEN") || strstr(text, "{nameless") || strstr(text, "{sane") ||
           strstr(text, "{bounded") || strstr(text, "{counted");
}

/* the plan of a prepared statement, for any values */
static enum srv_stored cost_explain(struct srv_sql *sql, const char *statement,
                                    struct cost_plan *plan) {
    char command[SRV_SQL_TEXT + 100], text[SRV_SQL_TEXT], nulls[200] = "";
    int values = 0;
    srv_sql_spell(&srv_sql_postgres, statement, text);
    for (int k = 1; k <= SRV_SQL_PARAMETERS; k++) {
        char mark[16];
        snprintf(mark, sizeof mark, "$%d", k);
        if (strstr(text, mark)) values = k;
    }
    for (int k = 0; k < values; k++) strcat(nulls, k ? ", NULL" : "(NULL");
    if (values) strcat(nulls, ")");
    snprintf(command, sizeof command, "PREPARE cost AS %s", text);
    SRV_STORED_TRY(sql->driver->run(sql, -1, command, NULL, 0, NULL, NULL));
    snprintf(command, sizeof command, "EXPLAIN EXECUTE cost%s", nulls);
    SRV_STORED_TRY(sql->driver->run(sql, -1, command, NULL, 0, cost_row, plan));
    return sql->driver->run(sql, -1, "DEALLOCATE cost", NULL, 0, NULL, NULL);
}

static void cost_plans(const struct ground *ground, int *looked) {
    struct pend_error error;
    struct srv_sql *sql;
    REQUIRE(srv_sql_postgres.open(&sql, ground->url, 0, &error) == PEND_OK);
    for (int i = 0; i < SQL_COUNT; i++) {
        const char *text = srv_statement_text[i];
        struct cost_plan plan = {.statement = text};
        if (!strchr("SIUD", text[0]) || cost_mends(text)) continue;
        CHECK_SAYING(cost_explain(sql, text, &plan) == SRV_STORED, "%s: %s", text, sql->complaint);
        ++*looked;
    }
    sql->driver->close(sql);
}

POSTGRES_TEST(every_statement_finds_its_rows_by_an_index) {
    int looked = 0;
    /* an empty store without statistics, one with rows and no statistics, one with both */
    cost_plans(ground, &looked);
    cost_seed(store);
    cost_fill(ground, FEW);
    cost_plans(ground, &looked);
    ground_run(ground, "ANALYZE");
    cost_plans(ground, &looked);
    CHECK_SAYING(looked > 100, "%d plans", looked);
}
