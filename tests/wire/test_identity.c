/* The owner of a job or a scene: tokens, accounts of a proxy, addresses; other hosts and web pages;
 * on both stores. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#include "tests/wire/place.h"

#define ALICE "Authorization: Bearer alice-Zm9vYmFyYmF6cXV4MTIz\r\n"
#define BOB "Authorization: bearer bob.Q29ycmVjdEhvcnNlQmF0dGVyeQ==\r\n"
#define KEYED "Idempotency-Key: same\r\n"

/* submits a request of this many seconds of the pendulum's time; returns the id of its job */
static int post(const struct test_server *server, const char *headers, int span, char id[ID + 1]) {
    char body[256], lines[512];
    snprintf(lines, sizeof lines, ASYNC "%s", headers);
    snprintf(body, sizeof body,
             "{\"pendulum\":" ASK_DOUBLE ",\"times\":{\"start\":0,\"stop\":%d,\"count\":5}}", span);
    return submit(server, "/v1/trajectories", lines, body, id);
}

static int drop(const struct test_server *server, const char *kind, const char *id,
                const char *headers) {
    OWN(test_reply, clear) reply;
    char path[96];
    snprintf(path, sizeof path, "/v1/%s/%s", kind, id);
    int status = test_request(server, &reply, "DELETE", path, headers, NULL);
    if (status == 401) CHECK(test_reply_header(&reply, "WWW-Authenticate") != NULL);
    if (status >= 400) ask_problem(&reply, status, NULL);
    return status;
}

/* the status of a list; checks that it contains so many of these ids */
static int listed(const struct test_server *server, const char *headers, const char *id) {
    OWN(test_reply, clear) reply;
    int status = test_request(server, &reply, "GET", "/v1/jobs", headers, NULL);
    int there = status == 200 && strstr(reply.body, id) != NULL;
    return status == 200 ? there : -status;
}

static void two_tokens(struct place *place) {
    struct test_reply reply;
    char alices[ID + 1], bobs[ID + 1], again[ID + 1], word[WORDS];
    OWN(test_server, stop) *server = place_serve(place, "all", "1", NULL, NULL);
    if (!server) return;
    /* one key of two clients is two keys, even with another request */
    CHECK_INT(post(server, ALICE KEYED, 1, alices), 202);
    CHECK_INT(post(server, BOB KEYED, 2, bobs), 202);
    CHECK(strcmp(alices, bobs) != 0);
    CHECK_INT(post(server, ALICE KEYED, 1, again), 202);
    CHECK_TEXT(again, alices);
    CHECK_INT(post(server, ALICE KEYED, 3, again), 422);
    /* each lists its own, and a client without a token is told how to get a list */
    CHECK_INT(listed(server, ALICE, alices), 1);
    CHECK_INT(listed(server, ALICE, bobs), 0);
    CHECK_INT(listed(server, BOB, bobs), 1);
    CHECK_INT(listed(server, BOB, alices), 0);
    CHECK_INT(test_request(server, &reply, "GET", "/v1/jobs", "", NULL), 401);
    ask_problem(&reply, 401, NULL);
    const char *asks = test_reply_header(&reply, "WWW-Authenticate");
    CHECK_SAYING(asks && !strncmp(asks, "Bearer", 6), "%s", asks ? asks : "no WWW-Authenticate");
    CHECK_SAYING(strstr(reply.body, "Authorization: Bearer") != NULL, "%s", reply.body);
    test_reply_clear(&reply);
    /* anyone who knows an id may read, and nothing more */
    CHECK_INT(job_get(server, &reply, alices, "", BOB), 200);
    CHECK_SAYING(strstr(reply.body, "\"owner\":\"token\"") != NULL, "%s", reply.body);
    test_reply_clear(&reply);
    job_wait(server, alices, word);
    CHECK_TEXT(word, "successful");
    CHECK_INT(job_get(server, &reply, alices, "/results", ""), 200);
    test_reply_clear(&reply);
    CHECK_INT(drop(server, "jobs", alices, BOB), 403);
    CHECK_INT(drop(server, "jobs", alices, ""), 401);
    job_wait(server, alices, word);
    CHECK_TEXT(word, "successful");
    CHECK_INT(drop(server, "jobs", alices, ALICE), 200);
    job_wait(server, alices, word);
    CHECK_TEXT(word, "dismissed");
    /* the key of a dismissed job is free: a new job, which is computed */
    CHECK_INT(post(server, ALICE KEYED, 1, again), 202);
    CHECK(strcmp(again, alices) != 0);
    job_wait(server, again, word);
    CHECK_TEXT(word, "successful");
}

