#include "server/store.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SCHEMA = 1, TRIES = 5, SHARD_HELD = 1, SHARD_DONE = 2, CLEAN_CHUNKS = 64, SWEEP_LEASES = 64, LAST_SHARDS = 8 };

struct srv_store {
    struct srv_sql *sql;
    struct srv_store_rules rules;
    int together; /* a batch's transaction is open: calls are savepoints in it */
    int settled;  /* the tables are there, as this version wants them */
};

#define JOB_COLUMNS                                                                                                    \
    "id, client, operation, state, shards, done, created, started, finished, expires, {now}, bytes, message"
/* whether a shard of a job can be claimed, once `waiting`, `begun` and `done` have these values */
#define READY(waiting, begun, done)                                                                                    \
    "CASE WHEN " waiting " > 0 OR (" begun " < shards AND (chained = 0 OR " begun " = " done ")) THEN 1 ELSE 0 END"

/* Each statement, in the dialect that both databases share. */
#define STATEMENTS(X)                                                                                                  \
    X(BEGIN, "{begin}")                                                                                                \
    X(COMMIT, "COMMIT")                                                                                                \
    X(ROLLBACK, "ROLLBACK")                                                                                            \
    X(SAVE, "SAVEPOINT one")                                                                                           \
    X(UNSAVE, "RELEASE one")                                                                                           \
    X(BACK, "ROLLBACK TO one")                                                                                         \
    X(RING, "{ring}")                                                                                                  \
    X(CLIENT_ENTER,                                                                                                    \
      "INSERT INTO clients (name, turn, jobs, bytes) VALUES ($1, COALESCE((SELECT MIN(turn) FROM clients "             \
      "WHERE jobs > 0), 0), 1, 0) ON CONFLICT (name) DO UPDATE SET jobs = clients.jobs + 1, turn = CASE "              \
      "WHEN clients.jobs = 0 AND clients.turn < EXCLUDED.turn THEN EXCLUDED.turn ELSE clients.turn END "               \
      "RETURNING jobs, bytes")                                                                                         \
    X(CLIENT_CHANGE, "UPDATE clients SET jobs = jobs + $2, bytes = bytes + $3, turn = turn + $4 WHERE name = $1 "      \
                     "RETURNING bytes")                                                                                \
    X(CLIENTS, "SELECT name FROM clients WHERE jobs > 0 AND EXISTS (SELECT 1 FROM jobs WHERE client = name AND "       \
               "ready = 1) ORDER BY turn, name LIMIT 8")                                                               \
    X(CLIENTS_LEAVE, "DELETE FROM clients WHERE jobs = 0 AND bytes = 0 AND NOT EXISTS (SELECT 1 FROM jobs WHERE "      \
                     "client = name)")                                                                                 \
    X(ALL_BYTES, "SELECT CAST(COALESCE(SUM(bytes), 0) AS BIGINT) FROM clients")                                        \
    X(JOB_PUT, "INSERT INTO jobs (id, client, operation, request, key, digest, shards, chained, turn, created) "       \
               "VALUES ($1, $2, $3, $4, $5, $6, $7, $8, COALESCE((SELECT MIN(turn) FROM jobs WHERE client = $2 AND "   \
               "ready = 1), 0), {now}) RETURNING " JOB_COLUMNS)                                                        \
    X(JOB, "SELECT " JOB_COLUMNS " FROM jobs WHERE id = $1")                                                           \
    X(JOB_LOCK, "SELECT " JOB_COLUMNS " FROM jobs WHERE id = $1 {lock}")                                               \
    X(JOB_OF_KEY, "SELECT " JOB_COLUMNS ", digest FROM jobs WHERE client = $1 AND key = $2")                           \
    X(JOB_REQUEST, "SELECT request FROM jobs WHERE id = $1")                                                           \
    X(JOB_READY, "SELECT id, operation, shards, begun, waiting, chained FROM jobs WHERE client = $1 AND ready = 1 "    \
                 "ORDER BY turn, created LIMIT 1 {skip}")                                                              \
    X(JOB_CLAIM, "UPDATE jobs SET turn = turn + 1, state = 1, started = CASE WHEN started = 0 THEN {now} ELSE "        \
                 "started END, waiting = waiting - $2, begun = begun + $3, ready = " READY(                            \
                     "waiting - $2", "begun + $3", "done") " WHERE id = $1")                                           \
    X(JOB_WAIT, "UPDATE jobs SET waiting = waiting + 1, ready = 1 WHERE id = $1")                                      \
    X(JOB_STEP, "UPDATE jobs SET done = done + 1, bytes = bytes + $2, carry = $3, ready = " READY(                     \
                    "waiting", "begun", "done + 1") " WHERE id = $1")                                                  \
    X(JOB_END, "UPDATE jobs SET state = $2, message = $3, ready = 0, waiting = 0, carry = NULL, finished = CASE WHEN " \
               "finished = 0 THEN {now} ELSE finished END, expires = {now} + $4 WHERE id = $1 RETURNING " JOB_COLUMNS) \
    X(JOB_EMPTY, "UPDATE jobs SET bytes = 0 WHERE id = $1")                                                            \
    X(JOB_REMOVE, "DELETE FROM jobs WHERE id = $1")                                                                    \
    X(JOB_UNCLEAN, "SELECT id FROM jobs WHERE state >= 3 AND bytes > 0 ORDER BY finished LIMIT 1 {skip}")              \
    X(JOB_EXPIRED, "SELECT id FROM jobs WHERE expires > 0 AND expires < {now} ORDER BY expires LIMIT 1 {skip}")        \
    X(JOBS, "SELECT " JOB_COLUMNS " FROM jobs WHERE client = $1 ORDER BY created DESC, id DESC LIMIT $2")              \
    X(JOBS_BEFORE, "SELECT " JOB_COLUMNS " FROM jobs WHERE client = $1 AND (created, id) < (SELECT created, id FROM "  \
                   "jobs WHERE id = $3 AND client = $1) ORDER BY created DESC, id DESC LIMIT $2")                      \
    X(SHARD_NEXT, "INSERT INTO shards (job, number, state, attempt, kills, worker, lease, start, bytes) SELECT id, "   \
                  "begun, 1, 1, 0, $2, {now} + $3, carry, 0 FROM jobs WHERE id = $1 RETURNING number, attempt, start") \
    X(SHARD_AGAIN, "UPDATE shards SET state = 1, attempt = attempt + 1, worker = $2, lease = {now} + $3 WHERE job = "  \
                   "$1 AND number = (SELECT MIN(number) FROM shards WHERE job = $1 AND state = 0) RETURNING number, "  \
                   "attempt, start")                                                                                   \
    X(SHARD, "SELECT state, attempt FROM shards WHERE job = $1 AND number = $2 {lock}")                                \
    X(SHARD_EXTEND, "UPDATE shards SET lease = {now} + $4 WHERE job = $1 AND number = $2 AND attempt = $3 AND state "  \
                    "= 1 RETURNING number")                                                                            \
    X(SHARD_END, "UPDATE shards SET state = 2, bytes = $3, start = NULL, worker = '' WHERE job = $1 AND number = $2")  \
    X(SHARDS_CLEARED, "UPDATE shards SET kills = 0 WHERE job = $1 AND kills > 0")                                      \
    X(SHARD_BACK, "UPDATE shards SET state = 0, kills = kills + $3, worker = '' WHERE job = $1 AND number = $2 AND "   \
                  "state = 1 AND ($3 = 0 OR lease < {now}) RETURNING kills")                                           \
    X(SHARDS_LATE, "SELECT job, number FROM shards WHERE state = 1 AND lease < $1 ORDER BY lease LIMIT 64")            \
    X(NOW, "SELECT {now}")                                                                                             \
    X(SHARDS_OF, "SELECT job, number FROM shards WHERE state = 1 AND worker = $1 LIMIT 64")                            \
    X(SHARDS_REMOVE, "DELETE FROM shards WHERE job = $1")                                                              \
    X(RESULT_PUT, "INSERT INTO results (job, shard, chunk, data) VALUES ($1, $2, $3, $4)")                             \
    X(RESULT, "SELECT data FROM results WHERE job = $1 AND shard = $2 AND chunk = $3")                                 \
    X(RESULTS_REMOVE, "DELETE FROM results WHERE job = $1 AND (shard, chunk) IN (SELECT shard, chunk FROM results "    \
                      "WHERE job = $1 ORDER BY shard, chunk LIMIT 64) RETURNING chunk")                                \
    X(FIGURES, "SELECT state, CAST(COUNT(*) AS BIGINT), CAST(SUM(bytes) AS BIGINT), CAST(SUM(CASE WHEN ready = 0 "     \
               "THEN 0 WHEN chained = 1 THEN 1 ELSE waiting + shards - begun END) AS BIGINT) FROM jobs GROUP BY "      \
               "state")                                                                                                \
    X(SCENES_OF, "SELECT CAST(COUNT(*) AS BIGINT) FROM scenes WHERE client = $1")                                      \
    X(SCENE_PUT, "INSERT INTO scenes (id, client, body, created) VALUES ($1, $2, $3, {now}) ON CONFLICT DO NOTHING "   \
                 "RETURNING created")                                                                                  \
    X(SCENE, "SELECT body FROM scenes WHERE id = $1")

