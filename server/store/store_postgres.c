#include "server/store/sql.h"

#include <assert.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#include "server/base/clock.h"
#include "server/base/container_of.h"
#include "server/store/store_postgres_line.h"

/* bytes sent before a reply is awaited */
enum { POST_BYTES = 1 << 20 };
enum { FIRST_WAIT_MS = 100, MOST_WAIT_MS = 5000 };
/* longest waits: ANSWER_MS for a reply; LISTEN_MS until a silent listener checks its connection */
enum { ANSWER_MS = 10000, LISTEN_MS = 5000 };
/* connections that worker processes leave free: enough for two api processes to start */
enum { CONNECTIONS_LEFT = 8 };

struct postgres_sql {
    struct srv_sql sql; /* first */
    PGconn *connection;
    int64_t retry_ms; /* time of the next reconnection attempt */
    int wait_ms;      /* delay between attempts */
    int silent;       /* the database did not reply in time */
    char *url;
    int role;    /* SRV_SQL_ bits of its process */
    int crowded; /* refused because it would use one of the last connections */
    int pooled;  /* behind a transaction pooler: different server processes run its transactions */
    int64_t listen_ms; /* time of the next LISTEN */
    char kept[SRV_SQL_STATEMENTS];
    int round;  /* generation number in the names of prepared statements */
    int unsure; /* statements were prepared since the last reply; after a failure they may not
                 * exist */
    size_t posted_bytes; /* bytes of statements sent or queued since the last reply */
    struct srv_sql_list *list[SRV_SQL_STATEMENTS]; /* collected rows of each statement; NULL = none
                                                    * so far */
    int listed[SRV_SQL_STATEMENTS], lists; /* the statements with rows, in order of arrival */
};

static int64_t postgres_clock_ms(void) { return srv_clock_now() / 1000000; }

static void postgres_close(struct srv_sql *sql) {
    struct postgres_sql *own = SRV_CONTAINER_OF(sql, struct postgres_sql, sql);
    PQfinish(own->connection);
    free(own->url);
    for (int i = 0; i < SRV_SQL_STATEMENTS; i++) {
        if (own->list[i]) srv_sql_list_free(own->list[i]);
        free(own->list[i]);
    }
    free(own);
}

static void postgres_quiet(void *context, const char *message) { (void)context, (void)message; }

/* waits until PQgetResult will not block, or until the timeout; sends queued bytes meanwhile */
static int postgres_wait(PGconn *connection, int64_t until_ms) {
    int unsent;
    while ((unsent = PQflush(connection)) > 0 || (unsent == 0 && PQisBusy(connection))) {
        int64_t left = until_ms - postgres_clock_ms();
        struct pollfd waiting = {PQsocket(connection), (short)(POLLIN | (unsent ? POLLOUT : 0)), 0};
        if (left <= 0) return 0;
        if (poll(&waiting, 1, (int)left) > 0 && !PQconsumeInput(connection)) break;
    }
    return 1;
}

/* the next result; NULL at the end of a statement's results; closes the connection on a timeout */
static PGresult *postgres_result_next(struct postgres_sql *own, int64_t until_ms) {
    if (!own->silent && !postgres_wait(own->connection, until_ms)) {
        own->silent = 1;
        shutdown(PQsocket(own->connection), SHUT_RDWR);
    }
    return PQgetResult(own->connection);
}

/* the reply to a command outside a pipeline; the first error if there are several results */
static PGresult *postgres_answer(struct postgres_sql *own, int said) {
    int64_t until_ms = postgres_clock_ms() + ANSWER_MS;
    PGresult *answer = NULL, *next;
    if (!said) return NULL;
    while ((next = postgres_result_next(own, until_ms))) {
        int bad = answer && PQresultStatus(answer) == PGRES_FATAL_ERROR;
        PQclear(bad ? next : answer);
        if (!bad) answer = next;
    }
    return answer;
}

/* keeps a result that is the reply or the first error and frees its predecessor; frees other
 * results */
static void postgres_keep(PGresult *result, PGresult **answer, PGresult **bad) {
    ExecStatusType status = PQresultStatus(result);
    PGresult **place = status == PGRES_FATAL_ERROR ? bad : answer;
    int passing =
        status == PGRES_PIPELINE_SYNC || status == PGRES_PIPELINE_ABORTED || (place == bad && *bad);
    PQclear(passing ? result : *place);
    if (!passing) *place = result;
}

/* the reply to the last statement of a pipeline, or the first error before it; NULL if the
 * connection is lost */
