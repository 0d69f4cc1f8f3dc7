/* Jobs as a client sees them, on both stores: the same bits as an undisturbed answer, whatever
 * crashes meanwhile. */
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/wire/place.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SECOND "3" /* everything takes longer */
#define WAY "2000"
#define PART "0.001"
enum { KILLS = 4, MOST_LIFE = 3 };
#else
#define SECOND "50"
#define WAY "20000"
#define PART "0.02"
enum { KILLS = 6, MOST_LIFE = 1 };
#endif
#define FLIPS                                                                                      \
    "{\"pendulum\":" ASK_DOUBLE                                                                    \
    ",\"duration\":20,\"grid\":[{\"vary\":\"theta\",\"arm\":1,\"start\":-3,\"stop\":3,"            \
    "\"count\":60},{\"vary\":\"theta\",\"arm\":2,\"start\":-3,\"stop\":3,\"count\":" SECOND "}],"  \
    "\"observables\":[\"first_flip\",\"final\"]}"

/* one trajectory of many parts */
#define LONG_WAY                                                                                   \
    "{\"pendulum\":" ASK_DOUBLE                                                                    \
    ",\"initial\":{\"phi\":[1,2]},\"times\":{\"start\":0,\"stop\":" WAY                            \
    ",\"step\":0.5},\"rtol\":1e-14,\"output\":[\"phi\",\"lambda\"]}"

#define LONG_BRANCH                                                                                \
    "{\"pendulum\":{\"length\":[1,1,1,1],\"mass\":[1,1,1,1],\"parent\":[0,1,2,3]},\"mode\":1,"     \
    "\"amplitude\":0.8,\"branch\":true,\"rows\":\"orbits\",\"step\":0.0005,\"points\":2500}"

#define PASSAGES(duration)                                                                         \
    "{\"pendulum\":" ASK_DOUBLE ",\"section\":{\"arm\":1,\"theta\":0},\"duration\":" duration "}"

/* the only difference between two answers */
static void blank_seconds(struct test_reply *reply) {
    char *at = strstr(reply->body, "\"compute_seconds\":");
    if (!at) return;
    at += strlen("\"compute_seconds\":");
    size_t bytes = strcspn(at, ",}"), rest = strlen(at + bytes);
    memmove(at, at + bytes, rest + 1);
    reply->body_bytes -= bytes;
}

static void check_same(struct test_reply *one, struct test_reply *two, const char *what) {
    blank_seconds(one);
    blank_seconds(two);
    int same = one->body_bytes == two->body_bytes && !memcmp(one->body, two->body, one->body_bytes);
    CHECK_SAYING(same && one->body_bytes > 20, "%s differs: %zu and %zu bytes", what,
                 one->body_bytes, two->body_bytes);
}

/* one request whose reply, possibly not text, is not recorded; with a body it is a POST */
static int fetch(const struct test_server *server, struct test_reply *reply, const char *path,
                 const char *accept, const char *body) {
    OWN(test_client, close) client;
    static char text[16384];
    *reply = (struct test_reply){0};
    if (!test_client_open(&client, test_server_port(server))) return 0;
    snprintf(text, sizeof text,
             "%s %s HTTP/1.1\r\nHost: x\r\nConnection: close\r\nAccept: %s\r\nContent-Type: "
             "application/json\r\n"
             "Content-Length: %zu\r\n\r\n%s",
             body ? "POST" : "GET", path, accept, body ? strlen(body) : 0, body ? body : "");
    test_client_say(&client, text);
    return test_client_receive(&client, reply, 0, TEST_PATIENCE);
}

static const struct {
    const char *path, *body, *accept[5];
} kinds[] = {
    {"/v1/ensembles",
     FLIPS,
     {"application/json", "text/csv", "application/octet-stream", "application/x-ndjson",
      "image/png"}},
    {"/v1/ensembles",
     "{\"pendulum\":" ASK_DOUBLE
     ",\"random\":{\"count\":400,\"draw\":[{\"vary\":\"theta\",\"arm\":1,\"distribution\":"
     "\"normal\",\"mean\":1,\"deviation\":1}]},\"duration\":9,\"rows\":\"events\",\"events\":[{"
     "\"of\":\"y\",\"arm\":2,\"value\":-1},{\"of\":\"lambda\",\"arm\":1,\"bound\":5,\"stop\":9}]}",
     {"application/json", "text/csv", "application/octet-stream", "application/x-ndjson"}},
    {"/v1/trajectories", ASK_EXAMPLE, {"application/json", "text/csv", "application/octet-stream"}},
    {"/v1/trajectories", LONG_WAY, {"application/json", "text/csv", "application/octet-stream"}},
    {"/v1/trajectories",
     "{\"pendulum\":" ASK_DOUBLE ",\"times\":[0,30],\"rows\":\"events\",\"events\":[{\"of\":\"y\","
     "\"arm\":2,\"value\":-1},{\"of\":\"lambda\",\"arm\":1,\"bound\":5,\"stop\":9}]}",
     {"application/json", "text/csv", "application/octet-stream", "application/x-ndjson"}},
    {"/v1/forces", ASK_LITTLE, {"application/json", "text/csv"}},
    {"/v1/modes", ASK_LITTLE, {"application/json", "text/csv"}},
    {"/v1/lyapunov",
     "{\"pendulum\":" ASK_DOUBLE ",\"duration\":20,\"samples\":70,\"count\":\"all\"}",
     {"application/json", "text/csv", "application/octet-stream", "application/x-ndjson"}},
    {"/v1/sections",
     PASSAGES("20"),
     {"application/json", "text/csv", "application/octet-stream", "application/x-ndjson"}},
    {"/v1/response",
     "{\"pendulum\":" ASK_DOUBLE ",\"drive\":{\"torque\":{\"arm\":2}},\"poles\":true,\"omega\":{"
     "\"start\":0,\"stop\":9,\"count\":500}}",
     {"application/json"}},
    {"/v1/response",
     "{\"pendulum\":" ASK_DOUBLE ",\"drive\":{\"pivot\":{\"x\":1}},\"output\":["
     "\"transmissibility\"],\"omega\":{\"start\":0,\"stop\":9,\"count\":500}}",
     {"application/json", "text/csv", "application/octet-stream", "application/x-ndjson"}},
    {"/v1/orbits",
     "{\"pendulum\":" ASK_DOUBLE ",\"mode\":1,\"amplitude\":1,\"branch\":true,\"rows\":\"orbits\"}",
     {"application/json", "text/csv", "application/octet-stream", "application/x-ndjson"}},
    {"/v1/fits",
     "{\"pendulum\":" ASK_DOUBLE
     ",\"data\":{\"t\":[0,0.1,0.2,0.3,0.4,0.5],\"series\":[{\"theta\":1,\"values\":[1,0.95,0.8,0."
     "58,0.3,0]}]},\"unknowns\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"theta\",\"arm\":1}]}",
     {"application/json"}},
    /* no passage at all */
    {"/v1/sections", PASSAGES("1e-6"), {"application/json"}},
};
enum { KINDS = sizeof kinds / sizeof *kinds };

