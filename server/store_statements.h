/* Every statement on the store's tables, in the dialect that both databases share.
 * Leaves to others: the tables (store_schema), what is done with rows (the files of the store), the dialects (sql).
 * Invariant: what comes from outside is a parameter; a statement that may find many rows says how many it takes. */
#ifndef SRV_STORE_STATEMENTS_H
#define SRV_STORE_STATEMENTS_H

#include "server/sql.h"

#define JOB_COLUMNS                                                                                                    \
    "id, client, operation, state, shards, done, created, started, finished, expires, {now}, bytes, message, "         \
    "begun - waiting"
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
      "INSERT INTO clients (name, turn, jobs, bytes, source) VALUES ($1, COALESCE((SELECT MIN(turn) FROM clients "     \
      "WHERE jobs > 0), 0), 1, 0, $2) ON CONFLICT (name) DO UPDATE SET jobs = clients.jobs + 1, turn = CASE "          \
      "WHEN clients.jobs = 0 AND clients.turn < EXCLUDED.turn THEN EXCLUDED.turn ELSE clients.turn END, source = "     \
      "CASE WHEN clients.jobs = 0 AND clients.bytes = 0 THEN EXCLUDED.source ELSE clients.source END "                 \
      "RETURNING jobs, bytes")                                                                                         \
    X(SOURCE, "SELECT CAST(COUNT(*) AS BIGINT), CAST(COALESCE(SUM(jobs), 0) AS BIGINT), CAST(COALESCE(SUM(bytes), 0) " \
              "AS BIGINT) FROM clients WHERE source = $1 AND (jobs > 0 OR bytes > 0)")                                 \
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
    X(KEY_FREE, "UPDATE jobs SET key = NULL WHERE id = $1")                                                            \
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
    X(KEEPERS_OF, "SELECT CAST(COUNT(*) AS BIGINT) FROM keepers WHERE client = $1")                                    \
    X(KEEPERS_FROM, "SELECT CAST(COUNT(*) AS BIGINT) FROM keepers WHERE source = $1")                                  \
    X(KEEPER, "SELECT CAST(COUNT(*) AS BIGINT) FROM keepers WHERE scene = $1 AND client = $2")                         \
    X(KEEPERS, "SELECT CAST(COUNT(*) AS BIGINT) FROM keepers WHERE scene = $1")                                        \
    X(KEEPER_PUT, "INSERT INTO keepers (scene, client, source, bytes) VALUES ($1, $2, $3, $4) ON CONFLICT DO NOTHING") \
    X(KEEPER_REMOVE, "DELETE FROM keepers WHERE scene = $1 AND client = $2")                                           \
    X(SCENE_PUT, "INSERT INTO scenes (id, client, body, created) VALUES ($1, '', $2, {now}) ON CONFLICT DO NOTHING "   \
                 "RETURNING created")                                                                                  \
    X(SCENE_LOCK, "SELECT id FROM scenes WHERE id = $1 {lock}")                                                        \
    X(SCENE_SIZE, "SELECT CAST(LENGTH(body) AS BIGINT) FROM scenes WHERE id = $1")                                     \
    X(SCENE_REMOVE, "DELETE FROM scenes WHERE id = $1")                                                                \
    X(SCENE, "SELECT body FROM scenes WHERE id = $1")

enum srv_statement {
#define X(name, text) SQL_##name,
    STATEMENTS(X)
#undef X
        SQL_COUNT
};

/* the LIMITs of SHARDS_LATE and SHARDS_OF, and of RESULTS_REMOVE: as many rows mean that there may be more */
enum { SQL_SHARDS_MOST = 64, SQL_CHUNKS_MOST = 64 };

/* the text of each */
extern const char *const srv_statement_text[SQL_COUNT];

#endif
