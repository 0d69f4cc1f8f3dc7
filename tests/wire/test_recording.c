/* --record writes each request that is computed into a file, and --replay computes it again. */
#include <dirent.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/wire/ask.h"

#define SECRET "Authorization: Bearer 3f1c9a5b7d2e4f60819a2b3c4d5e6f70\r\n"

/* A daemon that records into a directory of its own. */
struct recorded {
    char directory[32], into[48];
    struct test_server *server;
};

static int recorded_begin(struct recorded *recorded) {
    *recorded = (struct recorded){.directory = "/tmp/pendulumd-test-XXXXXX"};
    if (!CHECK(mkdtemp(recorded->directory) != NULL)) return 0;
    snprintf(recorded->into, sizeof recorded->into, "%s/requests", recorded->directory);
    const char *const options[] = {"--record", recorded->into, NULL};
    return CHECK((recorded->server = test_server_start(options)) != NULL);
}

static void recorded_end(struct recorded *recorded) {
    char command[64];
    if (recorded->server) test_server_stop(&recorded->server);
    snprintf(command, sizeof command, "rm -rf '%s'", recorded->directory);
    CHECK(!system(command));
}

/* the file of that number, ended by a NUL; NULL, to be freed */
static char *recorded_read(const struct recorded *recorded, int number, size_t *bytes) {
    char path[96], *text = NULL;
    snprintf(path, sizeof path, "%s/%06d.request", recorded->into, number);
    FILE *file = fopen(path, "r");
    *bytes = 0;
    if (!file) return NULL;
    text = calloc(1, 65536);
    *bytes = fread(text, 1, 65535, file);
    fclose(file);
    return text;
}

static void recorded_write(const struct recorded *recorded, int number, const char *text,
                           size_t bytes) {
    char path[96];
    snprintf(path, sizeof path, "%s/%06d.request", recorded->into, number);
    FILE *file = fopen(path, "w");
    REQUIRE(file != NULL);
    CHECK(fwrite(text, 1, bytes, file) == bytes && !fclose(file));
}

/* exit status of a replay, and what it says */
static int recorded_replay(const struct recorded *recorded, int number, char text[], size_t cap) {
    char path[96];
    snprintf(path, sizeof path, "%s/%06d.request", recorded->into, number);
    const char *const options[] = {"--replay", path, NULL};
    return test_server_run(options, text, cap);
}

static int recorded_files(const struct recorded *recorded) {
    int count = 0;
    DIR *directory = opendir(recorded->into);
    if (!directory) return -1;
    for (struct dirent *entry; (entry = readdir(directory));) {
        if (entry->d_name[0] == '.') continue;
        CHECK_INT((long long)strspn(entry->d_name, "0123456789"), 6);
        CHECK_TEXT(entry->d_name + 6, ".request");
        count++;
    }
    closedir(directory);
    return count;
}

TEST(a_recorded_request_replays_to_the_same_answer) {
    static const struct {
        const char *method, *path, *headers, *body;
        int status;
    } asked[] = {
        {"POST", "/v1/trees", "", ASK_LITTLE, 200},
        {"POST", "/v1/trees", "", "{\"pendulum\":3}", 422},
        {"POST", "/v1/trajectories", "Accept: text/csv\r\n", ASK_EXAMPLE, 200},
        {"GET", "/v1/presets/paper-four-arms", "", NULL, 200},
        {"GET", "/v1/presets/..%2f..%2fetc", "", NULL, 404},
        /* 2 MB: a stream */
        {"POST", "/v1/trajectories", "Accept: application/x-ndjson\r\n",
         "{\"pendulum\":" ASK_DOUBLE ",\"times\":{\"start\":0,\"stop\":10,\"step\":0.001}}", 200},
        {"POST", "/v1/trajectories", "Accept: application/x-ndjson\r\nAccept-Encoding: gzip\r\n",
         "{\"pendulum\":" ASK_DOUBLE ",\"times\":{\"start\":0,\"stop\":11,\"step\":0.001}}", 200},
    };
    enum { ASKED = sizeof asked / sizeof *asked, SAID = 1 << 26 };
    struct recorded recorded;
    char *said = malloc(SAID);
    REQUIRE(said && recorded_begin(&recorded));
    for (int i = 0; i < ASKED; i++) {
        struct test_reply reply;
        CHECK_INT(test_request(recorded.server, &reply, asked[i].method, asked[i].path,
                               asked[i].headers, asked[i].body),
                  asked[i].status);
        if (i < 2 || i == 3) CHECK(!strstr(reply.body, "compute_seconds"));
        char *answer = reply.body;
        int number = i + 1;
        CHECK_INT(recorded_files(&recorded), number);
        CHECK_INT(recorded_replay(&recorded, number, said, SAID), 0);
        CHECK(strstr(said, "the answer is the recorded one") != NULL);
        if (!strstr(asked[i].headers, "gzip")) CHECK(strstr(said, answer) != NULL);
        test_reply_clear(&reply);
    }
    free(said);
    recorded_end(&recorded);
}

