#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "tests/wire/ask.h"

#define DRIVEN                                                                                     \
    "{\"length\":[1],\"mass\":[1],\"parent\":[0],\"damping\":[0.1],"                               \
    "\"torque\":[{\"harmonics\":[{\"amplitude\":1,\"omega\":3}]}]}"

/* every route with a request that it must answer, and a word that the answer must contain */
static const struct {
    const char *method, *path, *body, *type, *word;
} route[] = {
    {"POST", "/v1/trees", ASK_LITTLE, "application/json", "\"subtree_mass\""},
    {"POST", "/v1/trajectories", ASK_EXAMPLE, "application/json", "\"lambda\""},
    {"POST", "/v1/trajectories",
     "{\"pendulum\":" ASK_DOUBLE
     ",\"times\":[0,5],\"events\":[{\"of\":\"x\",\"arm\":2,\"value\":0}]}",
     "application/json", "\"direction\":\"down\""},
    {"POST", "/v1/forces", "{\"pendulum\":" ASK_DOUBLE ",\"state\":{\"theta\":[0,0]}}",
     "application/json", "\"zdd\""},
    {"POST", "/v1/modes", ASK_LITTLE, "application/json", "\"omega\""},
    {"POST", "/v1/ensembles", "{\"pendulum\":" ASK_DOUBLE ",\"states\":[{},{}],\"duration\":1}",
     "application/json", "\"final\""},
    {"POST", "/v1/lyapunov", "{\"pendulum\":" ASK_DOUBLE ",\"duration\":1}", "application/json",
     "\"exponents\""},
    {"POST", "/v1/sections",
     "{\"pendulum\":" ASK_DOUBLE ",\"duration\":5,\"section\":{\"arm\":1,\"theta\":0}}",
     "application/json", "\"direction\""},
    {"POST", "/v1/lyapunov", "{\"pendulum\":" DRIVEN ",\"start\":1,\"duration\":1}",
     "application/json", "\"exponents\""},
    {"POST", "/v1/sections",
     "{\"pendulum\":" DRIVEN ",\"duration\":5,\"section\":{\"period\":\"drive\"}}",
     "application/json", "\"passages\":2"},
    {"POST", "/v1/response",
     "{\"pendulum\":" ASK_DOUBLE ",\"drive\":{\"pivot\":{\"x\":1}},\"omega\":[1]}",
     "application/json", "\"equilibrium\""},
    {"POST", "/v1/response", "{\"pendulum\":" DRIVEN ",\"poles\":true}", "application/json",
     "\"damping_ratio\""},
    {"POST", "/v1/controllers",
     "{\"pendulum\":" ASK_DOUBLE ",\"actuators\":{\"joints\":[1]},\"period\":0.1}",
     "application/json", "\"multipliers\""},
    {"POST", "/v1/fits",
     "{\"pendulum\":" ASK_DOUBLE
     ",\"data\":{\"t\":[0,0.1,0.2,0.3,0.4,0.5],\"series\":[{\"theta\":1,\"values\":[1,0.95,0.8,0."
     "58,0.3,0]}]},\"unknowns\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"theta\",\"arm\":1}]}",
     "application/json", "\"follows_until\""},
    {"POST", "/v1/tables", "{\"data\":{\"csv\":\"t,theta_1\\n0,1\\n\"}}", "application/json",
     "\"is\":\"theta 1\""},
    {"POST", "/v1/trials", "{\"trials\":[{\"length\":1,\"period\":2}]}", "application/json",
     "\"gravity\""},
    {"POST", "/v1/orbits", "{\"pendulum\":" ASK_DOUBLE ",\"mode\":2,\"amplitude\":0.5}",
     "application/json", "\"multipliers\""},
    {"POST", "/v1/orbits",
     "{\"pendulum\":" DRIVEN ",\"branch\":{\"vary\":\"omega\",\"to\":4},\"points\":3}",
     "application/json", "\"bifurcations\""},
    {"POST", "/v1/equations", ASK_LITTLE, "application/json", "ell_{2}"},
    {"GET", "/", NULL, "text/html; charset=utf-8", "<title>"},
    {"GET", "/oembed?url=http%3A%2F%2Flocalhost%2F%3Flength%3D1", NULL, "application/json",
     "<iframe "},
    {"GET", "/docs", NULL, "text/html; charset=utf-8", "<title>"},
    {"GET", "/v1/presets", NULL, "application/json", "double"},
    {"GET", "/openapi.json", NULL, "application/json", "\"openapi\""},
    {"GET", "/openapi-3.0.json", NULL, "application/json", "\"openapi\":\"3.0.3\""},
    {"GET", "/healthz", NULL, NULL, ""},
    {"GET", "/readyz", NULL, NULL, ""},
    {"GET", "/version", NULL, "application/json", "\"engine\":\""},
};
enum { ROUTES = sizeof route / sizeof *route };

