/* Rows that are the same for all clients, altered in every way: the sums of everything stored, and
 * the version of the tables. Impossible values are found and recounted, or refused with a reason;
 * nothing stored is lost. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/store/store_tally.h"
#include "tests/server/ground.h"
#include "tests/server/live.h"

/* values that replace a number, and whether they can be recognized as wrong */
static const struct {
    const char *name, *sqlite, *postgres;
    int told;
} sums_way[] = {
    {"null", "NULL", "NULL", 1},
    {"negative", "-1000000", "-1000000", 1},
    {"possible", "2000000", "2000000", 0},
    {"most", "9223372036854775807", "9223372036854775807", 1},
    {"least", "-9223372036854775807", "-9223372036854775807", 1},
    {"word", "'word'", "'word'", 1},
    {"empty", "''", "''", 1},
    {"long", "replace(hex(zeroblob(50000)), '0', 'x')", "repeat('x', 100000)", 1},
    {"bytes", "X'00ff00'", "'\\x00ff00'::bytea", 1},
    {"real", "0.5e300", "0.5e300", 1},
};
enum { WAYS = sizeof sums_way / sizeof *sums_way };

static struct srv_sql *sums_connect(const struct ground *ground) {
    const struct srv_sql_driver *driver = ground->postgres ? &srv_sql_postgres : &srv_sql_sqlite;
    struct pend_error error;
    struct srv_sql *sql = NULL;
    CHECK_SAYING(driver->open(&sql, ground->url, 0, &error) == PEND_OK, "%s", error.text);
    if (!sql || ground->postgres) return sql;
    CHECK(driver->run(sql, -1, "PRAGMA synchronous = OFF", NULL, 0, NULL, NULL) == SRV_STORED);
    return sql;
}

static int sums_run(struct srv_sql *sql, const char *text) {
    return sql->driver->run(sql, -1, text, NULL, 0, NULL, NULL) == SRV_STORED;
}

/* --- the sums --- */

/* a call that may have to be repeated while sums are recounted */
#define SUMS_CALL(what, call)                                                                      \
    do {                                                                                           \
        enum srv_stored stored_ = SRV_STORED_AGAIN;                                                \
        for (int tries_ = 0; stored_ == SRV_STORED_AGAIN && tries_ < 5; tries_++)                  \
            stored_ = (call);                                                                      \
        CHECK_SAYING(stored_ == SRV_STORED, "%s: %s is %d %s", what, #call, stored_,               \
                     srv_store_complaint(store));                                                  \
    } while (0)

/* a job from its beginning to its end, and a scene */
static void sums_live(struct srv_store *store, const char *id, const char *what) {
    struct srv_store_figures figures;
    struct srv_lease lease = {.attempt = 0};
    struct srv_job job;
    SUMS_CALL(what, ground_submit(store, id, "anna", NULL, 1, 0, &job));
    SUMS_CALL(what, ground_claim(store, "w", 60 * (int64_t)SECOND, &lease));
    SUMS_CALL(what, srv_store_finish(store, &lease, "data", 4, NULL, 0));
    srv_lease_clear(&lease);
    SUMS_CALL(what, srv_store_scene_put(store, "scene", "anna", NULL, "{}", 2));
    SUMS_CALL(what, srv_store_scene_drop(store, "scene", "anna"));
    SUMS_CALL(what, srv_store_dismiss(store, id, &job));
    SUMS_CALL(what, srv_store_figures(store, &figures));
    for (int i = 0; i < SRV_JOB_STATES; i++)
        CHECK_SAYING(figures.jobs[i] >= 0, "%s: %ld", what, figures.jobs[i]);
    CHECK_SAYING(figures.bytes >= 0 && figures.parts >= 0 && figures.scenes >= 0 &&
                     figures.scene_bytes >= 0,
                 "%s: %lld bytes", what, figures.bytes);
}

static void sums_sweep(struct srv_store *store) {
    struct srv_store_sweep sweep;
    enum srv_stored stored;
    int sweeps = 0;
    do stored = srv_store_sweep(store, NULL, &sweep);
    while (((stored == SRV_STORED && sweep.more) || stored == SRV_STORED_AGAIN) && ++sweeps < 100);
    CHECK_INT(stored, SRV_STORED);
}

