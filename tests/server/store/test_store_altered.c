/* A live daemon on a store in which every column of every row was altered in every way: it may
 * refuse, or fail jobs with a reason, but must not end, hang, or affect anything that was not
 * altered. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/part.h"
#include "server/protocol/identity.h"
#include "server/store/store_rows.h"
#include "tests/server/ground.h"
#include "tests/server/live.h"

static const char altered_body[] = "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]"
                                   "},\"times\":{\"start\":0,\"stop\":5,\"count\":41}}";

/* values that replace a value; %1$s is the column */
static const struct {
    const char *name, *sqlite, *postgres;
} altered_way[] = {
    {"null", "NULL", "NULL"},
    {"negative", "-1", "-1"},
    {"huge", "2000000", "2000000"},
    {"most", "9223372036854775807", "9223372036854775807"},
    {"word", "'word'", "'word'"},
    {"empty", "''", "''"},
    {"long", "CAST(zeroblob(100000) AS TEXT) || hex(zeroblob(50000))", "repeat('x', 100000)"},
    {"bytes", "X'00ff00'", "'\\x00ff00'::bytea"},
    {"middle",
     "CAST(substr(%1$s, 1, length(%1$s) / 2) || X'5a' || substr(%1$s, length(%1$s) / 2 + 2) AS "
     "BLOB)",
     "set_byte(%1$s, length(%1$s) / 2, 255 - get_byte(%1$s, length(%1$s) / 2))"},
};
enum { WAYS = sizeof altered_way / sizeof *altered_way, MOST_CASES = 1200 };

/* the tables; the column that names a row's owner; the states of jobs whose rows are altered: one
 * that waits, one whose first part is done, one whose second part is held by a vanished worker, a
 * successful one, one that was dismissed with its results; "p" is not a job, but a scene. And all
 * states that have such rows. */
static const struct {
    const char *table, *owner, *lives, *all;
} altered_table[] = {{"jobs", "id", "hs", "whgsd"},   {"parts", "job", "gs", "hgsd"},
                     {"results", "job", "s", "hgsd"}, {"clients", "name", "w", "whgsdp"},
                     {"removals", "job", "d", "d"},   {"scenes", "id", "p", "p"},
                     {"keepers", "scene", "p", "p"}};
enum { TABLES = sizeof altered_table / sizeof *altered_table };

static const char altered_scene[] = "{\"scene\":1}";

struct altered_case {
    char id[SRV_ID_BYTES], account[16], life;
    char client[SRV_IDENTITY_KEY]; /* its client, as named in rows */
    const char *table, *way;
    char column[32];
    int bad;  /* it was altered: the database accepted it */
    int over; /* it was seen to have ended */
};

struct altered {
    int postgres, count;
    struct srv_sql *sql;
    struct altered_case *one;
    struct ground_columns columns[TABLES];
};

static int altered_run(struct altered *all, const char *text) {
    return all->sql->driver->run(all->sql, -1, text, NULL, 0, NULL, NULL) == SRV_STORED;
}

/* the results of each part of a job: the same for all jobs */
static struct api_buffer altered_result[2];

/* a copied row gets the seal of a row written for its position */
static void altered_seal(struct altered *all, const struct altered_case *one) {
    unsigned char seal[SRV_SEAL_JOB_BYTES];
    struct srv_job job = {.parts = 2, .chained = 1};
    struct srv_row_wholes created = {.count = 1};
    struct srv_value value[] = {srv_value_text(one->id), srv_value_bytes(seal, sizeof seal),
                                srv_value_whole(0)};
    const struct srv_sql_driver *driver = all->sql->driver;
    if (one->life == 'p') {
        srv_seal_scene(seal, one->id, altered_scene, sizeof altered_scene - 1);
        value[1].bytes = API_SEAL_BYTES;
        CHECK(driver->run(all->sql, -1, "UPDATE scenes SET seal = $2 WHERE id = $1", value, 2, NULL,
                          NULL) == SRV_STORED);
        return;
    }
    CHECK(driver->run(all->sql, -1, "SELECT created FROM jobs WHERE id = $1", value, 1,
                      srv_row_wholes, &created) == SRV_STORED);
    job.created = created.whole[0];
    snprintf(job.id, sizeof job.id, "%s", one->id);
    snprintf(job.client, sizeof job.client, "%s", one->client);
    snprintf(job.operation, sizeof job.operation, "trajectories");
    srv_seal_job(seal, &job, altered_body, sizeof altered_body - 1);
    CHECK(driver->run(all->sql, -1, "UPDATE jobs SET seal = $2 WHERE id = $1", value, 2, NULL,
                      NULL) == SRV_STORED);
    for (long part = 0; part < 2 && one->life != 'w'; part++) {
        srv_seal_chunk(seal, one->id, part, 0, altered_result[part].data,
                       altered_result[part].bytes);
        value[1].bytes = API_SEAL_BYTES;
        value[2].whole = part;
        CHECK(driver->run(all->sql, -1, "UPDATE results SET seal = $2 WHERE job = $1 AND part = $3",
                          value, 3, NULL, NULL) == SRV_STORED);
    }
}