TEST(every_route_answers) {
    struct test_reply reply;
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    for (int i = 0; i < ROUTES; i++) {
        CHECK_INT(test_request(server, &reply, route[i].method, route[i].path, "", route[i].body),
                  200);
        const char *type = test_reply_header(&reply, "Content-Type");
        if (route[i].type) CHECK_TEXT(type, route[i].type);
        CHECK_SAYING(reply.body && strstr(reply.body, route[i].word), "%s has no %s", route[i].path,
                     route[i].word);
        test_reply_clear(&reply);
    }
}

TEST(every_preset_can_be_fetched_and_integrated) {
    struct test_reply reply, one;
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    test_request(server, &reply, "GET", "/v1/presets", "", NULL);
    cJSON *answer = ask_json(&reply);
    const cJSON *presets = cJSON_GetObjectItemCaseSensitive(answer, "presets"), *preset;
    CHECK(cJSON_GetArraySize(presets) >= 11);
    cJSON_ArrayForEach(preset, presets) {
        char path[160];
        const char *name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(preset, "name"));
        snprintf(path, sizeof path, "/v1/presets/%s", name ? name : "");
        CHECK_INT(test_request(server, &one, "GET", path, "", NULL), 200);
        cJSON *got = ask_json(&one), *body = cJSON_CreateObject();
        test_reply_clear(&one);
        cJSON_AddItemToObject(body, "pendulum",
                              cJSON_DetachItemFromObjectCaseSensitive(got, "pendulum"));
        cJSON_AddItemToObject(body, "initial",
                              cJSON_DetachItemFromObjectCaseSensitive(got, "initial"));
        cJSON_AddItemToObject(body, "times", cJSON_Parse("[0,0.5,1]"));
        char *text = cJSON_PrintUnformatted(body);
        CHECK_SAYING(ask(server, &one, "/v1/trajectories", text) == 200, "%s: %s: %.300s", path,
                     text, one.body);
        test_reply_clear(&one);
        cJSON_free(text);
        cJSON_Delete(body);
        cJSON_Delete(got);
    }
    cJSON_Delete(answer);
    test_reply_clear(&reply);
}

TEST(head_answers_what_get_does_without_a_body) {
    struct test_reply get, head;
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    for (int i = 0; i < ROUTES; i++) {
        if (strcmp(route[i].method, "GET") != 0) continue;
        int status = test_request(server, &get, "GET", route[i].path, "", NULL);
        CHECK_INT(test_request(server, &head, "HEAD", route[i].path, "", NULL), status);
        const char *length = test_reply_header(&head, "Content-Length");
        if (length) CHECK_INT(strtoll(length, NULL, 10), (long long)get.body_bytes);
        const char *type_of_head = test_reply_header(&head, "Content-Type");
        CHECK_TEXT(type_of_head, test_reply_header(&get, "Content-Type"));
        test_reply_clear(&get);
        test_reply_clear(&head);
    }
}

/* true if a comma-separated list contains a word */
static int listed(const char *list, const char *word) {
    size_t bytes = strlen(word);
    for (; list && *list; list += strcspn(list, ","), list += *list == ',') {
        list += strspn(list, " ");
        if (!strncasecmp(list, word, bytes) &&
            (!list[bytes] || list[bytes] == ',' || list[bytes] == ' '))
            return 1;
    }
    return 0;
}