static void answers_are_the_same(struct place *place) {
    OWN(test_server, stop) *server = place_serve(place, "all", "0.05", NULL, NULL);
    if (!server) return;
    for (int i = 0; i < KINDS; i++) {
        char id[ID + 1], word[WORDS];
        CHECK_INT(submit(server, kinds[i].path, ASYNC, kinds[i].body, id), 202);
        job_wait(server, id, word);
        CHECK_TEXT(word, "successful");
        struct test_reply reply;
        CHECK_INT(job_get(server, &reply, id, "/results", ""), 200);
        test_reply_clear(&reply);
        for (int a = 0; a < 5 && kinds[i].accept[a]; a++) {
            OWN(test_reply, clear) now, kept;
            const char *accept = kinds[i].accept[a];
            char path[96];
            snprintf(path, sizeof path, "/v1/jobs/%s/results", id);
            CHECK_INT(fetch(server, &now, kinds[i].path, accept, kinds[i].body), 200);
            CHECK_INT(fetch(server, &kept, path, accept, NULL), 200);
            const char *tag = test_reply_header(&now, "ETag");
            CHECK_TEXT(test_reply_header(&kept, "Content-Type"),
                       test_reply_header(&now, "Content-Type"));
            /* the same bytes, so that ranges can be requested: its tag is strong */
            CHECK(tag && !strncmp(tag, "W/", 2) &&
                  !strcmp(tag + 2, test_reply_header(&kept, "ETag")));
            CHECK_TEXT(test_reply_header(&kept, "Accept-Ranges"), "bytes");
            check_same(&now, &kept, kinds[i].accept[a]);
        }
    }
}

/* the HTTP side of a range: fields, conditions, and that a coding is omitted */
static void ranges(struct place *place) {
    char id[ID + 1], word[WORDS], headers[256], text[64];
    OWN(test_reply, clear) whole = {0}, reply = {0};
    OWN(test_server, stop) *server = place_serve(place, "all", "0.05", NULL, NULL);
    if (!server) return;
    CHECK_INT(submit(server, "/v1/trajectories", ASYNC, LONG_WAY, id), 202);
    job_wait(server, id, word);
    CHECK_INT(job_get(server, &whole, id, "/results", "Accept: text/csv\r\n"), 200);
    const char *tag = test_reply_header(&whole, "ETag");
    if (!CHECK(tag && tag[0] == '"' && whole.body_bytes > 100000)) return;
    const struct {
        const char *fields, *condition;
        size_t first, count; /* count 0: the whole */
        int status;
    } row[] = {
        {"Range: bytes=0-9\r\n", NULL, 0, 10, 206},
        {"Range: bytes=90000-90999\r\nAccept-Encoding: gzip, zstd\r\n", NULL, 90000, 1000, 206},
        {"Range: bytes=-5\r\n", NULL, whole.body_bytes - 5, 5, 206},
        {"Range: bytes=50000-\r\n", tag, 50000, whole.body_bytes - 50000, 206},
        {"Range: bytes=0-9\r\n", "\"another\"", 0, 0, 200},
        {"Range: bytes=0-9\r\n", "Sun, 06 Nov 1994 08:49:37 GMT", 0, 0, 200},
        {"Range: bytes=0-9,20-29\r\n", NULL, 0, 0, 200},
        {"Range: pages=1-2\r\n", NULL, 0, 0, 200},
        {"Range: bytes=99999999999-\r\n", NULL, 0, 0, 416},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        snprintf(headers, sizeof headers, "Accept: text/csv\r\n%s%s%s%s", row[i].fields,
                 row[i].condition ? "If-Range: " : "", row[i].condition ? row[i].condition : "",
                 row[i].condition ? "\r\n" : "");
        CHECK_INT(job_get(server, &reply, id, "/results", headers), row[i].status);
        size_t count = row[i].count ? row[i].count : whole.body_bytes;
        const char *range = test_reply_header(&reply, "Content-Range");
        if (row[i].status == 416) {
            ask_problem(&reply, 416, NULL);
            snprintf(text, sizeof text, "bytes */%zu", whole.body_bytes);
        } else {
            CHECK(reply.body_bytes == count &&
                  !memcmp(reply.body, whole.body + row[i].first, count));
            CHECK_TEXT(test_reply_header(&reply, "ETag"), tag);
            CHECK(!test_reply_header(&reply, "Content-Encoding"));
            snprintf(text, sizeof text, "bytes %zu-%zu/%zu", row[i].first, row[i].first + count - 1,
                     whole.body_bytes);
        }
        if (row[i].status == 200)
            CHECK(!range);
        else
            CHECK_TEXT(range, text);
        test_reply_clear(&reply);
    }
    /* a range has no effect on HEAD, nor for a client that has the answer */
    snprintf(headers, sizeof headers,
             "Accept: text/csv\r\nRange: bytes=0-9\r\nIf-None-Match: %s\r\n", tag);
    CHECK_INT(job_get(server, &reply, id, "/results", headers), 304);
    test_reply_clear(&reply);
    snprintf(text, sizeof text, "/v1/jobs/%s/results", id);
    CHECK_INT(test_request(server, &reply, "HEAD", text,
                           "Accept: application/octet-stream\r\nRange: bytes=0-9\r\n", NULL),
              200);
    const char *length = test_reply_header(&reply, "Content-Length");
    CHECK(length && atol(length) > 100000 && !test_reply_header(&reply, "Content-Range"));
    test_reply_clear(&reply);
    /* doubles cannot contain the statistics: they follow in trailers, except for a range */
    CHECK_INT(job_get(server, &reply, id, "/results", "Accept: application/octet-stream\r\n"), 200);
    CHECK(reply.trailer ? strstr(reply.trailer, "X-Horizon: ") != NULL
                        : test_reply_header(&reply, "X-Horizon") != NULL);
    test_reply_clear(&reply);
    CHECK_INT(job_get(server, &reply, id, "/results",
                      "Accept: application/octet-stream\r\nRange: bytes=8-15\r\n"),
              206);
    CHECK(reply.body_bytes == 8 && !reply.trailer && test_reply_header(&reply, "Content-Length"));
}

