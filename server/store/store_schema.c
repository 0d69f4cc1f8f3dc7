#include "server/store/store_tally.h"

#include <assert.h>
#include <stdio.h>

#include "server/store/store_rows.h"

static const char *const schema[] = {
    /* source: address or account of the client; turn: order of its next claim; weight: turns per
     * claim; sums: open jobs, jobs with claimable parts, stored bytes, scenes */
    "CREATE TABLE clients (name TEXT PRIMARY KEY, source TEXT NOT NULL, turn BIGINT NOT NULL, "
    "weight BIGINT NOT NULL, jobs BIGINT NOT NULL, ready BIGINT NOT NULL, bytes BIGINT NOT NULL, "
    "scenes BIGINT NOT NULL, scene_bytes BIGINT NOT NULL)",
    "CREATE INDEX clients_source ON clients (source)",
    "CREATE INDEX clients_ready ON clients (turn, name) WHERE ready > 0",
    "CREATE INDEX clients_open ON clients (turn) WHERE jobs > 0",
    /* pending changes of clients' sums */
    "CREATE TABLE changes (name TEXT NOT NULL, turn BIGINT NOT NULL, jobs BIGINT NOT NULL, ready "
    "BIGINT NOT NULL, bytes BIGINT NOT NULL)",
    "CREATE INDEX changes_name ON changes (name)",
    /* the sums of all clients; several rows that are added up */
    "CREATE TABLE totals (place BIGINT PRIMARY KEY, accepted BIGINT NOT NULL, running BIGINT NOT "
    "NULL, successful BIGINT NOT NULL, failed BIGINT NOT NULL, dismissed BIGINT NOT NULL, waiting "
    "BIGINT NOT NULL, bytes BIGINT NOT NULL, scenes BIGINT NOT NULL, scene_bytes BIGINT NOT NULL) {"
    "hot}",
    "INSERT INTO totals VALUES (0, 0, 0, 0, 0, 0, 0, 0, 0, 0)",
    /* begun: parts that have been claimed at least once; waiting: those of them that are neither
     * done nor held; carry: checkpoint for the next part of a chained job; ready: a part can be
     * claimed; rank: srv_store_rank; part_us: estimated time of a part; held: bytes counted for the
     * row and the request; version: of the program that accepted the job */
    "CREATE TABLE jobs (id TEXT PRIMARY KEY, client TEXT NOT NULL, operation TEXT NOT NULL, title "
    "TEXT NOT NULL, version TEXT NOT NULL, request {bytes} NOT NULL, seal {bytes} NOT NULL, key "
    "TEXT, digest {bytes} NOT NULL, state BIGINT NOT NULL DEFAULT 0, parts BIGINT NOT NULL, begun "
    "BIGINT NOT NULL DEFAULT 0, done BIGINT NOT NULL DEFAULT 0, waiting BIGINT NOT NULL DEFAULT 0, "
    "chained BIGINT NOT NULL, carry {bytes}, ready BIGINT NOT NULL DEFAULT 1, rank BIGINT NOT NULL,"
    " part_us BIGINT NOT NULL, created BIGINT NOT NULL, started BIGINT NOT NULL DEFAULT 0, "
    "finished BIGINT NOT NULL DEFAULT 0, expires BIGINT NOT NULL DEFAULT 0, bytes BIGINT NOT NULL "
    "DEFAULT 0, held BIGINT NOT NULL, message TEXT NOT NULL DEFAULT '')",
    "CREATE UNIQUE INDEX jobs_key ON jobs (client, key) WHERE key IS NOT NULL",
    "CREATE INDEX jobs_ready ON jobs (client, rank, created) WHERE ready = 1",
    "CREATE INDEX jobs_client ON jobs (client, created, id)",
    "CREATE INDEX jobs_expires ON jobs (expires) WHERE expires > 0",
    /* kills: workers that died while they computed only this part; aside: compute it alone, because
     * a worker died while it held this and other parts */
    "CREATE TABLE parts (job TEXT NOT NULL, number BIGINT NOT NULL, state BIGINT NOT NULL, attempt "
    "BIGINT NOT NULL, kills BIGINT NOT NULL, aside BIGINT NOT NULL DEFAULT 0, worker TEXT NOT NULL,"
    " lease BIGINT NOT NULL, start {bytes}, bytes BIGINT NOT NULL, PRIMARY KEY (job, number))",
    "CREATE INDEX parts_lease ON parts (lease) WHERE state = 1",
    "CREATE INDEX parts_marked ON parts (job) WHERE kills > 0",
    "CREATE INDEX parts_waiting ON parts (job, number) WHERE state = 0",
    "CREATE TABLE results (job TEXT NOT NULL, part BIGINT NOT NULL, chunk BIGINT NOT NULL, data {"
    "bytes} NOT NULL, seal {bytes} NOT NULL, PRIMARY KEY (job, part, chunk))",
    /* results of unsuccessful jobs until they are deleted; the row '.' is kept so that the table
     * has a page even when a full disk must be emptied */
    "CREATE TABLE removals (job TEXT PRIMARY KEY, client TEXT NOT NULL, bytes BIGINT NOT NULL)",
    "INSERT INTO removals (job, client, bytes) VALUES ('.', '.', 0)",
    "CREATE TABLE scenes (id TEXT PRIMARY KEY, body {bytes} NOT NULL, created BIGINT NOT NULL, "
    "seal {bytes} NOT NULL)",
    "CREATE TABLE keepers (scene TEXT NOT NULL, client TEXT NOT NULL, source TEXT NOT NULL, bytes "
    "BIGINT NOT NULL, PRIMARY KEY (scene, client))",
    "CREATE INDEX keepers_client ON keepers (client)",
    "CREATE INDEX keepers_source ON keepers (source)",
    /* source: digest bits of the address that created the room; near: of the address of its
     * teacher's last write; empty_ends: expiry while no pupil has joined (0 = at `ends`); share:
     * most pupils of one address (0 = the default) */
    "CREATE TABLE classes (code TEXT PRIMARY KEY, teacher TEXT NOT NULL, key TEXT, source TEXT NOT "
    "NULL, near TEXT NOT NULL DEFAULT '', created BIGINT NOT NULL, ends BIGINT NOT NULL, "
    "empty_ends BIGINT NOT NULL, version BIGINT NOT NULL DEFAULT 0, shared BIGINT NOT NULL DEFAULT "
    "0, pupils BIGINT NOT NULL DEFAULT 0, numbered BIGINT NOT NULL DEFAULT 0, share BIGINT NOT "
    "NULL DEFAULT 0, bytes BIGINT NOT NULL DEFAULT 0, shut BIGINT NOT NULL DEFAULT 0) {hot}",
    "CREATE UNIQUE INDEX classes_key ON classes (teacher, key) WHERE key IS NOT NULL",
    "CREATE INDEX classes_ends ON classes (ends)",
    "CREATE INDEX classes_teacher ON classes (teacher)",
    "CREATE INDEX classes_source ON classes (source)",
    /* fold: the folded nickname */
    "CREATE TABLE class_pupils (code TEXT NOT NULL, who TEXT NOT NULL, number BIGINT NOT NULL, "
    "bytes BIGINT NOT NULL, source TEXT NOT NULL, fold TEXT NOT NULL, PRIMARY KEY (code, who))",
    "CREATE UNIQUE INDEX class_pupils_number ON class_pupils (code, number)",
    "CREATE INDEX class_pupils_who ON class_pupils (who)",
    "CREATE TABLE class_items (code TEXT NOT NULL, name TEXT NOT NULL, version BIGINT NOT NULL, "
    "reader BIGINT NOT NULL, flag BIGINT NOT NULL, changed BIGINT NOT NULL, body {bytes} NOT NULL, "
    "seal {bytes} NOT NULL, PRIMARY KEY (code, name))",
    "CREATE INDEX class_items_version ON class_items (code, version)",
    "CREATE INDEX class_items_reader ON class_items (code, reader, version)",
    "INSERT INTO pendulumd (version) VALUES (1)"};