TEST(options_and_wrong_methods_say_what_is_allowed) {
    static const char *const wrong[] = {"DELETE", "PUT", "PATCH"};
    struct test_reply reply;
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    for (int i = 0; i < ROUTES; i++) {
        int status = test_request(server, &reply, "OPTIONS", route[i].path, "", NULL);
        CHECK_SAYING(status == 204 || status == 200, "OPTIONS %s gave %d", route[i].path, status);
        CHECK(listed(test_reply_header(&reply, "Allow"), route[i].method));
        CHECK(listed(test_reply_header(&reply, "Allow"), "OPTIONS"));
        test_reply_clear(&reply);
        for (int k = 0; k < 3; k++) {
            test_request(server, &reply, wrong[k], route[i].path, "", NULL);
            ask_problem(&reply, 405, NULL);
            CHECK(listed(test_reply_header(&reply, "Allow"), route[i].method));
            CHECK(!listed(test_reply_header(&reply, "Allow"), wrong[k]));
            test_reply_clear(&reply);
        }
    }
}

/* requests that are refused: what is sent, the status, and the pointer of the error */
static const struct {
    const char *method, *path, *headers, *body;
    int status;
    const char *pointer;
} refused[] = {
    {"GET", "/page/0000000000000000/index.html", "", NULL, 404, NULL},
    {"GET", "/nothing", "", NULL, 404, NULL},
    {"GET", "/v1/presets/no-such-thing", "", NULL, 404, NULL},
    {"GET", "/v1/trees/", "", NULL, 404, NULL},
    {"GET", "/v1/trajectories", "", NULL, 405, NULL},
    {"POST", "/v1/trees", "Accept: image/png\r\n", ASK_LITTLE, 406, NULL},
    {"POST", "/v1/trajectories", "Accept: text/html\r\n", ASK_LITTLE, 406, NULL},
    {"POST", "/v1/trees", "Content-Type: text/plain\r\n", ASK_LITTLE, 415, NULL},
    {"POST", "/v1/trees", "Content-Type: application/x-www-form-urlencoded\r\n", ASK_LITTLE, 415,
     NULL},
    {"POST", "/v1/trees", "", "", 400, NULL},
    {"POST", "/v1/trees", "", "{", 400, NULL},
    {"POST", "/v1/trees", "", "{\"pendulum\":" ASK_DOUBLE "} x", 400, NULL},
    {"POST", "/v1/trees", "", "{\"pendulum\":" ASK_DOUBLE ",\"pendulum\":" ASK_DOUBLE "}", 400,
     NULL},
    {"POST", "/v1/trees", "", "{\"pendulum\":{\"length\":[1e999],\"mass\":[1],\"parent\":[0]}}",
     400, NULL},
    {"POST", "/v1/trees", "", "{\"pendulum\":{\"length\":[NaN],\"mass\":[1],\"parent\":[0]}}", 400,
     NULL},
    {"GET", "/openapi.json?tag=fits", "", NULL, 422, NULL},
    {"GET", "/openapi-3.0.json?tag=fits", "", NULL, 422, NULL},
    {"POST", "/v1/trees", "", "[]", 422, NULL},
    {"POST", "/v1/trees", "", "{}", 422, "/pendulum"},
    {"POST", "/v1/trees", "", "{\"pendulum\":" ASK_DOUBLE ",\"colour\":1}", 422, "/colour"},
    {"POST", "/v1/trees", "", "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,0],\"parent\":[0,1]}}",
     422, "/pendulum/mass/1"},
    {"POST", "/v1/trees", "", "{\"pendulum\":{\"length\":[-1,1],\"mass\":[1,0],\"parent\":[0,1]}}",
     422, "/pendulum/length/0"},
    {"POST", "/v1/trees", "", "{\"pendulum\":{\"L\":[1,1],\"m\":[1,1],\"S\":[[1,0],[1,2]]}}", 422,
     "/pendulum/S/1/1"},
    {"POST", "/v1/forces", "", "{\"pendulum\":" ASK_DOUBLE ",\"state\":{\"phi\":[0]}}", 422,
     "/state/phi"},
    {"POST", "/v1/lyapunov", "", "{\"pendulum\":" ASK_DOUBLE ",\"duration\":1,\"count\":5}", 422,
     "/count"},
    {"POST", "/v1/sections", "",
     "{\"pendulum\":" ASK_DOUBLE ",\"duration\":1,\"section\":{\"arm\":3}}", 422, "/section/arm"},
    {"POST", "/v1/sections", "",
     "{\"pendulum\":" ASK_DOUBLE ",\"duration\":1,\"section\":{\"period\":\"drive\"}}", 422,
     "/section/period"},
    {"POST", "/v1/response", "",
     "{\"pendulum\":" ASK_DOUBLE ",\"drive\":{\"pivot\":{\"x\":1}},\"omega\":[-1]}", 422,
     "/omega/0"},
    {"POST", "/v1/trajectories", "",
     "{\"pendulum\":" ASK_DOUBLE
     ",\"times\":[0,1],\"events\":[{\"of\":\"x\",\"arm\":3,\"value\":0}]}",
     422, "/events/0/arm"},
    {"POST", "/v1/fits", "",
     "{\"pendulum\":" ASK_DOUBLE
     ",\"data\":{\"t\":[0,{}],\"series\":[{\"theta\":1,\"values\":[0,1]}"
     "]},\"unknowns\":[{\"vary\":\"gravity\"}]}",
     422, "/data/t"},
    {"POST", "/v1/tables", "", "{\"data\":{\"csv\":\"words\"}}", 422, "/data/csv"},
    {"POST", "/v1/trials", "", "{\"trials\":[]}", 422, "/trials"},
    {"POST", "/v1/orbits", "", "{\"pendulum\":" ASK_DOUBLE ",\"mode\":3,\"amplitude\":1}", 422,
     "/mode"},
    {"POST", "/v1/equations", "", "{\"pendulum\":" ASK_DOUBLE ",\"form\":\"long\"}", 422, "/form"},
    {"POST", "/v1/controllers", "", "{\"pendulum\":" ASK_DOUBLE ",\"period\":-1}", 422, "/period"},
    {"POST", "/v1/modes", "", "{\"pendulum\":" ASK_DOUBLE ",\"normalize\":\"big\"}", 422,
     "/normalize"},
    {"POST", "/v1/trajectories", "", "{\"pendulum\":" ASK_DOUBLE ",\"times\":[0,2,1]}", 422,
     "/times/2"},
    {"POST", "/v1/trajectories", "", "{\"pendulum\":" ASK_DOUBLE ",\"times\":[0,1],\"rtol\":5}",
     422, "/rtol"},
    {"POST", "/v1/trajectories", "",
     "{\"pendulum\":" ASK_DOUBLE ",\"times\":[0,1],\"method\":\"euler\"}", 422, "/method"},
};