TEST(what_is_recorded_says_nothing_of_who_asks_and_is_readable_by_its_user_only) {
    struct recorded recorded;
    struct test_reply reply;
    struct stat about;
    char path[96];
    size_t bytes;
    REQUIRE(recorded_begin(&recorded));
    test_request(recorded.server, &reply, "POST", "/v1/trees",
                 SECRET "Cookie: hidden=1\r\nX-Forwarded-For: 192.0.2.7\r\nIdempotency-Key: "
                        "hidden-2\r\nX-Api-Key: hidden-3\r\nX-Request-Id: told\r\n",
                 ASK_LITTLE);
    CHECK_INT(reply.status, 200);
    test_reply_clear(&reply);
    char *text = recorded_read(&recorded, 1, &bytes);
    if (CHECK(text != NULL)) {
        CHECK(strstr(text, "field: X-Request-Id: told\n") != NULL);
        CHECK(!strstr(text, "hidden") && !strstr(text, "3f1c9a5b") && !strstr(text, "192.0.2.7"));
        CHECK(!strstr(text, "Bearer") && !strstr(text, "127.0.0.1"));
    }
    free(text);
    snprintf(path, sizeof path, "%s/000001.request", recorded.into);
    CHECK(!stat(path, &about) && (about.st_mode & 0777) == 0600);
    CHECK(!stat(recorded.into, &about) && (about.st_mode & 0777) == 0700);
    recorded_end(&recorded);
}

TEST(an_answer_that_is_there_already_is_recorded_once) {
    struct recorded recorded;
    struct test_reply reply;
    REQUIRE(recorded_begin(&recorded));
    CHECK_INT(ask(recorded.server, &reply, "/v1/trees", ASK_LITTLE), 200);
    test_reply_clear(&reply);
    CHECK_INT(ask(recorded.server, &reply, "/v1/trees", ASK_LITTLE), 200);
    test_reply_clear(&reply);
    /* other bytes of the same meaning are known only once they were read */
    CHECK_INT(ask(recorded.server, &reply, "/v1/trees", ASK_LITTLE " "), 200);
    test_reply_clear(&reply);
    CHECK_INT(recorded_files(&recorded), 1);
    recorded_end(&recorded);
}

TEST(a_damaged_recording_is_refused_and_another_answer_is_told) {
    struct recorded recorded;
    struct test_reply reply;
    char said[4096];
    size_t bytes;
    REQUIRE(recorded_begin(&recorded));
    CHECK_INT(ask(recorded.server, &reply, "/v1/trees", ASK_LITTLE), 200);
    test_reply_clear(&reply);
    char *text = recorded_read(&recorded, 1, &bytes);
    REQUIRE(text != NULL);
    char *body = strstr(text, "\"length\":[1,1]"), *answer = strstr(text, "\nanswer ");
    REQUIRE(body != NULL && answer != NULL);
    body[10] = '2';
    recorded_write(&recorded, 2, text, bytes);
    CHECK_INT(recorded_replay(&recorded, 2, said, sizeof said), 2);
    CHECK(strstr(said, "its bytes are not those that were recorded") != NULL);
    body[10] = '1';
    recorded_write(&recorded, 3, text, bytes - 5);
    CHECK_INT(recorded_replay(&recorded, 3, said, sizeof said), 2);
    CHECK(strstr(said, "the line of its answer is damaged") != NULL);
    recorded_write(&recorded, 4, text, (size_t)(answer - text));
    CHECK_INT(recorded_replay(&recorded, 4, said, sizeof said), 1);
    CHECK(strstr(said, "no answer was recorded") != NULL);
    recorded_write(&recorded, 5, "nothing", 7);
    CHECK_INT(recorded_replay(&recorded, 5, said, sizeof said), 2);
    CHECK(strstr(said, "it is no recorded request") != NULL);
    CHECK_INT(recorded_replay(&recorded, 6, said, sizeof said), 2);
    CHECK(strstr(said, "No such file") != NULL);
    free(text);
    recorded_end(&recorded);
}

TEST(a_recorder_stops_at_its_bound_and_says_so_once) {
    struct recorded recorded;
    struct test_reply reply;
    REQUIRE(recorded_begin(&recorded));
    test_server_stop(&recorded.server);
    for (int i = 1; i < 1000; i++) recorded_write(&recorded, i, "", 0);
    const char *const options[] = {"--record", recorded.into, NULL};
    REQUIRE((recorded.server = test_server_start(options)) != NULL);
    for (int i = 0; i < 4; i++) {
        char body[128];
        snprintf(body, sizeof body,
                 "{\"pendulum\":{\"length\":[1,%d],\"mass\":[1,1],\"parent\":[0,1]}}", i + 1);
        CHECK_INT(ask(recorded.server, &reply, "/v1/trees", body), 200);
        test_reply_clear(&reply);
    }
    CHECK_INT(recorded_files(&recorded), 1000);
    test_server_signal(recorded.server, SIGTERM);
    CHECK_INT(test_server_wait(recorded.server), 0);
    const char *first = strstr(test_server_log(recorded.server), "--record: ");
    CHECK(first && strstr(first, "bounds of files and bytes") && !strstr(first + 1, "--record: "));
    test_server_drop(&recorded.server);
    recorded_end(&recorded);
}

TEST(a_directory_for_records_that_is_none_is_refused) {
    char said[1024];
    const char *const options[] = {"--listen", "127.0.0.1:0", "--store", "none",
                                   "--record", "/dev/null/x", NULL};
    CHECK_INT(test_server_run(options, said, sizeof said), 1);
    CHECK(strstr(said, "--record /dev/null/x is no directory that can be written") != NULL);
}