TEST(results_come_in_ranges_as_well) { place_on_both(ranges); }

TEST(results_of_a_job_are_those_of_a_request_bit_for_bit) { place_on_both(answers_are_the_same); }

/* a problem of that status for a method and a path */
static void refused(const struct test_server *server, const char *method, const char *path,
                    const char *headers, const char *body, int status) {
    OWN(test_reply, clear) reply;
    test_request(server, &reply, method, path, headers, body);
    ask_problem(&reply, status, NULL);
}

static void refusals(struct place *place) {
    char id[ID + 1], again[ID + 1], path[64], word[WORDS];
    struct test_reply reply;
    OWN(test_server, stop) *server = place_serve(place, "all", "1", NULL, NULL);
    if (!server) return;
    CHECK_INT(
        submit(server, "/v1/trajectories", ASYNC "Idempotency-Key: \"one\"\r\n", ask_long(1e6), id),
        202);
    CHECK_INT(
        submit(server, "/v1/trajectories", ASYNC "Idempotency-Key: one\r\n", ask_long(1e6), again),
        202);
    CHECK_TEXT(again, id);
    refused(server, "POST", "/v1/trajectories", ASYNC "Idempotency-Key: one\r\n", ASK_EXAMPLE, 422);
    refused(server, "POST", "/v1/forces", ASYNC "Idempotency-Key: one\r\n", ASK_LITTLE, 422);
    refused(server, "POST", "/v1/forces", ASYNC "Idempotency-Key: \r\n", ASK_LITTLE, 400);
    refused(server, "POST", "/v1/forces", ASYNC "Idempotency-Key: a b\r\n", ASK_LITTLE, 400);
    refused(server, "POST", "/v1/forces", ASYNC, "{\"pendulum\":{}}", 422);
    refused(server, "POST", "/v1/forces", ASYNC, "{", 400);
    refused(server, "POST", "/v1/ensembles", ASYNC, "{\"pendulum\":" ASK_DOUBLE "}", 422);
    refused(server, "POST", "/v1/lyapunov", ASYNC, ASK_LITTLE, 422);
    refused(server, "POST", "/v1/sections", ASYNC, ASK_LITTLE, 422);
    /* a direct answer is sent at once */
    CHECK_INT(test_request(server, &reply, "POST", "/v1/trees", ASYNC, ASK_LITTLE), 200);
    test_reply_clear(&reply);
    refused(server, "GET", "/v1/jobs/0123456789abcdefghjkmnpqrs", "", NULL, 404);
    refused(server, "GET", "/v1/jobs/0123456789abcdefghjkmnpqrs/results", "", NULL, 404);
    refused(server, "DELETE", "/v1/jobs/0123456789abcdefghjkmnpqrs", "", NULL, 404);
    refused(server, "GET", "/v1/jobs/'--", "", NULL, 404);
    refused(server, "GET", "/v1/jobs?limit=0", "", NULL, 422);
    refused(server, "GET", "/v1/jobs?before=x", "", NULL, 422);
    refused(server, "GET", "/v1/jobs?of=me", "", NULL, 422);
    refused(server, "POST", "/v1/jobs", "", "{}", 405);
    snprintf(path, sizeof path, "/v1/jobs/%s/results", id);
    refused(server, "GET", path, "", NULL, 409);
    path[9 + ID] = 0;
    CHECK_INT(test_request(server, &reply, "DELETE", path, "", NULL), 200);
    CHECK(strstr(reply.body, "\"status\":\"dismissed\"") != NULL);
    test_reply_clear(&reply);
    job_wait(server, id, word);
    CHECK_TEXT(word, "dismissed");
    path[9 + ID] = '/';
    refused(server, "GET", path, "", NULL, 409);
}

