/* Tests of server/store/storage: queries from many threads, and a store that becomes
 * unreachable. */
#include "server/store/storage.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <sqlite3.h>

#include "tests/server/ground.h"

struct setting {
    struct srv_log *log;
    struct srv_storage *storage;
    char directory[64], url[96];
    atomic_int news;
};

static void setting_news(void *context, int rings) {
    (void)rings;
    atomic_fetch_add(&((struct setting *)context)->news, 1);
}

static int setting_begin(struct setting *setting, const char *url) {
    struct pend_error error;
    struct srv_store_rules rules = ground_rules;
    rules.client_jobs = 100000;
    snprintf(setting->directory, sizeof setting->directory, "/tmp/pendulumd-test-XXXXXX");
    if (!CHECK(mkdtemp(setting->directory) &&
               srv_log_new(&setting->log, -1, open("/dev/null", O_WRONLY)) == PEND_OK))
        return 0;
    snprintf(setting->url, sizeof setting->url, "sqlite:%s/store.db", setting->directory);
    return CHECK(srv_storage_new(&setting->storage, url ? url : setting->url, &rules, setting->log,
                                 setting_news, setting, &error) == PEND_OK);
}

static void setting_end(struct setting *setting) {
    char command[128];
    srv_storage_free(&setting->storage);
    srv_log_free(&setting->log);
    snprintf(command, sizeof command, "rm -rf '%s'", setting->directory);
    CHECK(!system(command));
}

/* submits one job; counts the results */
struct submission {
    struct srv_ask ask; /* first */
    char id[SRV_ID_BYTES];
    struct srv_job job;
    atomic_int *done, *good;
};

static enum srv_stored submission_run(struct srv_store *store, struct srv_store_call *call) {
    struct submission *own = (struct submission *)call;
    struct srv_job_order order = ground_order(own->id, "anna");
    return srv_store_submit(store, &order, &own->job);
}

static void submission_done(struct srv_ask *ask) {
    struct submission *own = (struct submission *)ask;
    atomic_fetch_add(own->good, ask->call.stored == SRV_STORED);
    atomic_fetch_add(own->done, 1);
}

enum { SUBMITTERS = 4, EACH = 200 };

struct submitter {
    struct srv_storage *storage;
    struct submission *submission;
};

static void *submitter_main(void *context) {
    struct submitter *own = context;
    for (int i = 0; i < EACH; i++)
        srv_storage_ask(own->storage, SRV_ASK_WRITE, &own->submission[i].ask);
    return NULL;
}

TEST(everything_that_many_threads_ask_is_answered_once_and_kept) {
    static struct submission submission[SUBMITTERS * EACH];
    OWN(setting, end) setting = {0};
    struct submitter submitter[SUBMITTERS];
    pthread_t thread[SUBMITTERS];
    atomic_int done = 0, good = 0;
    REQUIRE(setting_begin(&setting, NULL));
    for (int i = 0; i < SUBMITTERS * EACH; i++) {
        submission[i] =
            (struct submission){.ask = {.call = {.run = submission_run}, .done = submission_done},
                                .done = &done,
                                .good = &good};
        snprintf(submission[i].id, sizeof submission[i].id, "j%d", i);
    }
    for (int i = 0; i < SUBMITTERS; i++) {
        submitter[i] = (struct submitter){setting.storage, submission + i * EACH};
        REQUIRE(!pthread_create(&thread[i], NULL, submitter_main, &submitter[i]));
    }
    for (int i = 0; i < SUBMITTERS; i++) pthread_join(thread[i], NULL);
    /* the end waits for queued queries */
    srv_storage_free(&setting.storage);
    CHECK(done == SUBMITTERS * EACH && good == SUBMITTERS * EACH);
    OWN(srv_store, close) *store;
    struct srv_store_figures figures;
    struct pend_error error;
    REQUIRE(srv_store_open(&store, setting.url, &ground_rules, &error) == PEND_OK);
    CHECK_INT(srv_store_figures(store, &figures), SRV_STORED);
    CHECK_INT(figures.jobs[SRV_JOB_ACCEPTED], SUBMITTERS * EACH);
}

/* A query that only records when it ran. */
struct turn {
    struct srv_ask ask; /* first */
    int number;
    int *order, *count; /* the storage's one reading thread writes there */
    atomic_int *gate;   /* the query sets this to 1 and waits until it is 2; NULL = it does not
                         * wait */
    atomic_int *done;
};

