#include "server/base/log.h"

#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "api/json/json_in.h"
#include "tests/harness/server.h"
#include "tests/harness/test.h"

static const struct srv_log_request log_sample = {.id = "i1",
                                                  .client = "127.0.0.1",
                                                  .method = "GET",
                                                  .target = "/healthz",
                                                  .status = 200,
                                                  .outcome = "answered",
                                                  .bytes_in = 1,
                                                  .bytes_out = 23,
                                                  .wait = 4567,
                                                  .compute = 1234567890,
                                                  .total = 10,
                                                  .steps = 7};

/* the contents of a file, followed by a NUL */
static size_t log_file(FILE *file, char text[], size_t cap) {
    rewind(file);
    size_t bytes = fread(text, 1, cap - 1, file);
    text[bytes] = 0;
    return bytes;
}

/* the number or text of a member of a line, as text */
static const char *log_member(const char *line, const char *name, char out[256]) {
    OWN(api_problem, clear) problem;
    OWN(api_json, free) *document = NULL;
    api_problem_init(&problem);
    out[0] = 0;
    if (!CHECK_SAYING(api_json_new(&document, line, strcspn(line, "\n"), 8, &problem) == PEND_OK,
                      "no JSON: %.200s", line))
        return out;
    struct api_value root = api_json_root(document), value = api_value_member(&root, name);
    const char *text = api_value_text(&value);
    if (text)
        snprintf(out, 256, "%s", text);
    else if (api_value_kind(&value) == API_NUMBER)
        snprintf(out, 256, "%.15g", api_value_number(&value));
    return out;
}

TEST(a_request_is_one_line_of_json) {
    FILE *file = tmpfile();
    struct srv_log *log;
    char text[4096], member[256];
    struct srv_log_request request = log_sample;
    REQUIRE(file && srv_log_new(&log, dup(fileno(file)), dup(fileno(file))) == PEND_OK);
    request.target = "/a\"b\\c\n\x01\xff";
    request.agent = "caf\xc3\xa9";
    srv_log_request(log, &request);
    srv_log_free(&log);
    CHECK(log == NULL);
    size_t bytes = log_file(file, text, sizeof text);
    CHECK(bytes && strchr(text, '\n') == text + bytes - 1);
    CHECK_TEXT(log_member(text, "id", member), "i1");
    CHECK_TEXT(log_member(text, "client", member), "127.0.0.1");
    CHECK_TEXT(log_member(text, "method", member), "GET");
    CHECK_TEXT(log_member(text, "target", member), "/a\"b\\c\n\x01\xef\xbf\xbd");
    CHECK_TEXT(log_member(text, "agent", member), "caf\xc3\xa9");
    CHECK_TEXT(log_member(text, "outcome", member), "answered");
    CHECK_TEXT(log_member(text, "status", member), "200");
    CHECK_TEXT(log_member(text, "bytes_in", member), "1");
    CHECK_TEXT(log_member(text, "bytes_out", member), "23");
    CHECK_TEXT(log_member(text, "wait", member), "4e-06");
    CHECK_TEXT(log_member(text, "compute", member), "1.234567");
    CHECK_TEXT(log_member(text, "total", member), "0");
    CHECK_TEXT(log_member(text, "steps", member), "7");
    CHECK_INT((long long)strlen(log_member(text, "time", member)), 24);
    fclose(file);
}

TEST(a_message_is_one_line_whatever_is_in_it) {
    FILE *file = tmpfile();
    struct srv_log *log;
    char text[4096];
    REQUIRE(file && srv_log_new(&log, -1, dup(fileno(file))) == PEND_OK);
    srv_log_message(log, "one %d\ntwo\x1b[31m", 1);
    srv_log_request(log, &log_sample); /* dropped: no descriptor */
    srv_log_free(&log);
    log_file(file, text, sizeof text);
    CHECK_TEXT(text, "one 1?two?[31m\n");
    fclose(file);
}

struct log_crowd {
    struct srv_log *log;
    int number;
};

static void *log_writer(void *argument) {
    struct log_crowd *crowd = argument;
    struct srv_log_request request = log_sample;
    for (int i = 0; i < 500; i++) {
        request.steps = 500 * crowd->number + i;
        srv_log_request(crowd->log, &request);
    }
    return NULL;
}

TEST(lines_of_many_threads_come_whole_and_once_each) {
    enum { THREADS = 4, LINES = 500 * THREADS };
    FILE *file = tmpfile();
    struct log_crowd crowd[THREADS];
    pthread_t thread[THREADS];
    struct srv_log *log;
    static unsigned char seen[LINES];
    static char text[LINES * 300];
    char member[256];
    REQUIRE(file && srv_log_new(&log, dup(fileno(file)), 2) == PEND_OK);
    for (int i = 0; i < THREADS; i++) {
        crowd[i] = (struct log_crowd){log, i};
        pthread_create(&thread[i], NULL, log_writer, &crowd[i]);
    }
    for (int i = 0; i < THREADS; i++) pthread_join(thread[i], NULL);
    srv_log_free(&log);
    log_file(file, text, sizeof text);
    int lines = 0;
    memset(seen, 0, sizeof seen);
    for (char *line = text; *line; line = strchr(line, '\n') + 1, lines++) {
        int steps = atoi(log_member(line, "steps", member));
        if (!CHECK(steps >= 0 && steps < LINES && !seen[steps]++)) break;
    }
    CHECK_INT(lines, LINES);
    fclose(file);
}