/* copies the rows of a template for another id and client */
static void altered_clone(struct altered *all, int t, const struct altered_case *one) {
    const struct ground_columns *columns = &all->columns[t];
    const char *table = altered_table[t].table;
    char text[4096], list[1024] = "", values[1024] = "";
    for (int i = 0; i < columns->count; i++) {
        const char *name = columns->name[i], *comma = i ? ", " : "";
        int id = !strcmp(name, "id") || !strcmp(name, "job") || !strcmp(name, "scene");
        int client = !strcmp(name, "client") || !strcmp(name, "source") || !strcmp(name, "name");
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", comma, name);
        snprintf(values + strlen(values), sizeof values - strlen(values), "%s%s%s%s", comma,
                 id || client ? "'" : "",
                 id       ? one->id
                 : client ? one->client
                          : name,
                 id || client ? "'" : "");
    }
    snprintf(text, sizeof text, "INSERT INTO %s (%s) SELECT %s FROM %s WHERE %s = '%s%c'", table,
             list, values, table, altered_table[t].owner, !strcmp(table, "clients") ? "client" : "",
             one->life);
    CHECK_SAYING(altered_run(all, text), "%s: %s", text, all->sql->complaint);
}

/* --- the templates --- */

static void altered_part(long number, struct api_buffer *carry, struct api_buffer *out) {
    struct api_request request = {.op = API_OP_TRAJECTORIES,
                                  .content_type = "application/json",
                                  .body = altered_body,
                                  .body_bytes = sizeof altered_body - 1};
    struct api_limits limits;
    struct pend_error error;
    OWN(api_part, free) *part;
    int done = 0;
    api_limits_init(&limits);
    out->bytes = 0;
    if (!CHECK(api_part_new(&part, &request, &limits, number, 2, &error) == PEND_OK)) return;
    if (number) CHECK(api_part_resume(part, carry->data, carry->bytes, &error) == PEND_OK);
    while (!done)
        if (!CHECK(api_part_run(part, out, &done, &error) == PEND_OK)) break;
    carry->bytes = 0;
    CHECK(api_part_carry(part, carry) == PEND_OK);
}

static void altered_digest(unsigned char digest[SRV_DIGEST_BYTES]) {
    struct api_request request = {.op = API_OP_TRAJECTORIES,
                                  .content_type = "application/json",
                                  .body = altered_body,
                                  .body_bytes = sizeof altered_body - 1};
    struct api_limits limits;
    struct api_plan plan;
    OWN(api_buffer, clear) out;
    api_limits_init(&limits);
    api_buffer_init(&out, 1 << 16);
    CHECK_INT(api_plan_read(&plan, &request, &limits, 1, NULL, &out), 0);
    for (int i = 0; i < SRV_DIGEST_BYTES; i++) sscanf(plan.digest + 2 * i, "%2hhx", &digest[i]);
}

static void altered_template(struct srv_store *store, char life) {
    char id[2] = {life, 0}, client[8] = "client";
    unsigned char digest[SRV_DIGEST_BYTES];
    struct srv_lease lease;
    struct srv_job job;
    OWN(api_buffer, clear) carry, out;
    client[6] = life;
    client[7] = 0;
    altered_digest(digest);
    struct srv_job_order order = ground_order(id, client);
    order.operation = "trajectories";
    order.request = altered_body;
    order.request_bytes = sizeof altered_body - 1;
    order.digest = digest;
    order.parts = 2;
    order.chained = 1;
    order.title = order.version = NULL;
    api_buffer_init(&carry, 1 << 20);
    api_buffer_init(&out, 1 << 20);
    if (life == 'p') {
        CHECK_INT(
            srv_store_scene_put(store, id, client, NULL, altered_scene, sizeof altered_scene - 1),
            SRV_STORED);
        return;
    }
    CHECK_INT(srv_store_submit(store, &order, &job), SRV_STORED);
    for (long number = 0; number < (life == 'w' ? 0 : life == 'h' ? 1 : 2); number++) {
        CHECK_INT(ground_claim_whole(store, "ghost", 60 * (int64_t)SECOND, &lease), SRV_STORED);
        CHECK_TEXT(lease.job, id);
        altered_part(number, &carry, &out);
        if (life != 'g' || !number)
            CHECK_INT(srv_store_finish(store, &lease, out.data, out.bytes,
                                       number ? NULL : carry.data, carry.bytes),
                      SRV_STORED);
        CHECK(out.bytes <= SRV_CHUNK_BYTES);
        altered_result[number].bytes = 0;
        CHECK(api_buffer_add(&altered_result[number], out.data, out.bytes) == PEND_OK);
        srv_lease_clear(&lease);
    }
    if (life == 'd') CHECK_INT(srv_store_dismiss(store, id, &job), SRV_STORED);
}

