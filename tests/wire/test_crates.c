/* How a job is cited, and its crate, as a client asks for them. */
#include <stdio.h>
#include <string.h>

#include "tests/wire/place.h"

TEST(a_job_that_has_succeeded_can_be_cited_and_packed) {
    static const struct {
        const char *what, *type, *word;
        int status;
    } asked[] = {{"/cite.bib", "application/x-bibtex; charset=utf-8", "title = {{the \\%}}", 200},
                 {"/crate", "application/zip", "results.json", 200},
                 {"/crate?results=csv", "application/zip", "results.csv", 200},
                 {"/crate?results=csv&author=Emmy+Noether", "application/zip", "Emmy Noether", 200},
                 {"/crate?license=https%3A%2F%2Fspdx.org%2Flicenses%2FCC0-1.0", "application/zip",
                  "{\"@id\":\"https://spdx.org/licenses/CC0-1.0\",\"@type\":\"CreativeWork\"", 200},
                 {"/crate?license=mine", "application/problem+json", "license=URL", 422},
                 {"/crate?license=https://a%20b", "application/problem+json", "license=URL", 422},
                 {"/crate?author=", "application/problem+json", "author=NAME", 422},
                 {"/crate?author=a&author=b", "application/problem+json", "author=NAME", 422},
                 {"/crate?results=png", "application/problem+json", "Accept", 406},
                 {"/crate?results=doc", "application/problem+json", "parquet", 422},
                 {"/crate?form=csv", "application/problem+json", "parquet", 422}};
    struct place place;
    struct test_server *server = NULL;
    struct test_reply reply;
    char id[ID + 1], word[WORDS];
    REQUIRE(place_begin(&place, 0));
    server = place_serve(&place, "all", "1", NULL, NULL);
    if (CHECK(server != NULL)) {
        CHECK_INT(
            submit(server, "/v1/trajectories", "Job-Title: the %25\r\n" ASYNC, ASK_EXAMPLE, id),
            202);
        job_wait(server, id, word);
        CHECK_TEXT(word, "successful");
        for (size_t i = 0; i < sizeof asked / sizeof *asked; i++) {
            CHECK_INT(job_get(server, &reply, id, asked[i].what, ""), asked[i].status);
            CHECK_TEXT(test_reply_header(&reply, "Content-Type"), asked[i].type);
            CHECK(memmem(reply.body, reply.body_bytes, asked[i].word, strlen(asked[i].word)));
            test_reply_clear(&reply);
        }
        CHECK_INT(job_get(server, &reply, "00000000000000000000000000", "/crate", ""), 404);
        test_reply_clear(&reply);
        CHECK_INT(job_get(server, &reply, "00000000000000000000000000", "/cite.bib", ""), 404);
        test_reply_clear(&reply);
    }
    test_server_stop(&server);
    place_end(&place);
}

TEST(a_crate_that_a_client_has_is_not_sent_again_and_has_no_ranges) {
    struct place place;
    struct test_server *server = NULL;
    struct test_reply reply;
    char id[ID + 1], word[WORDS], known[128] = "";
    REQUIRE(place_begin(&place, 0));
    server = place_serve(&place, "all", "1", NULL, NULL);
    if (CHECK(server != NULL)) {
        CHECK_INT(submit(server, "/v1/trajectories", ASYNC, ASK_EXAMPLE, id), 202);
        job_wait(server, id, word);
        CHECK_INT(job_get(server, &reply, id, "/crate", "Range: bytes=0-9\r\n"), 200);
        CHECK(reply.body_bytes > 1000 && !test_reply_header(&reply, "Accept-Ranges"));
        snprintf(known, sizeof known, "If-None-Match: %s\r\n", test_reply_header(&reply, "ETag"));
        test_reply_clear(&reply);
        CHECK_INT(job_get(server, &reply, id, "/crate", known), 304);
        test_reply_clear(&reply);
        /* one that says more is another */
        CHECK_INT(job_get(server, &reply, id, "/crate?author=a", known), 200);
        test_reply_clear(&reply);
        /* that of the results is another */
        CHECK_INT(job_get(server, &reply, id, "/results", known), 200);
        test_reply_clear(&reply);
    }
    test_server_stop(&server);
    place_end(&place);
}

TEST(a_job_without_results_has_no_crate_and_nothing_to_cite) {
    struct place place;
    struct test_server *server = NULL;
    struct test_reply reply;
    char id[ID + 1];
    REQUIRE(place_begin(&place, 0));
    /* who only answers computes no job */
    server = place_serve(&place, "api", "1", NULL, NULL);
    if (CHECK(server != NULL)) {
        CHECK_INT(submit(server, "/v1/trajectories", ASYNC, ASK_EXAMPLE, id), 202);
        CHECK_INT(job_get(server, &reply, id, "/crate", ""), 409);
        test_reply_clear(&reply);
        CHECK_INT(job_get(server, &reply, id, "/cite.bib", ""), 409);
        CHECK(strstr(reply.body, "not-done") != NULL);
        test_reply_clear(&reply);
    }
    test_server_stop(&server);
    place_end(&place);
}
