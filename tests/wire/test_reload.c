/* SIGHUP reloads the options and SIGUSR1 reopens the log; neither ends the process. */
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/wire/ask.h"

/* A daemon with a file of options and a file of request lines, in a separate directory. */
struct house {
    char directory[32], file[64], log[64], old[64];
    struct test_server *server;
};

/* writes the file of options: its own log, unless the text names another */
static int house_write(const struct house *house, const char *text) {
    FILE *file = fopen(house->file, "w");
    if (!CHECK(file != NULL)) return 0;
    if (!strstr(text, "log =")) fprintf(file, "log = %s\n", house->log);
    fputs(text, file);
    return CHECK(!fclose(file));
}

static int house_begin(struct house *house, const char *text) {
    *house = (struct house){.directory = "/tmp/pendulumd-test-XXXXXX"};
    if (!CHECK(mkdtemp(house->directory) != NULL)) return 0;
    snprintf(house->file, sizeof house->file, "%s/options", house->directory);
    snprintf(house->log, sizeof house->log, "%s/log", house->directory);
    snprintf(house->old, sizeof house->old, "%s/log.1", house->directory);
    const char *const options[] = {"--config", house->file, NULL};
    return house_write(house, text) && CHECK((house->server = test_server_start(options)) != NULL);
}

static void house_end(struct house *house) {
    char command[64];
    test_server_signal(house->server, SIGTERM);
    CHECK_INT(test_server_wait(house->server), 0);
    test_server_drop(&house->server);
    snprintf(command, sizeof command, "rm -rf '%s'", house->directory);
    CHECK(!system(command));
}

/* sends SIGHUP and waits until the log has this many lines with a word */
static int house_reload(struct house *house, const char *word, int count) {
    test_server_signal(house->server, SIGHUP);
    for (double end = test_clock() + TEST_PATIENCE; test_clock() < end; test_sleep(0.01)) {
        int found = 0;
        for (const char *at = test_server_log(house->server); (at = strstr(at, word)); at++)
            found++;
        if (found == count) return 1;
    }
    return CHECK_SAYING(0, "it does not say %s %d times but: %s", word, count,
                        test_server_log(house->server));
}

static int house_ask(const struct house *house, const char *fields, char origin[64]) {
    OWN(test_reply, clear) reply;
    int status = test_request(house->server, &reply, "POST", "/v1/trees", fields, ASK_LITTLE);
    const char *allowed = test_reply_header(&reply, "Access-Control-Allow-Origin");
    snprintf(origin, 64, "%s", allowed ? allowed : "");
    return status;
}

TEST(a_reload_puts_new_options_in_force_and_names_those_that_want_a_restart) {
    OWN(house, end) house;
    char origin[64];
    REQUIRE(house_begin(&house, "cache-bytes = 0\nmax-arms = 1\ncors-origins = none\n"));
    CHECK_INT(house_ask(&house, "Origin: https://a.example\r\n", origin), 422);
    CHECK_TEXT(origin, "");
    house_write(&house,
                "cache-bytes = 0\nmax-arms = 10\ncors-origins = https://a.example\nworkers = "
                "3\nmax-requests-a-minute = 1000\n");
    REQUIRE(house_reload(&house, "reload: 3 options have changed", 1));
    CHECK_INT(house_ask(&house, "Origin: https://a.example\r\n", origin), 200);
    CHECK_TEXT(origin, "https://a.example");
    const char *log = test_server_log(house.server);
    CHECK(strstr(log, "reload: max-arms has a new value") &&
          strstr(log, "reload: cors-origins has a new value"));
    CHECK(strstr(log, "reload: workers has changed, which needs a restart"));
    /* and back to the defaults */
    house_write(&house, "cache-bytes = 0\nmax-arms = 1\n");
    REQUIRE(house_reload(&house, "reload: 3 options have changed", 2));
    CHECK_INT(house_ask(&house, "Origin: https://a.example\r\n", origin), 422);
    CHECK_TEXT(origin, "*");
}