enum statement {
#define X(name, text) SQL_##name,
    STATEMENTS(X)
#undef X
        SQL_COUNT
};
static_assert((int)SQL_COUNT <= (int)SRV_SQL_STATEMENTS, "a connection keeps every statement");

static const char *const statement_text[] = {
#define X(name, text) text,
    STATEMENTS(X)
#undef X
};

/* The tables, version by version; a statement each, NULL between versions. */
static const char *const schema[] = {
    "CREATE TABLE clients (name TEXT PRIMARY KEY, turn BIGINT NOT NULL, jobs BIGINT NOT NULL, bytes BIGINT NOT NULL)",
    "CREATE TABLE jobs (id TEXT PRIMARY KEY, client TEXT NOT NULL, operation TEXT NOT NULL, request {bytes} NOT NULL, "
    "key TEXT, digest {bytes} NOT NULL, state BIGINT NOT NULL DEFAULT 0, shards BIGINT NOT NULL, "
    "begun BIGINT NOT NULL DEFAULT 0, done BIGINT NOT NULL DEFAULT 0, waiting BIGINT NOT NULL DEFAULT 0, "
    "chained BIGINT NOT NULL, carry {bytes}, ready BIGINT NOT NULL DEFAULT 1, turn BIGINT NOT NULL, "
    "created BIGINT NOT NULL, started BIGINT NOT NULL DEFAULT 0, finished BIGINT NOT NULL DEFAULT 0, "
    "expires BIGINT NOT NULL DEFAULT 0, bytes BIGINT NOT NULL DEFAULT 0, message TEXT NOT NULL DEFAULT '')",
    "CREATE UNIQUE INDEX jobs_key ON jobs (client, key) WHERE key IS NOT NULL",
    "CREATE INDEX jobs_ready ON jobs (client, turn, created) WHERE ready = 1",
    "CREATE INDEX jobs_client ON jobs (client, created, id)",
    "CREATE INDEX jobs_expires ON jobs (expires) WHERE expires > 0",
    "CREATE INDEX jobs_unclean ON jobs (finished) WHERE state >= 3 AND bytes > 0",
    "CREATE TABLE shards (job TEXT NOT NULL, number BIGINT NOT NULL, state BIGINT NOT NULL, attempt BIGINT NOT NULL, "
    "kills BIGINT NOT NULL, worker TEXT NOT NULL, lease BIGINT NOT NULL, start {bytes}, bytes BIGINT NOT NULL, "
    "PRIMARY KEY (job, number))",
    "CREATE INDEX shards_lease ON shards (lease) WHERE state = 1",
    "CREATE INDEX shards_marked ON shards (job) WHERE kills > 0",
    "CREATE INDEX shards_waiting ON shards (job, number) WHERE state = 0",
    "CREATE TABLE results (job TEXT NOT NULL, shard BIGINT NOT NULL, chunk BIGINT NOT NULL, data {bytes} NOT NULL, "
    "PRIMARY KEY (job, shard, chunk))",
    "CREATE TABLE scenes (id TEXT PRIMARY KEY, client TEXT NOT NULL, body {bytes} NOT NULL, created BIGINT NOT NULL)",
    "CREATE INDEX scenes_client ON scenes (client)",
    NULL};