static_assert(SRV_SCHEMA == 1, "the last statement says so");

static enum srv_stored schema_run(struct srv_sql *sql, const char *text) {
    return sql->driver->run(sql, -1, text, NULL, 0, NULL, NULL);
}

/* reads the schema version; 0 if there is none */
static enum srv_stored schema_read(struct srv_sql *sql, int64_t *version) {
    struct srv_row_wholes row = {.count = 1};
    SRV_STORED_TRY(
        sql->driver->run(sql, -1, "SELECT version FROM pendulumd", NULL, 0, srv_row_wholes, &row));
    *version = row.whole[0];
    if (!row.flawed && (!row.rows || *version > 0)) return SRV_STORED;
    srv_sql_complain(sql, "the version of its tables, in the table pendulumd, is damaged");
    return SRV_STORED_BROKEN;
}

static enum srv_stored schema_make(struct srv_sql *sql, int64_t *version) {
    SRV_STORED_TRY(schema_run(sql, "{alone}"));
    SRV_STORED_TRY(
        schema_run(sql, "CREATE TABLE IF NOT EXISTS pendulumd (version BIGINT NOT NULL)"));
    SRV_STORED_TRY(schema_read(sql, version));
    if (*version) return SRV_STORED;
    *version = SRV_SCHEMA;
    for (size_t i = 0; i < sizeof schema / sizeof *schema; i++)
        SRV_STORED_TRY(schema_run(sql, schema[i]));
    return SRV_STORED;
}

enum srv_stored srv_schema_other(struct srv_sql *sql, int64_t version) {
    assert(version != SRV_SCHEMA);
    char text[SRV_SQL_COMPLAINT];
    snprintf(text, sizeof text, "the store has version %lld, but this program needs version %d",
             (long long)version, SRV_SCHEMA);
    srv_sql_complain(sql, text);
    return SRV_STORED_BROKEN;
}

enum srv_stored srv_schema_settle(struct srv_sql *sql) {
    int64_t version = 0;
    /* existing tables are only read, so that a start does not wait for writers */
    if (schema_read(sql, &version) != SRV_STORED || !version) {
        SRV_STORED_TRY(schema_run(sql, "{begin}"));
        enum srv_stored stored = schema_make(sql, &version);
        if (stored == SRV_STORED) stored = schema_run(sql, "COMMIT");
        if (stored != SRV_STORED) schema_run(sql, "ROLLBACK");
        SRV_STORED_TRY(stored);
    }
    return version == SRV_SCHEMA ? SRV_STORED : srv_schema_other(sql, version);
}