static void failures(struct place *place) {
    char id[ID + 1], word[WORDS];
    OWN(test_reply, clear) reply = {0};
    OWN(test_server, stop) *server = place_serve(place, "all", "1", "--max-client-jobs", "1");
    if (!server) return;
    /* found during the computation */
    CHECK_INT(submit(server, "/v1/trajectories", ASYNC,
                     "{\"pendulum\":" ASK_DOUBLE
                     ",\"initial\":{\"phi\":[0,0],\"phid\":[1e200,0]},\"times\":[0,1]}",
                     id),
              202);
    job_wait(server, id, word);
    CHECK_TEXT(word, "failed");
    CHECK_INT(job_get(server, &reply, id, "", ""), 200);
    CHECK_SAYING(!strstr(reply.body, "\"message\":\"\""), "no reason in %s", reply.body);
    test_reply_clear(&reply);
    CHECK_INT(job_get(server, &reply, id, "/results", ""), 409);
    test_reply_clear(&reply);
    /* over a quota */
    CHECK_INT(submit(server, "/v1/trajectories", ASYNC, ask_long(1e6), id), 202);
    refused(server, "POST", "/v1/forces", ASYNC, ASK_LITTLE, 429);
    test_server_stop(&server);
    server = place_serve(place, "all", "1", "--max-client-bytes", "65536");
    if (!server) return;
    char path[64];
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    CHECK_INT(test_request(server, &reply, "DELETE", path, "", NULL), 200);
    test_reply_clear(&reply);
    CHECK_INT(submit(server, "/v1/trajectories", ASYNC,
                     "{\"pendulum\":" ASK_DOUBLE
                     ",\"times\":{\"start\":0,\"stop\":1,\"count\":9999}}",
                     id),
              202);
    job_wait(server, id, word);
    CHECK_TEXT(word, "failed");
    CHECK_INT(job_get(server, &reply, id, "", ""), 200);
    CHECK_SAYING(strstr(reply.body, "max-client-bytes") != NULL, "it says %s", reply.body);
}

TEST(a_job_that_fails_says_why) { place_on_both(failures); }

TEST(what_is_wrong_about_a_job_is_said) { place_on_both(refusals); }

enum { DISMISSALS = 4 };

/* a worker is notified long before it renews its lease, after a third of the hour */
static void a_dismissal(struct place *place) {
    char id[ID + 1], path[64];
    struct test_reply reply;
    place->lease = "3600";
    struct test_server *one = place_serve(place, "api", "1", NULL, NULL);
    struct test_server *two = place_serve(place, "all", "1", NULL, NULL);
    for (int i = 0; i < DISMISSALS && one && two; i++) {
        CHECK_INT(submit(one, "/v1/trajectories", ASYNC, ask_long(1e6), id), 202);
        ask_await(two, "pendulumd_workers_busy", 1, 1);
        snprintf(path, sizeof path, "/v1/jobs/%s", id);
        /* here, and in another process */
        CHECK_INT(test_request(i % 2 ? one : two, &reply, "DELETE", path, "", NULL), 200);
        test_reply_clear(&reply);
        ask_await(two, "pendulumd_workers_busy", 0, 0);
    }
    test_server_stop(&one);
    test_server_stop(&two);
}

TEST(a_dismissed_job_stops_here_and_elsewhere) { place_on_both(a_dismissal); }

/* a job during whose only part four workers die is not tried for ever, and says why */
static void poison(struct place *place) {
    char id[ID + 1], word[WORDS], path[64];
    struct test_reply reply;
    place->lease = "0.7";
    struct test_server *server = place_serve(place, "all", "3600", NULL, NULL);
    if (!server) return;
    CHECK_INT(submit(server, "/v1/trajectories", ASYNC, ask_long(1e6), id), 202);
    for (int i = 0; i < 4 && server; i++) {
        ask_await(server, "pendulumd_workers_busy", 1, 1);
        test_server_drop(&server);
        server = place_serve(place, "all", "3600", NULL, NULL);
    }
    if (server) {
        job_wait(server, id, word);
        CHECK_TEXT(word, "failed");
        CHECK_INT(job_get(server, &reply, id, "", ""), 200);
        CHECK_SAYING(strstr(reply.body, "failed: 3 workers ended or stopped responding while they "
                                        "computed only part 1 of 1"),
                     "%s", reply.body);
        test_reply_clear(&reply);
        snprintf(path, sizeof path, "/v1/jobs/%s/results", id);
        refused(server, "GET", path, "", NULL, 409);
        stop_after_deaths(&server);
    }
}

TEST(a_job_that_kills_its_workers_is_given_up) { place_on_both(poison); }

static void forgotten(struct place *place) {
    char id[ID + 1];
    struct test_reply reply;
    int status = 0;
    OWN(test_server, stop) *server = place_serve(place, "all", "1", "--keep-seconds", "1");
    if (!server) return;
    CHECK_INT(submit(server, "/v1/forces", ASYNC, ASK_LITTLE, id), 202);
    for (double end = test_clock() + TEST_PATIENCE; status != 404 && test_clock() < end;
         test_sleep(0.1)) {
        status = job_get(server, &reply, id, "", "");
        test_reply_clear(&reply);
    }
    CHECK_INT(status, 404);
}

TEST(a_job_is_forgotten_when_it_was_kept_for_its_time) { place_on_both(forgotten); }

/* the stored request contains its meaning without blanks, and is deleted by DELETE */
static void padding(struct place *place) {
    static char body[12000];
    char id[ID + 1], path[64];
    struct test_reply reply;
    const char *little = ASK_LITTLE;
    OWN(test_server, stop) *server = place_serve(place, "api", "1", NULL, NULL);
    if (!server) return;
    memset(body, ' ', sizeof body - 1);
    memcpy(body, little, 1);
    memcpy(body + sizeof body - strlen(little), little + 1, strlen(little));
    CHECK_INT(submit(server, "/v1/forces", ASYNC, body, id), 202);
    CHECK(ask_await(server, "pendulumd_store_bytes", 1024, 1024 + (double)strlen(little) + 8));
    CHECK(ask_metric(server, "pendulumd_store_bytes") > 1024);
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    CHECK_INT(test_request(server, &reply, "DELETE", path, "", NULL), 200);
    test_reply_clear(&reply);
    CHECK(ask_await(server, "pendulumd_store_bytes", 1024, 1024));
}

