#include "tests/server/ground.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

const struct srv_store_rules ground_rules = {
    .client_jobs = 1000, .client_bytes = 1 << 28, .all_bytes = 1LL << 30, .keep_us = 3600000000LL, .client_scenes = 3};

static struct test_postgres *ground_postgres;

__attribute__((destructor)) static void ground_end(void) { test_postgres_stop(&ground_postgres); }

int ground_begin(struct ground *ground, int postgres) {
    *ground = (struct ground){.rules = ground_rules};
    if (!postgres) {
        snprintf(ground->path, sizeof ground->path, "/tmp/pendulumd-test-XXXXXX");
        if (!mkdtemp(ground->path)) return 0;
        snprintf(ground->url, sizeof ground->url, "sqlite:%s/store.db", ground->path);
        return 1;
    }
    if (!ground_postgres) ground_postgres = test_postgres_start();
    ground->postgres = ground_postgres;
    if (!ground->postgres) return 0;
    snprintf(ground->url, sizeof ground->url, "%s", test_postgres_url(ground->postgres));
    return test_postgres_run(ground->postgres, "DROP SCHEMA public CASCADE; CREATE SCHEMA public");
}

void ground_clear(struct ground *ground) {
    char command[128];
    if (!*ground->path) return;
    snprintf(command, sizeof command, "rm -rf '%s'", ground->path);
    CHECK(!system(command));
}

struct srv_store *ground_open(const struct ground *ground) {
    struct pend_error error;
    struct srv_store *store;
    CHECK_SAYING(srv_store_open(&store, ground->url, &ground->rules, &error) == PEND_OK, "%s: %s", ground->url,
                 error.text);
    return store;
}

void ground_test(int postgres, void (*test)(struct ground *ground, struct srv_store *store)) {
    struct ground ground;
    if (postgres && access("/usr/lib/postgresql", F_OK)) {
        test_skip("PostgreSQL is not installed");
        return;
    }
    REQUIRE(ground_begin(&ground, postgres));
    struct srv_store *store = ground_open(&ground);
    if (store) test(&ground, store);
    srv_store_close(&store);
    ground_clear(&ground);
}

void ground_pause_ms(int ms) { nanosleep(&(struct timespec){ms / 1000, ms % 1000 * 1000000L}, NULL); }

enum srv_stored ground_submit(struct srv_store *store, const char *id, const char *client, const char *key, long shards,
                              int chained, struct srv_job *job) {
    unsigned char digest[SRV_DIGEST_BYTES] = {1, 2, 3};
    struct srv_job_order order = {.id = id,
                                  .client = client,
                                  .operation = "ensembles",
                                  .key = key,
                                  .request = "{\"a\":1}",
                                  .request_bytes = 7,
                                  .digest = digest,
                                  .shards = shards,
                                  .chained = chained};
    return srv_store_submit(store, &order, job);
}