static enum srv_stored turn_run(struct srv_store *store, struct srv_store_call *call) {
    struct turn *own = (struct turn *)call;
    struct timespec moment = {0, 1000000};
    (void)store;
    if (own->gate) atomic_store(own->gate, 1);
    while (own->gate && atomic_load(own->gate) != 2) nanosleep(&moment, NULL);
    own->order[(*own->count)++] = own->number;
    return SRV_STORED;
}

static void turn_done(struct srv_ask *ask) { atomic_fetch_add(((struct turn *)ask)->done, 1); }

/* One client of an address sends eight queries, then another client of the same address, another
 * address and the process itself send two each. While the first query runs all others wait. */
TEST(who_asks_much_makes_nobody_wait_for_more_than_a_turn) {
    enum { MANY = 8, ALL = MANY + 6 };
    static const int expected[ALL] = {0, 1, 8, 10, 12, 2, 9, 11, 13, 3, 4, 5, 6, 7};
    OWN(setting, end) setting = {0};
    struct srv_asker home = {0}, one = {.origin = &home}, two = {.origin = &home}, far = {0};
    struct srv_asker *const who[ALL] = {&one, &one, &one, &one, &one, &one, &one,
                                        &one, &two, &two, &far, &far, NULL, NULL};
    struct turn turn[ALL];
    int order[ALL], count = 0;
    atomic_int gate = 0, done = 0;
    REQUIRE(setting_begin(&setting, NULL));
    for (int i = 0; i < ALL; i++) {
        turn[i] = (struct turn){{.call = {.run = turn_run}, .done = turn_done, .asker = who[i]},
                                i,
                                order,
                                &count,
                                i ? NULL : &gate,
                                &done};
        srv_storage_ask(setting.storage, SRV_ASK_READ, &turn[i].ask);
        /* The first one is running when the others arrive. */
        struct timespec moment = {0, 1000000};
        while (!atomic_load(&gate)) nanosleep(&moment, NULL);
    }
    atomic_store(&gate, 2);
    srv_storage_free(&setting.storage);
    CHECK_INT(done, ALL);
    for (int i = 0; i < ALL && count == ALL; i++) CHECK_INT(order[i], expected[i]);
    CHECK_INT(count, ALL);
}

static void *setting_free(void *context) {
    struct setting *setting = context;
    srv_storage_free(&setting->storage);
    return NULL;
}

/* A writer sweeps each second. Another program locks the store meanwhile, so that the sweep lasts
 * until a query has arrived, followed by the end. */
TEST(what_is_asked_during_a_sweep_is_answered_before_the_end) {
    OWN(setting, end) setting = {0};
    atomic_int done = 0, good = 0;
    struct submission submission = {
        .ask = {.call = {.run = submission_run}, .done = submission_done},
        .id = "j",
        .done = &done,
        .good = &good};
    pthread_t end;
    sqlite3 *db;
    REQUIRE(setting_begin(&setting, NULL));
    REQUIRE(sqlite3_open(setting.url + strlen("sqlite:"), &db) == SQLITE_OK);
    sqlite3_busy_timeout(db, 10000);
    REQUIRE(sqlite3_exec(db, "BEGIN IMMEDIATE", NULL, NULL, NULL) == SQLITE_OK);
    struct timespec sweep = {1, 300000000}, moment = {0, 100000000};
    nanosleep(&sweep, NULL);
    srv_storage_ask(setting.storage, SRV_ASK_WRITE, &submission.ask);
    REQUIRE(!pthread_create(&end, NULL, setting_free, &setting));
    nanosleep(&moment, NULL);
    CHECK(sqlite3_exec(db, "COMMIT", NULL, NULL, NULL) == SQLITE_OK);
    pthread_join(end, NULL);
    CHECK(done == 1 && good == 1);
    sqlite3_close(db);
}

TEST(who_may_wait_waits_and_sees_what_was_written) {
    OWN(setting, end) setting = {0};
    atomic_int none = 0;
    struct submission submission = {
        .ask = {.call = {.run = submission_run}}, .id = "j", .done = &none, .good = &none};
    REQUIRE(setting_begin(&setting, NULL));
    CHECK_INT(srv_storage_wait(setting.storage, SRV_ASK_WRITE, &submission.ask), SRV_STORED);
    CHECK_TEXT(submission.job.id, "j");
    CHECK_INT(srv_storage_wait(setting.storage, SRV_ASK_WRITE, &submission.ask), SRV_STORED_AGAIN);
    CHECK(srv_storage_here(setting.storage));
    CHECK(none == 0);
    /* the figures follow within about a second */
    for (double until = test_clock() + TEST_PATIENCE;
         !srv_storage_figures(setting.storage).parts;) {
        if (test_clock() > until) break;
        test_sleep(0.01);
    }
    CHECK_INT(srv_storage_figures(setting.storage).parts, 1);
}