/* ---- values and rows */

static struct srv_value whole_value(int64_t whole) { return (struct srv_value){SRV_SQL_WHOLE, whole, NULL, 0}; }

static struct srv_value text_value(const char *text) {
    return (struct srv_value){text ? SRV_SQL_STRING : SRV_SQL_NULL, 0, text, text ? strlen(text) : 0};
}

static struct srv_value bytes_value(const void *data, size_t bytes) {
    return (struct srv_value){data ? SRV_SQL_BYTES : SRV_SQL_NULL, 0, data, bytes};
}

/* the most that one statement's rows are asked for by those who only want some whole numbers of the first */
struct row_wholes {
    int rows, count;
    int64_t whole[4];
};

static enum srv_stored row_wholes(void *context, const struct srv_value field[]) {
    struct row_wholes *row = context;
    for (int i = 0; i < row->count && !row->rows; i++) row->whole[i] = field[i].whole;
    row->rows++;
    return SRV_STORED;
}

struct row_bytes {
    void *data;
    size_t bytes;
};

static enum srv_stored row_bytes(void *context, const struct srv_value field[]) {
    struct row_bytes *row = context;
    row->data = malloc(field[0].bytes + 1);
    if (!row->data) return SRV_STORED_BROKEN;
    if (field[0].bytes) memcpy(row->data, field[0].data, field[0].bytes);
    row->bytes = field[0].bytes;
    return SRV_STORED;
}

static void row_text(const struct srv_value *field, char text[], size_t cap) {
    snprintf(text, cap, "%s", field->data ? (const char *)field->data : "");
}

struct row_jobs {
    int count, cap;
    struct srv_job *job;
    unsigned char digest[SRV_DIGEST_BYTES]; /* of the last, where the statement asks for it */
    int with_digest;
};

static enum srv_stored row_job(void *context, const struct srv_value field[]) {
    struct row_jobs *rows = context;
    if (rows->count == rows->cap) return SRV_STORED;
    struct srv_job *job = &rows->job[rows->count++];
    row_text(&field[0], job->id, sizeof job->id);
    row_text(&field[1], job->client, sizeof job->client);
    row_text(&field[2], job->operation, sizeof job->operation);
    job->state = (enum srv_job_state)field[3].whole;
    job->shards = (long)field[4].whole;
    job->done = (long)field[5].whole;
    job->created = field[6].whole;
    job->started = field[7].whole;
    job->finished = field[8].whole;
    job->expires = field[9].whole;
    job->now = field[10].whole;
    job->bytes = field[11].whole;
    row_text(&field[12], job->message, sizeof job->message);
    if (rows->with_digest && field[13].bytes == SRV_DIGEST_BYTES)
        memcpy(rows->digest, field[13].data, SRV_DIGEST_BYTES);
    return SRV_STORED;
}

/* ---- statements and transactions */

#define STORE_TRY(call)                                                                                                \
    do {                                                                                                               \
        enum srv_stored stored_try_ = (call);                                                                          \
        if (stored_try_ != SRV_STORED) return stored_try_;                                                             \
    } while (0)

static enum srv_stored store_run(struct srv_store *store, enum statement id, const struct srv_value value[], int count,
                                 srv_row_fn *row, void *context) {
    return store->sql->driver->run(store->sql, (int)id, statement_text[id], value, count, row, context);
}

#define RUN(store, id, row, context, ...)                                                                              \
    store_run((store), (id), (const struct srv_value[]){__VA_ARGS__},                                                  \
              (int)(sizeof(const struct srv_value[]){__VA_ARGS__} / sizeof(struct srv_value)), (row), (context))

static enum srv_stored store_plain(struct srv_store *store, enum statement id) {
    return store_run(store, id, NULL, 0, NULL, NULL);
}

static enum srv_stored store_settle(struct srv_store *store);

/* a call begins: a transaction of its own, or a savepoint in the batch's */
static enum srv_stored store_begin(struct srv_store *store) {
    if (!store->settled) STORE_TRY(store_settle(store));
    return store_plain(store, store->together ? SQL_SAVE : SQL_BEGIN);
}

/* a call ends: what it wrote stays or goes */
static enum srv_stored store_end(struct srv_store *store, int keep, enum srv_stored stored) {
    enum srv_stored ended;
    if (!keep && store->together) {
        ended = store_plain(store, SQL_BACK);
        if (ended == SRV_STORED) ended = store_plain(store, SQL_UNSAVE);
    } else if (!keep) {
        store_plain(store, SQL_ROLLBACK);
        ended = SRV_STORED;
    } else {
        ended = store_plain(store, store->together ? SQL_UNSAVE : SQL_COMMIT);
        if (ended != SRV_STORED && !store->together) store_plain(store, SQL_ROLLBACK);
    }
    return ended == SRV_STORED ? stored : ended;
}

/* failures after which a batch's transaction is not to be trusted */
static int store_hard(enum srv_stored stored) { return stored >= SRV_STORED_FULL; }

static void store_single(struct srv_store *store, struct srv_store_call *call) {
    for (int i = 0; i < TRIES; i++)
        if ((call->stored = call->run(store, call)) != SRV_STORED_AGAIN) break;
}

void srv_store_together(struct srv_store *store, struct srv_store_call *const calls[], int count) {
    enum srv_stored stored = count > 1 && store->settled ? store_plain(store, SQL_BEGIN) : SRV_STORED_AGAIN;
    if (stored == SRV_STORED) {
        store->together = 1;
        for (int i = 0; i < count && !store_hard(stored); i++)
            stored = calls[i]->stored = calls[i]->run(store, calls[i]);
        store->together = 0;
        stored = store_hard(stored) ? stored : store_plain(store, SQL_COMMIT);
        if (stored == SRV_STORED) return;
        store_plain(store, SQL_ROLLBACK);
    }
    for (int i = 0; i < count; i++) store_single(store, calls[i]);
}

