/* Tests of server/store/store_sqlite in addition to those that run on each store: the file, and the
 * contents of foreign files. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "server/store/store.h"
#include "tests/server/ground.h"

static int mode_of(const struct ground *ground, const char *end) {
    char path[128];
    struct stat stat_of;
    snprintf(path, sizeof path, "%s/store.db%s", ground->path, end);
    return CHECK_SAYING(!stat(path, &stat_of), "%s is not there", path)
               ? (int)(stat_of.st_mode & 0777)
               : -1;
}

TEST(a_new_store_is_its_owners_alone) {
    struct ground ground;
    struct srv_job job;
    char path[128];
    mode_t before = umask(0);
    if (CHECK(ground_begin(&ground, 0))) {
        struct srv_store *store = ground_open(&ground);
        if (store) CHECK_INT(ground_submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
        CHECK_INT(mode_of(&ground, ""), 0600);
        CHECK_INT(mode_of(&ground, "-wal"), 0600);
        CHECK_INT(mode_of(&ground, "-shm"), 0600);
        srv_store_close(&store);
        /* an owner who shares it continues to do so */
        snprintf(path, sizeof path, "%s/store.db", ground.path);
        CHECK(!chmod(path, 0640));
        store = ground_open(&ground);
        CHECK_INT(mode_of(&ground, ""), 0640);
        srv_store_close(&store);
        ground_clear(&ground);
    }
    umask(before);
}

/* a foreign file may contain more than tables */
TEST(a_store_from_elsewhere_runs_nothing_of_its_own) {
    OWN(ground, clear) ground;
    struct srv_sql *sql;
    struct srv_job job;
    struct pend_error error;
    REQUIRE(ground_begin(&ground, 0));
    OWN(srv_store, close) *store = ground_open(&ground);
    srv_store_close(&store);
    char command[400];
    snprintf(command, sizeof command,
             "python3 -c \"import sqlite3; c = sqlite3.connect('%s/store.db'); c.execute('CREATE "
             "TRIGGER t AFTER INSERT ON "
             "jobs BEGIN SELECT load_extension(NEW.id); END'); c.commit()\"",
             ground.path);
    REQUIRE(!system(command));
    store = ground_open(&ground);
    if (store) {
        CHECK_INT(ground_submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED_BROKEN);
        CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED_NONE);
        REQUIRE(srv_sql_sqlite.open(&sql, ground.url, 0, &error) == PEND_OK);
        CHECK_INT(srv_sql_sqlite.run(sql, -1, "PRAGMA writable_schema = ON", NULL, 0, NULL, NULL),
                  SRV_STORED);
        CHECK(srv_sql_sqlite.run(sql, -1, "DELETE FROM sqlite_schema WHERE name = 't'", NULL, 0,
                                 NULL, NULL) != SRV_STORED);
        srv_sql_sqlite.close(sql);
    }
}