TEST(a_reader_that_does_not_read_holds_nobody_up) {
    enum { KEPT = 64 };
    int ends[2];
    struct srv_log *log;
    char text[65536];
    REQUIRE(!pipe(ends));
    REQUIRE(srv_log_new(&log, dup(ends[1]), 2) == PEND_OK);
    double begin = test_clock();
    for (int i = 0; i < 20000; i++) srv_log_request(log, &log_sample);
    double seconds = test_clock() - begin;
    CHECK_SAYING(seconds < TEST_PATIENCE, "20000 lines took %.1f s", seconds);
    /* the reader comes back: what it then reads ends with the count of lost lines */
    fcntl(ends[0], F_SETFL, O_NONBLOCK);
    size_t all = 0, last = 0;
    int found = 0;
    for (double until = test_clock() + TEST_PATIENCE; !found && test_clock() < until;) {
        ssize_t got = read(ends[0], text + last, sizeof text - 1 - KEPT);
        if (got <= 0) {
            test_sleep(0.005);
            continue;
        }
        all += (size_t)got;
        text[last + (size_t)got] = 0;
        found = strstr(text, "{\"lost_lines\":") != NULL;
        last = last + (size_t)got > KEPT ? KEPT : last + (size_t)got;
        memmove(text, text + strlen(text) - last, last);
    }
    CHECK(found);
    CHECK_SAYING(all > 1000000, "%zu bytes were kept", all);
    srv_log_free(&log);
    close(ends[0]);
    close(ends[1]);
}

TEST(the_end_of_the_log_does_not_wait_for_ever) {
    int ends[2];
    struct srv_log *log;
    REQUIRE(!pipe(ends));
    REQUIRE(srv_log_new(&log, dup(ends[1]), 2) == PEND_OK);
    for (int i = 0; i < 2000; i++) srv_log_request(log, &log_sample);
    double begin = test_clock();
    srv_log_free(&log);
    double seconds = test_clock() - begin;
    CHECK_SAYING(seconds > 0.2 && seconds < TEST_PATIENCE, "it took %.1f s", seconds);
    close(ends[0]);
    close(ends[1]);
}

TEST(a_log_survives_want_of_memory) {
    FILE *file = tmpfile();
    struct srv_log *log = NULL;
    static char text[65536];
    REQUIRE(file != NULL);
    test_alloc_fail(1, 1);
    CHECK(srv_log_new(&log, dup(fileno(file)), 2) == PEND_NO_MEMORY && !log);
    test_alloc_faults_off();
    REQUIRE(srv_log_new(&log, dup(fileno(file)), 2) == PEND_OK);
    test_alloc_fail(1, 1);
    srv_log_request(log, &log_sample);
    test_alloc_faults_off();
    srv_log_request(log, &log_sample);
    srv_log_free(&log);
    log_file(file, text, sizeof text);
    CHECK(strstr(text, "\"i1\"") != NULL);
    CHECK(strstr(text, "{\"lost_lines\":1}\n") != NULL);
    fclose(file);
}

TEST(audit_entries_go_to_a_file_of_their_own_once_it_is_named) {
    FILE *file = tmpfile(), *other = tmpfile();
    struct srv_log *log;
    char text[4096], member[256];
    const struct srv_log_audit_entry entry = {.id = "i1",
                                              .who = "key:a\"b",
                                              .role = "teacher",
                                              .what = "DELETE /v1/jobs/{id}",
                                              .of = "x",
                                              .status = 200,
                                              .outcome = "done"};
    REQUIRE(file && other && srv_log_new(&log, dup(fileno(other)), dup(fileno(other))) == PEND_OK);
    srv_log_audit_entry(log, &entry);
    srv_log_turn(log, SRV_LOG_AUDIT, dup(fileno(file)));
    srv_log_audit_entry(log, &entry);
    srv_log_free(&log);
    log_file(file, text, sizeof text);
    CHECK_TEXT(log_member(text, "who", member), "key:a\"b");
    CHECK_TEXT(log_member(text, "what", member), "DELETE /v1/jobs/{id}");
    CHECK_TEXT(log_member(text, "of", member), "x");
    CHECK_TEXT(log_member(text, "status", member), "200");
    CHECK_TEXT(log_member(text, "outcome", member), "done");
    /* what was logged before the file was named is lost, and no entry is among the requests */
    CHECK(strchr(text, '\n') == strrchr(text, '\n'));
    CHECK_INT(log_file(other, text, sizeof text), 0);
    fclose(file);
    fclose(other);
}
