/* The host names that the server accepts, and what web pages of other origins may do. */
#include <stdio.h>
#include <string.h>

#include "tests/wire/place.h"

#define ALICE "Authorization: Bearer alice-Zm9vYmFyYmF6cXV4MTIz\r\n"
#define EVIL "Origin: https://evil.example\r\n"
#define HEADERS                                                                                    \
    "Accept, Authorization, Class-Token, Content-Type, Idempotency-Key, If-None-Match, If-Range, " \
    "Job-Title, Last-Event-ID, Prefer, Range, "                                                    \
    "Traceparent, X-Request-Id"

/* sends a request unchanged; returns its status */
static int said(const struct test_server *server, struct test_reply *reply, const char *text) {
    OWN(test_client, close) client;
    *reply = (struct test_reply){0};
    if (!test_client_open(&client, test_server_port(server)) ||
        !CHECK(test_client_say(&client, text)))
        return 0;
    return test_client_receive(&client, reply, 0, TEST_PATIENCE);
}

/* the status of a request to a host */
static int told(const struct test_server *server, const char *path, const char *host) {
    OWN(test_reply, clear) reply;
    char text[512];
    snprintf(text, sizeof text, "GET %s HTTP/1.1\r\nHost: %s\r\nConnection: close\r\n\r\n", path,
             host);
    int status = said(server, &reply, text);
    if (status == 421) ask_problem(&reply, 421, NULL);
    test_reply_record(&reply, "GET", path);
    if (status == 421) CHECK_SAYING(strstr(reply.body, "--hosts") != NULL, "%s", reply.body);
    return status;
}

TEST(a_server_on_loopback_answers_to_loopbacks_names_alone) {
    static const char *const options[] = {"--hosts", "auto", NULL};
    static const char *const good[] = {"localhost",     "LOCALHOST:8080", "localhost.",
                                       "lab.localhost", "127.0.0.1:1",    "127.1.2.3",
                                       "[::1]:8080"};
    static const char *const bad[] = {"evil.example",
                                      "evil.example:80",
                                      "localhost.evil.example",
                                      "127.0.0.1.evil.example",
                                      "x",
                                      "128.0.0.1",
                                      "[::2]",
                                      "notlocalhost",
                                      "192.0.2.1",
                                      "localhost:80.evil.x"};
    struct test_reply reply;
    OWN(test_server, stop) *server = test_server_start(options);
    if (!server) return;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        CHECK_SAYING(told(server, "/v1/presets", good[i]) == 200, "%s: %d", good[i],
                     told(server, "/v1/presets", good[i]));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        int status = told(server, "/v1/presets", bad[i]);
        /* a value that is no host is a malformed message */
        CHECK_SAYING(status == 421 || (i >= 9 && status == 400), "%s: %d", bad[i], status);
        CHECK_SAYING(told(server, "/", bad[i]) == status, "%s", bad[i]);
    }
    /* the target's own host counts, if it has one; without any it is HTTP/1.0, which no browser
     * uses */
    CHECK_INT(said(server, &reply,
                   "GET http://evil.example/v1/presets HTTP/1.1\r\nHost: localhost\r\n\r\n"),
              421);
    test_reply_clear(&reply);
    CHECK_INT(said(server, &reply,
                   "GET http://localhost:1/v1/presets HTTP/1.1\r\nHost: evil.example\r\n\r\n"),
              200);
    test_reply_clear(&reply);
    CHECK_INT(said(server, &reply, "GET /v1/presets HTTP/1.0\r\n\r\n"), 200);
    test_reply_clear(&reply);
    /* supervisors use an address */
    CHECK_INT(told(server, "/healthz", "10.1.2.3:8080"), 200);
    CHECK_INT(told(server, "/readyz", "10.1.2.3:8080"), 200);
    CHECK_INT(told(server, "/metrics", "10.1.2.3:8080"), 200);
    CHECK_INT(told(server, "/metrics", "[2001:db8::1]:8080"), 200);
    CHECK_INT(told(server, "/healthz", "pendulumd.default.svc"), 200);
    CHECK_INT(told(server, "/metrics", "evil.example"), 421);
    CHECK_INT(told(server, "/metrics", "10.1.2.3.evil.example"), 421);
}