/* ---- opening */

static enum srv_stored store_version(struct srv_sql *sql, int64_t *version) {
    struct row_wholes row = {.count = 1};
    STORE_TRY(sql->driver->run(sql, -1, "CREATE TABLE IF NOT EXISTS pendulumd (version BIGINT NOT NULL)", NULL, 0, NULL,
                               NULL));
    STORE_TRY(sql->driver->run(sql, -1, "SELECT version FROM pendulumd", NULL, 0, row_wholes, &row));
    *version = row.rows ? row.whole[0] : 0;
    if (row.rows) return SRV_STORED;
    return sql->driver->run(sql, -1, "INSERT INTO pendulumd (version) VALUES (0)", NULL, 0, NULL, NULL);
}

/* brings the tables to this version's, in one transaction */
static enum srv_stored store_migrate(struct srv_sql *sql, int64_t *version) {
    enum srv_stored stored = sql->driver->run(sql, -1, "{begin}", NULL, 0, NULL, NULL);
    if (stored == SRV_STORED) stored = sql->driver->run(sql, -1, "{alone}", NULL, 0, NULL, NULL);
    if (stored == SRV_STORED) stored = store_version(sql, version);
    int at = 0;
    for (int64_t v = 0; v < SCHEMA && stored == SRV_STORED; v++, at++)
        for (; schema[at] && stored == SRV_STORED; at++)
            if (v >= *version) stored = sql->driver->run(sql, -1, schema[at], NULL, 0, NULL, NULL);
    if (stored == SRV_STORED && *version < SCHEMA) {
        struct srv_value value[] = {whole_value(SCHEMA)};
        stored = sql->driver->run(sql, -1, "UPDATE pendulumd SET version = $1", value, 1, NULL, NULL);
    }
    enum srv_stored ended =
        sql->driver->run(sql, -1, stored == SRV_STORED ? "COMMIT" : "ROLLBACK", NULL, 0, NULL, NULL);
    return stored == SRV_STORED ? ended : stored;
}

/* makes or migrates the tables, once the database can be reached */
static enum srv_stored store_settle(struct srv_store *store) {
    int64_t version = 0;
    STORE_TRY(store_migrate(store->sql, &version));
    if (version > SCHEMA) {
        char text[SRV_SQL_COMPLAINT];
        snprintf(text, sizeof text, "the store is of version %lld, this program knows up to %d", (long long)version,
                 SCHEMA);
        srv_sql_complain(store->sql, text);
        return SRV_STORED_BROKEN;
    }
    store->settled = 1;
    return SRV_STORED;
}

int srv_store_settled(const struct srv_store *store) { return store->settled; }

enum pend_status srv_store_open(struct srv_store **store, const char *url, const struct srv_store_rules *rules,
                                struct pend_error *error) {
    static const struct srv_sql_driver *const drivers[] = {&srv_sql_sqlite, &srv_sql_postgres};
    const struct srv_sql_driver *driver = NULL;
    struct srv_store *made = NULL;
    enum pend_status status = PEND_OK;
    *store = NULL;
    for (size_t i = 0; i < sizeof drivers / sizeof *drivers; i++)
        if (!strncmp(url, drivers[i]->scheme, strlen(drivers[i]->scheme))) driver = drivers[i];
    if (!driver)
        return pend_fail(error, PEND_INVALID, -1, 0, "wants sqlite:PATH or postgresql://..., got \"%.80s\"", url);
    if (!(made = calloc(1, sizeof *made))) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    made->rules = *rules;
    status = driver->open(&made->sql, url, error);
    if (status == PEND_OK) {
        enum srv_stored stored = store_settle(made);
        int waits = stored == SRV_STORED_AWAY && driver->distant;
        if (stored != SRV_STORED && !waits)
            status = pend_fail(error, PEND_INVALID, -1, 0, "its tables cannot be used: %.180s", made->sql->complaint);
    }
    if (status == PEND_OK)
        *store = made;
    else
        srv_store_close(&made);
    return status;
}

void srv_store_close(struct srv_store **store) {
    struct srv_store *gone = *store;
    *store = NULL;
    if (!gone) return;
    if (gone->sql) gone->sql->driver->close(gone->sql);
    free(gone);
}

const char *srv_store_complaint(const struct srv_store *store) { return store->sql->complaint; }

int srv_store_batch(const struct srv_store *store) { return store->sql->driver->batch; }

int srv_store_listen(struct srv_store *store, int timeout_ms) {
    return store->sql->driver->listen(store->sql, timeout_ms);
}

/* ---- jobs */

static enum srv_stored store_find(struct srv_store *store, enum statement id, const char *name, struct srv_job *job) {
    struct row_jobs rows = {.cap = 1, .job = job};
    STORE_TRY(RUN(store, id, row_job, &rows, text_value(name)));
    return rows.count ? SRV_STORED : SRV_STORED_NONE;
}

static int job_open(const struct srv_job *job) { return job->state <= SRV_JOB_RUNNING; }

/* a client's figures after a change */
static enum srv_stored store_client(struct srv_store *store, const char *client, long jobs, long long bytes, int turn,
                                    int64_t *total) {
    struct row_wholes row = {.count = 1};
    STORE_TRY(RUN(store, SQL_CLIENT_CHANGE, row_wholes, &row, text_value(client), whole_value(jobs), whole_value(bytes),
                  whole_value(turn)));
    if (total) *total = row.whole[0];
    return SRV_STORED;
}

/* whether so many new bytes, and all bytes of a client's, leave room on the disk and under the quotas; `message` says
 * which of these does not */
