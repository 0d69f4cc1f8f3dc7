/* The partial results of an unfinished job: the rows of its first parts. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/wire/place.h"

#define OCTETS "Accept: application/octet-stream\r\n"
#define RECORDS "Accept: application/x-ndjson\r\n"

#define BRANCH                                                                                     \
    "{\"pendulum\":{\"length\":[1,1,1,1],\"mass\":[1,1,1,1],\"parent\":[0,1,2,3]},\"mode\":1,"     \
    "\"amplitude\":0.8,\"branch\":true,\"rows\":\"orbits\",\"step\":0.0005,\"points\":2500}"

/* too many members to compute during a test, or the first `%s` of them */
#define MEMBERS                                                                                    \
    "{\"pendulum\":" ASK_DOUBLE ",\"duration\":1,\"observables\":[\"final\"],\"random\":{"         \
    "\"count\":%ld,\"seed\":5,\"draw\":[{\"vary\":\"theta\",\"arm\":1,\"distribution\":"           \
    "\"uniform\",\"low\":-3,\"high\":3}]}}"

enum { ALL = 90000000, ROW = 8 * 6 /* member, status, final phi and phid of two arms */ };

/* computes until the first part of a job is done, and ends; returns 1 if one is, and the job is not
 * over */
static int partial_begin(const struct place *place, const char *path, const char *body,
                         const char *accept, char id[ID + 1]) {
    int over = 0, some = 0;
    OWN(test_server, stop) *server = place_serve(place, "all", "0.05", "--workers", "1");
    if (!CHECK(server != NULL)) return 0;
    CHECK_INT(submit(server, path, ASYNC, body, id), 202);
    for (int tries = 0; !some && !over && tries < 100 * TEST_PATIENCE; tries++) {
        struct test_reply reply;
        (void)job_get(server, &reply, id, "/results?partial=true", accept);
        over = reply.status == 200;
        some = reply.status == 202 && reply.body_bytes > 0;
        CHECK(over || reply.status == 202 || reply.status == 409);
        test_reply_clear(&reply);
        if (!some) usleep(10000);
    }
    return CHECK(some || over) && some;
}

static void partial_read(struct place *place) {
    struct test_reply reply, first;
    char id[ID + 1], body[512];
    snprintf(body, sizeof body, MEMBERS, (long)ALL);
    if (!CHECK(partial_begin(place, "/v1/ensembles", body, OCTETS, id))) return;
    /* an api process computes no further part */
    OWN(test_server, stop) *server = place_serve(place, "api", "0.05", NULL, NULL);
    if (!CHECK(server != NULL)) return;
    CHECK_INT(job_get(server, &reply, id, "/results", OCTETS), 409);
    CHECK(strstr(reply.body, "partial=true") != NULL);
    test_reply_clear(&reply);
    CHECK_INT(job_get(server, &reply, id, "/results?partial=true", OCTETS), 202);
    long rows = (long)(reply.body_bytes / ROW);
    CHECK_SAYING(rows > 0 && rows < ALL && reply.body_bytes % ROW == 0, "%zu bytes",
                 reply.body_bytes);
    CHECK(!test_reply_header(&reply, "ETag") && !test_reply_header(&reply, "Accept-Ranges"));
    /* these members by themselves are the same to the bit */
    snprintf(body, sizeof body, MEMBERS, rows);
    CHECK_INT(test_request(server, &first, "POST", "/v1/ensembles", OCTETS, body), 200);
    CHECK(first.body_bytes == reply.body_bytes &&
          !memcmp(first.body, reply.body, reply.body_bytes));
    test_reply_clear(&first);
    test_reply_clear(&reply);
    CHECK_INT(job_get(server, &reply, id, "/results?partial=true", RECORDS), 202);
    snprintf(body, sizeof body, "{\"stats\":{\"rows\":%ld,\"rows_all\":%ld}}\n", rows, (long)ALL);
    CHECK_SAYING(reply.body_bytes > strlen(body) &&
                     !strcmp(reply.body + reply.body_bytes - strlen(body), body),
                 "%.200s", reply.body + (reply.body_bytes > 200 ? reply.body_bytes - 200 : 0));
    test_reply_clear(&reply);
    CHECK_INT(job_get(server, &reply, id, "/results?partial=yes", ""), 422);
    test_reply_clear(&reply);
}

TEST(what_is_done_of_a_job_is_read_before_its_end) { place_on_both(partial_read); }

/* a representation that contains more than rows is available at the end */
static void partial_apart(struct place *place) {
    OWN(test_reply, clear) reply = {0};
    char id[ID + 1];
    if (!partial_begin(place, "/v1/orbits", BRANCH, RECORDS, id)) {
        test_skip("the job was over before it was looked at");
        return;
    }
    OWN(test_server, stop) *server = place_serve(place, "api", "0.05", NULL, NULL);
    if (!CHECK(server != NULL)) return;
    CHECK_INT(job_get(server, &reply, id, "/results?partial=true", RECORDS), 202);
    test_reply_clear(&reply);
    CHECK_INT(job_get(server, &reply, id, "/results?partial=true", ""), 422);
    CHECK_SAYING(strstr(reply.body, "x-ndjson") != NULL, "%s", reply.body);
}

TEST(of_orbits_that_are_not_done_there_are_rows_and_no_json) {
    OWN(place, end) place;
    if (place_begin(&place, 0)) partial_apart(&place);
}
