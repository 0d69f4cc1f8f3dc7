/* Lists of jobs, their filters and pages, and the JSON of a job, on both stores. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/wire/place.h"

#define ANNA "Authorization: Bearer anna-0123456789abcdef0123456789\r\n"
#define BERTA "Authorization: Bearer berta-0123456789abcdef012345678\r\n"

/* a client's list; the ids of its jobs, newest first, and the next page's path, "" = none */
static int list(const struct test_server *server, const char *who, const char *path,
                char id[][ID + 1], char next[1200]) {
    OWN(test_reply, clear) reply;
    int count = 0;
    next[0] = 0;
    CHECK_INT(test_request(server, &reply, "GET", path, who, NULL), 200);
    cJSON *json = ask_json(&reply), *at;
    cJSON_ArrayForEach(at, cJSON_GetObjectItem(json, "jobs")) {
        if (count < 10)
            snprintf(id[count++], ID + 1, "%s",
                     cJSON_GetStringValue(cJSON_GetObjectItem(at, "id")));
    }
    const cJSON *link = cJSON_GetArrayItem(cJSON_GetObjectItem(json, "links"), 0);
    if (link) {
        const char *href = cJSON_GetStringValue(cJSON_GetObjectItem(link, "href"));
        char field[1300];
        snprintf(next, 1200, "%s", href);
        snprintf(field, sizeof field, "<%s>; rel=\"next\"", href);
        CHECK_TEXT(test_reply_header(&reply, "Link"), field);
    } else {
        CHECK(!test_reply_header(&reply, "Link"));
    }
    cJSON_Delete(json);
    return count;
}

/* a job's JSON */
static cJSON *told(const struct test_server *server, const char *id) {
    OWN(test_reply, clear) reply;
    CHECK_INT(job_get(server, &reply, id, "", ""), 200);
    return ask_json(&reply);
}

static void filters(struct place *place) {
    OWN(test_reply, clear) reply = {0};
    char id[7][ID + 1], got[10][ID + 1], next[1200], path[1200], since[64];
    OWN(test_server, stop) *server = place_serve(place, "api", "1", NULL, NULL);
    if (!server) return;
    for (int i = 0; i < 7; i++) {
        char headers[400];
        snprintf(headers, sizeof headers, "%s%sJob-Title: run %d of f%%C3%%BCnf%%25\r\n", ASYNC,
                 i == 3 ? BERTA : ANNA, i);
        CHECK_INT(submit(server, i % 2 ? "/v1/modes" : "/v1/forces", i == 6 ? ASYNC ANNA : headers,
                         ASK_LITTLE, id[i]),
                  202);
        test_sleep(0.005);
    }
    CHECK_INT(list(server, ANNA, "/v1/jobs", got, next), 6);
    CHECK_TEXT(next, "");
    CHECK_TEXT(got[0], id[6]);
    CHECK_INT(list(server, BERTA, "/v1/jobs", got, next), 1);
    CHECK_TEXT(got[0], id[3]);
    CHECK_INT(list(server, ANNA, "/v1/jobs?operation=modes", got, next), 2);
    CHECK(!strcmp(got[0], id[5]) && !strcmp(got[1], id[1]));
    CHECK_INT(list(server, ANNA, "/v1/jobs?title=RUN%204", got, next), 1);
    CHECK_TEXT(got[0], id[4]);
    CHECK_INT(list(server, ANNA, "/v1/jobs?title=f%C3%BCnf%25", got, next), 5);
    CHECK_INT(list(server, ANNA, "/v1/jobs?title=run+4+OF", got, next), 1);
    CHECK_INT(list(server, ANNA, "/v1/jobs?title=run%2B4", got, next), 0);
    CHECK_INT(
        list(server, ANNA, "/v1/jobs?status=accepted&since=1999-12-31T23:59:59%2B01:00", got, next),
        6);
    CHECK_INT(list(server, ANNA, "/v1/jobs?status=successful", got, next), 0);
    CHECK_INT(list(server, ANNA, "/v1/jobs?since=2999-12-31T23:59:59Z", got, next), 0);
    /* the pages of a filter contain every match once */
    int count = 0;
    snprintf(next, sizeof next,
             "/v1/jobs?operation=forces&limit=1&title=f%%C3%%BCnf&since="
             "2001-01-01T00:00:00.5Z&status=accepted");
    for (int page = 0; page < 5 && next[0]; page++) {
        snprintf(path, sizeof path, "%s", next);
        int some = list(server, ANNA, path, &got[count], next);
        count += some;
        CHECK(some <= 1);
    }
    CHECK_INT(count, 3);
    CHECK(!strcmp(got[0], id[4]) && !strcmp(got[1], id[2]) && !strcmp(got[2], id[0]));
    /* since is inclusive to the microsecond of the answer's milliseconds */
    cJSON *job = told(server, id[4]);
    snprintf(since, sizeof since, "%s", cJSON_GetStringValue(cJSON_GetObjectItem(job, "created")));
    cJSON_Delete(job);
    snprintf(path, sizeof path, "/v1/jobs?since=%s", since);
    CHECK_INT(list(server, ANNA, path, got, next), 3);
    static const char *const bad[] = {
        "status=done", "since=yesterday", "since=2026-02-29T00:00:00Z",
        "limit=0",     "limit=101",       "limit=",
        "before=x",    "title=",          "title=%ff",
        "title=%0",    "title=a&title=b", "what=1",
        "status"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        snprintf(path, sizeof path, "/v1/jobs?%s", bad[i]);
        CHECK_SAYING(test_request(server, &reply, "GET", path, ANNA, NULL) == 422, "%s", bad[i]);
        ask_problem(&reply, 422, NULL);
        test_reply_clear(&reply);
    }
    CHECK_INT(test_request(server, &reply, "GET", "/v1/jobs?status=accepted", "", NULL), 401);
}