static enum srv_stored store_room(struct srv_store *store, size_t bytes, int64_t client_bytes,
                                  char message[SRV_MESSAGE_BYTES]) {
    const struct srv_store_rules *rules = &store->rules;
    struct row_wholes all = {.count = 1};
    if (store->sql->driver->room && !store->sql->driver->room(store->sql, bytes)) return SRV_STORED_FULL;
    STORE_TRY(store_run(store, SQL_ALL_BYTES, NULL, 0, row_wholes, &all));
    if (client_bytes > rules->client_bytes)
        snprintf(message, SRV_MESSAGE_BYTES,
                 "the client's kept results would pass max-client-bytes, %lld bytes; "
                 "DELETE jobs that are not needed any more",
                 rules->client_bytes);
    else if (all.whole[0] > rules->all_bytes)
        snprintf(message, SRV_MESSAGE_BYTES, "all kept results would pass max-store-bytes, %lld bytes",
                 rules->all_bytes);
    else
        return SRV_STORED;
    return SRV_STORED_QUOTA;
}

static enum srv_stored submit_known(struct srv_store *store, const struct srv_job_order *order, struct srv_job *job) {
    struct row_jobs rows = {.cap = 1, .job = job, .with_digest = 1};
    STORE_TRY(RUN(store, SQL_JOB_OF_KEY, row_job, &rows, text_value(order->client), text_value(order->key)));
    if (!rows.count) return SRV_STORED_NONE;
    return memcmp(rows.digest, order->digest, SRV_DIGEST_BYTES) ? SRV_STORED_CLASH : SRV_STORED;
}

static enum srv_stored submit_new(struct srv_store *store, const struct srv_job_order *order,
                                  const struct row_wholes *client, struct srv_job *job) {
    struct row_jobs rows = {.cap = 1, .job = job};
    if (client->whole[0] > store->rules.client_jobs) {
        snprintf(job->message, sizeof job->message, "the client has max-client-jobs, %ld, open jobs",
                 store->rules.client_jobs);
        return SRV_STORED_QUOTA;
    }
    STORE_TRY(store_room(store, order->request_bytes, client->whole[1], job->message));
    STORE_TRY(RUN(store, SQL_JOB_PUT, row_job, &rows, text_value(order->id), text_value(order->client),
                  text_value(order->operation), bytes_value(order->request, order->request_bytes),
                  text_value(order->key), bytes_value(order->digest, SRV_DIGEST_BYTES), whole_value(order->shards),
                  whole_value(order->chained)));
    return store_plain(store, SQL_RING);
}

enum srv_stored srv_store_submit(struct srv_store *store, const struct srv_job_order *order, struct srv_job *job) {
    struct row_wholes client = {.count = 2};
    *job = (struct srv_job){0};
    STORE_TRY(store_begin(store));
    /* the client's row is locked first, so that requests with one key come one after the other */
    enum srv_stored stored = RUN(store, SQL_CLIENT_ENTER, row_wholes, &client, text_value(order->client));
    int known = 0;
    if (stored == SRV_STORED && order->key) {
        stored = submit_known(store, order, job);
        known = stored != SRV_STORED_NONE;
        if (!known) stored = SRV_STORED;
    }
    if (stored == SRV_STORED && !known) stored = submit_new(store, order, &client, job);
    return store_end(store, stored == SRV_STORED && !known, stored);
}

enum srv_stored srv_store_job(struct srv_store *store, const char *id, struct srv_job *job) {
    STORE_TRY(store_begin(store));
    return store_end(store, 1, store_find(store, SQL_JOB, id, job));
}

/* a statement of one parameter that answers with one field of bytes */
static enum srv_stored store_bytes(struct srv_store *store, enum statement id, const char *name, void **data,
                                   size_t *bytes) {
    struct row_bytes row = {0};
    *data = NULL;
    *bytes = 0;
    STORE_TRY(store_begin(store));
    enum srv_stored stored = RUN(store, id, row_bytes, &row, text_value(name));
    if (stored == SRV_STORED && !row.data) stored = SRV_STORED_NONE;
    stored = store_end(store, 1, stored);
    if (stored == SRV_STORED) {
        *data = row.data;
        *bytes = row.bytes;
    } else
        free(row.data);
    return stored;
}

enum srv_stored srv_store_request(struct srv_store *store, const char *id, void **request, size_t *bytes) {
    return store_bytes(store, SQL_JOB_REQUEST, id, request, bytes);
}

enum srv_stored srv_store_list(struct srv_store *store, const char *client, const char *before, int most,
                               struct srv_job job[], int *count) {
    struct row_jobs rows = {.cap = most, .job = job};
    *count = 0;
    STORE_TRY(store_begin(store));
    enum srv_stored stored =
        before ? RUN(store, SQL_JOBS_BEFORE, row_job, &rows, text_value(client), whole_value(most), text_value(before))
               : RUN(store, SQL_JOBS, row_job, &rows, text_value(client), whole_value(most));
    stored = store_end(store, 1, stored);
    if (stored == SRV_STORED) *count = rows.count;
    return stored;
}

/* ends a job that was locked; its shards go, so that no attempt can write any more */
static enum srv_stored store_job_end(struct srv_store *store, struct srv_job *job, enum srv_job_state state,
                                     const char *message) {
    struct row_jobs rows = {.cap = 1, .job = job};
    int was_open = job_open(job);
    if (state != SRV_JOB_SUCCESSFUL) STORE_TRY(RUN(store, SQL_SHARDS_REMOVE, NULL, NULL, text_value(job->id)));
    if (was_open) STORE_TRY(store_client(store, job->client, -1, 0, 0, NULL));
    char id[SRV_ID_BYTES];
    memcpy(id, job->id, sizeof id);
    STORE_TRY(RUN(store, SQL_JOB_END, row_job, &rows, text_value(id), whole_value(state), text_value(message),
                  whole_value(store->rules.keep_us)));
    return store_plain(store, SQL_RING);
}

enum srv_stored srv_store_dismiss(struct srv_store *store, const char *id, struct srv_job *job) {
    STORE_TRY(store_begin(store));
    enum srv_stored stored = store_find(store, SQL_JOB_LOCK, id, job);
    if (stored == SRV_STORED && job->state != SRV_JOB_DISMISSED)
        stored = store_job_end(store, job, SRV_JOB_DISMISSED, job_open(job) ? "" : job->message);
    return store_end(store, stored == SRV_STORED, stored);
}

