/* Scenes in a class: one id for all, the same bytes for ever, whatever crashes meanwhile; on both
 * stores. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/wire/place.h"

#define SCENE                                                                                      \
    "{\"title\":\"Zw\\u00f6lf <b>\",\"request\":" ASK_EXAMPLE                                      \
    ",\"view\":{\"speed\":0.5,\"trails\":[1,2]}}"
#define SCENE_AGAIN                                                                                \
    "{\"view\":{\"trails\":[1.0,2e0],\"speed\":5e-1},\n \"request\":" ASK_EXAMPLE                  \
    ",\"title\":\"Zw\xc3\xb6lf <b>\"}"

static struct test_server *serve(const struct place *place, const char *option, const char *value) {
    const char *const options[] = {"--store", place->url, option, value, NULL};
    return test_server_start(options);
}

/* stores a scene; returns its path, "" if there is none */
static int put(const struct test_server *server, const char *body, char path[64], char **text) {
    OWN(test_reply, clear) reply;
    path[0] = 0;
    int status = ask((struct test_server *)server, &reply, "/v1/scenes", body);
    const char *location = test_reply_header(&reply, "Location");
    if (status == 201 &&
        CHECK(location && strlen(location) == 11 + ID && !strncmp(location, "/v1/scenes/", 11)))
        strcpy(path, location);
    if (text) *text = strdup(reply.body);
    return status;
}

/* checks that the scene at a path is that text, byte for byte */
static void check_there(const struct test_server *server, const char *path, const char *text) {
    OWN(test_reply, clear) reply;
    CHECK_INT(test_request(server, &reply, "GET", path, "", NULL), 200);
    CHECK_TEXT(reply.body, text);
    CHECK_TEXT(test_reply_header(&reply, "Cache-Control"), "public, max-age=31536000, immutable");
}

static void lasts(struct place *place) {
    char path[64], again[64];
    char *text = NULL, *second = NULL;
    struct test_server *server = serve(place, NULL, NULL);
    if (!server) return;
    CHECK_INT(put(server, SCENE, path, &text), 201);
    test_sleep(0.01);
    CHECK_INT(put(server, SCENE_AGAIN, again, &second), 201);
    CHECK_TEXT(again, path);
    CHECK_TEXT(second, text);
    CHECK(text && strstr(text, "\"title\":\"Zw\xc3\xb6lf <b>\"") && strstr(text, path + 11));
    check_there(server, path, text);
    /* an orderly end, then a crash */
    test_server_stop(&server);
    for (int life = 0; life < 3 && (server = serve(place, NULL, NULL)); life++) {
        char body[400], other[64];
        OWN_MEMORY char *kept = NULL;
        check_there(server, path, text);
        snprintf(body, sizeof body,
                 "{\"title\":\"life %d\",\"request\":{\"pendulum\":%s,\"times\":[0,1]}}", life,
                 ASK_DOUBLE);
        CHECK_INT(put(server, body, other, &kept), 201);
        test_server_signal(server, SIGKILL);
        test_server_wait(server);
        test_server_drop(&server);
        if (!(server = serve(place, NULL, NULL))) break;
        check_there(server, other, kept);
        CHECK_INT(put(server, SCENE, again, NULL), 201);
        CHECK_TEXT(again, path);
        test_server_stop(&server);
    }
    free(text);
    free(second);
}

TEST(a_scene_is_the_same_for_ever_through_restarts_and_kills) { place_on_both(lasts); }

static void two_servers(struct place *place) {
    char path[2][64];
    OWN_MEMORY char *text = NULL;
    struct test_server *one = serve(place, NULL, NULL), *two = serve(place, NULL, NULL);
    if (one && two) {
        CHECK_INT(put(one, SCENE, path[0], &text), 201);
        check_there(two, path[0], text);
        CHECK_INT(put(two, SCENE_AGAIN, path[1], NULL), 201);
        CHECK_TEXT(path[1], path[0]);
    }
    test_server_stop(&one);
    test_server_stop(&two);
}

TEST(a_scene_that_one_server_kept_is_there_for_another) { place_on_both(two_servers); }