TEST(a_request_is_kept_without_its_blanks_and_not_after_its_job) { place_on_both(padding); }

/* processes that are suspended for longer than their leases, more often than a poisonous job would
 * be tried, continue with their parts; one on each store, suspended at the same time */
TEST(a_process_that_slept_takes_nothing_from_itself) {
    struct place place[2];
    struct test_server *server[2];
    char id[2][ID + 1], path[64];
    struct test_reply reply;
    int count = 0, stores = access("/usr/lib/postgresql", F_OK) ? 1 : 2;
    if (stores == 1) test_skip("PostgreSQL is not installed");
    for (; count < stores && place_begin(&place[count], count); count++) {
        place[count].lease = "0.7";
        server[count] = place_serve(&place[count], "all", "3600", NULL, NULL);
        REQUIRE(server[count]);
        CHECK_INT(submit(server[count], "/v1/trajectories", ASYNC, ask_long(1e6), id[count]), 202);
        ask_await(server[count], "pendulumd_workers_busy", 1, 1);
    }
    for (int i = 0; i < 8; i++) {
        for (int k = 0; k < count; k++) test_server_signal(server[k], i % 2 ? SIGCONT : SIGSTOP);
        test_sleep(i % 2 ? 0.4 : 1.2);
    }
    for (int k = 0; k < count; k++) {
        ask_await(server[k], "pendulumd_workers_busy", 1, 1);
        snprintf(path, sizeof path, "/v1/jobs/%s", id[k]);
        CHECK_INT(test_request(server[k], &reply, "DELETE", path, "", NULL), 200);
        CHECK_SAYING(strstr(reply.body, "\"dismissed\"") != NULL, "%s", reply.body);
        test_reply_clear(&reply);
        /* it did not report returned parts or an unreachable store */
        test_server_stop(&server[k]);
        place_end(&place[k]);
    }
}

/* invalid ensembles are refused as jobs, too, with their pointers */
TEST(ensembles_that_make_no_sense_make_no_job) {
    static const struct {
        const char *rest, *pointer;
    } bad[] = {
        {"\"grid\":[{\"vary\":\"theta\",\"arm\":1,\"start\":0,\"stop\":1,\"count\":100000},{"
         "\"vary\":\"theta\",\"arm\":2,\"start\":0,\"stop\":1,\"count\":100000}]",
         "/grid"},
        {"\"grid\":[{\"vary\":\"theta\",\"arm\":3,\"start\":0,\"stop\":1,\"count\":2}]",
         "/grid/0/arm"},
        {"\"states\":[{}],\"observables\":[\"colour\"]", "/observables/0"},
    };
    OWN(place, end) place;
    struct test_reply reply;
    REQUIRE(place_begin(&place, 0));
    OWN(test_server, stop) *server = place_serve(&place, "all", "1", NULL, NULL);
    for (size_t i = 0; server && i < sizeof bad / sizeof *bad; i++) {
        char body[512];
        snprintf(body, sizeof body, "{\"pendulum\":" ASK_DOUBLE ",\"duration\":1,%s}", bad[i].rest);
        CHECK_INT(test_request(server, &reply, "POST", "/v1/ensembles", ASYNC, body), 422);
        ask_problem(&reply, 422, bad[i].pointer);
        test_reply_clear(&reply);
    }
    if (server) CHECK_INT((int)ask_metric(server, "pendulumd_jobs{state=\"accepted\"}"), 0);
}

/* the undisturbed answer of FLIPS */
static void flips_now(const struct test_server *server, struct test_reply *reply) {
    CHECK_INT(test_request(server, reply, "POST", "/v1/ensembles", "Accept: text/csv\r\n", FLIPS),
              200);
}

static void check_flips(const struct test_server *server, const char *id,
                        struct test_reply *right) {
    char word[WORDS];
    OWN(test_reply, clear) kept = {0};
    job_wait(server, id, word);
    if (strcmp(word, "successful") != 0 && job_get(server, &kept, id, "", "") == 200) {
        CHECK_SAYING(0, "%s", kept.body);
        test_reply_clear(&kept);
    }
    CHECK_INT(job_get(server, &kept, id, "/results", "Accept: text/csv\r\n"), 200);
    check_same(right, &kept, "what was disturbed");
}

/* whether a job waits or runs */
static int is_open(const struct test_server *server, const char *id) {
    OWN(test_reply, clear) reply;
    return job_get(server, &reply, id, "", "") == 200 &&
           (strstr(reply.body, "\"status\":\"running\"") ||
            strstr(reply.body, "\"status\":\"accepted\""));
}

/* waits until this life of a server has stored so many parts, or no job is left: three lives in a
 * row without progress of a job end it as poison, and on a busy machine a life may be too short for
 * anything */
static void until_kept(const struct test_server *server, int parts, char id[][ID + 1], int jobs) {
    for (double end = test_clock() + TEST_PATIENCE; test_clock() < end; test_sleep(0.01)) {
        if (ask_metric(server, "pendulumd_job_parts_total{end=\"kept\"}") >= parts) return;
        int open = 0;
        for (int i = 0; i < jobs && !open; i++) open = is_open(server, id[i]);
        if (!open) return;
    }
    CHECK_SAYING(0, "no parts are kept");
}