/* ---- leases */

struct row_lease {
    int rows;
    struct srv_lease *lease;
};

static enum srv_stored row_lease(void *context, const struct srv_value field[]) {
    struct row_lease *row = context;
    struct srv_lease *lease = row->lease;
    lease->shard = (long)field[0].whole;
    lease->attempt = (long)field[1].whole;
    lease->start_bytes = field[2].bytes;
    if (field[2].kind == SRV_SQL_BYTES) {
        lease->start = malloc(field[2].bytes + 1);
        if (!lease->start) return SRV_STORED_BROKEN;
        memcpy(lease->start, field[2].data, field[2].bytes);
    }
    row->rows++;
    return SRV_STORED;
}

void srv_lease_clear(struct srv_lease *lease) {
    free(lease->start);
    *lease = (struct srv_lease){0};
}

/* the clients whose turn it is, first come first */
struct row_clients {
    int count;
    char name[8][SRV_NAME_BYTES];
};

static enum srv_stored row_client(void *context, const struct srv_value field[]) {
    struct row_clients *rows = context;
    if (rows->count < 8) row_text(&field[0], rows->name[rows->count++], SRV_NAME_BYTES);
    return SRV_STORED;
}

struct row_ready {
    int rows;
    struct srv_lease *lease;
    int again; /* one that was held before is next */
};

static enum srv_stored row_ready(void *context, const struct srv_value field[]) {
    struct row_ready *row = context;
    row_text(&field[0], row->lease->job, sizeof row->lease->job);
    row_text(&field[1], row->lease->operation, sizeof row->lease->operation);
    row->lease->shards = (long)field[2].whole;
    /* what was held before comes last, unless there is much of it: it may be what kills its workers */
    int last = !field[5].whole && field[3].whole < field[2].whole && field[4].whole <= LAST_SHARDS;
    row->again = field[4].whole > 0 && !last;
    row->rows++;
    return SRV_STORED;
}

/* takes a shard of the job that is ready and locked */
static enum srv_stored claim_shard(struct srv_store *store, const char *client, const char *worker, int64_t lease_us,
                                   const struct row_ready *ready) {
    struct srv_lease *lease = ready->lease;
    struct row_lease row = {.lease = lease};
    enum statement take = ready->again ? SQL_SHARD_AGAIN : SQL_SHARD_NEXT;
    STORE_TRY(RUN(store, take, row_lease, &row, text_value(lease->job), text_value(worker), whole_value(lease_us)));
    if (!row.rows) return SRV_STORED_BROKEN;
    STORE_TRY(RUN(store, SQL_JOB_CLAIM, NULL, NULL, text_value(lease->job), whole_value(ready->again),
                  whole_value(!ready->again)));
    return store_client(store, client, 0, 0, 1, NULL);
}

enum srv_stored srv_store_claim(struct srv_store *store, const char *worker, int64_t lease_us,
                                struct srv_lease *lease) {
    struct row_clients clients = {0};
    struct row_ready ready = {.lease = lease};
    *lease = (struct srv_lease){0};
    STORE_TRY(store_begin(store));
    enum srv_stored stored = store_run(store, SQL_CLIENTS, NULL, 0, row_client, &clients);
    const char *client = NULL;
    for (int i = 0; i < clients.count && stored == SRV_STORED && !ready.rows; i++) {
        client = clients.name[i];
        stored = RUN(store, SQL_JOB_READY, row_ready, &ready, text_value(client));
    }
    if (stored == SRV_STORED && ready.rows) stored = claim_shard(store, client, worker, lease_us, &ready);
    /* what is ready but locked by another process will be free in a moment */
    else if (stored == SRV_STORED)
        stored = clients.count ? SRV_STORED_AGAIN : SRV_STORED_NONE;
    stored = store_end(store, stored == SRV_STORED, stored);
    if (stored != SRV_STORED) srv_lease_clear(lease);
    return stored;
}

enum srv_stored srv_store_extend(struct srv_store *store, const struct srv_lease *lease, int64_t lease_us) {
    struct row_wholes row = {.count = 1};
    STORE_TRY(store_begin(store));
    enum srv_stored stored = RUN(store, SQL_SHARD_EXTEND, row_wholes, &row, text_value(lease->job),
                                 whole_value(lease->shard), whole_value(lease->attempt), whole_value(lease_us));
    if (stored == SRV_STORED && !row.rows) stored = SRV_STORED_LOST;
    return store_end(store, stored == SRV_STORED, stored);
}

/* locks the job, then the shard; LOST unless this attempt holds it or, with `done`, has already finished it */
static enum srv_stored lease_check(struct srv_store *store, const struct srv_lease *lease, struct srv_job *job,
                                   int *done) {
    struct row_wholes shard = {.count = 2};
    *done = 0;
    enum srv_stored stored = store_find(store, SQL_JOB_LOCK, lease->job, job);
    if (stored == SRV_STORED_NONE) return SRV_STORED_LOST;
    STORE_TRY(stored);
    STORE_TRY(RUN(store, SQL_SHARD, row_wholes, &shard, text_value(lease->job), whole_value(lease->shard)));
    if (!shard.rows || shard.whole[1] != lease->attempt) return SRV_STORED_LOST;
    *done = shard.whole[0] == SHARD_DONE;
    return *done || (shard.whole[0] == SHARD_HELD && job_open(job)) ? SRV_STORED : SRV_STORED_LOST;
}

static enum srv_stored finish_data(struct srv_store *store, const struct srv_lease *lease, const char *data,
                                   size_t bytes) {
    for (size_t at = 0; at < bytes; at += SRV_CHUNK_BYTES) {
        size_t piece = bytes - at < SRV_CHUNK_BYTES ? bytes - at : SRV_CHUNK_BYTES;
        STORE_TRY(RUN(store, SQL_RESULT_PUT, NULL, NULL, text_value(lease->job), whole_value(lease->shard),
                      whole_value((int64_t)(at / SRV_CHUNK_BYTES)), bytes_value(data + at, piece)));
    }
    return RUN(store, SQL_SHARD_END, NULL, NULL, text_value(lease->job), whole_value(lease->shard),
               whole_value((int64_t)bytes));
}

