#include "server/store/store_schema.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "server/store/store_rows.h"

/* SRV_ROW_BYTES and SRV_PART_BYTES */
#define ROW_BYTES "1024"
#define PART_BYTES "256"

/* The tables, version by version; a statement each, NULL between versions; $1 is no bytes. */
static const char *const schema[] = {
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
    "CREATE INDEX scenes_client ON scenes (client)", NULL,
    /* 2: from which address or account a client's things came; who keeps a scene. Scenes of
     * before have a keeper that nobody is, so that they are kept for ever as they were promised;
     * the addresses of who made them go. */
    "ALTER TABLE clients ADD COLUMN source TEXT NOT NULL DEFAULT ''",
    "CREATE INDEX clients_source ON clients (source)",
    "CREATE TABLE keepers (scene TEXT NOT NULL, client TEXT NOT NULL, source TEXT NOT NULL, bytes "
    "BIGINT NOT NULL, "
    "PRIMARY KEY (scene, client))",
    "INSERT INTO keepers (scene, client, source, bytes) SELECT id, '', '', LENGTH(body) FROM "
    "scenes",
    "CREATE INDEX keepers_client ON keepers (client)",
    "CREATE INDEX keepers_source ON keepers (source)", "DROP INDEX scenes_client",
    "UPDATE scenes SET client = ''", NULL,
    /* 3: sums are kept, not counted; requests, rows and scenes are counted as well; results of
     * jobs that ended without success wait for their removal in a table of their own; short jobs
     * go before long ones */
    "CREATE TABLE totals (place BIGINT PRIMARY KEY, accepted BIGINT NOT NULL, running BIGINT NOT "
    "NULL, "
    "successful BIGINT NOT NULL, failed BIGINT NOT NULL, dismissed BIGINT NOT NULL, waiting BIGINT "
    "NOT NULL, "
    "bytes BIGINT NOT NULL, scenes BIGINT NOT NULL, scene_bytes BIGINT NOT NULL) {hot}",
    "CREATE TABLE removals (job TEXT PRIMARY KEY, client TEXT NOT NULL, bytes BIGINT NOT NULL)",
    /* a row that stays, so that the table has a page already where a full disk is to be emptied */
    "INSERT INTO removals (job, client, bytes) VALUES ('.', '.', 0)",
    "INSERT INTO removals (job, client, bytes) SELECT id, client, bytes FROM jobs WHERE state >= 3 "
    "AND bytes > 0",
    "DROP INDEX jobs_unclean", "DROP INDEX jobs_ready",
    "ALTER TABLE jobs RENAME COLUMN turn TO rank",
    "ALTER TABLE jobs ADD COLUMN part BIGINT NOT NULL DEFAULT 0",
    "ALTER TABLE jobs ADD COLUMN held BIGINT NOT NULL DEFAULT 0",
    "UPDATE jobs SET rank = created, held = " ROW_BYTES " + LENGTH(request) + " PART_BYTES
    " * (shards - 1) WHERE state < 3",
    "UPDATE jobs SET rank = created, held = " ROW_BYTES
    ", bytes = 0, request = $1 WHERE state >= 3",
    "CREATE INDEX jobs_ready ON jobs (client, rank, created) WHERE ready = 1",
    "ALTER TABLE clients ADD COLUMN ready BIGINT NOT NULL DEFAULT 0",
    "ALTER TABLE clients ADD COLUMN scenes BIGINT NOT NULL DEFAULT 0",
    "ALTER TABLE clients ADD COLUMN scene_bytes BIGINT NOT NULL DEFAULT 0",
    "INSERT INTO clients (name, turn, jobs, bytes, source) SELECT client, 0, 0, 0, MIN(source) "
    "FROM keepers "
    "WHERE client <> '' AND client NOT IN (SELECT name FROM clients) GROUP BY client",
    "UPDATE clients SET ready = (SELECT COUNT(*) FROM jobs WHERE client = name AND ready = 1), "
    "bytes = "
    "COALESCE((SELECT CAST(SUM(jobs.bytes + jobs.held) AS BIGINT) FROM jobs WHERE jobs.client = "
    "name), 0) + "
    "COALESCE((SELECT CAST(SUM(removals.bytes) AS BIGINT) FROM removals WHERE removals.client = "
    "name), 0), "
    "scenes = (SELECT COUNT(*) FROM keepers WHERE keepers.client = name), scene_bytes = "
    "COALESCE((SELECT "
    "CAST(SUM(keepers.bytes + " ROW_BYTES
    ") AS BIGINT) FROM keepers WHERE keepers.client = name), 0)",
    "INSERT INTO totals (place, accepted, running, successful, failed, dismissed, waiting, bytes, "
    "scenes, scene_bytes) "
    "SELECT 0, COALESCE(SUM(CASE WHEN state = 0 THEN 1 ELSE 0 END), 0), "
    "COALESCE(SUM(CASE WHEN state = 1 THEN 1 ELSE 0 END), 0), COALESCE(SUM(CASE WHEN state = 2 "
    "THEN 1 ELSE 0 END), 0), "
    "COALESCE(SUM(CASE WHEN state = 3 THEN 1 ELSE 0 END), 0), COALESCE(SUM(CASE WHEN state = 4 "
    "THEN 1 ELSE 0 END), 0), "
    "CAST(COALESCE(SUM(CASE WHEN ready = 0 THEN 0 WHEN chained = 1 THEN 1 ELSE waiting + shards - "
    "begun END), 0) AS "
    "BIGINT), (SELECT CAST(COALESCE(SUM(bytes), 0) AS BIGINT) FROM clients), (SELECT COUNT(*) FROM "
    "scenes), "
    "(SELECT CAST(COALESCE(SUM(LENGTH(body) + " ROW_BYTES "), 0) AS BIGINT) FROM scenes) FROM jobs",
    "CREATE INDEX clients_ready ON clients (turn, name) WHERE ready > 0",
    "CREATE INDEX clients_open ON clients (turn) WHERE jobs > 0", NULL,
    /* 4: how many turns a claim counts for, so that many clients of one address take few */
    "ALTER TABLE clients ADD COLUMN weight BIGINT NOT NULL DEFAULT 1", NULL,
    /* 5: what tells that a chunk of results is what was written; NULL with those of before */
    "ALTER TABLE results ADD COLUMN seal {bytes}", NULL,
    /* 6: jobs and scenes have seals as well, and those of results know their job; `sealed` is 1
     * in every row that is written from now on, so that a seal that went missing is told from
     * one that never was */
    "ALTER TABLE results ADD COLUMN sealed BIGINT NOT NULL DEFAULT 0",
    "ALTER TABLE jobs ADD COLUMN seal {bytes}",
    "ALTER TABLE jobs ADD COLUMN sealed BIGINT NOT NULL DEFAULT 0",
    "ALTER TABLE scenes ADD COLUMN seal {bytes}",
    "ALTER TABLE scenes ADD COLUMN sealed BIGINT NOT NULL DEFAULT 0", NULL,
    /* 7: rooms in which a class works together, who is in them, and what stands there */
    "CREATE TABLE classes (code TEXT PRIMARY KEY, teacher TEXT NOT NULL, key TEXT, created BIGINT "
    "NOT NULL, ends BIGINT NOT NULL, version BIGINT NOT NULL DEFAULT 0, shared BIGINT NOT NULL "
    "DEFAULT 0, pupils BIGINT NOT NULL DEFAULT 0, numbered BIGINT NOT NULL DEFAULT 0, bytes BIGINT "
    "NOT NULL DEFAULT 0, shut BIGINT NOT NULL DEFAULT 0) {hot}",
    "CREATE UNIQUE INDEX classes_key ON classes (teacher, key) WHERE key IS NOT NULL",
    "CREATE INDEX classes_ends ON classes (ends)",
    "CREATE TABLE class_pupils (code TEXT NOT NULL, who TEXT NOT NULL, number BIGINT NOT NULL, "
    "bytes BIGINT NOT NULL, PRIMARY KEY (code, who))",
    "CREATE UNIQUE INDEX class_pupils_number ON class_pupils (code, number)",
    "CREATE TABLE class_items (code TEXT NOT NULL, name TEXT NOT NULL, version BIGINT NOT NULL, "
    "reader BIGINT NOT NULL, flag BIGINT NOT NULL, changed BIGINT NOT NULL, body {bytes} NOT NULL, "
    "seal {bytes} NOT NULL, PRIMARY KEY (code, name))",
    "CREATE INDEX class_items_version ON class_items (code, version)",
    "CREATE INDEX class_items_reader ON class_items (code, reader, version)", NULL,
    /* 8: what a client calls its job, and the version of the program that took it in; '' with those
     * of before */
    "ALTER TABLE jobs ADD COLUMN title TEXT NOT NULL DEFAULT ''",
    "ALTER TABLE jobs ADD COLUMN version TEXT NOT NULL DEFAULT ''", NULL,
    /* 9: whom a job's end is told, and how that went: enum srv_notify, how often it was tried, and
     * the status of the last answer. A hook is here until it was delivered or given up; it is due
     * from the end of its job on, and again when the one who tries should long have said how it
     * went */
    "ALTER TABLE jobs ADD COLUMN notify BIGINT NOT NULL DEFAULT 0",
    "ALTER TABLE jobs ADD COLUMN notify_attempts BIGINT NOT NULL DEFAULT 0",
    "ALTER TABLE jobs ADD COLUMN notify_status BIGINT NOT NULL DEFAULT 0",
    "CREATE TABLE hooks (job TEXT PRIMARY KEY, client TEXT NOT NULL, url TEXT NOT NULL, due BIGINT "
    "NOT NULL DEFAULT 0, "
    "attempts BIGINT NOT NULL DEFAULT 0)",
    "CREATE INDEX hooks_due ON hooks (due) WHERE due > 0", NULL,
    /* 10: of a class room: the marks of the address that made it and of the one from which its
     * teacher wrote last, when it ends while nobody has
     * joined (0 = not before `ends`), and how many pupils one address may have there (0 = as
     * many as by default); of a pupil: the mark of the address, and the folded nickname. Whose
     * rooms they are and from where is asked as one is made, who is where as a client is erased */
    "ALTER TABLE classes ADD COLUMN source TEXT NOT NULL DEFAULT ''",
    "ALTER TABLE classes ADD COLUMN near TEXT NOT NULL DEFAULT ''",
    "ALTER TABLE classes ADD COLUMN empty_ends BIGINT NOT NULL DEFAULT 0",
    "ALTER TABLE classes ADD COLUMN share BIGINT NOT NULL DEFAULT 0",
    "ALTER TABLE class_pupils ADD COLUMN source TEXT NOT NULL DEFAULT ''",
    "ALTER TABLE class_pupils ADD COLUMN fold TEXT NOT NULL DEFAULT ''",
    "CREATE INDEX classes_teacher ON classes (teacher)",
    "CREATE INDEX classes_source ON classes (source)",
    "CREATE INDEX class_pupils_who ON class_pupils (who)", NULL,
    /* 11: changes of clients' sums that are not in their rows yet; whether a part is computed alone
     * in a process, because one that held it with others has ended */
    "CREATE TABLE changes (name TEXT NOT NULL, turn BIGINT NOT NULL, jobs BIGINT NOT NULL, ready "
    "BIGINT NOT NULL, bytes BIGINT NOT NULL)",
    "CREATE INDEX changes_name ON changes (name)",
    "ALTER TABLE shards ADD COLUMN aside BIGINT NOT NULL DEFAULT 0", NULL};