TEST(a_bad_file_changes_nothing) {
    static const char *const bad[] = {
        "max-arms = 10\nmax-arm = 10\n",       "max-arms = 10\nmax-queue = many\n",
        "max-arms = 10\ntrusted-proxy = me\n", "max-arms = 10\nlog = /nowhere/log\n",
        "max-arms = 10\nhosts = a b\n",        "max-arms = 10\ncors-origins\n",
    };
    OWN(house, end) house;
    char origin[64];
    REQUIRE(house_begin(&house, "max-arms = 1\n"));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        house_write(&house, bad[i]);
        REQUIRE(house_reload(&house, "reload: nothing has changed: ", (int)i + 1));
        CHECK_INT(house_ask(&house, "", origin), 422);
    }
    unlink(house.file);
    REQUIRE(house_reload(&house, "options: No such file", 1));
    CHECK_INT(house_ask(&house, "", origin), 422);
}

static long size_of(const char *path) {
    struct stat file;
    return stat(path, &file) ? -1 : (long)file.st_size;
}

/* sends requests until a file has more than this many bytes */
static int grows(const struct house *house, const char *path, long bytes) {
    char origin[64];
    for (double end = test_clock() + TEST_PATIENCE; test_clock() < end; test_sleep(0.02)) {
        CHECK_INT(house_ask(house, "", origin), 200);
        if (size_of(path) > bytes) return 1;
    }
    return CHECK_SAYING(0, "%s does not grow beyond %ld bytes", path, bytes);
}

TEST(a_log_that_was_moved_away_is_opened_anew) {
    static const int told[] = {SIGUSR1, SIGHUP};
    OWN(house, end) house;
    struct stat file;
    REQUIRE(house_begin(&house, "\n"));
    CHECK(grows(&house, house.log, 0));
    CHECK(!stat(house.log, &file) && (file.st_mode & 0777) == 0600);
    for (int i = 0; i < 2; i++) {
        CHECK(!rename(house.log, house.old));
        CHECK(grows(&house, house.old, size_of(house.old)));
        CHECK_INT(size_of(house.log), -1);
        test_server_signal(house.server, told[i]);
        CHECK(grows(&house, house.log, 0));
        long before = size_of(house.old);
        CHECK(grows(&house, house.log, size_of(house.log)));
        CHECK_INT(size_of(house.old), before);
    }
    test_server_signal(house.server, SIGUSR2);
    CHECK(grows(&house, house.log, size_of(house.log)));
}

TEST(options_change_under_load_and_no_request_notices) {
    OWN(house, end) house;
    REQUIRE(house_begin(&house, "max-arms = 10\n"));
    for (int i = 0; i < 20; i++) {
        char text[64], origin[64];
        snprintf(text, sizeof text, "max-arms = %d\n", 11 + i);
        house_write(&house, text);
        test_server_signal(house.server, SIGHUP);
        for (int k = 0; k < 10; k++) CHECK_INT(house_ask(&house, "", origin), 200);
    }
}

/* Signals are received before there is a socket, so the end is requested only then. */
TEST(closed_standard_streams_are_nobodys_socket) {
    char directory[] = "/tmp/pendulumd-test-XXXXXX", command[1024];
    REQUIRE(mkdtemp(directory));
    char program[256] = "";
    ssize_t bytes = readlink("/proc/self/exe", program, sizeof program - 1);
    char *end = strstr(program, "/tests/wire/");
    REQUIRE(bytes > 0 && end);
    strcpy(end, "/pendulumd");
    snprintf(
        command, sizeof command,
        "'%s' --listen 127.0.0.1:0 --store none --allow-root on <&- >&- 2>&- & pid=$!; for i in "
        "$(seq 1000); do readlink /proc/$pid/fd/* | grep -q socket: && break; sleep 0.02; done; "
        "readlink /proc/$pid/fd/0 /proc/$pid/fd/1 /proc/$pid/fd/2 >%s/fds; kill $pid; wait $pid",
        program, directory);
    CHECK_INT(system(command), 0);
    snprintf(command, sizeof command,
             "test \"$(cat %s/fds | tr '\\n' ' ')\" = '/dev/null /dev/null /dev/null '; s=$?; rm "
             "-r %s; exit $s",
             directory, directory);
    CHECK_INT(system(command), 0);
}