static PGresult *postgres_sync(struct postgres_sql *own, int said) {
    int64_t until_ms = postgres_clock_ms() + ANSWER_MS;
    PGresult *answer = NULL, *bad = NULL, *next;
    int over = !said || !PQpipelineSync(own->connection);
    /* one NULL ends the results of a statement; two, or one on a lost connection, end all */
    for (int ends = 0; !over && ends < 2;) {
        next = postgres_result_next(own, until_ms);
        ends = next ? 0 : ends + 1;
        over = (next && PQresultStatus(next) == PGRES_PIPELINE_SYNC) ||
               PQstatus(own->connection) != CONNECTION_OK;
        if (next) postgres_keep(next, &answer, &bad);
    }
    /* some of the statements may still exist, so their names are not used again */
    if (bad && own->unsure) {
        memset(own->kept, 0, sizeof own->kept);
        own->round++;
    }
    own->unsure = 0;
    own->posted_bytes = 0;
    if (!bad) return answer;
    PQclear(answer);
    return bad;
}

/* Every statement has a suitable index, and its plan must use it from the first row on: a plan made
 * for an empty table, or before statistics exist, would scan and sort the table. */
#define POSTGRES_PLANS                                                                             \
    "SET plan_cache_mode = force_generic_plan; SET enable_seqscan = off; SET enable_bitmapscan = " \
    "off;"                                                                                         \
    "SET enable_sort = off; SET enable_hashjoin = off; SET enable_mergejoin = off; SET jit = off;" \
    "SET max_parallel_workers_per_gather = 0"

#define POSTGRES_POOLED                                                                            \
    "a connection pooler gives each transaction another connection to the database (such as "      \
    "PgBouncer with pool_mode = transaction): use the database directly, or pool sessions"

/* Returns 0 behind a transaction pooler, where a statement may be prepared on one server connection
 * and run on another. It is detected because a pooler reports no server process at connection, and
 * gives a second connection the server process that the first has just used. Also returns 0 if a
 * worker would use one of the last connections. */
static int postgres_suits(struct postgres_sql *own) {
    int said = PQsendQuery(own->connection, SRV_POSTGRES_SERVER);
    long left, server = srv_postgres_server(postgres_answer(own, said), &left);
    own->pooled = server && server != PQbackendPID(own->connection) &&
                  srv_postgres_pooled(own->url, own->role, server);
    own->crowded = server && own->role == SRV_SQL_WORKS && left < CONNECTIONS_LEFT;
    if (server && !own->pooled && !own->crowded) return 1;
    PQfinish(own->connection);
    own->connection = NULL;
    return 0;
}

/* settings of a connection: a process that is suspended within a transaction must not lock rows for
 * long, and no wait for a lock is unlimited */
static int postgres_settle(struct postgres_sql *own) {
    if (PQsetnonblocking(own->connection, 1)) return 0;
    PQsetNoticeProcessor(own->connection, postgres_quiet, NULL);
    PGresult *result = postgres_answer(
        own, PQsendQuery(own->connection,
                         "SET idle_in_transaction_session_timeout = 5000; SET lock_timeout = 5000;"
                         "SET statement_timeout = 8000; SET synchronous_commit = on;"
                         "SET client_min_messages = warning;"
                         "SET default_transaction_isolation = 'read committed';" POSTGRES_PLANS));
    int good = PQresultStatus(result) == PGRES_COMMAND_OK;
    PQclear(result);
    return good && postgres_suits(own) && PQenterPipelineMode(own->connection);
}

static void postgres_complain(struct postgres_sql *own, const PGresult *result) {
    static_assert(ANSWER_MS == 10000, "the limit is in a text");
    static_assert(CONNECTIONS_LEFT == 8, "the number is in a text");
    srv_sql_complain(&own->sql, own->pooled ? POSTGRES_POOLED
                                : own->crowded
                                    ? "the database has 8 connections left, which are reserved for "
                                      "processes that answer requests: max_connections"
                                : own->silent ? "the database gave no answer in 10 s"
                                : result      ? PQresultErrorMessage(result)
                                              : PQerrorMessage(own->connection));
}

static void postgres_lost(struct postgres_sql *own) {
    postgres_complain(own, NULL);
    own->wait_ms = !own->wait_ms                     ? FIRST_WAIT_MS
                   : own->wait_ms < MOST_WAIT_MS / 2 ? 2 * own->wait_ms
                                                     : MOST_WAIT_MS;
    own->retry_ms = postgres_clock_ms() + own->wait_ms;
}