TEST(two_tokens_cannot_see_or_end_each_others_jobs) { place_on_both(two_tokens); }

static int scene(const struct test_server *server, const char *headers, const char *title,
                 char id[ID + 1]) {
    OWN(test_reply, clear) reply;
    char body[400];
    snprintf(body, sizeof body, "{\"title\":\"%s\",\"request\":{\"pendulum\":%s,\"times\":[0,1]}}",
             title, ASK_DOUBLE);
    int status = test_request(server, &reply, "POST", "/v1/scenes", headers, body);
    const char *location = test_reply_header(&reply, "Location");
    id[0] = 0;
    if (status == 201 && CHECK(location && strlen(location) == 11 + ID))
        memcpy(id, location + 11, ID + 1);
    return status;
}

static int scene_there(const struct test_server *server, const char *id) {
    OWN(test_reply, clear) reply;
    char path[96];
    snprintf(path, sizeof path, "/v1/scenes/%s", id);
    return test_request(server, &reply, "GET", path, "", NULL);
}

static void scenes_of_two(struct place *place) {
    char one[ID + 1], two[ID + 1], open[ID + 1], again[ID + 1];
    OWN(test_server, stop) *server = place_serve(place, "all", "1", NULL, NULL);
    if (!server) return;
    CHECK_INT(scene(server, ALICE, "one", one), 201);
    CHECK_INT(scene(server, "", "open", open), 201);
    /* a link is shared: anyone who has it reads, only its creator deletes it */
    CHECK_INT(drop(server, "scenes", one, BOB), 403);
    CHECK_INT(drop(server, "scenes", one, ""), 401);
    CHECK_INT(drop(server, "scenes", open, ""), 401);
    CHECK_INT(drop(server, "scenes", open, ALICE), 403);
    CHECK_INT(drop(server, "scenes", "0123456789abcdefghjkmnpqrs", ALICE), 404);
    CHECK_INT(drop(server, "scenes", "nothing", ALICE), 404);
    CHECK_INT(scene_there(server, one), 200);
    /* the same scene of two creators exists until both have deleted it */
    CHECK_INT(scene(server, BOB, "one", two), 201);
    CHECK_TEXT(two, one);
    CHECK_INT(drop(server, "scenes", one, ALICE), 204);
    CHECK_INT(scene_there(server, one), 200);
    CHECK_INT(drop(server, "scenes", one, ALICE), 403);
    CHECK_INT(drop(server, "scenes", one, BOB), 204);
    CHECK_INT(scene_there(server, one), 404);
    CHECK_INT(scene(server, BOB, "one", again), 201);
    CHECK_INT(scene_there(server, again), 200);
    CHECK_INT(scene_there(server, open), 200);
}

TEST(a_scene_is_taken_away_by_its_makers_and_nobody_else) { place_on_both(scenes_of_two); }