static void kills(struct place *place) {
    unsigned long long random = (unsigned long long)(test_clock() * 1e6);
    char id[KILLS + 1][ID + 1];
    OWN(test_reply, clear) right = {0};
    place->lease = "0.7";
    struct test_server *server = place_serve(place, "all", PART, NULL, NULL);
    if (!server) return;
    flips_now(server, &right);
    for (int i = 0; i < KILLS && server; i++) {
        CHECK_INT(submit(server, "/v1/ensembles", ASYNC, FLIPS, id[i]), 202);
        /* all jobs get their turns */
        until_kept(server, 2 * KILLS, id, i + 1);
        test_sleep(0.5 * MOST_LIFE * test_random(&random));
        test_server_drop(&server);
        server = place_serve(place, "all", PART, NULL, NULL);
    }
    if (server) {
        CHECK_INT((int)ask_metric(server, "pendulumd_jobs{state=\"failed\"}"), 0);
        for (int i = 0; i < KILLS; i++) check_flips(server, id[i], &right);
        stop_after_deaths(&server);
    }
}

TEST(a_daemon_killed_at_any_instant_loses_no_job_and_no_bit) { place_on_both(kills); }

/* kills a server again and again while it computes; returns how often the job was still running
 * before a kill */
static int kill_running(struct place *place, const char *path, const char *body,
                        const struct test_reply *right) {
    unsigned long long random = (unsigned long long)(test_clock() * 1e6);
    char id[1][ID + 1], word[WORDS];
    struct test_reply kept, same = {.body = strdup(right->body), .body_bytes = right->body_bytes};
    int killed_running = 0;
    struct test_server *server = place_serve(place, "all", PART, NULL, NULL);
    if (server) CHECK_INT(submit(server, path, ASYNC, body, id[0]), 202);
    for (int i = 0; i < KILLS && server; i++) {
        until_kept(server, 1, id, 1);
        test_sleep(0.05 + 0.2 * MOST_LIFE * test_random(&random));
        killed_running += is_open(server, id[0]);
        test_server_drop(&server);
        server = place_serve(place, "all", PART, NULL, NULL);
    }
    if (server) {
        job_wait(server, id[0], word);
        CHECK_TEXT(word, "successful");
        CHECK_INT(job_get(server, &kept, id[0], "/results", "Accept: text/csv\r\n"), 200);
        check_same(&same, &kept, "a job whose parts were killed");
        test_reply_clear(&kept);
    }
    stop_after_deaths(&server);
    test_reply_clear(&same);
    return killed_running;
}

/* the parts of a chain begin where the one before ended, in any process; those in between were
 * killed. If a job was over before it could be killed, another one is tried */
static void chained_kills(struct place *place, const char *path, const char *body) {
    OWN(test_reply, clear) right = {0};
    int killed_running = 0;
    place->lease = "0.7";
    struct test_server *server = place_serve(place, "all", PART, NULL, NULL);
    if (!server) return;
    CHECK_INT(test_request(server, &right, "POST", path, "Accept: text/csv\r\n", body), 200);
    test_server_stop(&server);
    for (int i = 0; i < 10 && !killed_running; i++)
        killed_running = kill_running(place, path, body, &right);
    CHECK_SAYING(killed_running > 0, "every job was over before it was killed once");
}

static void trajectory_kills(struct place *place) {
    chained_kills(place, "/v1/trajectories", LONG_WAY);
}

TEST(a_trajectory_killed_in_mid_part_goes_on_with_the_same_bits) {
    place_on_both(trajectory_kills);
}

static void branch_kills(struct place *place) { chained_kills(place, "/v1/orbits", LONG_BRANCH); }

TEST(a_branch_of_orbits_killed_in_mid_part_goes_on_with_the_same_bits) {
    place_on_both(branch_kills);
}

static void drains(struct place *place) {
    char id[ID + 1];
    OWN(test_reply, clear) right = {0};
    struct test_server *server = place_serve(place, "all", PART, NULL, NULL);
    if (!server) return;
    flips_now(server, &right);
    CHECK_INT(submit(server, "/v1/ensembles", ASYNC, FLIPS, id), 202);
    for (int i = 0; i < 4 && server; i++) {
        test_sleep(0.05);
        test_server_stop(&server);
        server = place_serve(place, "all", PART, "--job-lease-seconds", "600");
    }
    /* returned parts are taken at once: nobody waits for a lease of ten minutes */
    if (server) {
        check_flips(server, id, &right);
        test_server_stop(&server);
    }
}

TEST(a_daemon_that_drains_gives_its_parts_back) { place_on_both(drains); }

/* one job is submitted while a process is stopped; without an answer within a second the process
 * continues, because it was stopped in the middle of a write. Returns whether there was one */
static int written_meanwhile(const struct test_server *sleeper, const struct test_server *api) {
    char text[1024];
    OWN(test_client, close) client;
    OWN(test_reply, clear) reply = {0};
    if (!test_client_open(&client, test_server_port(api))) return 0;
    snprintf(text, sizeof text,
             "POST /v1/forces HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n" ASYNC
             "Content-Length: %zu\r\n\r\n%s",
             strlen(ASK_LITTLE), ASK_LITTLE);
    test_client_say(&client, text);
    struct pollfd look = {.fd = client.fd, .events = POLLIN};
    int answered = poll(&look, 1, 1000) > 0;
    if (!answered) test_server_signal(sleeper, SIGCONT);
    int status = test_client_receive(&client, &reply, 0, TEST_PATIENCE);
    return answered && status == 202;
}

/* stops a process, but not in the middle of a write: then it would lock an SQLite file until it
 * continues */
static void stop_between_writes(const struct test_server *sleeper, const struct test_server *api) {
    int written = 0;
    for (int i = 0; i < 100 && !written; i++) {
        if (i) test_server_signal(sleeper, SIGCONT);
        if (i) test_sleep(0.01);
        test_server_signal(sleeper, SIGSTOP);
        written = written_meanwhile(sleeper, api);
    }
    CHECK(written);
}