TEST(requests_that_cannot_be_answered_are_refused_with_their_problem) {
    struct test_reply reply;
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        test_request(server, &reply, refused[i].method, refused[i].path, refused[i].headers,
                     refused[i].body);
        if (reply.status != refused[i].status)
            printf("  %s %s %s%.100s\n", refused[i].method, refused[i].path, refused[i].headers,
                   refused[i].body ? refused[i].body : "");
        ask_problem(&reply, refused[i].status, refused[i].pointer);
        test_reply_clear(&reply);
    }
}

TEST(an_address_that_is_nearly_right_is_told_the_right_one) {
    static const char *const row[][2] = {
        {"/v1/trajectories/", "did you mean /v1/trajectories"},
        {"/trajectories", "did you mean /v1/trajectories"},
        {"/api/v1/modes", "did you mean /v1/modes"},
        {"/v1/lyapunow", "did you mean /v1/lyapunov"},
        {"/v1/trajectory", "did you mean /v1/trajectories"},
        {"/simulate", "did you mean /v1/trajectories"},
        {"/v1/poincare", "did you mean /v1/sections"},
        {"/v1/Modes/", "did you mean /v1/modes"},
        {"/v1/openapi.json", "did you mean /openapi.json"},
        {"/v1/weather", "see /openapi.json"},
    };
    struct test_reply reply;
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        CHECK_INT(test_request(server, &reply, "POST", row[i][0], "", ASK_LITTLE), 404);
        CHECK_SAYING(reply.body && strstr(reply.body, row[i][1]), "%s: %s", row[i][0],
                     reply.body ? reply.body : "");
        test_reply_clear(&reply);
    }
}

