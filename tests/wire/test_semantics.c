/* Methods, preconditions and codings have the meaning of RFC 9110, and QUERY that of its draft. */
#include <stdio.h>
#include <string.h>

#include "tests/wire/ask.h"

static int answer(const struct test_server *server, const char *method, const char *path,
                  const char *fields, const char *body, struct test_reply *reply) {
    char all[1024];
    snprintf(all, sizeof all, "Content-Type: application/json\r\n%s", fields);
    return test_request(server, reply, method, path, all, body);
}

static int answered(const struct test_server *server, const char *method, const char *path,
                    const char *fields, const char *body) {
    OWN(test_reply, clear) reply;
    return answer(server, method, path, fields, body, &reply);
}

TEST(a_query_is_a_post_that_changes_nothing) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    struct test_reply posted, queried;
    char etag[256];
    REQUIRE(server != NULL);
    CHECK_INT(answer(server, "POST", "/v1/trees", "", ASK_LITTLE, &posted), 200);
    CHECK_INT(answer(server, "QUERY", "/v1/trees", "", ASK_LITTLE, &queried), 200);
    CHECK_TEXT(queried.body, posted.body);
    CHECK_TEXT(test_reply_header(&queried, "ETag"), test_reply_header(&posted, "ETag"));
    snprintf(etag, sizeof etag, "If-None-Match: %s\r\n", test_reply_header(&posted, "ETag"));
    test_reply_clear(&posted);
    test_reply_clear(&queried);
    CHECK_INT(answered(server, "QUERY", "/v1/trees", etag, ASK_LITTLE), 304);
    CHECK_INT(answered(server, "QUERY", "/v1/trees", "", "{"), 400);
    CHECK_INT(answered(server, "QUERY", "/v1/scenes", "", "{}"), 405);
    CHECK_INT(answered(server, "QUERY", "/v1/presets", "", "{}"), 405);
    CHECK_INT(answer(server, "OPTIONS", "/v1/forces", "", "", &queried), 204);
    CHECK_TEXT(test_reply_header(&queried, "Allow"), "POST, QUERY, OPTIONS");
    test_reply_clear(&queried);
    CHECK_INT(test_request(server, &queried, "OPTIONS", "/v1/forces",
                           "Origin: https://a.example\r\nAccess-Control-Request-Method: QUERY\r\n",
                           ""),
              204);
    CHECK_TEXT(test_reply_header(&queried, "Access-Control-Allow-Methods"), "POST, QUERY, OPTIONS");
    test_reply_clear(&queried);
}

TEST(if_none_match_is_304_for_safe_methods_and_412_for_others) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    struct test_reply reply;
    char fields[2][256] = {"", "If-None-Match: *\r\n"};
    REQUIRE(server != NULL);
    CHECK_INT(answer(server, "POST", "/v1/trees", "", ASK_LITTLE, &reply), 200);
    snprintf(fields[0], sizeof fields[0], "If-None-Match: \"x\", %s\r\n",
             test_reply_header(&reply, "ETag"));
    test_reply_clear(&reply);
    for (int i = 0; i < 2; i++) {
        /* from the exact bytes, from their meaning, and for a request that nobody has sent
         * before */
        static const char *const body[] = {
            ASK_LITTLE, " " ASK_LITTLE,
            "{\"pendulum\":{\"length\":[2],\"mass\":[1],\"parent\":[0]}}"};
        for (int k = 0; k < 3; k++) {
            if (!i && k == 2) continue;
            CHECK_INT(answer(server, "POST", "/v1/trees", fields[i], body[k], &reply), 412);
            ask_problem(&reply, 412, NULL);
            CHECK(test_reply_header(&reply, "ETag") != NULL);
            test_reply_clear(&reply);
            CHECK_INT(answered(server, "QUERY", "/v1/trees", fields[i], body[k]), 304);
        }
    }
    CHECK_INT(answered(server, "POST", "/v1/trees", "If-None-Match: \"x\"\r\n", ASK_LITTLE), 200);
    CHECK_INT(answered(server, "GET", "/v1/presets", "If-None-Match: *\r\n", ""), 304);
}

TEST(a_body_in_a_coding_or_of_another_type_is_415_and_says_what_is_taken) {
    static const char *const coding[] = {"gzip", "rot13", "identity, gzip", "zstd"};
    OWN(test_server, stop) *server = test_server_start(NULL);
    OWN(test_reply, clear) reply = {0};
    char fields[128];
    REQUIRE(server != NULL);
    for (size_t i = 0; i < sizeof coding / sizeof *coding; i++) {
        snprintf(fields, sizeof fields, "Content-Encoding: %s\r\n", coding[i]);
        CHECK_INT(answer(server, "POST", "/v1/trees", fields, ASK_LITTLE, &reply), 415);
        CHECK_TEXT(test_reply_header(&reply, "Accept-Encoding"), "identity");
        ask_problem(&reply, 415, NULL);
        test_reply_clear(&reply);
    }
    CHECK_INT(answered(server, "POST", "/v1/trees", "Content-Encoding: identity\r\n", ASK_LITTLE),
              200);
    CHECK_INT(answered(server, "GET", "/v1/presets", "Content-Encoding: gzip\r\n", ""), 200);
    CHECK_INT(
        test_request(server, &reply, "POST", "/v1/trees", "Content-Type: text/csv\r\n", ASK_LITTLE),
        415);
    CHECK_TEXT(test_reply_header(&reply, "Accept-Post"), "application/json");
    test_reply_clear(&reply);
    CHECK_INT(
        test_request(server, &reply, "POST", "/v1/fits", "Content-Type: text/csv\r\n", "t,x\n"),
        415);
    CHECK_TEXT(test_reply_header(&reply, "Accept-Post"), "application/json, multipart/form-data");
}

