/* All SQL statements, in the dialect that both databases share.
 * Leaves to others: the tables (store_schema), processing rows (the other files), dialects (sql).
 * Invariant: external data are parameters only; a statement that may match many rows has a LIMIT
 * and uses an index, so that its cost does not depend on the number of rows. Changes of many jobs
 * in one transaction are statements on rows of values ({from ...} and similar, see sql). */
#pragma once

#include "server/store/sql.h"

/* Each statement, in the dialect that both databases share. */
#define STATEMENTS(X)                                                                              \
    X(BEGIN, "{begin}")                                                                            \
    X(COMMIT, "COMMIT")                                                                            \
    X(ROLLBACK, "ROLLBACK")                                                                        \
    X(FIGURES, "SELECT {crowd}, COALESCE({now} - (SELECT MIN((SELECT created FROM jobs WHERE "     \
               "client = next.name AND ready = 1 ORDER BY rank, created LIMIT 1)) FROM (SELECT "   \
               "name FROM clients WHERE ready > 0 ORDER BY turn, name LIMIT 64) AS next), 0)")     \
    X(CARRIES, "SELECT {carries}")                                                                 \
    X(RING, "SELECT {ring}")                                                                       \
    X(RING_WORK, "SELECT {ring work}")                                                             \
    X(RING_STOP, "SELECT {ring stop}")                                                             \
    X(NOW, "SELECT {now}, (SELECT MAX(version) FROM pendulumd)")                                   \
    X(CLIENT,                                                                                      \
      "SELECT {late jobs}, {late bytes}, scenes, scene_bytes FROM clients WHERE name = $1")        \
    X(CLIENT_CHANGE,                                                                               \
      "INSERT INTO clients (name, turn, jobs, ready, bytes, scenes, scene_bytes, source, weight) " \
      "VALUES ($1, CAST($2 AS BIGINT) + CAST($9 AS BIGINT) - 1 + COALESCE((SELECT {late turn} "    \
      "FROM clients WHERE jobs > 0 ORDER BY turn LIMIT 1), 0), $3, $4, $5, $6, $7, $8, $9) ON "    \
      "CONFLICT (name) DO UPDATE SET jobs = clients.jobs + $3, ready = clients.ready + $4, bytes " \
      "= clients.bytes + $5, scenes = clients.scenes + $6, scene_bytes = clients.scene_bytes + "   \
      "$7, turn = CASE WHEN {late jobs} = 0 AND clients.turn + $2 < EXCLUDED.turn THEN "           \
      "EXCLUDED.turn ELSE clients.turn + $2 END, source = CASE WHEN EXCLUDED.source <> '' AND "    \
      "clients.jobs = 0 AND clients.bytes = 0 THEN EXCLUDED.source ELSE clients.source END, "      \
      "weight = CASE WHEN EXCLUDED.source <> '' THEN EXCLUDED.weight ELSE clients.weight END")     \
    X(SOURCE, "SELECT COUNT(*), {sum jobs}, {sum bytes}, {count jobs > 0} FROM (SELECT {late "     \
              "jobs} AS jobs, {late bytes} AS bytes FROM clients WHERE source = $1 AND (jobs > 0 " \
              "OR bytes > 0) AND {sane jobs} AND {sane bytes}) AS own")                            \
    X(CLIENT_LEAVES, "DELETE FROM clients WHERE name = $1 AND jobs = 0 AND bytes = 0 AND scenes "  \
                     "= 0 AND NOT EXISTS (SELECT 1 FROM changes WHERE changes.name = $1)")         \
    X(CLIENTS, "SELECT name, {late turn}, weight, (SELECT COUNT(*) FROM changes WHERE name = "     \
               "clients.name) FROM clients WHERE ready > 0 AND {late ready} > 0 ORDER BY turn, "   \
               "name LIMIT 8")                                                                     \
    X(CLIENT_WRONG, "SELECT COUNT(*) FROM clients WHERE name = $1 AND {late ready} > 0 AND NOT "   \
                    "EXISTS (SELECT 1 FROM jobs WHERE client = $1 AND ready = 1)")                 \
    X(CLIENT_LATER, "INSERT INTO changes (name, turn, jobs, ready, bytes) SELECT {1}, {2}, {3}, "  \
                    "{4}, {5} {from twwww}")                                                       \
    X(CHANGES_FOLD,                                                                                \
      "WITH gone AS (DELETE FROM changes WHERE ctid = ANY (ARRAY(SELECT ctid FROM changes WHERE "  \
      "name = $1 LIMIT 1024 {skip})) RETURNING *), sums AS (SELECT {sum turn} AS turn, {sum "      \
      "jobs} AS jobs, {sum ready} AS ready, {sum bytes} AS bytes FROM gone WHERE {bounded turn} "  \
      "AND {bounded jobs} AND {bounded ready} AND {bounded bytes}) UPDATE clients SET turn = "     \
      "clients.turn + sums.turn, jobs = clients.jobs + sums.jobs, ready = clients.ready + "        \
      "sums.ready, bytes = clients.bytes + sums.bytes FROM sums WHERE name = $1")                  \
    X(CHANGED, "SELECT name FROM changes WHERE name > $1 ORDER BY name LIMIT 1")                   \
    X(SOON, "SELECT set_config('synchronous_commit', 'off', true)")                                \
    X(CLIENTS_NAMELESS, "DELETE FROM clients WHERE name IS NULL OR LENGTH(name) NOT BETWEEN 1 "    \
                        "AND 95 OR CAST(name AS TEXT) <> name")                                    \
    X(TOTALS,                                                                                      \
      "SELECT {sum accepted}, {sum running}, {sum successful}, {sum failed}, {sum dismissed}, "    \
      "{sum waiting}, {sum bytes}, {sum scenes}, {sum scene_bytes}, (SELECT COUNT(*) FROM "        \
      "totals), COUNT(*) FROM totals WHERE {bounded accepted} AND {bounded running} AND {bounded " \
      "successful} AND {bounded failed} AND {bounded dismissed} AND {bounded waiting} AND "        \
      "{bounded bytes} AND {bounded scenes} AND {bounded scene_bytes}")                            \
    X(TOTALS_CLEAR, "DELETE FROM totals")                                                          \
    X(TOTALS_RECOUNT,                                                                              \
      "INSERT INTO totals SELECT 0, {count state = 0}, {count state = 1}, {count state = 2}, "     \
      "{count state = 3}, {count state = 4}, {sum CASE WHEN ready = 0 THEN 0 WHEN chained = 1 "    \
      "THEN 1 ELSE waiting + parts - begun END}, {sum bytes + held} + (SELECT {sum bytes} FROM "   \
      "removals WHERE {sane bytes}), (SELECT COUNT(*) FROM scenes), (SELECT {sum LENGTH(body) + "  \
      "1024} FROM scenes) FROM jobs WHERE {counted}")                                              \
    X(CLIENT_LOCK, "SELECT jobs FROM clients WHERE name = $1 {lock}")                              \
    X(CLIENT_RECOUNT,                                                                              \
      "UPDATE clients SET jobs = -{pending jobs} + (SELECT COUNT(*) FROM jobs WHERE client = $1 "  \
      "AND state BETWEEN 0 AND 1), ready = -{pending ready} + (SELECT COUNT(*) FROM jobs WHERE "   \
      "client = $1 AND ready = 1), bytes = -{pending bytes} + (SELECT {sum jobs.bytes + held} "    \
      "FROM jobs WHERE client = $1 AND {counted}) + (SELECT {sum removals.bytes} FROM removals "   \
      "WHERE client = $1 AND {sane removals.bytes}), turn = CASE WHEN {sane turn} THEN turn ELSE " \
      "0 END, weight = CASE WHEN {sane weight} AND weight > 0 THEN weight ELSE 1 END, source = "   \
      "COALESCE(source, ''), scenes = (SELECT COUNT(*) FROM keepers WHERE client = $1), "          \
      "scene_bytes = (SELECT {sum keepers.bytes + 1024} FROM keepers WHERE client = $1 AND {sane " \
      "keepers.bytes}) WHERE name = $1")                                                           \
    X(TOTALS_CHANGE,                                                                               \
      "INSERT INTO totals VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10) ON CONFLICT (place) "   \
      "DO UPDATE SET accepted = totals.accepted + $2, running = totals.running + $3, successful "  \
      "= totals.successful + $4, failed = totals.failed + $5, dismissed = totals.dismissed + $6, " \
      "waiting = totals.waiting + $7, bytes = totals.bytes + $8, scenes = totals.scenes + $9, "    \
      "scene_bytes = totals.scene_bytes + $10")                                                    \
    X(JOB_PUT,                                                                                     \
      "INSERT INTO jobs (id, client, operation, request, key, digest, parts, chained, part_us, "   \
      "rank, created, held, seal, title, version) SELECT {1}, {2}, {3}, {4}, {5}, {6}, "           \
      "{7}, {8}, {9}, {10}, {11}, {12}, {13}, {14}, {15} {from tttbtbwwwwwwbtt}")                  \
    X(JOB, "SELECT {job} FROM jobs WHERE id = $1")                                                 \
    X(JOB_LOCK, "SELECT {job} FROM jobs WHERE id = $1 {lock}")                                     \
    X(JOB_OF_KEY, "SELECT {job}, digest FROM jobs WHERE client = $1 AND key = $2")                 \
    X(KEY_FREE, "UPDATE jobs SET key = NULL WHERE id = $1")                                        \
    X(JOB_REQUEST, "SELECT request, seal, state FROM jobs WHERE id = $1")                          \
    X(JOBS_READY, "SELECT {job}, part_us, rank, CASE WHEN waiting > 0 THEN (SELECT COUNT(*) FROM " \
                  "parts WHERE job = jobs.id AND state = 0 AND aside = 1) ELSE 0 END, CASE WHEN "  \
                  "LENGTH(request) <= 4096 THEN request END FROM jobs WHERE client = $1 AND "      \
                  "ready = 1 AND rank >= $3 ORDER BY rank, created LIMIT $2 {skip}")               \
    X(JOB_CLAIM,                                                                                   \
      "UPDATE jobs SET rank = rank - {rank parts - begun} + {rank parts - begun - {3}}, state = "  \
      "1, started = CASE WHEN started = 0 THEN {now} ELSE started END, waiting = waiting - {2}, "  \
      "begun = begun + {3}, ready = CASE WHEN waiting > {2} OR (begun + {3} < parts AND (chained " \
      "= 0 OR begun + {3} = done)) THEN 1 ELSE 0 END {from tww} WHERE id = {1}")                   \
    X(JOB_WAIT, "UPDATE jobs SET waiting = waiting + 1, ready = 1 WHERE id = $1")                  \
    X(JOB_STEP, "UPDATE jobs SET done = done + 1, bytes = bytes + $2, carry = $3, ready = CASE "   \
                "WHEN waiting > 0 OR (begun < parts AND (chained = 0 OR begun = done + 1)) THEN "  \
                "1 ELSE 0 END WHERE id = $1")                                                      \
    X(JOB_SUCCEED,                                                                                 \
      "UPDATE jobs SET state = 2, done = done + 1, bytes = bytes + {2}, carry = NULL, ready = 0, " \
      "waiting = 0, finished = {3}, expires = {4} {from twww} WHERE id = {1}")                     \
    X(JOB_END, "UPDATE jobs SET state = $2, message = $3, finished = $4, expires = $5, held = "    \
               "$6, bytes = 0, ready = 0, waiting = 0, carry = NULL, request = $7 WHERE id = $1")  \
    X(JOB_CONDEMN,                                                                                 \
      "UPDATE jobs SET client = $2, operation = $3, state = 3, message = $4, parts = 1, begun = "  \
      "0, done = 0, title = '', version = '', waiting = 0, chained = 0, carry = "                  \
      "NULL, ready = 0, rank = 0, part_us = 0, created = $5, started = 0, finished = $6, expires " \
      "= $7, bytes = 0, held = $8, request = $9, seal = $10 WHERE id = $1")                        \
    X(JOBS_NAMELESS, "DELETE FROM jobs WHERE (ready = 1 OR expires > 0) AND {nameless id}")        \
    X(REMOVALS_NAMELESS, "DELETE FROM removals WHERE {nameless job}")                              \
    X(JOBS_EXPIRED, "SELECT {job} FROM jobs WHERE expires > 0 AND expires >= $1 AND expires < "    \
                    "{now} ORDER BY expires LIMIT $2 {skip}")                                      \
    X(JOBS_REMOVE, "DELETE FROM jobs {using t} WHERE id = {1}")                                    \
    X(JOBS, "SELECT {job} FROM jobs WHERE client = $1 ORDER BY created DESC, id DESC LIMIT $2")    \
    X(JOB_CREATED, "SELECT created FROM jobs WHERE id = $1 AND client = $2")                       \
    X(JOBS_BEFORE, "SELECT {job} FROM jobs WHERE client = $1 AND (created, id) < ($4, $3) ORDER "  \
                   "BY created DESC, id DESC LIMIT $2")                                            \
    X(REMOVAL_PUT,                                                                                 \
      "INSERT INTO removals (job, client, bytes) VALUES ($1, $2, $3) ON CONFLICT DO NOTHING")      \
    X(REMOVAL_LOST,                                                                                \
      "INSERT INTO removals (job, client, bytes) SELECT $1, 'nobody', 0 WHERE NOT EXISTS (SELECT " \
      "1 FROM jobs WHERE id = $1) ON CONFLICT DO NOTHING")                                         \
    X(REMOVAL,                                                                                     \
      "SELECT job, client, bytes FROM removals WHERE job <> '.' ORDER BY job LIMIT 1 {skip}")      \
    X(REMOVAL_END, "DELETE FROM removals WHERE job = $1")                                          \
    X(LEASE, "SELECT {job}, parts.state, parts.attempt FROM {beside tw} jobs JOIN parts ON "       \
             "parts.job = jobs.id WHERE jobs.id = {1} AND parts.number = {2} {lock}")              \
    X(PART_FIRST, "INSERT INTO parts (job, number, state, attempt, kills, worker, lease, start, "  \
                  "bytes) SELECT {1}, {2}, 1, 1, 0, {3}, {now} + {4}, NULL, 0 {from twtw}")        \
    X(PART_NEXT, "INSERT INTO parts (job, number, state, attempt, kills, worker, lease, start, "   \
                 "bytes) SELECT id, begun, 1, 1, 0, $2, {now} + $3, carry, 0 FROM jobs WHERE id "  \
                 "= $1 ON CONFLICT DO NOTHING RETURNING number, attempt, start")                   \
    X(PART_AGAIN, "UPDATE parts SET state = 1, attempt = attempt + 1, worker = $2, lease = {now} " \
                  "+ $3 WHERE job = $1 AND number = COALESCE((SELECT MIN(number) FROM parts "      \
                  "WHERE job = $1 AND state = 0 AND aside = 0), (SELECT MIN(number) FROM parts "   \
                  "WHERE job = $1 AND state = 0)) RETURNING number, attempt, start")               \
    X(PART_EXTEND,                                                                                 \
      "UPDATE parts SET lease = {now} + $4 WHERE job = $1 AND number = $2 AND attempt = $3 AND "   \
      "state = 1 AND EXISTS (SELECT 1 FROM jobs WHERE id = $1 AND state < 2) RETURNING number")    \
    X(PART_END, "UPDATE parts SET state = 2, bytes = {3}, start = NULL, worker = '' {from tww} "   \
                "WHERE job = {1} AND number = {2}")                                                \
    X(PART_OURS, "SELECT number FROM parts WHERE job = $1 AND number = $2 AND attempt = $3 AND "   \
                 "worker = $4 AND state = 1")                                                      \
    X(PARTS_CLEARED, "UPDATE parts SET kills = 0 WHERE job = $1 AND kills > 0")                    \
    X(PART_BACK,                                                                                   \
      "UPDATE parts SET state = 0, kills = CASE WHEN kills < 99 THEN kills + $3 * aside ELSE "     \
      "kills END, aside = CASE WHEN $3 = 1 THEN 1 ELSE aside END, worker = '' WHERE job = $1 AND " \
      "number = $2 AND state = 1 AND ($3 = 0 OR lease < {now}) RETURNING kills")                   \
    X(PARTS_LATE,                                                                                  \
      "SELECT job, number FROM parts WHERE state = 1 AND lease < $1 ORDER BY lease LIMIT 64")      \
    X(PARTS_OF, "SELECT job, number FROM parts WHERE state = 1 AND worker = $1 LIMIT 64")          \
    X(PARTS_REMOVE, "DELETE FROM parts {using t} WHERE job = {1}")                                 \
    X(PARTS_REMOVE_SOME, "DELETE FROM parts WHERE job = $1 AND number IN (SELECT number FROM "     \
                         "parts WHERE job = $1 ORDER BY number LIMIT 512) RETURNING number")       \
    X(PARTS_HELD_REMOVE, "DELETE FROM parts WHERE job = $1 AND number IN (SELECT number FROM "     \
                         "parts WHERE job = $1 AND state = 1 ORDER BY number LIMIT 512)")          \
    X(RESULT_PUT, "INSERT INTO results (job, part, chunk, data, seal) SELECT {1}, {2}, {3}, {4}, " \
                  "{5} {from twwbb}")                                                              \
    X(RESULT, "SELECT data, seal FROM results WHERE job = $1 AND part = $2 AND chunk = $3")        \
    X(RESULTS, "SELECT part, data, seal FROM results WHERE job = $1 AND part >= $2 AND chunk = 0 " \
               "ORDER BY part LIMIT $3")                                                           \
    X(RESULTS_REMOVE, "DELETE FROM results {using t} WHERE job = {1}")                             \
    X(RESULTS_REMOVE_SOME,                                                                         \
      "DELETE FROM results WHERE job = $1 AND (part, chunk) IN (SELECT part, chunk FROM results "  \
      "WHERE job = $1 ORDER BY part, chunk LIMIT 64) RETURNING chunk")                             \
    X(KEEPERS_FROM, "SELECT COUNT(*) FROM keepers WHERE source = $1")                              \
    X(KEEPER, "SELECT COUNT(*) FROM keepers WHERE scene = $1 AND client = $2")                     \
    X(KEEPERS, "SELECT COUNT(*) FROM keepers WHERE scene = $1")                                    \
    X(KEEPERS_OF, "SELECT scene FROM keepers WHERE client = $1 LIMIT 64")                          \
    X(KEEPER_PUT, "INSERT INTO keepers (scene, client, source, bytes) VALUES ($1, $2, $3, $4)")    \
    X(KEEPER_REMOVE, "DELETE FROM keepers WHERE scene = $1 AND client = $2")                       \
    X(SCENE_PUT, "INSERT INTO scenes (id, body, created, seal) VALUES ($1, $2, {now}, $3) ON "     \
                 "CONFLICT DO NOTHING RETURNING created")                                          \
    X(SCENE_LOCK, "SELECT CAST(LENGTH(body) AS BIGINT) FROM scenes WHERE id = $1 {lock}")          \
    X(SCENE_REMOVE, "DELETE FROM scenes WHERE id = $1")                                            \
    X(SCENE, "SELECT body, seal FROM scenes WHERE id = $1")                                        \
    X(CLASS_PUT, "INSERT INTO classes (code, teacher, key, created, ends, empty_ends, source) "    \
                 "VALUES ($1, $2, $3, $4, $5, $6, $7) ON CONFLICT DO NOTHING RETURNING created")   \
    X(CLASS_OF_KEY, "SELECT code FROM classes WHERE teacher = $1 AND key = $2")                    \
    X(CLASS_COUNT, "SELECT (SELECT COUNT(*) FROM classes), (SELECT COUNT(*) FROM classes WHERE "   \
                   "teacher = $1), (SELECT COUNT(*) FROM classes WHERE source = $2)")              \
    X(CLASSES, "SELECT code FROM classes WHERE (teacher = $1 OR $1 = '') AND code > $2 ORDER BY "  \
               "code LIMIT 64")                                                                    \
    X(CLASS_OF, "SELECT code FROM classes WHERE teacher = $1 UNION ALL SELECT code FROM "          \
                "class_pupils WHERE who = $1 LIMIT 1")                                             \
    X(CLASS_PUPILS_FROM, "SELECT COUNT(*) FROM class_pupils WHERE code = $1 AND source = $2")      \
    X(CLASS_FOLDS, "SELECT fold FROM class_pupils WHERE code = $1 AND fold <> ''")                 \
    X(CLASS, "SELECT {class} FROM classes WHERE code = $1")                                        \
    X(CLASS_LOCK, "SELECT {class} FROM classes WHERE code = $1 {skip}")                            \
    X(CLASS_CHANGE,                                                                                \
      "UPDATE classes SET version = $2, shared = $3, pupils = $4, numbered = $5, bytes = $6, "     \
      "shut = $7, empty_ends = $8, share = $9, near = $10 WHERE code = $1")                        \
    X(CLASS_MARK, "SELECT version, shared FROM classes WHERE code = $1 AND ends > {now} AND "      \
                  "(empty_ends = 0 OR empty_ends > {now})")                                        \
    X(CLASS_PUPIL_PUT, "INSERT INTO class_pupils (code, who, number, bytes, source, fold) VALUES " \
                       "($1, $2, $3, $4, $5, $6)")                                                 \
    X(CLASS_PUPIL_BYTES, "UPDATE class_pupils SET bytes = $3 WHERE code = $1 AND who = $2")        \
    X(CLASS_PUPIL_REMOVE,                                                                          \
      "DELETE FROM class_pupils WHERE code = $1 AND number = $2 RETURNING number")                 \
    X(CLASS_ITEM, "SELECT name, version, reader, flag, changed, body, seal FROM class_items "      \
                  "WHERE code = $1 AND name = $2")                                                 \
    X(CLASS_ITEM_PUT,                                                                              \
      "INSERT INTO class_items (code, name, version, reader, flag, changed, body, seal) VALUES "   \
      "($1, $2, $3, $4, $5, $6, $7, $8) ON CONFLICT (code, name) DO UPDATE SET version = $3, "     \
      "reader = $4, flag = $5, changed = $6, body = $7, seal = $8")                                \
    X(CLASS_ITEMS, "SELECT name, version, reader, flag, changed, body, seal FROM class_items "     \
                   "WHERE code = $1 AND version > $2 ORDER BY version LIMIT 64")                   \
    X(CLASS_ITEMS_OF,                                                                              \
      "SELECT name, version, reader, flag, changed, body, seal FROM class_items WHERE code = $1 "  \
      "AND reader IN (0, $3) AND version > $2 ORDER BY version LIMIT 64")                          \
    X(CLASS_ITEMS_OWN,                                                                             \
      "SELECT name, version, reader, flag, changed, body, seal FROM class_items WHERE code = $1 "  \
      "AND reader = $2 AND version > $3 ORDER BY version LIMIT 64")                                \
    X(CLASSES_NAMELESS, "DELETE FROM classes WHERE ends < $1 AND (code IS NULL OR LENGTH(code) "   \
                        "<> 6 OR CAST(code AS TEXT) <> code)")                                     \
    X(CLASS_ENDED, "SELECT code FROM classes WHERE ends < $1 OR (empty_ends > 0 AND empty_ends < " \
                   "$1) ORDER BY ends LIMIT 1 {skip}")                                             \
    X(CLASS_ITEMS_REMOVE, "DELETE FROM class_items WHERE code = $1")                               \
    X(CLASS_PUPILS_REMOVE, "DELETE FROM class_pupils WHERE code = $1")                             \
    X(CLASS_REMOVE, "DELETE FROM classes WHERE code = $1")

enum srv_statement {
#define X(name, text) SQL_##name,
    STATEMENTS(X)
#undef X
        SQL_COUNT
};

/* The LIMITs of KEEPERS_OF, PARTS_LATE and PARTS_OF, PARTS_REMOVE_SOME and RESULTS_REMOVE_SOME: if
 * a statement returns as many rows, there may be more. Then the most rows of JOBS_EXPIRED: 512
 * would delay submits to PostgreSQL during a sweep, for little gain. */
enum {
    SQL_KEPT_MOST = 64,
    SQL_PARTS_MOST = 64,
    SQL_PARTS_REMOVED = 512,
    SQL_CHUNKS_MOST = 64,
    SQL_EXPIRED_MOST = 128,
    SQL_CLASS_ITEMS_MOST = 64, /* LIMIT of CLASS_ITEMS, _OF and _OWN */
    SQL_CLASSES_MOST = 64
};

/* the text of each statement */
extern const char *const srv_statement_text[SQL_COUNT];
