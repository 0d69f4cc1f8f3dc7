#include "tests/wire/place.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int place_begin(struct place *place, int postgres) {
    *place = (struct place){.lease = "60"};
    if (postgres) {
        place->postgres = test_postgres_start();
        if (place->postgres)
            snprintf(place->url, sizeof place->url, "%s", test_postgres_url(place->postgres));
        return CHECK(place->postgres != NULL);
    }
    snprintf(place->directory, sizeof place->directory, "/tmp/pendulumd-test-XXXXXX");
    if (!CHECK(mkdtemp(place->directory) != NULL)) return 0;
    snprintf(place->url, sizeof place->url, "sqlite:%s/store.db", place->directory);
    return 1;
}

void place_end(struct place *place) {
    char command[128];
    test_postgres_stop(&place->postgres);
    if (!place->directory[0]) return;
    snprintf(command, sizeof command, "rm -rf '%s'", place->directory);
    CHECK(!system(command));
}

struct test_server *place_serve(const struct place *place, const char *role, const char *part,
                                const char *option, const char *value) {
    const char *const options[] = {"--store",
                                   place->url,
                                   "--cache-bytes",
                                   "0",
                                   "--job-part-seconds",
                                   part,
                                   "--role",
                                   role,
                                   "--job-lease-seconds",
                                   place->lease,
                                   "--workers",
                                   "2",
                                   option,
                                   value,
                                   NULL};
    return test_server_start(options);
}

void stop_after_deaths(struct test_server **server) {
    if (!*server) return;
    test_server_signal(*server, SIGTERM);
    CHECK_INT(test_server_wait(*server), 0);
    test_server_drop(server);
}

/* The stores on which drills run. Sanitizers check the code and not what a client sees, and the
 * tests of server run the stores' own code on both under either of them: here one of them uses
 * PostgreSQL and the other SQLite. */
#if defined __SANITIZE_ADDRESS__
enum { PLACE_FIRST = 1, PLACE_LAST = 1 };
#elif defined __SANITIZE_THREAD__
enum { PLACE_FIRST = 0, PLACE_LAST = 0 };
#else
enum { PLACE_FIRST = 0, PLACE_LAST = 1 };
#endif

void place_on_both(void (*drill)(struct place *place)) {
    for (int postgres = PLACE_FIRST; postgres <= PLACE_LAST; postgres++) {
        OWN(place, end) place = {0};
        if (postgres && access("/usr/lib/postgresql", F_OK)) {
            test_skip("PostgreSQL is not installed");
            return;
        }
        if (place_begin(&place, postgres)) drill(&place);
    }
}

int submit(const struct test_server *server, const char *path, const char *headers,
           const char *body, char id[ID + 1]) {
    OWN(test_reply, clear) reply;
    id[0] = 0;
    int status = test_request(server, &reply, "POST", path, headers, body);
    const char *location = test_reply_header(&reply, "Location");
    if (status == 202 &&
        CHECK(location && strlen(location) == 9 + ID && !strncmp(location, "/v1/jobs/", 9)))
        memcpy(id, location + 9, ID + 1);
    return status;
}

int job_get(const struct test_server *server, struct test_reply *reply, const char *id,
            const char *what, const char *headers) {
    char path[96];
    snprintf(path, sizeof path, "/v1/jobs/%s%s", id, what);
    return test_request(server, reply, "GET", path, headers, NULL);
}

void job_wait(const struct test_server *server, const char *id, char word[WORDS]) {
    double end = test_clock() + TEST_PATIENCE;
    word[0] = 0;
    for (; test_clock() < end; test_sleep(0.02)) {
        struct test_reply reply;
        if (job_get(server, &reply, id, "", "") == 200) {
            cJSON *json = ask_json(&reply);
            const char *status =
                cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "status"));
            snprintf(word, WORDS, "%s", status ? status : "");
            cJSON_Delete(json);
        } else {
            snprintf(word, WORDS, "%d", reply.status);
        }
        test_reply_clear(&reply);
        if (strcmp(word, "accepted") && strcmp(word, "running")) return;
    }
}