static enum pend_status postgres_open(struct srv_sql **sql, const char *url, int role,
                                      struct pend_error *error) {
    struct postgres_sql *own = calloc(1, sizeof *own);
    enum pend_status status = PEND_OK;
    *sql = NULL;
    if (!own) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    own->sql.driver = &srv_sql_postgres;
    own->role = role;
    if (!(own->url = strdup(url)))
        status = pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    char *said = NULL;
    PQconninfoOption *options = PQconninfoParse(url, &said);
    if (!options) {
        /* the quoted text may be part of the password, unless it names a parameter */
        if (said && strncmp(said, "invalid URI query parameter", 27) != 0)
            said[strcspn(said, "\"")] = 0;
        srv_sql_complain(&own->sql, said ? said : "out of memory");
        status = pend_fail(
            error, PEND_INVALID, -1, 0,
            "the url of the database: %.120s (values are hidden, since one may be the password)",
            own->sql.complaint);
    }
    PQconninfoFree(options);
    PQfreemem(said);
    if (status == PEND_OK) own->connection = srv_postgres_connect(url, role);
    /* an unreachable database may return: treat the connection as lost */
    if (own->connection && (PQstatus(own->connection) != CONNECTION_OK || !postgres_settle(own)))
        postgres_lost(own);
    if (own->pooled) status = pend_fail(error, PEND_INVALID, -1, 0, "%s", POSTGRES_POOLED);
    if (status == PEND_OK)
        *sql = &own->sql;
    else
        postgres_close(&own->sql);
    return status;
}

static int postgres_again(struct postgres_sql *own) {
    int64_t now = postgres_clock_ms();
    if (now < own->retry_ms || own->pooled) return 0;
    own->silent = own->crowded = 0;
    if (own->connection)
        PQreset(own->connection);
    else
        own->connection = srv_postgres_connect(own->url, own->role);
    memset(own->kept, 0, sizeof own->kept);
    own->unsure = 0;
    own->posted_bytes = 0;
    own->listen_ms = 0;
    if (PQstatus(own->connection) == CONNECTION_OK && postgres_settle(own)) {
        own->wait_ms = 0;
        return 1;
    }
    postgres_lost(own);
    return 0;
}

/* converts PostgreSQL's SQLSTATE */
static enum srv_stored postgres_result(struct postgres_sql *own, const PGresult *result) {
    static const struct {
        const char *state; /* prefix of the SQLSTATE */
        enum srv_stored stored;
    } rows[] = {{"53100", SRV_STORED_FULL},
                {"40", SRV_STORED_AGAIN},
                {"55P03", SRV_STORED_AGAIN},
                {"23505", SRV_STORED_AGAIN},
                {"08", SRV_STORED_AWAY},
                {"57P", SRV_STORED_AWAY},
                {"57014", SRV_STORED_AWAY},
                {"53", SRV_STORED_AWAY},
                {"25P03", SRV_STORED_AGAIN},
                {"25006", SRV_STORED_AWAY},
                /* a prepared statement is missing, or exists already */
                {"26000", SRV_STORED_AWAY},
                {"42P05", SRV_STORED_AWAY},
                /* a row has an out-of-range number or an invalid text */
                {"22", SRV_STORED_DAMAGED}};
    ExecStatusType status = PQresultStatus(result);
    if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return SRV_STORED;
    const char *state = result ? PQresultErrorField(result, PG_DIAG_SQLSTATE) : NULL;
    own->pooled |= state && (!strcmp(state, "26000") || !strcmp(state, "42P05"));
    postgres_complain(own, result);
    for (size_t i = 0; state && i < sizeof rows / sizeof *rows; i++)
        if (!strncmp(state, rows[i].state, strlen(rows[i].state))) return rows[i].stored;
    return !state || PQstatus(own->connection) != CONNECTION_OK ? SRV_STORED_AWAY
                                                                : SRV_STORED_BROKEN;
}

/* queues a statement in the pipeline, after its preparation if needed; returns 0 on failure */
static int postgres_put(struct postgres_sql *own, int id, const char *text,
                        const struct srv_postgres_values *values, int count) {
    char spelt[SRV_SQL_TEXT], name[32];
    if (id < 0 || !own->kept[id]) srv_sql_spell(&srv_sql_postgres, text, spelt);
    if (id < 0)
        return PQsendQueryParams(own->connection, spelt, count, values->type, values->data,
                                 values->bytes, values->binary, 1);
    snprintf(name, sizeof name, "s%d_%d", id, own->round);
    if (!own->kept[id]) {
        if (!PQsendPrepare(own->connection, name, spelt, count, values->type)) return 0;
        own->kept[id] = 1;
        own->unsure = 1;
    }
    return PQsendQueryPrepared(own->connection, name, count, values->data, values->bytes,
                               values->binary, 1);
}