/* --- altering --- */

static void altered_case(struct altered *all, int table, const char *column, int way, char life) {
    char text[2048], value[512];
    struct altered_case *one = &all->one[all->count];
    if (!CHECK(all->count < MOST_CASES)) return;
    *one = (struct altered_case){
        .life = life, .table = altered_table[table].table, .way = altered_way[way].name};
    snprintf(one->id, sizeof one->id, "case%04daaaaaaaaaaaaaaaaaa", all->count);
    snprintf(one->account, sizeof one->account, "c%04d", all->count++);
    struct srv_identity identity;
    CHECK(srv_identity_begin(&identity, "127.0.0.1", one->account));
    memcpy(one->client, identity.key, sizeof one->client);
    snprintf(one->column, sizeof one->column, "%.31s", column);
    for (int t = 0; t < TABLES; t++)
        if (strchr(altered_table[t].all, life)) altered_clone(all, t, one);
    altered_seal(all, one);
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
#pragma GCC diagnostic ignored "-Wformat-extra-args"
    snprintf(value, sizeof value,
             all->postgres ? altered_way[way].postgres : altered_way[way].sqlite, column);
#pragma GCC diagnostic pop
    snprintf(text, sizeof text, "UPDATE %s SET %s = %s WHERE %s = '%s'", one->table, column, value,
             altered_table[table].owner, strcmp(one->table, "clients") ? one->id : one->client);
    one->bad = altered_run(all, text);
}

/* a table that nobody alters was forgotten here; test_store_altered_sums has those that are the
 * same for all, test_store_claims those that claims leave, test_store_classes those of rooms */
static void altered_tables(const struct ground *ground) {
    struct ground_columns tables;
    ground_look(ground, NULL, &tables);
    for (int i = 0; i < tables.count; i++) {
        const char *name = tables.name[i];
        int known = !strcmp(name, "totals") || !strcmp(name, "pendulumd") ||
                    !strcmp(name, "changes") || !strncmp(name, "class", 5);
        for (int t = 0; t < TABLES; t++) known |= !strcmp(name, altered_table[t].table);
        CHECK_SAYING(known, "no test alters the table %s", name);
    }
}

static void altered_all(struct altered *all, const struct ground *ground) {
    // once they are read, rows of PostgreSQL come by the same code as those of SQLite
    int stride = all->postgres ? 3 : TEST_STRIDE;
    /* the lease of a part held by a vanished worker has expired */
    altered_run(all, "UPDATE parts SET lease = 1 WHERE state = 1");
    altered_tables(ground);
    for (int t = 0; t < TABLES; t++) ground_look(ground, altered_table[t].table, &all->columns[t]);
    for (int t = 0; t < TABLES; t++)
        for (int c = 0; c < all->columns[t].count; c++)
            for (int w = c % stride; w < WAYS; w += stride)
                for (const char *life = altered_table[t].lives; *life; life++)
                    altered_case(all, t, all->columns[t].name[c], w, *life);
    for (int t = 0; t < TABLES; t++)
        for (const char *life = altered_table[t].all; *life; life++) {
            char text[128];
            snprintf(text, sizeof text, "DELETE FROM %s WHERE %s = '%s%c'", altered_table[t].table,
                     altered_table[t].owner,
                     strcmp(altered_table[t].table, "clients") ? "" : "client", *life);
            CHECK(altered_run(all, text));
        }
}

/* --- asking --- */

/* one request on a connection that is kept open; the reply's status, and its body up to `cap` */
static int altered_ask(const struct srv_daemon *daemon, struct test_client *client,
                       const char *method, const char *path, const char *key, char body[],
                       size_t cap) {
    char text[512];
    OWN(test_reply, clear) reply = {0};
    snprintf(text, sizeof text, "%s %s HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Key: %s\r\n\r\n", method,
             path, key);
    if (client->fd < 0 && !test_client_open(client, live_port(daemon))) return 0;
    if (!test_client_say(client, text)) return 0;
    int status = test_client_receive(client, &reply, 0, TEST_PATIENCE);
    snprintf(body, cap, "%s", reply.body);
    if (!status || !reply.keep_alive) test_client_close(client);
    return status;
}