/* waits until the storage is reachable, or unreachable; 0 if that does not happen */
static int storage_comes(const struct setting *setting, int here) {
    double until = test_clock() + TEST_PATIENCE;
    while (srv_storage_here(setting->storage) != here && test_clock() < until) test_sleep(0.01);
    return srv_storage_here(setting->storage) == here;
}

/* waits until it has reported newer news; that follows its becoming reachable */
static int storage_tells(const struct setting *setting, int before) {
    double until = test_clock() + TEST_PATIENCE;
    while (setting->news <= before && test_clock() < until) test_sleep(0.01);
    return setting->news > before;
}

TEST(a_store_that_goes_away_is_noticed_and_so_is_its_return) {
    struct setting setting = {0};
    OWN(test_postgres, stop) *postgres = NULL;
    if (access("/usr/lib/postgresql", F_OK)) {
        test_skip("PostgreSQL is not installed");
        return;
    }
    postgres = test_postgres_start();
    REQUIRE(postgres);
    if (setting_begin(&setting, test_postgres_url(postgres))) {
        int before = setting.news;
        CHECK(srv_storage_here(setting.storage));
        test_postgres_halt(postgres, SIGQUIT);
        CHECK(storage_comes(&setting, 0));
        CHECK(test_postgres_resume(postgres));
        CHECK(storage_comes(&setting, 1));
        CHECK(storage_tells(&setting, before));
        setting_end(&setting);
    }
}

struct silence {
    struct setting *setting;
    enum srv_ask_kind kind;
    struct submission submission;
    enum srv_stored stored;
    double seconds;
};

static void *silence_main(void *context) {
    struct silence *own = context;
    double begin = test_clock();
    own->stored = srv_storage_wait(own->setting->storage, own->kind, &own->submission.ask);
    own->seconds = test_clock() - begin;
    return NULL;
}

/* the connection stays open and nothing arrives: queries are answered after the limit of 10 s, and
 * not before; later ones wait for at most a connection; and it continues when the database does */
TEST(nobody_waits_for_a_database_that_is_silent_longer_than_the_limit) {
    struct setting setting = {0};
    struct silence silence[SRV_ASK_KINDS],
        later = {&setting, SRV_ASK_WRITE, {.id = "later"}, SRV_STORED, 0};
    pthread_t thread[SRV_ASK_KINDS];
    atomic_int none = 0;
    if (access("/usr/lib/postgresql", F_OK)) {
        test_skip("PostgreSQL is not installed");
        return;
    }
    OWN(test_postgres, stop) *postgres = test_postgres_start();
    REQUIRE(postgres);
    if (setting_begin(&setting, test_postgres_url(postgres))) {
        test_postgres_freeze(postgres, 1);
        for (int i = 0; i < SRV_ASK_FILE; i++) {
            silence[i] =
                (struct silence){&setting, (enum srv_ask_kind)i, {.id = "j"}, SRV_STORED, 0};
            silence[i].submission.ask.call.run = submission_run;
            silence[i].submission.done = silence[i].submission.good = &none;
            REQUIRE(!pthread_create(&thread[i], NULL, silence_main, &silence[i]));
        }
        for (int i = 0; i < SRV_ASK_FILE; i++) {
            pthread_join(thread[i], NULL);
            CHECK_INT(silence[i].stored, SRV_STORED_AWAY);
            CHECK_SAYING(silence[i].seconds > 5 && silence[i].seconds < TEST_PATIENCE,
                         "it took %.1f s", silence[i].seconds);
        }
        CHECK(!srv_storage_here(setting.storage));
        later.submission.ask.call.run = submission_run;
        silence_main(&later);
        CHECK_INT(later.stored, SRV_STORED_AWAY);
        CHECK_SAYING(later.seconds < TEST_PATIENCE, "it took %.1f s", later.seconds);
        int news = setting.news;
        test_postgres_freeze(postgres, 0);
        CHECK(storage_comes(&setting, 1));
        CHECK(storage_tells(&setting, news));
        CHECK_INT(srv_storage_wait(setting.storage, SRV_ASK_WRITE, &later.submission.ask),
                  SRV_STORED);
        setting_end(&setting);
    }
}