TEST(a_list_of_jobs_is_filtered_and_paged) { place_on_both(filters); }

static double number(const cJSON *job, const char *name) {
    return cJSON_GetNumberValue(cJSON_GetObjectItem(job, name));
}

static void telling(struct place *place) {
    struct test_reply reply;
    char id[ID + 1], other[ID + 1], word[WORDS];
    OWN(test_server, stop) *server = place_serve(place, "all", "1", NULL, NULL);
    if (!server) return;
    CHECK_INT(submit(server, "/v1/forces", ASYNC ANNA "Job-Title: two arms\r\n",
                     " { \"pendulum\" : " ASK_DOUBLE "}", id),
              202);
    job_wait(server, id, word);
    CHECK_TEXT(word, "successful");
    cJSON *job = told(server, id), *parts = cJSON_GetObjectItem(job, "parts");
    CHECK_TEXT(cJSON_GetStringValue(cJSON_GetObjectItem(job, "title")), "two arms");
    const char *version = cJSON_GetStringValue(cJSON_GetObjectItem(job, "version"));
    CHECK_SAYING(version && strchr(version, '+') && strlen(version) > 16, "%s", version);
    CHECK_INT((int)number(parts, "done"), 1);
    CHECK_INT((int)number(parts, "all"), 1);
    CHECK(number(job, "bytes") > 10 && number(job, "bytes") < 10000);
    cJSON_Delete(job);
    /* the request, which posted again gives the same job's results */
    CHECK_INT(job_get(server, &reply, id, "/request", ""), 200);
    CHECK_SAYING(strstr(reply.body, "\"parent\":[0,1]") != NULL, "%s", reply.body);
    CHECK_INT(submit(server, "/v1/forces", ASYNC ANNA, reply.body, other), 202);
    test_reply_clear(&reply);
    job_wait(server, other, word);
    job = told(server, other);
    CHECK(cJSON_IsNull(cJSON_GetObjectItem(job, "title")));
    cJSON_Delete(job);
    char path[64];
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    CHECK_INT(test_request(server, &reply, "DELETE", path, ANNA, NULL), 200);
    CHECK(!strstr(reply.body, "/request"));
    test_reply_clear(&reply);
    CHECK_INT(job_get(server, &reply, id, "/request", ""), 409);
    ask_problem(&reply, 409, NULL);
    test_reply_clear(&reply);
    CHECK_INT(job_get(server, &reply, "00000000000000000000000000", "/request", ""), 404);
    test_reply_clear(&reply);
    static const char *const bad[] = {"", "%", "%4", "%zz", "%00", "%1f", "%c3", "a%ff"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char headers[200];
        snprintf(headers, sizeof headers, ASYNC "Job-Title: %s\r\n", bad[i]);
        CHECK_SAYING(submit(server, "/v1/forces", headers, ASK_LITTLE, id) == 400, "%s", bad[i]);
    }
}

TEST(a_job_tells_its_title_version_parts_bytes_and_request) { place_on_both(telling); }