/* values that one reading cannot recognize as wrong: when it is the job's turn, whether it is, and
 * whose it is */
static int altered_lies_well(const struct altered_case *one) {
    static const char *const lies[] = {"jobs.ready",   "jobs.turn",    "jobs.id",    "jobs.client",
                                       "jobs.part_us", "jobs.rank",    "jobs.begun", "jobs.parts",
                                       "jobs.waiting", "jobs.chained", "parts.job",  "parts.lease",
                                       "parts.state",  "parts.number"};
    char name[64];
    snprintf(name, sizeof name, "%s.%s", one->table, one->column);
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++)
        if (!strcmp(name, lies[i])) return 1;
    return !strcmp(one->table, "clients");
}

static int altered_over(const char *body) {
    return strstr(body, "\"status\":\"successful\"") || strstr(body, "\"status\":\"failed\"") ||
           strstr(body, "\"status\":\"dismissed\"");
}

static void altered_judge(const struct altered_case *one, int status, const char *body) {
    char what[160];
    snprintf(what, sizeof what, "%s.%s %s of a job '%c': ", one->table, one->column, one->way,
             one->life);
    int known = altered_over(body) || strstr(body, "\"status\":\"accepted\"") ||
                strstr(body, "\"status\":\"running\"");
    CHECK_SAYING((status == 200 && known) || status == 404, "%s%d %.300s", what, status, body);
    const char *end = one->life == 'd' ? "dismissed" : "successful";
    if (!one->bad || !strcmp(one->table, "removals"))
        CHECK_SAYING(strstr(body, end), "%s%d %.300s", what, status, body);
    CHECK_SAYING(!strstr(body, "\"status\":\"failed\"") || !strstr(body, "\"message\":\"\""),
                 "%s%.300s", what, body);
}

/* a scene is returned as it was stored, or not at all, and its owner can delete it, unless the row
 * names another owner */
static void altered_picture(const struct srv_daemon *daemon, struct test_client *client,
                            const struct altered_case *one) {
    char path[128], body[2048];
    snprintf(path, sizeof path, "/v1/scenes/%s", one->id);
    int status = altered_ask(daemon, client, "GET", path, one->account, body, sizeof body);
    int whole = status == 200 && !strcmp(body, altered_scene);
    int mine = !strcmp(one->table, "scenes") && one->bad, id = mine && !strcmp(one->column, "id");
    int sealed = mine && (!strcmp(one->column, "body") || !strncmp(one->column, "seal", 4));
    CHECK_SAYING(id       ? status == 404
                 : sealed ? status == 500 && strstr(body, "damaged")
                          : whole,
                 "%s.%s %s: %d %.200s", one->table, one->column, one->way, status, body);
    status = altered_ask(daemon, client, "DELETE", path, one->account, body, sizeof body);
    int keeper = !strcmp(one->table, "keepers") && one->bad;
    CHECK_SAYING(status == 204 || (id && status == 404) || (keeper && status == 403),
                 "%s.%s %s: DELETE %d %.200s", one->table, one->column, one->way, status, body);
}