/* queues a statement with its collected rows of values */
static int postgres_put_list(struct postgres_sql *own, int id) {
    struct srv_sql_list *list = own->list[id];
    struct srv_postgres_values values = {0};
    srv_sql_list_arrays(list, values.data, values.bytes);
    for (int i = 0; i < list->columns; i++) values.binary[i] = 1;
    int good = postgres_put(own, id, list->text, &values, list->columns);
    srv_sql_list_empty(list);
    return good;
}

/* discards the collected rows of a failed transaction */
static void postgres_drop_lists(struct postgres_sql *own) {
    for (int i = 0; i < own->lists; i++) srv_sql_list_empty(own->list[own->listed[i]]);
    own->lists = 0;
}

/* queues all statements with collected rows, statement `last` after the others */
static int postgres_put_lists(struct postgres_sql *own, int last) {
    int good = 1;
    for (int i = 0; i + 1 < own->lists; i++)
        if (own->listed[i] == last) {
            own->listed[i] = own->listed[i + 1];
            own->listed[i + 1] = last;
        }
    for (int i = 0; i < own->lists && good; i++) good = postgres_put_list(own, own->listed[i]);
    postgres_drop_lists(own);
    return good;
}

/* collects a row of values for a statement; returns 0 if memory is short */
static int postgres_gather(struct postgres_sql *own, int id, const char *text,
                           const struct srv_value value[], int count) {
    if (!own->list[id] && !(own->list[id] = calloc(1, sizeof *own->list[id]))) return 0;
    if (!own->list[id]->rows) own->listed[own->lists++] = id;
    if (srv_sql_list_add(own->list[id], text, value, count)) return 1;
    postgres_drop_lists(own);
    return 0;
}

/* queues a statement after those with collected rows. With `later`, a statement on rows waits for
 * more rows. Returns 0 on failure */
static int postgres_send(struct postgres_sql *own, int id, const char *text,
                         const struct srv_value value[], int count, int later) {
    struct srv_postgres_values values;
    if (!strcmp(text, "{begin}") || !strcmp(text, "ROLLBACK")) postgres_drop_lists(own);
    for (int i = 0; i < count; i++) own->posted_bytes += value[i].bytes + sizeof value[i].whole;
    if (id >= 0 && srv_sql_columns(text)) {
        if (!postgres_gather(own, id, text, value, count)) return 0;
        return later || postgres_put_lists(own, id);
    }
    srv_postgres_values(&values, value, count);
    return postgres_put_lists(own, -1) && postgres_put(own, id, text, &values, count);
}

/* true if there is a connection; reconnects at the beginning of a transaction */
static int postgres_here(struct postgres_sql *own, const char *text) {
    if (PQstatus(own->connection) == CONNECTION_OK && !own->pooled) return 1;
    return (!strcmp(text, "{begin}") || !strcmp(text, "{look}")) && postgres_again(own);
}

static enum srv_stored postgres_post(struct srv_sql *sql, int id, const char *text,
                                     const struct srv_value value[], int count) {
    struct postgres_sql *own = SRV_CONTAINER_OF(sql, struct postgres_sql, sql);
    if (!postgres_here(own, text)) return SRV_STORED_AWAY;
    if (!strcmp(text, "{look}")) return SRV_STORED;
    if (!postgres_send(own, id, text, value, count, 1)) return postgres_result(own, NULL);
    if (own->posted_bytes < POST_BYTES) return SRV_STORED;
    PGresult *result = postgres_sync(own, postgres_put_lists(own, -1));
    enum srv_stored stored = postgres_result(own, result);
    PQclear(result);
    return stored;
}

static enum srv_stored postgres_run(struct srv_sql *sql, int id, const char *text,
                                    const struct srv_value value[], int count, srv_row_fn *row,
                                    void *context) {
    struct postgres_sql *own = SRV_CONTAINER_OF(sql, struct postgres_sql, sql);
    struct srv_value field[SRV_SQL_PARAMETERS];
    if (!postgres_here(own, text)) return SRV_STORED_AWAY;
    PGresult *result = postgres_sync(own, postgres_send(own, id, text, value, count, 0));
    enum srv_stored stored = postgres_result(own, result);
    /* after a failed statement PostgreSQL accepts COMMIT but rolls back */
    if (stored == SRV_STORED && !strcmp(text, "COMMIT") && strcmp(PQcmdStatus(result), text))
        stored = SRV_STORED_AGAIN;
    int rows = stored == SRV_STORED ? PQntuples(result) : 0,
        columns = stored == SRV_STORED ? PQnfields(result) : 0;
    for (int i = 0; i < rows && stored == SRV_STORED && row && columns <= SRV_SQL_PARAMETERS; i++) {
        srv_postgres_fields(result, i, field, columns);
        stored = row(context, field);
    }
    PQclear(result);
    return stored;
}