TEST(a_token_that_is_none_is_refused_and_not_repeated) {
    static const char *const bad[] = {
        "Bearer",
        "Bearer ",
        "Bearer short",
        "Bearer\tabcdefghijklmnopqrstuv",
        "Bearer, abcdefghijklmnopqrstuv",
        "Bearer abcdefghijklmnopqrstu",               /* 21 characters */
        "Bearer 0123456789abcdef0123456789abcde",     /* 31 hexadecimal digits: 124 bits */
        "Bearer aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa", /* nobody drew that at random */
        "Bearer secret-with-a-b\xc3\xbc-chse-in-it-1234",
        "Bearer two-tokens-are-one-too many-tokens-1",
        "Bearer comma,comma,comma,comma,comma,comma",
        "Bearer =leading-equals-sign-0123456789abc",
        "Bearer middle=equals=sign-0123456789abcde",
    };
    static const char *const good[] = {
        "Bearer abcdefghijklmnopqrstuv", "BEARER   0123456789abcdef0123456789abcdef",
        "bearer eyJhbGciOi.eyJzdWIiOiIx_~+/-MjM0NTY3ODkw==", "Basic YWxhZGRpbjpvcGVuc2VzYW1l",
        "Digest x"};
    OWN(test_reply, clear) reply = {0};
    OWN(test_server, stop) *server = test_server_start(NULL);
    char headers[160];
    if (!server) return;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        snprintf(headers, sizeof headers, "Authorization: %s\r\n", bad[i]);
        int status = test_request(server, &reply, "POST", "/v1/trees", headers, ASK_LITTLE);
        CHECK_SAYING(status == 401, "%s: %d", bad[i], status);
        if (status == 401) {
            ask_problem(&reply, 401, NULL);
            const char *asks = test_reply_header(&reply, "WWW-Authenticate");
            CHECK_SAYING(asks && strstr(asks, "invalid_token"), "%s",
                         asks ? asks : "no WWW-Authenticate");
            /* the rule is returned, the token is not */
            CHECK(strstr(reply.body, "22") && strstr(reply.body, "128 bits"));
            CHECK_SAYING(!strstr(reply.body, bad[i][6] && bad[i][7] ? bad[i] + 7 : "Bearer  "),
                         "%s", reply.body);
        }
        test_reply_clear(&reply);
    }
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        snprintf(headers, sizeof headers, "Authorization: %s\r\n", good[i]);
        int status = test_request(server, &reply, "POST", "/v1/trees", headers, ASK_LITTLE);
        CHECK_SAYING(status == 200, "%s: %d %s", good[i], status, reply.body);
        test_reply_clear(&reply);
    }
    CHECK_INT(test_request(server, &reply, "POST", "/v1/trees", ALICE BOB, ASK_LITTLE), 400);
}

#define KKK                                                                                        \
    "KKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKKK" \
    "KKKK"

/* a daemon behind a proxy that reports the client, which is the test itself */
static struct test_server *behind(const struct place *place, const char *header, const char *option,
                                  const char *value) {
    const char *const options[] = {
        "--store", place->url, "--trusted-proxy", "127.0.0.1", "--client-header", header, option,
        value,     NULL};
    return test_server_start(options);
}

static void accounts(struct place *place) {
    OWN(test_reply, clear) reply = {0};
    char alices[ID + 1], bobs[ID + 1];
    OWN(test_server, stop) *server = behind(place, "X-Account", NULL, NULL);
    if (!server) return;
    CHECK_INT(post(server, "X-Account: " KKK "alice\r\n", 1, alices), 202);
    CHECK_INT(post(server, "X-Account: " KKK "bob\r\n", 1, bobs), 202);
    CHECK_INT(listed(server, "X-Account: " KKK "bob\r\n", alices), 0);
    CHECK_INT(listed(server, "X-Account: " KKK "bob\r\n", bobs), 1);
    CHECK_INT(listed(server, "X-Account: " KKK "alice\r\n", alices), 1);
    CHECK_INT(listed(server, "", alices), -401);
    CHECK_INT(drop(server, "jobs", alices, "X-Account: " KKK "bob\r\n"), 403);
    /* an account with a token is identified by the token; what it posted without one it may still
     * end */
    CHECK_INT(listed(server, "X-Account: " KKK "alice\r\n" BOB, alices), 0);
    CHECK_INT(drop(server, "jobs", alices, "X-Account: " KKK "alice\r\n" BOB), 200);
    CHECK_INT(drop(server, "jobs", bobs, "X-Account: " KKK "bob\r\n"), 200);
    CHECK_INT(test_request(server, &reply, "GET", "/v1/jobs", "X-Account: j\xc3\xb6rg\r\n", NULL),
              400);
    ask_problem(&reply, 400, NULL);
    test_reply_clear(&reply);
    CHECK_INT(test_request(server, &reply, "GET", "/readyz", "", NULL), 200);
}

TEST(accounts_of_a_proxy_are_compared_whole) { place_on_both(accounts); }

