/* Tests of server/store/store_sqlite_disk: a full disk, and the database's use of it. */
#include "server/store/store_sqlite_disk.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "server/store/store_rows.h"
#include "tests/server/ground.h"

enum { LOG_BYTES = 4 << 20 }; /* a longer log triggers a checkpoint */

static char data[4 << 20];

static double file_bytes(const struct ground *ground, const char *suffix) {
    char path[128];
    struct stat file;
    snprintf(path, sizeof path, "%s/store.db%s", ground->path, suffix);
    return stat(path, &file) ? 0 : (double)file.st_size;
}

static struct srv_sql *other_connection(const struct ground *ground) {
    struct srv_sql *sql;
    struct pend_error error;
    CHECK_SAYING(srv_sql_sqlite.open(&sql, ground->url, 0, &error) == PEND_OK, "%s", error.text);
    return sql;
}

static double asked(struct srv_sql *sql, const char *text) {
    struct srv_row_wholes row = {.count = 1};
    CHECK_INT(srv_sql_sqlite.run(sql, -1, text, NULL, 0, srv_row_wholes, &row), SRV_STORED);
    return (double)row.whole[0];
}

static int submit_and_claim(struct srv_store *store, int number, struct srv_lease *lease) {
    struct srv_job job;
    char id[16];
    snprintf(id, sizeof id, "j%d", number);
    return ground_submit(store, id, "anna", NULL, 1, 0, &job) == SRV_STORED &&
           ground_claim(store, "w", 60 * SECOND, lease) == SRV_STORED;
}

/* from here on no file grows beyond this many bytes */
static int limit_files(double bytes, struct rlimit *before) {
    signal(SIGXFSZ, SIG_IGN);
    if (getrlimit(RLIMIT_FSIZE, before)) return 0;
    const struct rlimit tight = {(rlim_t)bytes, before->rlim_max};
    return !setrlimit(RLIMIT_FSIZE, &tight);
}

TEST(a_full_disk_is_said_and_harms_nothing) {
    OWN(ground, clear) ground;
    struct srv_job job;
    struct srv_lease lease;
    struct rlimit limit;
    REQUIRE(ground_begin(&ground, 0));
    OWN(srv_store, close) *store = ground_open(&ground);
    REQUIRE(store);
    CHECK_INT(ground_submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
    REQUIRE(limit_files(3 << 20, &limit));
    CHECK_INT(srv_store_finish(store, &lease, data, sizeof data, NULL, 0), SRV_STORED_FULL);
    /* the lease is still valid, and the job can be ended with a reason although the disk is full */
    CHECK_INT(srv_store_fail(store, &lease, "the disk is full"), SRV_STORED);
    REQUIRE(!setrlimit(RLIMIT_FSIZE, &limit));
    CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED);
    CHECK(job.state == SRV_JOB_FAILED && job.bytes == 0);
    CHECK_TEXT(job.message, "the disk is full");
}

/* committed changes can be copied to the file although the disk is full: the log frees its space */
TEST(a_log_of_writes_is_emptied_on_a_disk_without_room) {
    OWN(ground, clear) ground;
    struct srv_job job;
    struct srv_lease kept, lease;
    struct rlimit limit;
    enum srv_stored stored;
    REQUIRE(ground_begin(&ground, 0));
    OWN(srv_store, close) *store = ground_open(&ground);
    REQUIRE(store);
    REQUIRE(submit_and_claim(store, 1, &kept) && submit_and_claim(store, 2, &lease));
    CHECK_INT(srv_store_finish(store, &kept, data, 2 << 20, NULL, 0), SRV_STORED);
    CHECK(file_bytes(&ground, "-wal") > 2 << 20);
    REQUIRE(limit_files(file_bytes(&ground, ""), &limit));
    do stored = srv_store_finish(store, &lease, data, 1 << 18, NULL, 0);
    while (stored == SRV_STORED && submit_and_claim(store, 3, &lease));
    CHECK_INT(stored, SRV_STORED_FULL);
    CHECK_INT(srv_store_fail(store, &lease, "the disk is full"), SRV_STORED);
    CHECK_INT(srv_store_job(store, "j2", &job), SRV_STORED);
    CHECK(job.state == SRV_JOB_FAILED);
    CHECK_INT(srv_store_job(store, "j1", &job), SRV_STORED);
    CHECK(job.state == SRV_JOB_SUCCESSFUL && job.bytes == 2 << 20);
    REQUIRE(!setrlimit(RLIMIT_FSIZE, &limit));
}