/* a table as a file beside the JSON, as `curl -F request=@fit.json -F csv=@track.csv` sends it */
TEST(a_form_of_files_is_the_request_that_it_says) {
    static const char
        type[] = "Content-Type: multipart/form-data; boundary=----b\r\n",
        form[] = "------b\r\nContent-Disposition: form-data; name=\"request\"; filename="
                 "\"fit.json\"\r\nContent-Type: application/octet-stream\r\n\r\n{\"pendulum\":"
                 "{\"length\":[0.9],\"mass\":[1],\"parent\":[0]},\"unknowns\":[{\"vary\":"
                 "\"length\",\"arm\":1},{\"vary\":\"thetad\",\"arm\":1}],\"data\":{\"unit\":"
                 "\"deg\"}}\r\n------b\r\nContent-Disposition: form-data; name=\"csv\"; "
                 "filename=\"track.csv\"\r\nContent-Type: text/csv\r\n\r\nt,theta_1\r\n0,20"
                 "\r\n0.2,16.6\r\n0.4,7.7\r\n0.6,-3.3\r\n\r\n------b--\r\n",
        json[] = "{\"pendulum\":{\"length\":[0.9],\"mass\":[1],\"parent\":[0]},\"unknowns\":"
                 "[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"thetad\",\"arm\":1}],"
                 "\"data\":{\"unit\":\"deg\",\"csv\":\"t,theta_1\\r\\n0,20\\r\\n0.2,16.6"
                 "\\r\\n0.4,7.7\\r\\n0.6,-3.3\\r\\n\"}}";
    static const char *const options[] = {"--cors-origins", "none", NULL};
    OWN(test_server, stop) *server = test_server_start(options);
    struct test_reply reply, again;
    char fields[256];
    REQUIRE(server != NULL);
    CHECK_INT(test_request(server, &reply, "POST", "/v1/fits", type, form), 200);
    CHECK_INT(ask(server, &again, "/v1/fits", json), 200);
    CHECK_TEXT(test_reply_header(&reply, "ETag"), test_reply_header(&again, "ETag"));
    test_reply_clear(&reply);
    test_reply_clear(&again);
    // truncated, to a route that accepts none, and from a page that is not listed
    char cut[sizeof form];
    snprintf(cut, sizeof cut, "%.*s", (int)sizeof form - 12, form);
    CHECK_INT(test_request(server, &reply, "POST", "/v1/fits", type, cut), 400);
    ask_problem(&reply, 400, NULL);
    test_reply_clear(&reply);
    CHECK_INT(test_request(server, &reply, "POST", "/v1/modes", type, form), 415);
    test_reply_clear(&reply);
    for (int own = 0; own < 2; own++) {
        snprintf(fields, sizeof fields, "%sOrigin: http://%s\r\n", type,
                 own ? "localhost" : "evil.example");
        snprintf(fields + strlen(fields), sizeof fields - strlen(fields),
                 own ? "Sec-Fetch-Site: same-origin\r\n" : "");
        CHECK_INT(test_request(server, &reply, "POST", "/v1/fits", fields, form), own ? 200 : 403);
        test_reply_clear(&reply);
    }
}

TEST(a_trace_of_zeros_is_none) {
    static const struct {
        const char *trace;
        int taken;
    } told[] = {
        {"00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01", 1},
        {"00-00000000000000000000000000000001-0000000000000001-00", 1},
        {"00-00000000000000000000000000000000-b7ad6b7169203331-01", 0},
        {"00-0af7651916cd43dd8448eb211c80319c-0000000000000000-01", 0},
        {"ff-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01", 0},
    };
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    for (size_t i = 0; i < sizeof told / sizeof *told; i++) {
        OWN(test_reply, clear) reply;
        char fields[128];
        snprintf(fields, sizeof fields, "Traceparent: %s\r\n", told[i].trace);
        CHECK_INT(test_request(server, &reply, "GET", "/healthz", fields, NULL), 200);
        CHECK_SAYING(!test_reply_header(&reply, "Traceparent") == !told[i].taken, "%s",
                     told[i].trace);
    }
}

TEST(the_description_is_kept_and_packed) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    struct test_reply plain, packed;
    char fields[128];
    REQUIRE(server != NULL);
    CHECK_INT(test_request(server, &plain, "GET", "/openapi.json", "", NULL), 200);
    CHECK_INT(
        test_request(server, &packed, "GET", "/openapi.json", "Accept-Encoding: gzip\r\n", NULL),
        200);
    CHECK_TEXT(test_reply_header(&packed, "Content-Encoding"), "gzip");
    CHECK(packed.body_bytes * 3 < plain.body_bytes);
    CHECK_TEXT(test_reply_header(&plain, "Cache-Control"), "no-cache");
    CHECK_TEXT(test_reply_header(&plain, "Vary"), "Accept-Encoding");
    REQUIRE(test_reply_header(&plain, "ETag") != NULL);
    snprintf(fields, sizeof fields, "If-None-Match: %s\r\n", test_reply_header(&plain, "ETag"));
    test_reply_clear(&plain);
    test_reply_clear(&packed);
    CHECK_INT(test_request(server, &plain, "GET", "/openapi.json", fields, NULL), 304);
    test_reply_clear(&plain);
}