enum srv_stored srv_store_finish(struct srv_store *store, const struct srv_lease *lease, const void *data, size_t bytes,
                                 const void *carry, size_t carry_bytes) {
    struct srv_job job;
    int64_t kept = 0;
    int done, over = 0;
    char message[SRV_MESSAGE_BYTES];
    STORE_TRY(store_begin(store));
    enum srv_stored stored = lease_check(store, lease, &job, &done);
    if (stored != SRV_STORED || done) return store_end(store, 0, stored);
    stored = store_client(store, job.client, 0, (long long)bytes, 0, &kept);
    if (stored == SRV_STORED) stored = store_room(store, bytes, kept, message);
    if (stored == SRV_STORED_QUOTA) {
        /* what was counted is taken back, and the job ends */
        over = 1;
        stored = store_client(store, job.client, 0, -(long long)bytes, 0, NULL);
        if (stored == SRV_STORED) stored = store_job_end(store, &job, SRV_JOB_FAILED, message);
    } else {
        if (stored == SRV_STORED) stored = finish_data(store, lease, data, bytes);
        /* a job that gets on is not what kills its workers */
        if (stored == SRV_STORED) stored = RUN(store, SQL_SHARDS_CLEARED, NULL, NULL, text_value(lease->job));
        if (stored == SRV_STORED)
            stored = RUN(store, SQL_JOB_STEP, NULL, NULL, text_value(lease->job), whole_value((int64_t)bytes),
                         bytes_value(carry, carry_bytes));
        if (stored == SRV_STORED && job.done + 1 == job.shards)
            stored = store_job_end(store, &job, SRV_JOB_SUCCESSFUL, "");
        else if (stored == SRV_STORED && carry)
            stored = store_plain(store, SQL_RING);
    }
    int keep = stored == SRV_STORED;
    return store_end(store, keep, keep && over ? SRV_STORED_QUOTA : stored);
}

enum srv_stored srv_store_fail(struct srv_store *store, const struct srv_lease *lease, const char *message) {
    struct srv_job job;
    int done;
    STORE_TRY(store_begin(store));
    enum srv_stored stored = lease_check(store, lease, &job, &done);
    if (stored == SRV_STORED && done) stored = SRV_STORED_LOST;
    if (stored == SRV_STORED) stored = store_job_end(store, &job, SRV_JOB_FAILED, message);
    return store_end(store, stored == SRV_STORED, stored);
}

struct row_shards {
    int count;
    struct {
        char job[SRV_ID_BYTES];
        int64_t number;
    } shard[SWEEP_LEASES];
};

static enum srv_stored row_shard(void *context, const struct srv_value field[]) {
    struct row_shards *rows = context;
    if (rows->count == SWEEP_LEASES) return SRV_STORED;
    row_text(&field[0], rows->shard[rows->count].job, SRV_ID_BYTES);
    rows->shard[rows->count++].number = field[1].whole;
    return SRV_STORED;
}

/* a shard waits again; with `mark` because its lease ran out, which counts against it */
static enum srv_stored shard_back(struct srv_store *store, const char *id, int64_t number, int mark,
                                  struct srv_store_sweep *sweep) {
    struct row_wholes row = {.count = 1};
    struct srv_job job;
    char message[SRV_MESSAGE_BYTES];
    enum srv_stored stored = store_find(store, SQL_JOB_LOCK, id, &job);
    if (stored == SRV_STORED_NONE || (stored == SRV_STORED && !job_open(&job))) return SRV_STORED;
    STORE_TRY(stored);
    STORE_TRY(RUN(store, SQL_SHARD_BACK, row_wholes, &row, text_value(id), whole_value(number), whole_value(mark)));
    if (!row.rows) return SRV_STORED;
    sweep->released++;
    if (row.whole[0] < SRV_MOST_KILLS) return RUN(store, SQL_JOB_WAIT, NULL, NULL, text_value(id));
    sweep->given_up++;
    snprintf(message, sizeof message,
             "given up: %d workers ended or fell silent over part %lld of %ld, and nothing was done between",
             SRV_MOST_KILLS, (long long)number + 1, job.shards);
    return store_job_end(store, &job, SRV_JOB_FAILED, message);
}

static enum srv_stored shards_back(struct srv_store *store, const struct row_shards *rows, int mark,
                                   struct srv_store_sweep *sweep) {
    for (int i = 0; i < rows->count; i++)
        STORE_TRY(shard_back(store, rows->shard[i].job, rows->shard[i].number, mark, sweep));
    if (!sweep->released) return SRV_STORED;
    return store_plain(store, SQL_RING);
}

enum srv_stored srv_store_release(struct srv_store *store, const char *worker) {
    struct srv_store_sweep sweep;
    struct row_shards rows;
    enum srv_stored stored;
    do {
        rows.count = 0;
        sweep = (struct srv_store_sweep){0};
        STORE_TRY(store_begin(store));
        stored = RUN(store, SQL_SHARDS_OF, row_shard, &rows, text_value(worker));
        if (stored == SRV_STORED) stored = shards_back(store, &rows, 0, &sweep);
        stored = store_end(store, stored == SRV_STORED, stored);
    } while (stored == SRV_STORED && sweep.released == SWEEP_LEASES);
    return stored;
}

struct row_chunk {
    int rows;
    void *data;
    size_t bytes;
};

static enum srv_stored row_chunk(void *context, const struct srv_value field[]) {
    struct row_chunk *row = context;
    if (field[0].bytes > SRV_CHUNK_BYTES) return SRV_STORED_BROKEN;
    row->rows++;
    row->bytes = field[0].bytes;
    if (row->bytes) memcpy(row->data, field[0].data, row->bytes);
    return SRV_STORED;
}