struct call_dismiss {
    struct srv_store_call call;
    const char *id;
    struct srv_job job;
};

static enum srv_stored call_dismiss(struct srv_store *store, struct srv_store_call *call) {
    struct call_dismiss *own = (struct call_dismiss *)call;
    return srv_store_dismiss(store, own->id, &own->job);
}

/* a dismissal frees space: a connection that has not met the full disk yet does it at the first
 * attempt */
TEST(a_job_is_dismissed_on_a_disk_without_room) {
    OWN(ground, clear) ground;
    struct srv_lease lease;
    struct rlimit limit;
    struct call_dismiss dismiss = {.call.run = call_dismiss, .id = "j1"};
    struct srv_store_call *call = &dismiss.call;
    enum srv_stored stored;
    REQUIRE(ground_begin(&ground, 0));
    struct srv_store *store = ground_open(&ground), *other = ground_open(&ground);
    REQUIRE(store && other);
    int number = 1;
    REQUIRE(submit_and_claim(store, number, &lease));
    CHECK_INT(srv_store_finish(store, &lease, data, 2 << 20, NULL, 0), SRV_STORED);
    REQUIRE(limit_files(file_bytes(&ground, ""), &limit));
    do stored = submit_and_claim(store, ++number, &lease) ? SRV_STORED : SRV_STORED_FULL;
    while (stored == SRV_STORED && number < 1000);
    CHECK(number < 1000);
    srv_store_together(other, &call, 1);
    CHECK_INT(call->stored, SRV_STORED);
    CHECK(dismiss.job.state == SRV_JOB_DISMISSED);
    REQUIRE(!setrlimit(RLIMIT_FSIZE, &limit));
    srv_store_close(&other);
    srv_store_close(&store);
}

