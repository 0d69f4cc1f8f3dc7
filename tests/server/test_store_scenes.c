/* Tests of server/store_scenes: kept for ever. */
#include "server/store.h"

#include <stdlib.h>
#include <string.h>

#include "tests/server/ground.h"

STORE_TEST(scenes_last_and_never_change) {
    void *body;
    size_t bytes;
    (void)ground;
    CHECK_INT(srv_store_scene(store, "s", &body, &bytes), SRV_STORED_NONE);
    for (int i = 0; i < 2; i++) CHECK_INT(srv_store_scene_put(store, "s", "anna", "{}", 2), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "s", "berta", "{ }", 3), SRV_STORED_CLASH);
    CHECK_INT(srv_store_scene_put(store, "t", "anna", "", 0), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "u", "anna", "a\0b", 3), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "v", "anna", "x", 1), SRV_STORED_QUOTA);
    CHECK_INT(srv_store_scene(store, "u", &body, &bytes), SRV_STORED);
    CHECK(bytes == 3 && !memcmp(body, "a\0b", 3));
    free(body);
}
