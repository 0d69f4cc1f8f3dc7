#include "server/store/sql.h"

#include <assert.h>
#include <fcntl.h>
#include <poll.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/base/container_of.h"
#include "server/store/store_sqlite_disk.h"

enum {
    BUSY_MS = 5000,    /* longest wait for a writer */
    CARRY_MS = 250,    /* longest wait for readers before a checkpoint */
    BUSY_NAP_US = 1000 /* pause between two attempts */
};

struct sqlite_sql {
    struct srv_sql sql; /* first */
    sqlite3 *db;
    struct srv_sqlite_disk disk;
    sqlite3_stmt *kept[SRV_SQL_STATEMENTS];
    sqlite3_stmt *
        rollback; /* prepared in advance, so that a transaction can be rolled back without memory */
    int full;     /* the disk was full in the last transaction */
    int ringing;  /* a notification must be sent after the commit */
    int ear;      /* inotify descriptor for notifications; -1 = not opened yet */
    int64_t busy_ms; /* start of the wait for another process */
    int patience_ms; /* longest wait */
};

/* Busy handler, called while another process writes, which takes some milliseconds. SQLite's own
 * handler sleeps up to a tenth of a second, and starves when others write much. */
static int sqlite_busy(void *context, int tries) {
    struct sqlite_sql *own = context;
    const struct timespec nap = {0, BUSY_NAP_US * 1000};
    if (!tries) own->busy_ms = srv_clock_now() / 1000000;
    if (srv_clock_now() / 1000000 - own->busy_ms >= own->patience_ms) return 0;
    nanosleep(&nap, NULL);
    return 1;
}