/* as another program, or a crashed machine, may leave it: reads succeed, writes are refused */
TEST(a_file_that_is_short_on_a_full_disk_can_be_read) {
    OWN(ground, clear) ground;
    struct srv_job job;
    struct rlimit limit;
    char path[128];
    sqlite3 *db = NULL;
    REQUIRE(ground_begin(&ground, 0));
    OWN(srv_store, close) *store = ground_open(&ground);
    REQUIRE(store);
    CHECK_INT(ground_submit(store, "j1", "anna", NULL, 1, 0, &job), SRV_STORED);
    snprintf(path, sizeof path, "%s/store.db", ground.path);
    REQUIRE(sqlite3_open(path, &db) == SQLITE_OK);
    CHECK_INT(sqlite3_exec(db,
                           "PRAGMA wal_autocheckpoint = 0; CREATE TABLE strange (data BLOB);"
                           "INSERT INTO strange VALUES (zeroblob(1000000))",
                           NULL, NULL, NULL),
              SQLITE_OK);
    REQUIRE(limit_files(file_bytes(&ground, ""), &limit));
    CHECK_INT(srv_store_job(store, "j1", &job), SRV_STORED);
    CHECK_TEXT(job.id, "j1");
    CHECK_INT(ground_submit(store, "j2", "anna", NULL, 1, 0, &job), SRV_STORED_FULL);
    CHECK_INT(srv_store_job(store, "j1", &job), SRV_STORED);
    REQUIRE(!setrlimit(RLIMIT_FSIZE, &limit));
    CHECK_INT(ground_submit(store, "j2", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK(file_bytes(&ground, "") > 1000000);
    sqlite3_close(db);
}

/* several connections that write in turn, each result as large as a batch's */
TEST(whatever_is_committed_has_its_place_in_the_file) {
    enum { CONNECTIONS = 3, RESULTS = 24, RESULT = 700000 };
    OWN(ground, clear) ground;
    struct srv_store *store[CONNECTIONS];
    struct srv_lease lease;
    double longest = 0;
    REQUIRE(ground_begin(&ground, 0));
    for (int i = 0; i < CONNECTIONS; i++) REQUIRE(store[i] = ground_open(&ground));
    struct srv_sql *sql = other_connection(&ground);
    REQUIRE(sql);
    for (int i = 0; i < RESULTS; i++) {
        REQUIRE(submit_and_claim(store[i % CONNECTIONS], i, &lease));
        CHECK_INT(srv_store_finish(store[(i + 1) % CONNECTIONS], &lease, data, RESULT, NULL, 0),
                  SRV_STORED);
        double pages = asked(sql, "PRAGMA page_count") * asked(sql, "PRAGMA page_size");
        double file = file_bytes(&ground, ""), log = file_bytes(&ground, "-wal");
        CHECK_SAYING(pages > (double)i * RESULT && pages <= file && file <= pages + (1 << 18),
                     "%.0f bytes of pages in a file of %.0f", pages, file);
        if (log > longest) longest = log;
    }
    CHECK_SAYING(longest > LOG_BYTES / 2 && longest < LOG_BYTES + 2 * RESULT, "a log of %.0f bytes",
                 longest);
    srv_sql_sqlite.close(sql);
    for (int i = 0; i < CONNECTIONS; i++) srv_store_close(&store[i]);
}

/* a backup reads for a long time: writers continue, and the log is emptied when it has ended */
TEST(a_reader_that_does_not_end_stops_nobody) {
    OWN(ground, clear) ground;
    struct srv_lease lease;
    int number = 0;
    REQUIRE(ground_begin(&ground, 0));
    OWN(srv_store, close) *store = ground_open(&ground);
    struct srv_sql *reader = other_connection(&ground);
    REQUIRE(store && reader);
    CHECK_INT(srv_sql_sqlite.run(reader, -1, "BEGIN", NULL, 0, NULL, NULL), SRV_STORED);
    CHECK(asked(reader, "SELECT COUNT(*) FROM jobs") == 0);
    for (; number < 12; number++) {
        REQUIRE(submit_and_claim(store, number, &lease));
        CHECK_INT(srv_store_finish(store, &lease, data, 1 << 20, NULL, 0), SRV_STORED);
    }
    CHECK(file_bytes(&ground, "-wal") > 12 << 20);
    CHECK(asked(reader, "SELECT COUNT(*) FROM jobs") == 0);
    CHECK_INT(srv_sql_sqlite.run(reader, -1, "ROLLBACK", NULL, 0, NULL, NULL), SRV_STORED);
    CHECK(asked(reader, "SELECT COUNT(*) FROM jobs") == 12);
    for (; number < 18; number++) {
        REQUIRE(submit_and_claim(store, number, &lease));
        CHECK_INT(srv_store_finish(store, &lease, data, 1 << 20, NULL, 0), SRV_STORED);
    }
    CHECK_SAYING(file_bytes(&ground, "-wal") < LOG_BYTES + (2 << 20), "a log of %.0f bytes",
                 file_bytes(&ground, "-wal"));
    srv_sql_sqlite.close(reader);
}

/* reads without a pause, until it is told to end */
struct looker {
    struct srv_store *store;
    pthread_t thread;
    atomic_int reads, over;
};

static void *looker_main(void *context) {
    struct looker *own = context;
    struct srv_job job;
    while (!own->over) {
        CHECK_INT(srv_store_job(own->store, "j0", &job), SRV_STORED);
        own->reads++;
    }
    return NULL;
}

/* nor does a writer stop them; and the log is emptied although one of them always reads */
TEST(readers_without_a_pause_stop_no_writer) {
    enum { LOOKERS = 4 };
    OWN(ground, clear) ground;
    struct srv_lease lease;
    struct looker looker[LOOKERS] = {0};
    int number = 0, before;
    REQUIRE(ground_begin(&ground, 0));
    OWN(srv_store, close) *store = ground_open(&ground);
    struct srv_sql *writer = other_connection(&ground);
    REQUIRE(store && writer && submit_and_claim(store, number, &lease));
    for (int i = 0; i < LOOKERS; i++) {
        REQUIRE((looker[i].store = ground_open(&ground)) != NULL);
        REQUIRE(!pthread_create(&looker[i].thread, NULL, looker_main, &looker[i]));
    }
    CHECK_INT(srv_sql_sqlite.run(writer, -1, "BEGIN IMMEDIATE", NULL, 0, NULL, NULL), SRV_STORED);
    for (int i = 0; i < LOOKERS; i++) {
        before = looker[i].reads;
        for (double until = test_clock() + TEST_PATIENCE;
             looker[i].reads < before + 2 && test_clock() < until;)
            test_sleep(0.001);
        CHECK(looker[i].reads >= before + 2);
    }
    CHECK_INT(srv_sql_sqlite.run(writer, -1, "ROLLBACK", NULL, 0, NULL, NULL), SRV_STORED);
    CHECK_INT(srv_store_finish(store, &lease, data, 1 << 20, NULL, 0), SRV_STORED);
    for (double until = test_clock() + TEST_PATIENCE;
         ++number < 24 || (file_bytes(&ground, "-wal") > 2 * LOG_BYTES && test_clock() < until);) {
        REQUIRE(submit_and_claim(store, number, &lease));
        CHECK_INT(srv_store_finish(store, &lease, data, 1 << 20, NULL, 0), SRV_STORED);
    }
    CHECK_SAYING(file_bytes(&ground, "-wal") <= 2 * LOG_BYTES, "a log of %.0f bytes",
                 file_bytes(&ground, "-wal"));
    for (int i = 0; i < LOOKERS; i++) looker[i].over = 1;
    for (int i = 0; i < LOOKERS; i++) {
        pthread_join(looker[i].thread, NULL);
        srv_store_close(&looker[i].store);
    }
    srv_sql_sqlite.close(writer);
}

/* a process that writes much and runs checkpoints although only our writer may, as SQLite's own
 * shell does */
struct stranger {
    struct srv_sql *sql;
    atomic_int over;
};

static enum srv_stored stranger_write(struct srv_sql *sql, int i) {
    struct srv_value value[] = {srv_value_whole(i)};
    return srv_sql_sqlite.run(
        sql, -1,
        "INSERT INTO results (job, part, chunk, data, seal) WITH RECURSIVE n(k) AS (SELECT 1 "
        "UNION ALL SELECT k + 1 FROM n WHERE k < 20000) SELECT 'stranger', $1, k, "
        "zeroblob(60), zeroblob(8) FROM n",
        value, 1, NULL, NULL);
}

/* on a slow machine each may block the other for longer than the five seconds after which SQLite
 * gives up: then it tries again, as the storage does */
enum { PATIENCE = 100 };

static void *stranger_main(void *context) {
    struct stranger *own = context;
    struct srv_row_wholes row = {.count = 3};
    for (int i = 0; i < 20; i++) {
        enum srv_stored stored = SRV_STORED_AGAIN;
        for (int turn = 0; turn < PATIENCE && stored == SRV_STORED_AGAIN; turn++)
            stored = stranger_write(own->sql, i);
        CHECK_INT(stored, SRV_STORED);
        srv_sql_sqlite.run(own->sql, -1, "PRAGMA wal_checkpoint(PASSIVE)", NULL, 0, srv_row_wholes,
                           &row);
    }
    own->over = 1;
    return NULL;
}

TEST(who_carries_the_log_over_meanwhile_finds_its_pages_whole) {
    OWN(ground, clear) ground;
    struct srv_job job;
    struct stranger stranger = {0};
    pthread_t thread;
    REQUIRE(ground_begin(&ground, 0));
    OWN(srv_store, close) *store = ground_open(&ground);
    REQUIRE(store);
    REQUIRE((stranger.sql = other_connection(&ground)) != NULL);
    CHECK_INT(ground_submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    REQUIRE(!pthread_create(&thread, NULL, stranger_main, &stranger));
    for (int turns = PATIENCE; !stranger.over;) {
        enum srv_stored stored = srv_store_job(store, "j", &job);
        if (stored == SRV_STORED_AGAIN && turns-- > 0) continue;
        CHECK_INT(stored, SRV_STORED);
    }
    pthread_join(thread, NULL);
    CHECK_INT((long long)asked(stranger.sql,
                               "SELECT integrity_check = 'ok' FROM pragma_integrity_check LIMIT 1"),
              1);
    srv_sql_sqlite.close(stranger.sql);
}