TEST(a_body_above_the_limit_is_refused_before_it_is_read) {
    static const char *const options[] = {"--max-body-bytes", "4096", NULL};
    OWN(test_reply, clear) reply = {0};
    struct test_client client;
    OWN(test_server, stop) *server = test_server_start(options);
    REQUIRE(server != NULL);
    /* announced too large: the answer comes although no byte of the body is sent */
    REQUIRE(test_client_open(&client, test_server_port(server)));
    test_client_say(&client,
                    "POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n"
                    "Content-Length: 4097\r\n\r\n");
    test_client_receive(&client, &reply, 0, TEST_PATIENCE);
    ask_problem(&reply, 413, NULL);
    test_reply_record(&reply, "POST", "/v1/trees");
    test_reply_clear(&reply);
    test_client_close(&client);
    /* not announced: chunks without end */
    REQUIRE(test_client_open(&client, test_server_port(server)));
    test_client_say(&client,
                    "POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n"
                    "Transfer-Encoding: chunked\r\n\r\n");
    char chunk[1100] = "400\r\n";
    memset(chunk + 5, ' ', 1024);
    strcpy(chunk + 5 + 1024, "\r\n");
    for (int i = 0; i < 8; i++)
        if (!test_client_say(&client, chunk)) break;
    test_client_say(&client, "0\r\n\r\n");
    test_client_receive(&client, &reply, 0, TEST_PATIENCE);
    ask_problem(&reply, 413, NULL);
    test_reply_record(&reply, "POST", "/v1/trees");
    test_reply_clear(&reply);
    test_client_close(&client);
    CHECK_INT(ask(server, &reply, "/v1/trees", ASK_LITTLE), 200);
}

TEST(csv_comes_when_it_is_asked_for) {
    OWN(test_reply, clear) reply = {0};
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    CHECK_INT(test_request(server, &reply, "POST", "/v1/trajectories", "Accept: text/csv\r\n",
                           ASK_EXAMPLE),
              200);
    const char *type = test_reply_header(&reply, "Content-Type");
    CHECK_SAYING(type && !strncmp(type, "text/csv", 8), "the type is %s", type);
    CHECK(reply.body && !strncmp(reply.body, "t,phi_1,phi_2,phi_3,phi_4,phid_1,", 33));
    int lines = 0;
    for (const char *at = reply.body; at && *at; at++) lines += *at == '\n';
    CHECK_INT(lines, 502);
}

TEST(an_answer_that_the_client_has_is_not_sent_again) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    OWN(test_reply, clear) reply = {0};
    char headers[256];
    REQUIRE(server != NULL);
    CHECK_INT(test_request(server, &reply, "POST", "/v1/trees", "", ASK_LITTLE), 200);
    const char *etag = test_reply_header(&reply, "ETag");
    REQUIRE(etag != NULL);
    snprintf(headers, sizeof headers, "If-None-Match: %s\r\n", etag);
    test_reply_clear(&reply);
    CHECK_INT(test_request(server, &reply, "QUERY", "/v1/trees", headers, ASK_LITTLE), 304);
    CHECK(!reply.body_bytes);
    test_reply_clear(&reply);
    CHECK_INT(test_request(server, &reply, "POST", "/v1/trees", "If-None-Match: \"other\"\r\n",
                           ASK_LITTLE),
              200);
}

TEST(what_is_counted_is_there_for_prometheus) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    OWN(test_reply, clear) reply = {0};
    REQUIRE(server != NULL);
    CHECK_INT(test_request(server, &reply, "POST", "/v1/trees", "", ASK_LITTLE), 200);
    test_reply_clear(&reply);
    CHECK_INT(test_request(server, &reply, "GET", "/metrics", "", NULL), 200);
    CHECK_TEXT(test_reply_header(&reply, "Content-Type"),
               "text/plain; version=0.0.4; charset=utf-8");
    CHECK(strstr(reply.body,
                 "\npendulumd_requests_total{route=\"POST /v1/trees\",status=\"200\"} 1\n") !=
          NULL);
}