/* the wall clock in microseconds; SQLite's has milliseconds */
static void sqlite_now(sqlite3_context *context, int count, sqlite3_value **value) {
    struct timespec now;
    (void)count, (void)value;
    clock_gettime(CLOCK_REALTIME, &now);
    sqlite3_result_int64(context, (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000);
}

/* Notifies by changing the file's times, which all processes watch. The file is not opened for
 * that, because closing it would release SQLite's locks. */
static void sqlite_ring(sqlite3_context *context, int count, sqlite3_value **value) {
    struct sqlite_sql *own = sqlite3_user_data(context);
    (void)count, (void)value;
    own->ringing = 1;
    sqlite3_result_int(context, 1);
}

PEND_VALIDATOR sqlite_valid(const struct sqlite_sql *own) {
    return own->sql.driver && own->db && own->rollback && own->ear >= -1 && own->patience_ms > 0;
}

static void sqlite_close(struct srv_sql *sql) {
    struct sqlite_sql *own = SRV_CONTAINER_OF(sql, struct sqlite_sql, sql);
    if (own->ear >= 0) close(own->ear);
    for (int i = 0; i < SRV_SQL_STATEMENTS; i++) sqlite3_finalize(own->kept[i]);
    sqlite3_finalize(own->rollback);
    sqlite3_finalize(own->disk.pages);
    sqlite3_finalize(own->disk.unused);
    sqlite3_close(own->db);
    free(own);
}

/* settings of a connection: commits are synced to disk, and readers do not wait for the writer */
static const char *const sqlite_settings =
    "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA temp_store = "
    "MEMORY; PRAGMA journal_size_limit = 4194304;";

/* Creates a new store's file with mode 0600, whatever the umask; SQLite gives the log and its index
 * the same mode. An existing file keeps its mode, which may be wider on purpose. The library
 * reports a file that cannot be created. */
static void sqlite_private(const char *path) {
    int fd = open(path, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
    if (fd >= 0) close(fd);
}

static enum pend_status sqlite_open(struct srv_sql **sql, const char *url, int role,
                                    struct pend_error *error) {
    (void)role;
    const char *path = url + strlen(srv_sql_sqlite.scheme);
    struct sqlite_sql *own = calloc(1, sizeof *own);
    enum pend_status status = PEND_OK;
    char *said = NULL;
    *sql = NULL;
    if (!own) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    own->sql.driver = &srv_sql_sqlite;
    own->ear = -1;
    own->patience_ms = BUSY_MS;
    int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
    if (*path) sqlite_private(path);
    if (!*path) {
        status = pend_fail(
            error, PEND_INVALID, -1, 0,
            "sqlite: needs the path of a file, such as sqlite:/var/lib/pendulumd/store.db");
    } else if (sqlite3_open_v2(path, &own->db, flags, NULL) != SQLITE_OK) {
        status = pend_fail(error, PEND_INVALID, -1, 0, "%s cannot be opened: %s", path,
                           own->db ? sqlite3_errmsg(own->db) : "out of memory");
    } else {
        sqlite3_extended_result_codes(own->db, 1);
        sqlite3_busy_handler(own->db, sqlite_busy, own);
        /* a file of unknown origin: its triggers cannot call unsafe functions, views are off, and
         * the schema is read-only; operators may use plain triggers for audits (tests/drill does)
         */
        int code = sqlite3_db_config(own->db, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL) |
                   sqlite3_db_config(own->db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL) |
                   sqlite3_db_config(own->db, SQLITE_DBCONFIG_ENABLE_VIEW, 0, NULL);
        if (code != SQLITE_OK ||
            sqlite3_create_function(own->db, "now_us", 0, SQLITE_UTF8, NULL, sqlite_now, NULL,
                                    NULL) != SQLITE_OK ||
            sqlite3_create_function(own->db, "ring", 0, SQLITE_UTF8, own, sqlite_ring, NULL,
                                    NULL) != SQLITE_OK ||
            sqlite3_exec(own->db, sqlite_settings, NULL, NULL, &said) != SQLITE_OK ||
            sqlite3_prepare_v2(own->db, "ROLLBACK", -1, &own->rollback, NULL) != SQLITE_OK ||
            srv_sqlite_disk_open(&own->disk, own->db) != SQLITE_OK)
            status = pend_fail(error, PEND_INVALID, -1, 0, "%s is not a store: %s", path,
                               said ? said : sqlite3_errmsg(own->db));
    }
    sqlite3_free(said);
    if (status == PEND_OK)
        *sql = &own->sql;
    else
        sqlite_close(&own->sql);
    return status;
}

static enum srv_stored sqlite_result(struct sqlite_sql *own, int code) {
    if (code == SQLITE_OK || code == SQLITE_ROW || code == SQLITE_DONE) return SRV_STORED;
    srv_sql_complain(&own->sql,
                     code == SQLITE_FULL ? sqlite3_errstr(code) : sqlite3_errmsg(own->db));
    /* the addition of a number to NULL, in an altered row */
    if (code == SQLITE_CONSTRAINT_NOTNULL) return SRV_STORED_DAMAGED;
    switch (code & 0xff) {
    case SQLITE_FULL:
        return SRV_STORED_FULL;
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_CONSTRAINT:
        return SRV_STORED_AGAIN;
    /* some file systems report a short write instead of "no space" */
    case SQLITE_IOERR:
        return code == SQLITE_IOERR_WRITE || code == SQLITE_IOERR_SHMSIZE ? SRV_STORED_FULL
                                                                          : SRV_STORED_AWAY;
    case SQLITE_CANTOPEN:
        return SRV_STORED_AWAY;
    default:
        return SRV_STORED_BROKEN;
    }
}

static int sqlite_bind(sqlite3_stmt *statement, const struct srv_value value[], int count) {
    assert(count >= 0 && count <= SRV_SQL_PARAMETERS);
    int code = SQLITE_OK;
    for (int i = 0; i < count && code == SQLITE_OK; i++) {
        char name[16];
        snprintf(name, sizeof name, "$%d", i + 1);
        int at = sqlite3_bind_parameter_index(statement, name);
        if (!at) continue;
        switch (value[i].kind) {
        case SRV_SQL_NULL:
            code = sqlite3_bind_null(statement, at);
            break;
        case SRV_SQL_WHOLE:
            code = sqlite3_bind_int64(statement, at, value[i].whole);
            break;
        case SRV_SQL_STRING:
            code = sqlite3_bind_text(statement, at, value[i].data, -1, SQLITE_STATIC);
            break;
        case SRV_SQL_BYTES:
            code = sqlite3_bind_blob64(statement, at, value[i].bytes ? value[i].data : "",
                                       value[i].bytes, SQLITE_STATIC);
            break;
        }
    }
    return code;
}

static void sqlite_fields(sqlite3_stmt *statement, struct srv_value field[], int count) {
    for (int i = 0; i < count; i++) {
        struct srv_value *value = &field[i];
        *value = (struct srv_value){0};
        switch (sqlite3_column_type(statement, i)) {
        case SQLITE_INTEGER:
            value->kind = SRV_SQL_WHOLE;
            value->whole = sqlite3_column_int64(statement, i);
            break;
        case SQLITE_TEXT:
            value->kind = SRV_SQL_STRING;
            value->data = sqlite3_column_text(statement, i);
            break;
        case SQLITE_BLOB:
            value->kind = SRV_SQL_BYTES;
            value->data = sqlite3_column_blob(statement, i);
            break;
        default:
            break;
        }
        if (value->data) value->bytes = (size_t)sqlite3_column_bytes(statement, i);
    }
}

/* Rolls back a transaction whose commit failed. Left open, it would block all other writers, and
 * the next transaction here. */
static void sqlite_leave(struct sqlite_sql *own) {
    if (sqlite3_get_autocommit(own->db)) return;
    sqlite3_step(own->rollback);
    sqlite3_reset(own->rollback);
}

static void sqlite_before(struct sqlite_sql *own) {
    assert(sqlite_valid(own));
    sqlite_leave(own);
    own->ringing = 0;
    own->patience_ms = CARRY_MS;
    assert(sqlite3_get_autocommit(own->db));
    srv_sqlite_disk_begin(&own->disk, own->full);
    own->patience_ms = BUSY_MS;
    own->full = 0;
}

static int sqlite_prepare(struct sqlite_sql *own, sqlite3_stmt **statement, const char *text,
                          int keep, const struct srv_value value[], int count) {
    int code = SQLITE_OK;
    if (!*statement) {
        char spelt[SRV_SQL_TEXT];
        srv_sql_spell(&srv_sql_sqlite, text, spelt);
        code = sqlite3_prepare_v3(own->db, spelt, -1, keep ? SQLITE_PREPARE_PERSISTENT : 0,
                                  statement, NULL);
    }
    return code == SQLITE_OK ? sqlite_bind(*statement, value, count) : code;
}

/* passes the rows of a statement to `row`, until that returns an error */
static enum srv_stored sqlite_step(struct sqlite_sql *own, sqlite3_stmt *statement, srv_row_fn *row,
                                   void *context) {
    assert(statement);
    struct srv_value field[SRV_SQL_PARAMETERS];
    enum srv_stored stored = SRV_STORED;
    int code = SQLITE_OK, columns = sqlite3_column_count(statement);
    while (stored == SRV_STORED && (code = sqlite3_step(statement)) == SQLITE_ROW)
        if (row && columns <= SRV_SQL_PARAMETERS) {
            sqlite_fields(statement, field, columns);
            stored = row(context, field);
        }
    return stored == SRV_STORED ? sqlite_result(own, code) : stored;
}

static enum srv_stored sqlite_run(struct srv_sql *sql, int id, const char *text,
                                  const struct srv_value value[], int count, srv_row_fn *row,
                                  void *context) {
    struct sqlite_sql *own = SRV_CONTAINER_OF(sql, struct sqlite_sql, sql);
    assert(sqlite_valid(own) && id >= -1 && id < SRV_SQL_STATEMENTS);
    sqlite3_stmt *once = NULL, **statement = id < 0 ? &once : &own->kept[id];
    int code = SQLITE_OK, commit = !strcmp(text, "COMMIT");
    /* SQLite rolls back some failed transactions itself; its message is kept */
    if (!strcmp(text, "ROLLBACK") && sqlite3_get_autocommit(own->db)) return SRV_STORED;
    if (!strcmp(text, "{begin}")) sqlite_before(own);
    if (commit) code = srv_sqlite_disk_take(&own->disk);
    if (code == SQLITE_OK) code = sqlite_prepare(own, statement, text, id >= 0, value, count);
    enum srv_stored stored =
        code == SQLITE_OK ? sqlite_step(own, *statement, row, context) : sqlite_result(own, code);
    if (*statement) {
        sqlite3_reset(*statement);
        sqlite3_clear_bindings(*statement);
    }
    sqlite3_finalize(once);
    if (!strcmp(text, "ROLLBACK")) sqlite_leave(own);
    own->full |= stored == SRV_STORED_FULL;
    if (stored != SRV_STORED || !commit) return stored;
    if (own->ringing) utimensat(AT_FDCWD, sqlite3_db_filename(own->db, "main"), NULL, 0);
    own->ringing = 0;
    own->patience_ms = CARRY_MS;
    srv_sqlite_disk_committed(&own->disk);
    own->patience_ms = BUSY_MS;
    return stored;
}

static enum srv_stored sqlite_post(struct srv_sql *sql, int id, const char *text,
                                   const struct srv_value value[], int count) {
    return strcmp(text, "{look}") ? sqlite_run(sql, id, text, value, count, NULL, NULL)
                                  : SRV_STORED;
}

static int sqlite_room(struct srv_sql *sql, size_t bytes) {
    struct sqlite_sql *own = SRV_CONTAINER_OF(sql, struct sqlite_sql, sql);
    if (srv_sqlite_disk_room(&own->disk, bytes)) return 1;
    own->full = 1;
    srv_sql_complain(sql, "the disk is full except for a reserve to end jobs");
    return 0;
}

static int sqlite_listen(struct srv_sql *sql, int timeout_ms, int wake) {
    (void)wake;
    struct sqlite_sql *own = SRV_CONTAINER_OF(sql, struct sqlite_sql, sql);
    assert(sqlite_valid(own));
    char event[4096];
    int heard = 0;
    if (own->ear < 0) {
        own->ear = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
        if (own->ear < 0 ||
            inotify_add_watch(own->ear, sqlite3_db_filename(own->db, "main"), IN_ATTRIB) < 0)
            return -1;
    }
    struct pollfd waiting = {own->ear, POLLIN, 0};
    if (poll(&waiting, 1, timeout_ms) > 0)
        while (read(own->ear, event, sizeof event) > 0) heard = SRV_RING_ALL;
    return heard;
}

static const struct srv_sql_word sqlite_words[] = {
    // IMMEDIATE, because a transaction that began with a read could not wait for another writer
    {"begin", "BEGIN IMMEDIATE"},
    {"now", "now_us()"},
    {"lock", ""},
    {"skip", ""},
    {"alone", "SELECT 1"},
    {"ring", "ring()"},
    {"ring work", "ring()"},
    {"ring stop", "ring()"},
    {"crowd", "0, 0"},
    {"carries", "0, 0"},
    {"bytes", "BLOB"},
    {"hot", ""},
    {NULL, NULL}};

const struct srv_sql_driver srv_sql_sqlite = {
    .words = sqlite_words,
    .scheme = "sqlite:",
    .batch = 64,
    .lists = 0,
    .open = sqlite_open,
    .close = sqlite_close,
    .run = sqlite_run,
    .post = sqlite_post,
    .room = sqlite_room,
    .listen = sqlite_listen,
};