STORE_TEST(sums_of_all_that_cannot_have_been_counted_are_counted_anew) {
    struct srv_sql *sql = sums_connect(ground);
    struct ground_columns columns;
    struct srv_job job;
    int altered = 0;
    REQUIRE(sql);
    ground_nulls(ground);
    sums_live(store, "kept", "before");
    CHECK_INT(ground_submit(store, "waits", "anna", NULL, 3, 0, &job), SRV_STORED);
    ground_run(ground, "UPDATE jobs SET rank = rank + 1000000000000 WHERE id = 'waits'");
    CHECK_INT(srv_store_scene_put(store, "kept", "berta", NULL, "[]", 2), SRV_STORED);
    ground_look(ground, "totals", &columns);
    for (int c = 0; c < columns.count; c++)
        for (int way = 0; way < WAYS; way++) {
            char text[256], what[80], id[32];
            snprintf(id, sizeof id, "job%d", c * WAYS + way);
            snprintf(what, sizeof what, "totals.%s %s", columns.name[c], sums_way[way].name);
            snprintf(text, sizeof text, "UPDATE totals SET %s = %s", columns.name[c],
                     ground->postgres ? sums_way[way].postgres : sums_way[way].sqlite);
            if (!sums_run(sql, text)) continue;
            altered++;
            sums_live(store, id, what);
            sums_sweep(store);
            if (!sums_way[way].told) {
                /* a table of sums without a row is not a sum of 0 */
                CHECK(sums_run(sql, "DELETE FROM totals"));
                struct srv_store_figures figures;
                CHECK_INT(srv_store_figures(store, &figures), SRV_STORED);
            }
            if (!CHECK_SAYING(ground_sums(ground), "%s", what)) break;
        }
    CHECK_SAYING(altered > columns.count * 3, "%d were altered", altered);
    CHECK_INT(srv_store_job(store, "waits", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_ACCEPTED);
    sql->driver->close(sql);
}

/* --- the version of the tables --- */

static struct srv_store *sums_open(const struct ground *ground, struct pend_error *error) {
    struct srv_store *store;
    *error = (struct pend_error){.text = ""};
    enum pend_status status = srv_store_open(&store, ground->url, &ground->rules, error);
    CHECK_SAYING(store ? status == PEND_OK : status == PEND_INVALID && strlen(error->text) > 20,
                 "%d: %s", status, error->text);
    return store;
}

STORE_TEST(a_version_that_was_altered_is_refused_with_words_and_harms_nothing) {
    struct srv_sql *sql = sums_connect(ground);
    struct srv_job job;
    char text[256], restore[64];
    int refused = 0;
    REQUIRE(sql);
    ground_nulls(ground);
    snprintf(restore, sizeof restore, "UPDATE pendulumd SET version = %d", SRV_SCHEMA);
    CHECK_INT(ground_submit(store, "kept", "berta", NULL, 3, 0, &job), SRV_STORED);
    for (int way = 0; way < WAYS; way++) {
        struct pend_error error;
        char id[32];
        snprintf(id, sizeof id, "job%d", way);
        snprintf(text, sizeof text, "UPDATE pendulumd SET version = %s",
                 ground->postgres ? sums_way[way].postgres : sums_way[way].sqlite);
        if (!sums_run(sql, text)) continue;
        /* a process that has the store open continues, or says why not */
        enum srv_stored stored = ground_submit(store, id, "anna", NULL, 1, 0, &job);
        CHECK_SAYING(stored == SRV_STORED || (stored == SRV_STORED_BROKEN &&
                                              strstr(srv_store_complaint(store), "version")),
                     "%s: %d %s", text, stored, srv_store_complaint(store));
        /* a process that opens it is told why it cannot be used */
        struct srv_store *other = sums_open(ground, &error);
        CHECK_SAYING(!other && strstr(error.text, "version"), "%s: %s", text, error.text);
        refused += !other;
        srv_store_close(&other);
        CHECK(sums_run(sql, restore));
        snprintf(id, sizeof id, "again%d", way);
        CHECK_INT(ground_submit(store, id, "anna", NULL, 1, 0, &job), SRV_STORED);
        other = sums_open(ground, &error);
        if (CHECK_SAYING(other != NULL, "%s: %s", text, error.text)) {
            CHECK_INT(srv_store_job(other, "kept", &job), SRV_STORED);
            CHECK(job.state == SRV_JOB_ACCEPTED && job.parts == 3);
        }
        srv_store_close(&other);
        CHECK_SAYING(ground_sums(ground), "%s", text);
    }
    CHECK(refused > 3);
    sql->driver->close(sql);
}
