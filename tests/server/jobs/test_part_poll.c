/* Tests of server/jobs/part_poll: jobs that go on, that ended, that nobody knows, and a store
 * that cannot say. */
#include "server/jobs/part_poll.h"

#include <stdio.h>
#include <stdlib.h>

#include "tests/server/ground.h"

static void poll_submit(struct srv_store *store, const char *id) {
    unsigned char digest[SRV_DIGEST_BYTES] = {0};
    struct srv_job job;
    struct srv_job_order order = {.id = id,
                                  .client = "anna",
                                  .operation = "forces",
                                  .request = "",
                                  .digest = digest,
                                  .parts = 1};
    CHECK_INT(srv_store_submit(store, &order, &job), SRV_STORED);
}

static enum srv_stored poll_ask(struct srv_part_poll *poll, struct srv_store *store) {
    return poll->ask.call.run(store, &poll->ask.call);
}

TEST(a_poll_says_of_each_job_whether_it_has_ended) {
    char directory[] = "/tmp/pendulumd-test-XXXXXX", url[96], command[128];
    const char *const id[] = {"jobthatgoesonandonandonand", "jobthatwasdismissedbysome1",
                              "jobthatnobodyhaseverknown2"};
    struct srv_store *store;
    struct srv_job job;
    struct pend_error error;
    REQUIRE(mkdtemp(directory));
    snprintf(url, sizeof url, "sqlite:%s/store.db", directory);
    REQUIRE(srv_store_open(&store, url, &ground_rules, &error) == PEND_OK);
    struct srv_part_poll *poll = srv_part_poll_new(3, NULL, &job);
    REQUIRE(poll);
    CHECK(poll->context == &job);
    for (int i = 0; i < 2; i++) poll_submit(store, id[i]);
    CHECK_INT(srv_store_dismiss(store, id[1], &job), SRV_STORED);
    /* each is listed once */
    for (int i = 0; i < 6; i++) srv_part_poll_list(poll, id[i % 3]);
    CHECK_INT(poll->count, 3);
    CHECK_INT(poll_ask(poll, store), SRV_STORED);
    for (int i = 0; i < 3; i++) CHECK_INT(srv_part_poll_ended(poll, id[i]), i > 0);
    /* of what is not listed it knows nothing */
    poll->count = 0;
    CHECK(!srv_part_poll_ended(poll, id[1]));
    srv_part_poll_list(poll, id[1]);
    CHECK(!srv_part_poll_ended(poll, id[1]));
    free(poll);
    srv_store_close(&store);
    snprintf(command, sizeof command, "rm -rf '%s'", directory);
    CHECK(!system(command));
}

TEST(a_store_that_cannot_say_ends_no_job) {
    struct srv_store *store;
    struct pend_error error;
    struct srv_part_poll *poll = srv_part_poll_new(1, NULL, NULL);
    REQUIRE(poll);
    REQUIRE(srv_store_open(&store, "postgresql://nobody@/none?host=/nowhere", &ground_rules,
                           &error) == PEND_OK);
    srv_part_poll_list(poll, "jobthatgoesonandonandonand");
    CHECK_INT(poll_ask(poll, store), SRV_STORED_AWAY);
    CHECK(!srv_part_poll_ended(poll, "jobthatgoesonandonandonand"));
    srv_store_close(&store);
    free(poll);
    test_alloc_fail(1, 0);
    poll = srv_part_poll_new(1, NULL, NULL);
    test_alloc_faults_off();
    CHECK(!poll);
}
