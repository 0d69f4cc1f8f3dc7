/* Tests of server/store/store_schema: the tables are created once, and those of another version are
 * left unchanged. */
#include "server/store/store_tally.h"

#include <pthread.h>
#include <string.h>

#include "tests/server/ground.h"

static void *schema_open(void *context) { return ground_open(context); }

STORE_TEST(processes_that_begin_together_make_one_store) {
    struct srv_store *other[4];
    struct srv_job job;
    pthread_t thread[4];
    OWN(ground, clear) own;
    (void)store;
    REQUIRE(ground_begin(&own, ground->postgres != NULL));
    for (int i = 0; i < 4; i++) REQUIRE(!pthread_create(&thread[i], NULL, schema_open, &own));
    for (int i = 0; i < 4; i++) pthread_join(thread[i], (void **)&other[i]);
    CHECK_INT(ground_submit(other[0], "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    for (int i = 0; i < 4; i++) {
        CHECK_INT(srv_store_job(other[i], "j", &job), SRV_STORED);
        srv_store_close(&other[i]);
    }
    CHECK_INT(ground_ask(&own, "SELECT COUNT(*) FROM pendulumd"), 1);
}

STORE_TEST(tables_of_another_version_are_refused_in_a_sentence) {
    struct srv_store *other;
    struct srv_job job;
    struct pend_error error;
    ground_run(ground, "UPDATE pendulumd SET version = 2");
    CHECK_INT(srv_store_open(&other, ground->url, &ground->rules, &error), PEND_INVALID);
    CHECK_SAYING(strstr(error.text, "the store has version 2, but this program needs version 1"),
                 "%s", error.text);
    /* a process that has it open writes nothing more */
    CHECK_INT(ground_submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED_BROKEN);
    CHECK(strstr(srv_store_complaint(store), "version 2"));
}