TEST(hosts_are_those_that_are_listed) {
    static const char *const options[] = {
        "--hosts", "Pendulum.school.example, *.lab.example, 192.0.2.7, h:8443", NULL};
    static const char *const proxied[] = {"--hosts", "auto", "--trusted-proxy", "127.0.0.1", NULL};
    static const char *const wrong[] = {"",     "a b",  "http://a.org", "a/b",    "*a.org",
                                        "a,,b", "[::1", "a:b",          "*.*.org"};
    char text[512];
    struct test_server *server = test_server_start(options);
    if (!server) return;
    CHECK_INT(told(server, "/v1/presets", "pendulum.school.example"), 200);
    CHECK_INT(told(server, "/v1/presets", "pendulum.school.example:8443"), 200);
    CHECK_INT(told(server, "/v1/presets", "a.lab.example"), 200);
    CHECK_INT(told(server, "/v1/presets", "a.b.lab.example."), 200);
    CHECK_INT(told(server, "/v1/presets", "192.0.2.7:80"), 200);
    CHECK_INT(told(server, "/v1/presets", "h:8443"), 200);
    CHECK_INT(told(server, "/v1/presets", "h:80"), 421);
    CHECK_INT(told(server, "/v1/presets", "h"), 421);
    CHECK_INT(told(server, "/v1/presets", "lab.example"), 421);
    CHECK_INT(told(server, "/v1/presets", "school.example"), 421);
    CHECK_INT(told(server, "/v1/presets", "localhost"), 421);
    test_server_stop(&server);
    /* behind a proxy, which passes on the requested name, any host is accepted unless they are
     * listed */
    if (!(server = test_server_start(proxied))) return;
    CHECK_INT(told(server, "/v1/presets", "school.example"), 200);
    test_server_stop(&server);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        const char *const bad[] = {"--hosts", wrong[i], NULL};
        CHECK_SAYING(test_server_run(bad, text, sizeof text) == 2 && strstr(text, "--hosts"),
                     "%s: %s", wrong[i], text);
    }
}

/* a browser's query before a page's request, and the answer's origin and methods */
static const char *preflight(const struct test_server *server, struct test_reply *reply,
                             const char *path, const char *method, const char *origin,
                             const char **methods) {
    char text[512];
    snprintf(text, sizeof text,
             "OPTIONS %s HTTP/1.1\r\nHost: localhost\r\nConnection: "
             "close\r\n%sAccess-Control-Request-Method: %s\r\n"
             "Access-Control-Request-Headers: x-anything, authorization\r\n\r\n",
             path, origin, method);
    CHECK_INT(said(server, reply, text), 204);
    *methods = test_reply_header(reply, "Access-Control-Allow-Methods");
    const char *fields = test_reply_header(reply, "Access-Control-Allow-Headers");
    CHECK_TEXT(fields ? fields : "", HEADERS);
    return test_reply_header(reply, "Access-Control-Allow-Origin");
}

static int sent(const struct test_server *server, struct test_reply *reply, const char *method,
                const char *path, const char *headers, const char *body) {
    int status = test_request(server, reply, method, path, headers, body);
    if (status >= 400) ask_problem(reply, status, NULL);
    return status;
}

#define SCENE "{\"title\":\"t\",\"request\":{\"pendulum\":" ASK_DOUBLE ",\"times\":[0,1]}}"
#define MOTION "{\"pendulum\":" ASK_DOUBLE ",\"times\":[0,1]}"

