/* Tests of server/store/store_scenes: scenes are stored as long as a client keeps them. */
#include "server/store/store.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/server/ground.h"

STORE_TEST(scenes_last_and_never_change) {
    OWN_MEMORY void *body = NULL;
    size_t bytes;
    (void)ground;
    CHECK_INT(srv_store_scene(store, "s", &body, &bytes), SRV_STORED_NONE);
    for (int i = 0; i < 2; i++)
        CHECK_INT(srv_store_scene_put(store, "s", "anna", NULL, "{}", 2), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "s", "berta", NULL, "{ }", 3), SRV_STORED_CLASH);
    CHECK_INT(srv_store_scene_put(store, "t", "anna", NULL, "", 0), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "u", "anna", NULL, "a\0b", 3), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "v", "anna", NULL, "x", 1), SRV_STORED_QUOTA);
    CHECK_INT(srv_store_scene(store, "u", &body, &bytes), SRV_STORED);
    CHECK(bytes == 3 && !memcmp(body, "a\0b", 3));
}

STORE_TEST(a_scene_goes_with_the_last_who_keeps_it) {
    void *body;
    size_t bytes;
    (void)ground;
    CHECK_INT(srv_store_scene_keep(store, "s", "anna", NULL), SRV_STORED_NONE);
    CHECK_INT(srv_store_scene_drop(store, "s", "anna"), SRV_STORED_NONE);
    CHECK_INT(srv_store_scene_put(store, "s", "anna", NULL, "{}", 2), SRV_STORED);
    CHECK_INT(srv_store_scene_keep(store, "s", "berta", NULL), SRV_STORED);
    CHECK_INT(srv_store_scene_keep(store, "s", "berta", NULL), SRV_STORED);
    /* another client cannot, each keeper can for itself */
    CHECK_INT(srv_store_scene_drop(store, "s", "clara"), SRV_STORED_CLASH);
    CHECK_INT(srv_store_scene_drop(store, "s", "anna"), SRV_STORED);
    CHECK_INT(srv_store_scene_drop(store, "s", "anna"), SRV_STORED_CLASH);
    CHECK_INT(srv_store_scene(store, "s", &body, &bytes), SRV_STORED);
    free(body);
    CHECK_INT(srv_store_scene_drop(store, "s", "berta"), SRV_STORED);
    CHECK_INT(srv_store_scene(store, "s", &body, &bytes), SRV_STORED_NONE);
    /* a dropped scene no longer counts: three are allowed */
    for (int i = 0; i < 3; i++) {
        const char id[] = {(char)('a' + i), 0};
        CHECK_INT(srv_store_scene_put(store, id, "anna", NULL, "{}", 2), SRV_STORED);
    }
    CHECK_INT(srv_store_scene_put(store, "d", "anna", NULL, "{}", 2), SRV_STORED_QUOTA);
    CHECK_INT(srv_store_scene(store, "d", &body, &bytes), SRV_STORED_NONE);
    CHECK_INT(srv_store_scene_drop(store, "a", "anna"), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "d", "anna", NULL, "{}", 2), SRV_STORED);
    /* a scene that another client keeps counts for a second keeper too */
    CHECK_INT(srv_store_scene_keep(store, "d", "berta", NULL), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "e", "berta", NULL, "{}", 2), SRV_STORED);
    CHECK_INT(srv_store_scene_keep(store, "b", "berta", NULL), SRV_STORED);
    CHECK_INT(srv_store_scene_keep(store, "c", "berta", NULL), SRV_STORED_QUOTA);
}