static void addresses(struct place *place) {
    char first[ID + 1], second[ID + 1], third[ID + 1];
    OWN(test_server, stop) *server = behind(place, "X-Forwarded-For", NULL, NULL);
    if (!server) return;
    CHECK_INT(post(server, "X-Forwarded-For: 192.0.2.1\r\n", 1, first), 202);
    CHECK_INT(post(server, "X-Forwarded-For: 2001:db8:1:2::1\r\n", 1, second), 202);
    CHECK_INT(post(server, "X-Forwarded-For: 192.0.2.1\r\n" ALICE, 1, third), 202);
    CHECK_INT(listed(server, "X-Forwarded-For: 192.0.2.1\r\n", first), -401);
    /* without a token: clients from the same address, for IPv6 the same network, that know the
     * id */
    CHECK_INT(drop(server, "jobs", first, "X-Forwarded-For: 192.0.2.2\r\n"), 403);
    CHECK_INT(drop(server, "jobs", first, "X-Forwarded-For: 192.0.2.2\r\n" ALICE), 403);
    CHECK_INT(drop(server, "jobs", third, "X-Forwarded-For: 192.0.2.1\r\n"), 401);
    CHECK_INT(drop(server, "jobs", first, "X-Forwarded-For: 192.0.2.1\r\n"), 200);
    CHECK_INT(drop(server, "jobs", second, "X-Forwarded-For: 2001:db8:1:3::1\r\n"), 403);
    CHECK_INT(drop(server, "jobs", second, "X-Forwarded-For: 2001:db8:1:2:ffff::9\r\n" ALICE), 200);
    /* a token is the same client from any address */
    CHECK_INT(listed(server, "X-Forwarded-For: 198.51.100.7\r\n" ALICE, third), 1);
    CHECK_INT(drop(server, "jobs", third, "X-Forwarded-For: 198.51.100.7\r\n" ALICE), 200);
}

TEST(a_job_without_a_token_is_its_addresss_and_a_token_is_nobodys_address) {
    place_on_both(addresses);
}

/* opens a stream of a job's events as a client of an address; returns its status */
static int listens(const struct test_server *server, struct test_client *client, const char *id,
                   const char *headers) {
    char text[512], data[4096] = "";
    size_t bytes = 0;
    snprintf(text, sizeof text, "GET /v1/jobs/%s/events HTTP/1.1\r\nHost: localhost\r\n%s\r\n", id,
             headers);
    if (!test_client_open(client, test_server_port(server)) ||
        !CHECK(test_client_say(client, text)))
        return 0;
    while (bytes < 12) {
        long got = recv(client->fd, data + bytes, sizeof data - 1 - bytes, 0);
        if (got <= 0) return 0;
        bytes += (size_t)got;
    }
    return atoi(data + 9);
}

TEST(event_streams_are_counted_by_client_and_by_network) {
    OWN(place, end) place;
    struct test_client client[12];
    char id[ID + 1], headers[128];
    REQUIRE(place_begin(&place, 0));
    /* an api process computes nothing, so the job lives */
    const char *const options[] = {
        "--store", place.url,         "--role",    "api", "--max-event-streams",
        "8",       "--trusted-proxy", "127.0.0.1", NULL};
    OWN(test_server, stop) *server = test_server_start(options);
    if (server) {
        CHECK_INT(post(server, "", 1, id), 202);
        /* a quarter of eight for a client; eight addresses of one network are one */
        for (int i = 0; i < 3; i++) {
            snprintf(headers, sizeof headers, "X-Forwarded-For: 2001:db8:1:2::%d\r\n", i + 1);
            CHECK_INT(listens(server, &client[i], id, headers), i < 2 ? 200 : 429);
        }
        /* each token counts for itself, but one network has at most three quarters: 6 */
        for (int i = 3; i < 8; i++) {
            snprintf(headers, sizeof headers,
                     "X-Forwarded-For: 2001:db8:1:2::1\r\nAuthorization: Bearer "
                     "token-number-%d-abcdefgh\r\n",
                     i);
            CHECK_INT(listens(server, &client[i], id, headers), i < 7 ? 200 : 429);
        }
        /* others still have room */
        CHECK_INT(listens(server, &client[8], id, "X-Forwarded-For: 2001:db8:1:3::1\r\n"), 200);
        for (int i = 0; i < 9; i++) test_client_close(&client[i]);
    }
}