enum srv_stored srv_store_chunk(struct srv_store *store, const char *id, long shard, long chunk, void *data,
                                size_t *bytes) {
    struct row_chunk row = {.data = data};
    *bytes = 0;
    STORE_TRY(store_begin(store));
    enum srv_stored stored =
        RUN(store, SQL_RESULT, row_chunk, &row, text_value(id), whole_value(shard), whole_value(chunk));
    if (stored == SRV_STORED && !row.rows) stored = SRV_STORED_NONE;
    stored = store_end(store, 1, stored);
    if (stored == SRV_STORED) *bytes = row.bytes;
    return stored;
}

/* ---- sweeping */

static enum srv_stored row_id(void *context, const struct srv_value field[]) {
    row_text(&field[0], context, SRV_ID_BYTES);
    return SRV_STORED;
}

/* takes a piece of a job's results away; the last piece settles the client's account */
static enum srv_stored sweep_results(struct srv_store *store, const struct srv_job *job, int *emptied) {
    struct row_wholes gone = {.count = 1};
    STORE_TRY(RUN(store, SQL_RESULTS_REMOVE, row_wholes, &gone, text_value(job->id)));
    *emptied = gone.rows < CLEAN_CHUNKS;
    if (!*emptied) return SRV_STORED;
    STORE_TRY(store_client(store, job->client, 0, -job->bytes, 0, NULL));
    return RUN(store, SQL_JOB_EMPTY, NULL, NULL, text_value(job->id));
}

static enum srv_stored sweep_dismissed(struct srv_store *store, struct srv_store_sweep *sweep) {
    char id[SRV_ID_BYTES] = "";
    struct srv_job job;
    int emptied;
    STORE_TRY(store_run(store, SQL_JOB_UNCLEAN, NULL, 0, row_id, id));
    if (!*id) return SRV_STORED;
    STORE_TRY(store_find(store, SQL_JOB_LOCK, id, &job));
    sweep->more = 1;
    return sweep_results(store, &job, &emptied);
}

static enum srv_stored sweep_expired(struct srv_store *store, struct srv_store_sweep *sweep) {
    char id[SRV_ID_BYTES] = "";
    struct srv_job job;
    STORE_TRY(store_run(store, SQL_JOB_EXPIRED, NULL, 0, row_id, id));
    if (!*id) return SRV_STORED;
    STORE_TRY(store_find(store, SQL_JOB_LOCK, id, &job));
    sweep->more = 1;
    /* one with results is dismissed first, which takes them away piece by piece */
    if (job.bytes > 0)
        return job.state == SRV_JOB_SUCCESSFUL ? store_job_end(store, &job, SRV_JOB_DISMISSED, "") : SRV_STORED;
    STORE_TRY(RUN(store, SQL_SHARDS_REMOVE, NULL, NULL, text_value(id)));
    return RUN(store, SQL_JOB_REMOVE, NULL, NULL, text_value(id));
}

enum srv_stored srv_store_sweep(struct srv_store *store, int64_t *looked, struct srv_store_sweep *sweep) {
    struct row_shards late = {0};
    struct row_wholes now = {.count = 1};
    *sweep = (struct srv_store_sweep){0};
    STORE_TRY(store_begin(store));
    enum srv_stored stored = store_run(store, SQL_NOW, NULL, 0, row_wholes, &now);
    int64_t before = looked ? *looked : now.whole[0];
    if (stored == SRV_STORED) stored = RUN(store, SQL_SHARDS_LATE, row_shard, &late, whole_value(before));
    if (stored == SRV_STORED && looked) *looked = now.whole[0];
    if (stored == SRV_STORED) stored = shards_back(store, &late, 1, sweep);
    if (stored == SRV_STORED) stored = sweep_dismissed(store, sweep);
    if (stored == SRV_STORED) stored = sweep_expired(store, sweep);
    if (stored == SRV_STORED && !sweep->more) stored = store_plain(store, SQL_CLIENTS_LEAVE);
    sweep->more |= late.count == SWEEP_LEASES;
    return store_end(store, stored == SRV_STORED, stored);
}

static enum srv_stored row_figures(void *context, const struct srv_value field[]) {
    struct srv_store_figures *figures = context;
    if (field[0].whole < 0 || field[0].whole >= SRV_JOB_STATES) return SRV_STORED_BROKEN;
    figures->jobs[field[0].whole] = (long)field[1].whole;
    figures->bytes += field[2].whole;
    figures->shards += (long)field[3].whole;
    return SRV_STORED;
}

enum srv_stored srv_store_figures(struct srv_store *store, struct srv_store_figures *figures) {
    *figures = (struct srv_store_figures){0};
    STORE_TRY(store_begin(store));
    return store_end(store, 1, store_run(store, SQL_FIGURES, NULL, 0, row_figures, figures));
}

/* ---- scenes */

static enum srv_stored scene_put(struct srv_store *store, const char *id, const char *client, const void *body,
                                 size_t bytes) {
    struct row_wholes count = {.count = 1}, put = {.count = 1};
    struct row_bytes there = {0};
    STORE_TRY(RUN(store, SQL_SCENE, row_bytes, &there, text_value(id)));
    if (there.data) {
        int same = there.bytes == bytes && (!bytes || !memcmp(there.data, body, bytes));
        free(there.data);
        return same ? SRV_STORED : SRV_STORED_CLASH;
    }
    STORE_TRY(RUN(store, SQL_SCENES_OF, row_wholes, &count, text_value(client)));
    if (count.whole[0] >= store->rules.client_scenes) return SRV_STORED_QUOTA;
    STORE_TRY(
        RUN(store, SQL_SCENE_PUT, row_wholes, &put, text_value(id), text_value(client), bytes_value(body, bytes)));
    return put.rows ? SRV_STORED : SRV_STORED_AGAIN;
}

enum srv_stored srv_store_scene_put(struct srv_store *store, const char *id, const char *client, const void *body,
                                    size_t bytes) {
    STORE_TRY(store_begin(store));
    enum srv_stored stored = scene_put(store, id, client, body, bytes);
    return store_end(store, stored == SRV_STORED, stored);
}

enum srv_stored srv_store_scene(struct srv_store *store, const char *id, void **body, size_t *bytes) {
    return store_bytes(store, SQL_SCENE, id, body, bytes);
}