/* reads pending input; returns the SRV_RING_ bits of notifications, all bits if the connection is
 * lost */
static int postgres_heard(struct postgres_sql *own) {
    PGnotify *note;
    int heard = 0;
    if (!PQconsumeInput(own->connection)) return SRV_RING_ALL;
    while ((note = PQnotifies(own->connection))) {
        heard |= !strcmp(note->relname, "pendulumd_work")   ? SRV_RING_WORK
                 : !strcmp(note->relname, "pendulumd_stop") ? SRV_RING_STOP
                                                            : SRV_RING_ALL;
        PQfreemem(note);
    }
    return heard;
}

/* sends LISTEN; returns 0 if the connection is lost */
static int postgres_says(struct postgres_sql *own) {
    int good = 1;
    if (own->role != SRV_SQL_WORKS) good = postgres_send(own, -1, "LISTEN pendulumd", NULL, 0, 0);
    if (good && (own->role & ~SRV_SQL_BESIDE) != SRV_SQL_ANSWERS)
        good = postgres_send(own, -1, "LISTEN pendulumd_work", NULL, 0, 0) &&
               postgres_send(own, -1, "LISTEN pendulumd_stop", NULL, 0, 0);
    PGresult *result = postgres_sync(own, good);
    good = PQresultStatus(result) == PGRES_COMMAND_OK;
    own->listen_ms = good ? postgres_clock_ms() + LISTEN_MS : 0;
    PQclear(result);
    return good;
}

static int postgres_listen(struct srv_sql *sql, int timeout_ms, int wake) {
    struct postgres_sql *own = SRV_CONTAINER_OF(sql, struct postgres_sql, sql);
    int lost = !postgres_here(own, "{look}");
    if (!lost && postgres_clock_ms() >= own->listen_ms) lost = !postgres_says(own);
    struct pollfd waiting[] = {{lost ? -1 : PQsocket(own->connection), POLLIN, 0},
                               {wake, POLLIN, 0}};
    int heard = lost ? 0 : postgres_heard(own);
    if (!heard && poll(waiting, 2, timeout_ms) > 0 && waiting[0].revents)
        heard = postgres_heard(own);
    return heard;
}

static const struct srv_sql_word postgres_words[] = {
    {"begin", "BEGIN"},
    // stable within a statement, so that a condition on it can use an index; clock_timestamp()
    // cannot
    {"now", "(extract(epoch from statement_timestamp()) * 1000000)::bigint"},
    {"lock", "FOR UPDATE"},
    {"skip", "FOR UPDATE SKIP LOCKED"},
    {"alone", "SELECT pg_advisory_xact_lock(7016996765293437281)"},
    {"ring", "pg_notify('pendulumd', '')"},
    {"ring work", "pg_notify('pendulumd_work', '')"},
    {"ring stop", "pg_notify('pendulumd_stop', '')"},
    {"crowd",
     "(SELECT COUNT(*) FROM pg_stat_activity WHERE datname = current_database() AND "
     "application_name = 'pendulumd worker'), (SELECT COUNT(*) FROM pg_stat_activity WHERE "
     "datname = current_database() AND application_name LIKE 'pendulumd%')"},
    /* 3: the number of connections of an api process */
    {"carries", "CAST(current_setting('max_connections') AS BIGINT), CAST(current_setting("
                "'max_connections') AS BIGINT) - CAST(current_setting("
                "'superuser_reserved_connections') AS BIGINT) - 3 - 8"},
    {"bytes", "BYTEA"},
    {"hot", "WITH (fillfactor = 20)"},
    {NULL, NULL}};

const struct srv_sql_driver srv_sql_postgres = {
    .words = postgres_words,
    .scheme = "postgresql://",
    .batch = 128,
    .distant = 1,
    .shared = 1,
    .lists = 1,
    .open = postgres_open,
    .close = postgres_close,
    .run = postgres_run,
    .post = postgres_post,
    .listen = postgres_listen,
};