static void refusals(struct place *place) {
    OWN(test_reply, clear) reply = {0};
    char path[64], headers[160];
    OWN(test_server, stop) *server = serve(place, "--max-client-scenes", "1");
    if (!server) return;
    static const struct {
        const char *body, *pointer;
        int status;
    } bad[] = {
        {"{", NULL, 400},
        {"{}", "/request", 422},
        {"{\"request\":{\"pendulum\":" ASK_DOUBLE ",\"times\":[0,1],\"rtoll\":1}}",
         "/request/rtoll", 422},
        {"{\"request\":{\"pendulum\":{\"length\":[1,1],\"mass\":[1,0],\"parent\":[0,1]},\"times\":["
         "0,1]}}",
         "/request/pendulum/mass/1", 422},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        ask(server, &reply, "/v1/scenes", bad[i].body);
        ask_problem(&reply, bad[i].status, bad[i].pointer);
        test_reply_clear(&reply);
    }
    static const char *const none[] = {"/v1/scenes/nothing",
                                       "/v1/scenes/00000000000000000000000000",
                                       "/v1/scenes/0000000000000000000000000%27"};
    for (int i = 0; i < 3; i++) {
        test_request(server, &reply, "GET", none[i], "", NULL);
        ask_problem(&reply, 404, NULL);
        test_reply_clear(&reply);
    }
    /* the first is stored, the same again is the same; another is one too many */
    CHECK_INT(put(server, SCENE, path, NULL), 201);
    CHECK_INT(put(server, SCENE_AGAIN, path, NULL), 201);
    ask(server, &reply, "/v1/scenes", "{\"title\":\"more\",\"request\":" ASK_EXAMPLE "}");
    ask_problem(&reply, 429, NULL);
    CHECK(test_reply_header(&reply, "Retry-After") != NULL);
    test_reply_clear(&reply);
    /* a client that has it gets no body */
    snprintf(headers, sizeof headers, "If-None-Match: \"%s\"\r\n", path + 11);
    CHECK_INT(test_request(server, &reply, "GET", path, headers, NULL), 304);
    CHECK_INT((long long)reply.body_bytes, 0);
    CHECK(test_reply_header(&reply, "ETag") && strstr(headers, test_reply_header(&reply, "ETag")));
}

TEST(scenes_that_cannot_be_kept_are_refused_with_their_problem) { place_on_both(refusals); }

TEST(a_scene_can_be_asked_for_its_motion) {
    OWN(place, end) place;
    char path[64];
    REQUIRE(place_begin(&place, 0));
    OWN(test_server, stop) *server = serve(&place, NULL, NULL);
    if (server) {
        OWN(test_reply, clear) scene, kept, plain;
        CHECK_INT(put(server, SCENE, path, NULL), 201);
        CHECK_INT(test_request(server, &scene, "GET", path, "", NULL), 200);
        cJSON *json = ask_json(&scene);
        char *request = cJSON_PrintUnformatted(cJSON_GetObjectItemCaseSensitive(json, "request"));
        CHECK_INT(ask(server, &kept, "/v1/trajectories", request), 200);
        CHECK_INT(ask(server, &plain, "/v1/trajectories", ASK_EXAMPLE), 200);
        /* one meaning, one answer: from the cache */
        CHECK_TEXT(kept.body, plain.body);
        CHECK(kept.body_bytes > 10000);
        cJSON_free(request);
        cJSON_Delete(json);
    }
}

TEST(a_server_without_a_store_says_that_it_keeps_no_scenes) {
    OWN(test_reply, clear) reply = {0};
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    ask(server, &reply, "/v1/scenes", SCENE);
    ask_problem(&reply, 404, NULL);
    CHECK(reply.body && strstr(reply.body, "--store"));
    test_reply_clear(&reply);
    test_request(server, &reply, "GET", "/v1/scenes/00000000000000000000000000", "", NULL);
    ask_problem(&reply, 404, NULL);
}

TEST(a_scene_beyond_its_bytes_is_refused) {
    OWN(place, end) place;
    struct test_reply reply;
    REQUIRE(place_begin(&place, 0));
    OWN(test_server, stop) *server = serve(&place, "--max-scene-bytes", "1024");
    if (server) {
        char *body = malloc(5000), *at = body;
        at += sprintf(at, "{\"request\":{\"pendulum\":%s,\"times\":[0", ASK_DOUBLE);
        for (int i = 1; i < 400; i++) at += sprintf(at, ",%d", i);
        sprintf(at, "]}}");
        ask(server, &reply, "/v1/scenes", body);
        ask_problem(&reply, 413, NULL);
        test_reply_clear(&reply);
        free(body);
    }
}