static void roles(struct place *place) {
    char id[2][ID + 1];
    struct test_reply right, reply;
    place->lease = "2";
    struct test_server *api = place_serve(place, "api", PART, NULL, NULL);
    struct test_server *other = place_serve(place, "api", PART, NULL, NULL);
    struct test_server *worker = place_serve(place, "worker", PART, NULL, NULL);
    struct test_server *sleeper = place_serve(place, "worker", PART, NULL, NULL);
    if (api && other && worker && sleeper) {
        flips_now(api, &right);
        refused(worker, "POST", "/v1/forces", "", ASK_LITTLE, 503);
        CHECK_INT(test_request(worker, &reply, "GET", "/readyz", "", NULL), 200);
        test_reply_clear(&reply);
        for (int i = 0; i < 2; i++)
            CHECK_INT(submit(api, "/v1/ensembles", ASYNC, FLIPS, id[i]), 202);
        test_sleep(0.1);
        /* one is suspended for longer than its lease, and continues; another is killed */
        stop_between_writes(sleeper, api);
        test_sleep(0.3);
        test_server_drop(&worker);
        worker = place_serve(place, "worker", PART, NULL, NULL);
        check_flips(other, id[0], &right);
        test_server_signal(sleeper, SIGCONT);
        check_flips(other, id[1], &right);
        test_reply_clear(&right);
    }
    stop_after_deaths(&api);
    stop_after_deaths(&other);
    stop_after_deaths(&worker);
    stop_after_deaths(&sleeper);
}

TEST(api_and_workers_share_a_store_and_survive_each_other) { place_on_both(roles); }

static int ready_in_time(const struct test_server *server, int wanted) {
    struct test_reply reply;
    int status = 0;
    for (double end = test_clock() + TEST_PATIENCE; test_clock() < end && status != wanted;
         test_sleep(0.05)) {
        status = test_request(server, &reply, "GET", "/readyz?need=jobs", "", NULL);
        test_reply_clear(&reply);
    }
    return status;
}

TEST(a_daemon_starts_before_its_database_and_finds_it) {
    OWN(place, end) place = {0};
    struct test_reply reply;
    char id[ID + 1], word[WORDS];
    if (access("/usr/lib/postgresql", F_OK)) {
        test_skip("PostgreSQL is not installed");
        return;
    }
    REQUIRE(place_begin(&place, 1));
    test_postgres_halt(place.postgres, SIGINT);
    struct test_server *server = place_serve(&place, "all", PART, NULL, NULL);
    if (CHECK(server != NULL)) {
        CHECK_INT(ready_in_time(server, 503), 503);
        double end = test_clock() + TEST_PATIENCE;
        while (!strstr(test_server_log(server), "not reachable") && test_clock() < end)
            test_sleep(0.05);
        CHECK(strstr(test_server_log(server), "not reachable") != NULL);
        /* requests that need no store are answered; others are told to retry */
        CHECK_INT(ask(server, &reply, "/v1/forces", ASK_LITTLE), 200);
        test_reply_clear(&reply);
        refused(server, "POST", "/v1/forces", ASYNC, ASK_LITTLE, 503);
        CHECK(test_postgres_resume(place.postgres));
        CHECK_INT(ready_in_time(server, 200), 200);
        CHECK_INT(submit(server, "/v1/ensembles", ASYNC, FLIPS, id), 202);
        job_wait(server, id, word);
        CHECK_TEXT(word, "successful");
    }
    /* its log reports the absence */
    stop_after_deaths(&server);
}

TEST(a_database_that_crashes_loses_no_job_and_its_absence_is_told) {
    OWN(place, end) place = {0};
    char id[3][ID + 1], path[96];
    struct test_reply right, reply;
    if (access("/usr/lib/postgresql", F_OK)) {
        test_skip("PostgreSQL is not installed");
        return;
    }
    REQUIRE(place_begin(&place, 1));
    place.lease = "2";
    struct test_server *server = place_serve(&place, "all", PART, NULL, NULL);
    if (server) {
        flips_now(server, &right);
        for (int i = 0; i < 3; i++) {
            CHECK_INT(submit(server, "/v1/ensembles", ASYNC, FLIPS, id[i]), 202);
            test_sleep(0.1);
            if (i < 2) CHECK(test_postgres_restart(place.postgres, i ? SIGINT : SIGQUIT));
            CHECK_INT(ready_in_time(server, 200), 200);
            snprintf(path, sizeof path, "/v1/jobs/%s", id[i]);
            CHECK_INT(test_request(server, &reply, "GET", path, "", NULL), 200);
            test_reply_clear(&reply);
            test_sleep(0.3);
        }
        for (int i = 0; i < 3; i++) check_flips(server, id[i], &right);
        /* and now permanently: requests that need no store are answered, the others are told when
         * to retry */
        test_postgres_stop(&place.postgres);
        test_request(server, &reply, "POST", "/v1/forces", ASYNC, ASK_LITTLE);
        CHECK(test_reply_header(&reply, "Retry-After") != NULL);
        ask_problem(&reply, 503, NULL);
        test_reply_clear(&reply);
        refused(server, "GET", "/readyz?need=jobs", "", NULL, 503);
        /* for those this process works as usual, and no load balancer should exclude it */
        CHECK_INT(test_request(server, &reply, "GET", "/readyz", "", NULL), 200);
        CHECK_TEXT(reply.body, "{\"status\":\"degraded\",\"jobs\":\"the store is not reachable\"}");
        test_reply_clear(&reply);
        CHECK_INT(test_request(server, &reply, "POST", "/v1/forces", "", ASK_LITTLE), 200);
        test_reply_clear(&reply);
        stop_after_deaths(&server);
        test_reply_clear(&right);
    }
}