TEST(a_page_of_another_origin_may_compute_and_read_by_id_and_no_more) {
    OWN(place, end) place;
    struct test_reply reply;
    const char *methods;
    char id[ID + 1], path[96];
    REQUIRE(place_begin(&place, 0));
    OWN(test_server, stop) *server = place_serve(&place, "all", "1", NULL, NULL);
    if (server) {
        CHECK_INT(submit(server, "/v1/trajectories", ASYNC ALICE, MOTION, id), 202);
        snprintf(path, sizeof path, "/v1/jobs/%s", id);
        /* computing is open */
        CHECK_TEXT(preflight(server, &reply, "/v1/trajectories", "POST", EVIL, &methods), "*");
        CHECK_TEXT(methods, "POST, QUERY, OPTIONS");
        test_reply_clear(&reply);
        CHECK_INT(sent(server, &reply, "POST", "/v1/trajectories", EVIL, MOTION), 200);
        CHECK_TEXT(test_reply_header(&reply, "Access-Control-Allow-Origin"), "*");
        test_reply_clear(&reply);
        CHECK_INT(sent(server, &reply, "GET", path, EVIL, NULL), 200);
        CHECK_TEXT(test_reply_header(&reply, "Access-Control-Allow-Origin"), "*");
        test_reply_clear(&reply);
        /* lists, deletions, jobs and scenes are not, whatever the page sends */
        CHECK(!preflight(server, &reply, path, "DELETE", EVIL, &methods));
        CHECK_SAYING(methods && !strstr(methods, "DELETE"), "%s", methods ? methods : "no methods");
        test_reply_clear(&reply);
        CHECK(!preflight(server, &reply, "/v1/jobs", "GET", EVIL, &methods));
        test_reply_clear(&reply);
        static const struct {
            const char *method, *path, *headers, *body;
        } closed[] = {
            {"GET", "/v1/jobs", EVIL ALICE, NULL},
            {"GET", "/metrics", EVIL, NULL},
            {"DELETE", "", EVIL ALICE, NULL},
            {"DELETE", "/v1/scenes/0123456789abcdefghjkmnpqrs", EVIL ALICE, NULL},
            {"POST", "/v1/scenes", EVIL ALICE, SCENE},
            {"POST", "/v1/classes", EVIL, "{}"},
            {"GET", "/v1/classes", EVIL ALICE, NULL},
            {"GET", "/v1/classes/ABCDEF", EVIL ALICE, NULL},
            {"GET", "/v1/classes/ABCDEF/events", EVIL ALICE, NULL},
            {"GET", "/v1/classes/ABCDEF/table", EVIL ALICE, NULL},
            {"POST", "/v1/classes/ABCDEF/pupils", EVIL, "{\"nickname\":\"a\"}"},
            {"PUT", "/v1/classes/ABCDEF/stages/class", EVIL ALICE, "{}"},
            {"DELETE", "/v1/classes/ABCDEF/stages/class", EVIL ALICE, NULL},
            {"DELETE", "/v1/classes/ABCDEF", EVIL ALICE, NULL},
            {"POST", "/v1/scenes", "Origin: null\r\n", SCENE},
            {"GET", "/v1/jobs", EVIL "Sec-Fetch-Site: cross-site\r\n" ALICE, NULL},
            {"GET", "/v1/jobs", "Origin: http://localhost:1\r\nSec-Fetch-Site: same-site\r\n" ALICE,
             NULL},
        };
        for (size_t i = 0; i < sizeof closed / sizeof *closed; i++) {
            const char *to = closed[i].path[0] ? closed[i].path : path;
            CHECK_INT(sent(server, &reply, closed[i].method, to, closed[i].headers, closed[i].body),
                      403);
            CHECK_SAYING(strstr(reply.body, "cors-origins") != NULL, "%s", reply.body);
            CHECK(!test_reply_header(&reply, "Access-Control-Allow-Origin"));
            test_reply_clear(&reply);
        }
        /* a refused job is explained in words that the page can read */
        CHECK_INT(sent(server, &reply, "POST", "/v1/trajectories", EVIL ASYNC, MOTION), 403);
        CHECK_TEXT(test_reply_header(&reply, "Access-Control-Allow-Origin"), "*");
        test_reply_clear(&reply);
        /* the server's own page is allowed, however its browser identifies it */
        char own[160];
        snprintf(own, sizeof own, "Origin: http://127.0.0.1:%d\r\nHost: 127.0.0.1:%d\r\n",
                 test_server_port(server), test_server_port(server));
        char text[512];
        snprintf(text, sizeof text, "GET /v1/jobs HTTP/1.1\r\nConnection: close\r\n%s" ALICE "\r\n",
                 own);
        CHECK_INT(said(server, &reply, text), 200);
        test_reply_clear(&reply);
        snprintf(text, sizeof text,
                 "GET /v1/jobs HTTP/1.1\r\nConnection: close\r\nHost: school.example\r\nOrigin: "
                 "https://school.example:8443\r\n" ALICE "\r\n");
        CHECK_INT(said(server, &reply, text), 200);
        test_reply_clear(&reply);
        CHECK_INT(sent(server, &reply, "GET", "/v1/jobs",
                       "Origin: https://school.example\r\nSec-Fetch-Site: same-origin\r\n" ALICE,
                       NULL),
                  200);
        test_reply_clear(&reply);
    }
}

TEST(a_page_whose_origin_is_listed_may_do_all) {
    OWN(place, end) place;
    struct test_reply reply;
    const char *methods;
    char id[ID + 1], path[96];
    REQUIRE(place_begin(&place, 0));
    OWN(test_server, stop) *server =
        place_serve(&place, "all", "1", "--cors-origins", "*, https://good.example");
    if (server) {
        CHECK_INT(submit(server, "/v1/trajectories", "Origin: https://good.example\r\n" ASYNC ALICE,
                         MOTION, id),
                  202);
        snprintf(path, sizeof path, "/v1/jobs/%s", id);
        CHECK_TEXT(
            preflight(server, &reply, path, "DELETE", "Origin: https://good.example\r\n", &methods),
            "https://good.example");
        CHECK_TEXT(methods, "GET, HEAD, DELETE, OPTIONS");
        test_reply_clear(&reply);
        CHECK_INT(
            sent(server, &reply, "GET", "/v1/jobs", "Origin: https://good.example\r\n" ALICE, NULL),
            200);
        CHECK_TEXT(test_reply_header(&reply, "Access-Control-Allow-Origin"),
                   "https://good.example");
        CHECK_SAYING(strstr(reply.body, id) != NULL, "%s", reply.body);
        test_reply_clear(&reply);
        CHECK_INT(
            sent(server, &reply, "DELETE", path, "Origin: https://good.example\r\n" ALICE, NULL),
            200);
        test_reply_clear(&reply);
        CHECK_INT(sent(server, &reply, "POST", "/v1/trajectories", EVIL, MOTION), 200);
        CHECK_TEXT(test_reply_header(&reply, "Access-Control-Allow-Origin"), "*");
        test_reply_clear(&reply);
        CHECK_INT(sent(server, &reply, "GET", "/v1/jobs", EVIL ALICE, NULL), 403);
        test_reply_clear(&reply);
    }
}