/* the tables' version; -1 where none is written */
static enum srv_stored schema_read(struct srv_sql *sql, int64_t *version) {
    struct srv_row_wholes row = {.count = 1};
    SRV_STORED_TRY(
        sql->driver->run(sql, -1, "SELECT version FROM pendulumd", NULL, 0, srv_row_wholes, &row));
    *version = row.rows ? row.whole[0] : -1;
    if (!row.flawed) return SRV_STORED;
    srv_sql_complain(sql, "the version of its tables, in the table pendulumd, is damaged");
    return SRV_STORED_BROKEN;
}

static enum srv_stored schema_version(struct srv_sql *sql, int64_t *version) {
    SRV_STORED_TRY(
        sql->driver->run(sql, -1, "CREATE TABLE IF NOT EXISTS pendulumd (version BIGINT NOT NULL)",
                         NULL, 0, NULL, NULL));
    SRV_STORED_TRY(schema_read(sql, version));
    if (*version >= 0) return SRV_STORED;
    *version = 0;
    return sql->driver->run(sql, -1, "INSERT INTO pendulumd (version) VALUES (0)", NULL, 0, NULL,
                            NULL);
}

/* brings the tables to this version's, in one transaction */
static enum srv_stored schema_migrate(struct srv_sql *sql, int64_t *version) {
    SRV_STORED_TRY(sql->driver->run(sql, -1, "{begin}", NULL, 0, NULL, NULL));
    enum srv_stored stored = sql->driver->run(sql, -1, "{alone}", NULL, 0, NULL, NULL);
    if (stored == SRV_STORED) stored = schema_version(sql, version);
    struct srv_value none = srv_value_bytes("", 0);
    int at = 0;
    for (int64_t v = 0; v < SRV_SCHEMA && stored == SRV_STORED; v++, at++)
        for (; schema[at] && stored == SRV_STORED; at++)
            if (v >= *version)
                stored = sql->driver->run(sql, -1, schema[at], &none, !!strstr(schema[at], "$1"),
                                          NULL, NULL);
    if (stored == SRV_STORED && *version < SRV_SCHEMA) {
        struct srv_value value[] = {srv_value_whole(SRV_SCHEMA)};
        stored =
            sql->driver->run(sql, -1, "UPDATE pendulumd SET version = $1", value, 1, NULL, NULL);
    }
    if (stored == SRV_STORED) stored = sql->driver->run(sql, -1, "COMMIT", NULL, 0, NULL, NULL);
    if (stored == SRV_STORED) return SRV_STORED;
    // what went wrong is what is told, not that nothing was left to roll back
    char complaint[SRV_SQL_COMPLAINT], text[2 * SRV_SQL_COMPLAINT];
    memcpy(complaint, sql->complaint, sizeof complaint);
    sql->driver->run(sql, -1, "ROLLBACK", NULL, 0, NULL, NULL);
    memcpy(sql->complaint, complaint, sizeof complaint);
    if (stored != SRV_STORED_BROKEN) return stored;
    snprintf(text, sizeof text,
             "tables that say they are of version %lld cannot be brought to version %d: %s",
             (long long)*version, SRV_SCHEMA, complaint);
    srv_sql_complain(sql, text);
    return stored;
}

enum srv_stored srv_schema_newer(struct srv_sql *sql, int64_t version) {
    assert(version > SRV_SCHEMA);
    char text[SRV_SQL_COMPLAINT];
    snprintf(text, sizeof text, "the store is of version %lld, this program knows up to %d",
             (long long)version, SRV_SCHEMA);
    srv_sql_complain(sql, text);
    return SRV_STORED_BROKEN;
}

enum srv_stored srv_schema_settle(struct srv_sql *sql) {
    int64_t version = 0;
    // tables that are as they should be are only read: whoever starts waits for nobody who writes
    if (schema_read(sql, &version) != SRV_STORED || version < SRV_SCHEMA)
        SRV_STORED_TRY(schema_migrate(sql, &version));
    return version > SRV_SCHEMA ? srv_schema_newer(sql, version) : SRV_STORED;
}