/* --- doubled submissions --- */

enum { CLIENTS = 8, ROUNDS = 5 };

#define TOKEN "Authorization: Bearer a-nightly-script-of-the-lab\r\n"

struct doubled {
    const struct test_server *server;
    char id[ROUNDS][ID + 1];
    int status[ROUNDS];
};

static void *doubled_main(void *context) {
    struct doubled *own = context;
    for (int i = 0; i < ROUNDS; i++) {
        char headers[160];
        snprintf(headers, sizeof headers, ASYNC TOKEN "Idempotency-Key: round-%d\r\n", i);
        OWN(test_client, close) client;
        OWN(test_reply, clear) reply = {0};
        char text[600];
        if (!test_client_open(&client, test_server_port(own->server))) return NULL;
        snprintf(text, sizeof text,
                 "POST /v1/forces HTTP/1.1\r\nHost: x\r\nContent-Type: "
                 "application/json\r\n%sContent-Length: %zu\r\n\r\n%s",
                 headers, strlen(ASK_LITTLE), ASK_LITTLE);
        test_client_say(&client, text);
        own->status[i] = test_client_receive(&client, &reply, 0, TEST_PATIENCE);
        const char *location = test_reply_header(&reply, "Location");
        if (location && strlen(location) == 9 + ID) memcpy(own->id[i], location + 9, ID + 1);
    }
    return NULL;
}

static void doubles(struct place *place) {
    static struct doubled own[CLIENTS];
    pthread_t thread[CLIENTS];
    struct test_reply reply;
    OWN(test_server, stop) *server = place_serve(place, "all", "1", NULL, NULL);
    if (!server) return;
    memset(own, 0, sizeof own);
    for (int i = 0; i < CLIENTS; i++) {
        own[i].server = server;
        if (!CHECK(!pthread_create(&thread[i], NULL, doubled_main, &own[i]))) return;
    }
    for (int i = 0; i < CLIENTS; i++) pthread_join(thread[i], NULL);
    for (int i = 0; i < CLIENTS; i++)
        for (int k = 0; k < ROUNDS; k++) {
            CHECK_INT(own[i].status[k], 202);
            CHECK_TEXT(own[i].id[k], own[0].id[k]);
        }
    /* pages of two: every job once, the newest first */
    char path[96] = "/v1/jobs?limit=2";
    int seen = 0;
    for (int page = 0; page < ROUNDS && path[0]; page++) {
        CHECK_INT(test_request(server, &reply, "GET", path, TOKEN, NULL), 200);
        cJSON *json = ask_json(&reply);
        const cJSON *jobs = cJSON_GetObjectItemCaseSensitive(json, "jobs"), *job;
        cJSON_ArrayForEach(job, jobs) {
            const char *id = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(job, "id"));
            if (seen < ROUNDS) CHECK_TEXT(id, own[0].id[ROUNDS - 1 - seen]);
            seen++;
        }
        const cJSON *links = cJSON_GetObjectItemCaseSensitive(json, "links");
        const char *next = cJSON_GetStringValue(
            cJSON_GetObjectItemCaseSensitive(cJSON_GetArrayItem(links, 0), "href"));
        snprintf(path, sizeof path, "%s", next ? next : "");
        cJSON_Delete(json);
        test_reply_clear(&reply);
    }
    CHECK_INT(seen, ROUNDS);
}

TEST(eight_clients_with_one_key_make_one_job) { place_on_both(doubles); }

TEST(a_server_without_a_store_answers_at_once_and_says_so_of_jobs) {
    struct test_reply reply;
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server);
    CHECK_INT(test_request(server, &reply, "POST", "/v1/forces", ASYNC, ASK_LITTLE), 200);
    CHECK(!test_reply_header(&reply, "Preference-Applied"));
    test_reply_clear(&reply);
    refused(server, "GET", "/v1/jobs", "", NULL, 404);
}

/* a form's numbers may be longer as canonical JSON, in which a job stores it, than as sent */
TEST(a_form_whose_numbers_grow_is_a_job) {
    enum { ARMS = 60, BYTES = 4096 };
    char form[BYTES], mass[BYTES / 4] = "", length[BYTES / 4] = "", parent[BYTES / 4] = "";
    OWN(test_reply, clear) reply = {0};
    OWN(place, end) place;
    for (int i = 0; i < ARMS; i++) {
        snprintf(mass + strlen(mass), sizeof mass - strlen(mass), "%s1e15", i ? "," : "");
        snprintf(length + strlen(length), sizeof length - strlen(length), "%s1e15", i ? "," : "");
        snprintf(parent + strlen(parent), sizeof parent - strlen(parent), "%s%d", i ? "," : "", i);
    }
    snprintf(form, sizeof form,
             "--b\r\nContent-Disposition: form-data; name=request\r\n\r\n{\"pendulum\":{\"mass\":["
             "%s],\"length\":[%s],\"parent\":[%s]},\"unknowns\":[{\"vary\":\"theta\",\"arm\":1}]}"
             "\r\n--b\r\nContent-Disposition: form-data; name=csv\r\n\r\nt,theta_1\r\n0,0.1\r\n"
             "1,0.1\r\n\r\n--b--\r\n",
             mass, length, parent);
    REQUIRE(place_begin(&place, 0));
    OWN(test_server, stop) *server = place_serve(&place, "api", "1", NULL, NULL);
    REQUIRE(server);
    CHECK_INT(test_request(server, &reply, "POST", "/v1/fits",
                           ASYNC "Content-Type: multipart/form-data; boundary=b\r\n", form),
              202);
}
