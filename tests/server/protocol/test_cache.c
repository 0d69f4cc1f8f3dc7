/* Tests of server/protocol/cache and server/protocol/response_body. */
#include "server/protocol/cache.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"

/* the parts of a service that response bodies need */
struct cache_room {
    struct srv_memory memory;
    struct srv_buffer_pool pool;
};

static struct srv_response_body *cache_response_body(struct cache_room *room, size_t bytes,
                                                     char fill) {
    struct api_buffer body;
    api_buffer_init(&body, 1 << 24);
    if (api_buffer_room(&body, bytes) != PEND_OK) return NULL;
    memset(body.data, fill, bytes);
    body.bytes = bytes;
    return srv_response_body_new(200, "application/json", &body, 64, &room->memory, &room->pool);
}

static void cache_put(struct srv_cache *cache, struct cache_room *room, const char *key,
                      size_t bytes, char fill) {
    struct srv_response_body *response_body = cache_response_body(room, bytes, fill);
    if (!CHECK(response_body != NULL)) return;
    srv_cache_add(cache, key, strlen(key), response_body);
    srv_response_body_drop(&response_body);
    CHECK(!response_body);
}

/* the first byte of the response body of a key, 0 if there is none */
static char cache_get(struct srv_cache *cache, const char *key) {
    OWN(srv_response_body, drop) *response_body = srv_cache_find(cache, key, strlen(key));
    return response_body ? response_body->body.data[0] : 0;
}

TEST(a_response_body_lives_as_long_as_somebody_has_it) {
    struct cache_room room = {0};
    srv_buffer_pool_init(&room.pool);
    struct srv_response_body *one = cache_response_body(&room, 1000, 'a'),
                             *two = srv_response_body_share(one);
    CHECK(room.memory.all >= 1000);
    srv_response_body_header(one, "ETag", "\"x\"");
    CHECK_TEXT(one->header[0].value, "\"x\"");
    srv_response_body_drop(&one);
    CHECK(!one && room.memory.all >= 1000 && two->body.data[999] == 'a');
    srv_response_body_drop(&two);
    CHECK_INT(room.memory.all, 0);
    srv_response_body_drop(&two);
    srv_buffer_pool_clear(&room.pool);
}

TEST(a_cache_gives_what_was_put_under_a_key_and_forgets_the_oldest) {
    struct srv_cache *cache;
    struct cache_room room = {0};
    srv_buffer_pool_init(&room.pool);
    REQUIRE(srv_cache_new(&cache, 100000, 7) == PEND_OK);
    CHECK(srv_cache_on(cache));
    char key[8] = "k?";
    for (char c = 'a'; c <= 'h'; c++) {
        key[1] = c;
        cache_put(cache, &room, key, 10000, c);
        CHECK(srv_cache_valid(cache));
        /* a is requested repeatedly, and stays */
        CHECK_INT(cache_get(cache, "ka"), 'a');
    }
    /* one more than fit, then some */
    for (char c = 'i'; c <= 'l'; c++) {
        key[1] = c;
        cache_put(cache, &room, key, 10000, c);
        CHECK(srv_cache_valid(cache) && srv_cache_size(cache).bytes <= 100000);
        CHECK_INT(cache_get(cache, "ka"), 'a');
    }
    CHECK_INT(cache_get(cache, "kb"), 0);
    CHECK_INT(cache_get(cache, "kl"), 'l');
    CHECK_INT(cache_get(cache, "k"), 0);
    CHECK_INT(cache_get(cache, "kll"), 0);
    /* the same key again replaces the body */
    cache_put(cache, &room, "ka", 10, 'z');
    CHECK_INT(cache_get(cache, "ka"), 'z');
    CHECK(srv_cache_valid(cache));
    /* a body that would evict too many is not stored */
    cache_put(cache, &room, "big", 50000, 'b');
    CHECK_INT(cache_get(cache, "big"), 0);
    CHECK_INT(cache_get(cache, "ka"), 'z');
    srv_cache_free(&cache);
    CHECK(!cache);
    CHECK_INT(room.memory.all, 0);
    srv_buffer_pool_clear(&room.pool);
}