/* tokens are easily created: the scenes of all tokens of an address are limited too */
STORE_TEST(the_scenes_of_all_clients_of_an_address_are_bounded) {
    char client[16], id[16];
    OWN(srv_store, close) *bounded;
    (void)store;
    ground->rules.source_scenes = 5;
    REQUIRE((bounded = ground_open(ground)) != NULL);
    for (int i = 0; i < 6; i++) {
        snprintf(client, sizeof client, "t%d", i);
        snprintf(id, sizeof id, "s%d", i);
        CHECK_INT(srv_store_scene_put(bounded, id, client, "home", "{}", 2),
                  i < 5 ? SRV_STORED : SRV_STORED_QUOTA);
    }
    CHECK_INT(srv_store_scene_put(bounded, "elsewhere", "t9", "school", "{}", 2), SRV_STORED);
    CHECK_INT(srv_store_scene_drop(bounded, "s0", "t0"), SRV_STORED);
    CHECK_INT(srv_store_scene_put(bounded, "s9", "t8", "home", "{}", 2), SRV_STORED);
}

/* scenes are limited in bytes, for each client and in total */
STORE_TEST(scenes_are_bounded_in_bytes) {
    static const char body[4000];
    struct srv_store_figures figures;
    OWN(srv_store, close) *own;
    char id[16];
    (void)store;
    ground->rules.client_scenes = 100;
    ground->rules.client_scene_bytes = 3 * (sizeof body + SRV_ROW_BYTES);
    ground->rules.all_scene_bytes = 5 * (sizeof body + SRV_ROW_BYTES);
    REQUIRE((own = ground_open(ground)) != NULL);
    for (int i = 0; i < 8; i++) {
        snprintf(id, sizeof id, "s%d", i);
        int fits = i < 3 || i == 4 || i == 5;
        CHECK_SAYING(srv_store_scene_put(own, id, i < 4 ? "anna" : "berta", NULL, body,
                                         sizeof body) == (fits ? SRV_STORED : SRV_STORED_QUOTA),
                     "scene %d", i);
    }
    /* an existing scene takes no more space in total, but counts for its keeper */
    CHECK_INT(srv_store_scene_keep(own, "s0", "berta", NULL), SRV_STORED);
    CHECK_INT(srv_store_scene_keep(own, "s1", "berta", NULL), SRV_STORED_QUOTA);
    CHECK_INT(srv_store_figures(own, &figures), SRV_STORED);
    CHECK(figures.scenes == 5 && figures.scene_bytes == ground->rules.all_scene_bytes);
    ground_sums(ground);
    CHECK_INT(srv_store_scene_drop(own, "s1", "anna"), SRV_STORED);
    CHECK_INT(srv_store_scene_put(own, "s9", "anna", NULL, body, sizeof body), SRV_STORED);
    ground_sums(ground);
}

/* a full disk has space for the removal of only a few rows at a time */
STORE_TEST(a_client_is_erased_in_pieces_of_any_size) {
    struct srv_job job;
    char id[16];
    int count = 0;
    for (int i = 0; i < 3; i++) {
        snprintf(id, sizeof id, "s%d", i);
        CHECK_INT(srv_store_scene_put(store, id, "anna", NULL, id, 2), SRV_STORED);
        snprintf(id, sizeof id, "j%d", i);
        CHECK_INT(ground_submit(store, id, "anna", NULL, 1, 0, &job), SRV_STORED);
    }
    CHECK_INT(srv_store_scene_put(store, "bob", "bob", NULL, "{}", 2), SRV_STORED);
    for (int i = 0; i < 3; i++) {
        CHECK_INT(srv_store_erase_jobs(store, "anna", 1, &count), SRV_STORED);
        CHECK_INT(count, 1);
        CHECK_INT(srv_store_erase_scenes(store, "anna", 1, &count), SRV_STORED);
        CHECK_INT(count, 1);
        CHECK_INT(ground_ask(ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM keepers"), 3 - i);
    }
    CHECK_INT(srv_store_erase_jobs(store, "anna", SRV_ERASE_MOST, &count), SRV_STORED);
    CHECK_INT(count, 0);
    CHECK_INT(ground_ask(ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM jobs"), 0);
    CHECK_INT(ground_ask(ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM scenes"), 1);
    ground_sums(ground);
}