static void altered_serve(struct altered *all, const char *url) {
    const char *const options[] = {
        "--store",         url,           "--workers", "1", "--client-header", "X-Key",
        "--trusted-proxy", "127.0.0.0/8", NULL};
    OWN(srv_daemon, free) *daemon = live_start(options);
    OWN(test_client, close) client = {.fd = -1};
    char path[128], body[2048];
    int failed = 0, left = 1, were = 0;
    if (!daemon) return;
    /* as long as jobs end, the others are waited for */
    for (double until = test_clock() + TEST_PATIENCE; left && test_clock() < until;) {
        if (left != were) until = test_clock() + TEST_PATIENCE;
        were = left;
        left = 0;
        for (int i = 0; i < all->count; i++) {
            struct altered_case *one = &all->one[i];
            if (one->over || one->life == 'p') continue;
            snprintf(path, sizeof path, "/v1/jobs/%s", one->id);
            int status = altered_ask(daemon, &client, "GET", path, one->account, body, sizeof body);
            one->over = status == 404 || altered_over(body);
            left += status != 404 && !altered_over(body) && !(one->bad && altered_lies_well(one));
        }
        if (left) test_sleep(0.05);
    }
    for (int i = 0; i < all->count; i++) {
        struct altered_case *one = &all->one[i];
        if (one->life == 'p') {
            altered_picture(daemon, &client, one);
            continue;
        }
        snprintf(path, sizeof path, "/v1/jobs/%s", one->id);
        int status = altered_ask(daemon, &client, "GET", path, one->account, body, sizeof body);
        altered_judge(one, status, body);
        failed += strstr(body, "\"status\":\"failed\"") != NULL;
        CHECK_SAYING(status == 404 || altered_over(body) || altered_lies_well(one),
                     "%s.%s %s '%c': %.300s", one->table, one->column, one->way, one->life, body);
        snprintf(path, sizeof path, "/v1/jobs/%s/results", one->id);
        status = altered_ask(daemon, &client, "GET", path, one->account, body, sizeof body);
        CHECK_SAYING(status == 200 || status == 404 || status == 409 || status == 422 ||
                         status == 500 || status == 503,
                     "%d %s", status, body);
        if (!one->bad) CHECK_INT(status, one->life == 'd' ? 409 : 200);
        if (one->bad && !strcmp(one->table, "results") && !strcmp(one->column, "data"))
            CHECK_SAYING(status != 200 && strstr(body, "damaged"), "%s of results: %d %.200s",
                         one->way, status, body);
        status = altered_ask(daemon, &client, "GET", "/v1/jobs", one->account, body, sizeof body);
        CHECK_INT(status, 200);
    }
    CHECK_SAYING(failed > all->count / 10, "%d of %d failed", failed, all->count);
    CHECK_INT(altered_ask(daemon, &client, "GET", "/readyz", "x", body, sizeof body), 200);
    for (int i = 0; i < all->count; i++) {
        if (all->one[i].life == 'p') continue;
        snprintf(path, sizeof path, "/v1/jobs/%s", all->one[i].id);
        int status =
            altered_ask(daemon, &client, "DELETE", path, all->one[i].account, body, sizeof body);
        CHECK_SAYING(status == 200 || status == 404 || altered_lies_well(&all->one[i]), "%s: %d %s",
                     path, status, body);
    }
    CHECK_INT(altered_ask(daemon, &client, "GET", "/readyz", "x", body, sizeof body), 200);
}

STORE_TEST(no_altered_row_harms_more_than_its_job) {
    struct altered all = {.postgres = ground->postgres != NULL,
                          .one = calloc(MOST_CASES, sizeof *all.one)};
    struct pend_error error;
    REQUIRE(all.one);
    for (int part = 0; part < 2; part++) api_buffer_init(&altered_result[part], 1 << 20);
    for (const char *life = "sdghwp"; *life; life++) altered_template(store, *life);
    const struct srv_sql_driver *driver = all.postgres ? &srv_sql_postgres : &srv_sql_sqlite;
    if (CHECK(driver->open(&all.sql, ground->url, 0, &error) == PEND_OK)) {
        if (!all.postgres) {
            driver->close(all.sql);
            ground_nulls(ground);
            REQUIRE(driver->open(&all.sql, ground->url, 0, &error) == PEND_OK);
            CHECK(altered_run(&all, "PRAGMA synchronous = OFF"));
        } else
            CHECK(altered_run(&all, "SET synchronous_commit = off"));
        altered_all(&all, ground);
        driver->close(all.sql);
        altered_serve(&all, ground->url);
        /* and by their owners: every row can be ended, and deleted by sweeps */
        for (int i = 0; i < all.count; i++) {
            struct srv_job job;
            enum srv_stored stored = SRV_STORED_AGAIN;
            for (int tries = 0; stored == SRV_STORED_AGAIN && tries < 10; tries++)
                stored = srv_store_dismiss(store, all.one[i].id, &job);
            CHECK_SAYING(stored == SRV_STORED || stored == SRV_STORED_NONE, "%s.%s %s '%c': %d %s",
                         all.one[i].table, all.one[i].column, all.one[i].way, all.one[i].life,
                         stored, srv_store_complaint(store));
        }
        struct srv_store_sweep sweep;
        enum srv_stored stored;
        int sweeps = 0;
        do stored = srv_store_sweep(store, NULL, &sweep);
        while (((stored == SRV_STORED && sweep.more) || stored == SRV_STORED_AGAIN) &&
               ++sweeps < 2000);
        CHECK_SAYING(stored == SRV_STORED && sweeps < 2000, "%d after %d: %s", stored, sweeps,
                     srv_store_complaint(store));
    }
    for (int part = 0; part < 2; part++) api_buffer_clear(&altered_result[part]);
    free(all.one);
}