TEST(two_keys_of_one_response_body_count_it_once) {
    struct srv_cache *cache;
    struct cache_room room = {0};
    srv_buffer_pool_init(&room.pool);
    REQUIRE(srv_cache_new(&cache, 1000000, 7) == PEND_OK);
    struct srv_response_body *response_body = cache_response_body(&room, 50000, 'a');
    srv_cache_add(cache, "one", 3, response_body);
    size_t once = srv_cache_size(cache).bytes;
    srv_cache_add(cache, "two", 3, response_body);
    CHECK(srv_cache_valid(cache) && srv_cache_size(cache).bytes < once + 200);
    CHECK_INT((long)srv_cache_size(cache).bodies, (long)response_body->body.cap);
    CHECK_INT((long)srv_cache_size(cache).entries, 2);
    /* the response body stays as long as the second key */
    cache_put(cache, &room, "one", 10, 'b');
    CHECK(srv_cache_valid(cache));
    CHECK_INT(cache_get(cache, "two"), 'a');
    cache_put(cache, &room, "two", 10, 'c');
    CHECK(srv_cache_valid(cache) && srv_cache_size(cache).bytes < 5000);
    CHECK(response_body->body.data[49999] == 'a');
    srv_response_body_drop(&response_body);
    srv_cache_free(&cache);
    CHECK_INT(room.memory.all, 0);
    srv_buffer_pool_clear(&room.pool);
}

TEST(a_cache_of_no_bytes_takes_nothing_and_want_of_memory_is_no_fault) {
    struct srv_cache *cache = NULL;
    struct cache_room room = {0};
    srv_buffer_pool_init(&room.pool);
    REQUIRE(srv_cache_new(&cache, 0, 7) == PEND_OK);
    CHECK(!srv_cache_on(cache));
    cache_put(cache, &room, "a", 10, 'a');
    CHECK_INT(cache_get(cache, "a"), 0);
    srv_cache_free(&cache);
    test_alloc_fail(1, 0);
    CHECK(srv_cache_new(&cache, 1000, 7) == PEND_NO_MEMORY && !cache);
    test_alloc_faults_off();
    REQUIRE(srv_cache_new(&cache, 100000, 7) == PEND_OK);
    struct srv_response_body *response_body = cache_response_body(&room, 10, 'a');
    test_alloc_fail(1, 0);
    srv_cache_add(cache, "a", 1, response_body);
    test_alloc_faults_off();
    CHECK(srv_cache_valid(cache) && !srv_cache_size(cache).entries);
    srv_response_body_drop(&response_body);
    CHECK_INT(room.memory.all, 0);
    srv_cache_free(&cache);
    srv_buffer_pool_clear(&room.pool);
}

struct cache_crowd {
    struct srv_cache *cache;
    struct cache_room *room;
    int number, wrong;
};

static void *cache_crowd(void *argument) {
    struct cache_crowd *crowd = argument;
    unsigned long long random = (unsigned)crowd->number;
    for (int i = 0; i < 3000; i++) {
        char key[16];
        int k = test_random_int(&random, 60);
        snprintf(key, sizeof key, "key %d", k);
        OWN(srv_response_body, drop) *found = srv_cache_find(crowd->cache, key, strlen(key));
        if (found) crowd->wrong += found->body.data[found->body.bytes - 1] != 'A' + k % 26;
        if (!found) {
            found = cache_response_body(crowd->room, 100 + (size_t)test_random_int(&random, 3000),
                                        (char)('A' + k % 26));
            if (found) srv_cache_add(crowd->cache, key, strlen(key), found);
        }
    }
    return NULL;
}

TEST(many_threads_find_and_add_at_once) {
    struct cache_room room = {0};
    struct srv_cache *cache;
    struct cache_crowd crowd[4];
    pthread_t thread[4];
    srv_buffer_pool_init(&room.pool);
    REQUIRE(srv_cache_new(&cache, 60000, 7) == PEND_OK);
    for (int i = 0; i < 4; i++) {
        crowd[i] = (struct cache_crowd){cache, &room, i + 1, 0};
        CHECK(!pthread_create(&thread[i], NULL, cache_crowd, &crowd[i]));
    }
    for (int i = 0; i < 4; i++) {
        pthread_join(thread[i], NULL);
        CHECK_INT(crowd[i].wrong, 0);
    }
    CHECK(srv_cache_valid(cache) && srv_cache_size(cache).entries > 10);
    srv_cache_free(&cache);
    CHECK_INT(room.memory.all, 0);
    srv_buffer_pool_clear(&room.pool);
}