/* 1 if a file, or its write-ahead log, contains a text */
static int file_has(const char *path, const char *text) {
    static const char *const ends[] = {"", "-wal"};
    int has = 0;
    for (int i = 0; i < 2; i++) {
        char name[160], *data = NULL;
        size_t bytes = 0, size = 0;
        FILE *file = NULL;
        snprintf(name, sizeof name, "%s%s", path, ends[i]);
        if ((file = fopen(name, "rb"))) {
            FILE *copy = open_memstream(&data, &size);
            char block[4096];
            while (copy && (bytes = fread(block, 1, sizeof block, file)) > 0)
                fwrite(block, 1, bytes, copy);
            if (copy) fclose(copy);
            fclose(file);
        }
        has |= data && memmem(data, size, text, strlen(text)) != NULL;
        free(data);
    }
    return has;
}

TEST(tokens_accounts_and_addresses_are_nowhere_in_clear_but_addresses_in_the_log) {
    static const char *const secrets[] = {"alice-Zm9v", KKK};
    OWN(place, end) place;
    struct test_reply reply;
    char id[ID + 1], path[128], sought[ID + 8];
    REQUIRE(place_begin(&place, 0));
    OWN(test_server, drop) *server = behind(&place, "X-Account", NULL, NULL);
    if (server) {
        CHECK_INT(post(server, "X-Account: " KKK "alice\r\n" ALICE, 1, id), 202);
        CHECK_INT(scene(server, "X-Account: " KKK "alice\r\n" KEYED, "mine", id), 201);
        CHECK_INT(scene(server, "X-Account: " KKK "alice\r\n" ALICE, "mine", id), 201);
        CHECK_INT(scene(server, "", "nobody's", id), 201);
        CHECK_INT(post(server, "X-Account: " KKK "alice\r\n", 1, id), 202);
        CHECK_INT(drop(server, "jobs", id, "X-Account: " KKK "bob\r\n" ALICE), 403);
        CHECK_INT(test_request(server, &reply, "GET", "/metrics", "", NULL), 200);
        for (int i = 0; i < 2; i++) CHECK(!strstr(reply.body, secrets[i]));
        test_reply_clear(&reply);
        snprintf(path, sizeof path, "%s/store.db", place.directory);
        snprintf(sought, sizeof sought, "%s", id);
        CHECK(file_has(path, sought));
        for (int i = 0; i < 2; i++) CHECK(!file_has(path, secrets[i]));
        CHECK(!file_has(path, "127.0.0.1"));
        test_server_signal(server, SIGTERM);
        CHECK_INT(test_server_wait(server), 0);
        const char *log = test_server_log(server);
        for (int i = 0; i < 2; i++) CHECK_SAYING(!strstr(log, secrets[i]), "%s", log);
        CHECK_SAYING(strstr(log, "\"client\":\"account:") && strstr(log, "\"token\":\"token:"),
                     "%s", log);
        CHECK(strstr(log, "\"client\":\"127.0.0.1\"") != NULL);
    }
}

/* a list and a deletion cost the store something: they count like computations; reading by id does
 * not */
TEST(lists_and_ends_count_for_the_quota_of_requests) {
    OWN(place, end) place;
    struct test_reply reply;
    char id[ID + 1];
    REQUIRE(place_begin(&place, 0));
    OWN(test_server, stop) *server =
        place_serve(&place, "all", "1", "--max-requests-a-minute", "3");
    if (server) {
        CHECK_INT(post(server, ALICE, 1, id), 202);
        CHECK_INT(listed(server, ALICE, id), 1);
        CHECK_INT(drop(server, "scenes", id, ALICE), 404);
        CHECK_INT(drop(server, "jobs", id, ALICE), 429);
        CHECK_INT(listed(server, ALICE, id), -429);
        CHECK_INT(drop(server, "scenes", id, ALICE), 429);
        for (int i = 0; i < 5; i++) {
            CHECK_INT(job_get(server, &reply, id, "", ALICE), 200);
            test_reply_clear(&reply);
        }
        /* another token of the address has a quota of its own */
        CHECK_INT(listed(server, BOB, id), 0);
    }
}
