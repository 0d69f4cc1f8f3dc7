/* A daemon with --isolate: what it answers is what one without it answers, and a process that
 * computes is ended in the middle as its crash would end it, by a signal that anybody may send who
 * may end the daemon. */
#include <dirent.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/wire/ask.h"
#include "tests/harness/requests.h"
#include "tests/wire/place.h"

enum { MOST = 64, PATH = 128, LITTLE = 40 };

/* s of a motion whose computation takes longer than three crashes of it */
#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
enum { BORNE = 30 };
#else
enum { BORNE = 150 };
#endif

/* the processes that another has begun; returns how many */
static int children(int parent, int pid[MOST]) {
    int count = 0;
    DIR *all = opendir("/proc");
    for (struct dirent *entry; all && (entry = readdir(all));) {
        char path[PATH], text[512];
        int its = 0, number = atoi(entry->d_name);
        if (number <= 0) continue;
        snprintf(path, sizeof path, "/proc/%d/stat", number);
        FILE *file = fopen(path, "r");
        if (!file) continue;
        /* PID (NAME) STATE PARENT */
        char *end = fgets(text, sizeof text, file) ? strrchr(text, ')') : NULL;
        char state = 0;
        if (end && sscanf(end + 1, " %c %d", &state, &its) == 2 && state != 'Z' && its == parent &&
            count < MOST)
            pid[count++] = number;
        fclose(file);
    }
    if (all) closedir(all);
    return count;
}

/* the process that makes those which compute */
static int maker(const struct test_server *server) {
    int pid[MOST];
    return CHECK_INT(children(test_server_pid(server), pid), 1) ? pid[0] : -1;
}

/* ticks that a process has had of a processor; -1 = there is none of that number, or it has ended
 */
static long ticks(int pid) {
    char path[PATH], text[512];
    long user = -1, system = 0;
    snprintf(path, sizeof path, "/proc/%d/stat", pid);
    FILE *file = fopen(path, "r");
    char *end = file && fgets(text, sizeof text, file) ? strrchr(text, ')') : NULL;
    if (file) fclose(file);
    char state = 'Z';
    if (!end || sscanf(end + 1, " %c", &state) != 1 || state == 'Z') return -1;
    sscanf(end + 1, " %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %ld %ld", &user, &system);
    return user + system;
}

/*
 * waits for a process that computes: one that has had 0.05 s of a processor since it was first seen
 * here, for what it had before may have been another's request, and it idle since; 0 where none
 * comes
 */
static int busiest(const struct test_server *server) {
    struct {
        int pid;
        long ticks;
    } seen[MOST];
    int zygote = maker(server), pid[MOST], known = 0;
    double end = test_clock() + TEST_PATIENCE;
    for (; test_clock() < end; test_sleep(0.005)) {
        int count = children(zygote, pid);
        for (int i = 0; i < count; i++) {
            int at = 0;
            while (at < known && seen[at].pid != pid[i]) at++;
            if (at < known && ticks(pid[i]) >= seen[at].ticks + 5) return pid[i];
            if (at < known || known == MOST) continue;
            seen[known].pid = pid[i];
            seen[known++].ticks = ticks(pid[i]);
        }
    }
    CHECK_SAYING(0, "no process computed for a while");
    return 0;
}

static struct test_server *isolated(const char *option, const char *value) {
    const char *const options[] = {"--isolate", "on",   "--cache-bytes", "0", "--workers",
                                   "2",         option, value,           NULL};
    return test_server_start(options);
}

/* --- answers --- */

/* the name of the number that tells how long it took, and how many bytes of an archive it takes,
 * with the archive's own sums of these bytes */
#define SECONDS "compute_seconds"
enum { TIMED = 24 };

/* takes that number out of a text */
static void without_seconds(struct test_reply *reply) {
    static const char name[] = "\"" SECONDS "\":";
    for (char *at = reply->body; (at = strstr(at, name));) {
        char *from = at + sizeof name - 1;
        size_t digits = strspn(from, "0123456789.e+-");
        memmove(from, from + digits, strlen(from + digits) + 1);
        at = from;
    }
    reply->body_bytes = strlen(reply->body);
}

/* leaves the rows of a Parquet file: the description behind them has that number as a text, which
 * may be longer or shorter */
static void without_description(struct test_reply *reply) {
    const unsigned char *end = (const unsigned char *)reply->body + reply->body_bytes - 8;
    size_t bytes = end[0] | (size_t)end[1] << 8 | (size_t)end[2] << 16 | (size_t)end[3] << 24;
    if (CHECK(bytes + 12 <= reply->body_bytes)) reply->body_bytes -= bytes + 8;
}

/* how many bytes of two answers differ */
static int unlike(const struct test_reply *one, const struct test_reply *other) {
    int count = 0;
    if (one->body_bytes != other->body_bytes) return TIMED + 1;
    for (size_t i = 0; i < one->body_bytes; i++) count += one->body[i] != other->body[i];
    return count;
}

TEST(answers_of_processes_are_those_of_threads_to_the_bit) {
    static const char *const fields[] = {"Content-Type", "ETag", "X-Columns", "X-Warning",
                                         "Content-Disposition"};
    struct test_server *with = isolated(NULL, NULL), *without = test_server_start(NULL);
    int same = 0;
    for (int i = 0; with && without && i < TEST_REQUESTS; i++) {
        const struct test_request *one = &test_requests[i];
        struct test_reply here, there;
        char path[PATH], headers[PATH] = "";
        if (!one->body) continue;
        snprintf(path, sizeof path, "/v1/%s", api_op_at(one->op)->name);
        if (one->accept) snprintf(headers, sizeof headers, "Accept: %s\r\n", one->accept);
        int status = test_request(without, &here, "POST", path, headers, one->body);
        CHECK_INT(test_request(with, &there, "POST", path, headers, one->body), status);
        if (here.body_bytes && here.body[0] == '{') {
            without_seconds(&here);
            without_seconds(&there);
        }
        if (here.body_bytes >= 12 && there.body_bytes >= 12 && !memcmp(here.body, "PAR1", 4)) {
            without_description(&here);
            without_description(&there);
        }
        int others = unlike(&here, &there);
        same += !others;
        CHECK_SAYING(others == 0 || (others <= TIMED && memmem(here.body, here.body_bytes, SECONDS,
                                                               sizeof SECONDS - 1)),
                     "request %d: %d bytes differ", i, others);
        for (size_t f = 0; f < sizeof fields / sizeof *fields; f++) {
            const char *other = test_reply_header(&there, fields[f]),
                       *own = test_reply_header(&here, fields[f]);
            CHECK_TEXT(other ? other : "", own ? own : "");
        }
        test_reply_clear(&here);
        test_reply_clear(&there);
    }
    CHECK_SAYING(same > TEST_REQUESTS / 2, "%d of %d", same, TEST_REQUESTS);
    test_server_stop(&with);
    test_server_stop(&without);
}

TEST(an_answer_is_kept_for_a_requests_bytes_and_not_for_what_its_process_says_of_them) {
    const char *const options[] = {"--isolate", "on", "--cache-bytes", "16M", NULL};
    /* the same bytes, and others that mean the same */
    static const char *const body[] = {ASK_LITTLE, ASK_LITTLE, ASK_LITTLE " "};
    struct test_server *server = test_server_start(options);
    for (int i = 0; server && i < 3; i++) {
        struct test_reply reply;
        CHECK_INT(ask(server, &reply, "/v1/modes", body[i]), 200);
        test_reply_clear(&reply);
    }
    if (!server) return;
    CHECK_INT((int)ask_metric(server, "pendulumd_cache_lookups_total{result=\"exact\"}"), 1);
    CHECK_INT((int)ask_metric(server, "pendulumd_cache_lookups_total{result=\"digest\"}"), 0);
    CHECK_INT((int)ask_metric(server, "pendulumd_cache_lookups_total{result=\"missed\"}"), 2);
    test_server_stop(&server);
}

/* --- what they may --- */

TEST(a_process_that_computes_has_no_files_no_network_and_no_privileges) {
    struct test_server *server = isolated("--walls", "auto");
    int pid[MOST], zygote = server ? maker(server) : -1, count = 0;
    char path[PATH], text[64];
    double end = test_clock() + TEST_PATIENCE;
    /* one is made ahead */
    while (server && !(count = children(zygote, pid)) && test_clock() < end) test_sleep(0.01);
    if (!server || !CHECK(count > 0)) return;
    /* it is of this number before it has given up all */
    while (ask_process(pid[0], "Seccomp", 10) != 2 && test_clock() < end &&
           !strstr(test_server_log(server), "walls: not all"))
        test_sleep(0.01);
    snprintf(path, sizeof path, "/proc/%d/fd/4", pid[0]);
    while (!access(path, F_OK) && test_clock() < end) test_sleep(0.01);
    int lacks = strstr(test_server_log(server), "walls: not all") != NULL;
    CHECK_INT(ask_process(pid[0], "Seccomp", 10), lacks ? 0 : 2);
    CHECK_INT(ask_process(pid[0], "NoNewPrivs", 10), 1);
    CHECK_INT(ask_process(zygote, "NoNewPrivs", 10), 1);
    CHECK_INT(ask_process(pid[0], "CapEff", 16), 0);
#ifndef __SANITIZE_THREAD__ /* which has one of its own */
    CHECK_INT(ask_process(pid[0], "Threads", 10), 1);
#endif
    /* its socket, and nowhere */
    for (int fd = 0; fd < 16; fd++) {
        snprintf(path, sizeof path, "/proc/%d/fd/%d", pid[0], fd);
        ssize_t bytes = readlink(path, text, sizeof text - 1);
        text[bytes > 0 ? bytes : 0] = 0;
        if (fd > 3) CHECK_TEXT(text, "");
        if (fd == 3) CHECK_SAYING(!strncmp(text, "socket:", 7), "%s", text);
        if (fd < 2) CHECK_TEXT(text, "/dev/null");
    }
    /* and nothing of the daemon's environment */
    snprintf(path, sizeof path, "/proc/%d/environ", pid[0]);
    FILE *file = fopen(path, "r");
    char all[4096] = "";
    size_t bytes = file ? fread(all, 1, sizeof all - 1, file) : 0;
    CHECK(!memmem(all, bytes, "HOME=", 5) && !memmem(all, bytes, "PENDULUMD_", 10));
    if (file) fclose(file);
    test_server_stop(&server);
}

/* s of a processor that a process may take that was made ahead; -1 = there is none, or no bound */
static long seconds_of(int zygote) {
    int pid[MOST];
    char path[PATH], line[256];
    long value = -1;
    if (!children(zygote, pid)) return -1;
    snprintf(path, sizeof path, "/proc/%d/limits", pid[0]);
    FILE *file = fopen(path, "r");
    while (file && fgets(line, sizeof line, file) && sscanf(line, "Max cpu time %ld", &value) != 1)
        continue;
    if (file) fclose(file);
    return value;
}

TEST(after_a_reload_processes_may_take_what_it_says) {
    char name[] = "/tmp/pendulumd-test-XXXXXX", text[80];
    const char *const options[] = {"--config", name, NULL};
    struct test_server *server = NULL;
    int fd = mkstemp(name);
    for (int seconds = 1000; CHECK(fd >= 0) && seconds <= 2000; seconds += 1000) {
        struct test_reply reply;
        double end = test_clock() + TEST_PATIENCE;
        int bytes = snprintf(text, sizeof text,
                             "isolate = on\ncache-bytes = 0\nmax-job-seconds = %d\n", seconds);
        if (!CHECK(pwrite(fd, text, (size_t)bytes, 0) == bytes)) break;
        if (server)
            test_server_signal(server, SIGHUP);
        else
            server = test_server_start(options);
        if (!CHECK(server != NULL)) break;
        while (seconds > 1000 && !strstr(test_server_log(server), "has changed") &&
               test_clock() < end)
            test_sleep(0.01);
        CHECK_INT(ask(server, &reply, "/v1/modes", ASK_LITTLE), 200);
        test_reply_clear(&reply);
        /* and a minute more */
        int zygote = maker(server);
        while (seconds_of(zygote) != seconds + 60 && test_clock() < end) test_sleep(0.01);
        CHECK_INT((int)seconds_of(zygote), seconds + 60);
    }
    /* its log says more than that it listens: that it has read its options again */
    if (server) test_server_drop(&server);
    if (fd >= 0) close(fd);
    unlink(name);
}

TEST(compute_is_for_the_server_alone) {
    char said[512];
    char program[PATH * 8], command[PATH * 9];
    ssize_t bytes = readlink("/proc/self/exe", program, sizeof program - 1);
    program[bytes > 0 ? bytes : 0] = 0;
    char *end = strstr(program, "/tests/wire/run");
    if (!CHECK(end != NULL)) return;
    *end = 0;
    snprintf(command, sizeof command, "'%s/pendulumd' compute 2>&1 3<&-", program);
    FILE *pipe = popen(command, "r");
    if (!CHECK(pipe != NULL)) return;
    said[fread(said, 1, sizeof said - 1, pipe)] = 0;
    CHECK_INT(WEXITSTATUS(pclose(pipe)), 2);
    CHECK_SAYING(strstr(said, "--isolate on") != NULL, "%s", said);
}

/* --- crashes --- */

/* a client that asks in a thread of its own */
struct client {
    pthread_t thread;
    int port, status;
    struct test_reply reply;
};

static void *client_long(void *context) {
    struct client *client = context;
    struct test_client socket;
    const char *body = ask_long(3000);
    char head[256];
    snprintf(head, sizeof head,
             "POST /v1/trajectories HTTP/1.1\r\nHost: localhost\r\nContent-Type: "
             "application/json\r\nContent-Length: %zu\r\n\r\n",
             strlen(body));
    memset(&client->reply, 0, sizeof client->reply);
    if (!test_client_open(&socket, client->port)) return NULL;
    test_client_say(&socket, head);
    test_client_say(&socket, body);
    client->status = test_client_receive(&socket, &client->reply, 0, TEST_PATIENCE);
    test_client_close(&socket);
    return NULL;
}

TEST(a_crash_in_a_computation_is_one_answer_and_nobody_else_notices) {
    struct test_server *server = isolated(NULL, NULL);
    struct client client = {.port = server ? test_server_port(server) : 0};
    struct test_reply reply;
    int answered = 0;
    if (!server || !CHECK(!pthread_create(&client.thread, NULL, client_long, &client))) return;
    int pid = busiest(server);
    /* others ask before, at and after it */
    for (int i = 0; i < LITTLE; i++) {
        if (i == LITTLE / 2 && pid) CHECK(!kill(pid, SIGSEGV));
        answered += ask(server, &reply, "/v1/modes", ASK_LITTLE) == 200;
        test_reply_clear(&reply);
    }
    pthread_join(client.thread, NULL);
    CHECK_INT(answered, LITTLE);
    CHECK_INT(client.status, 500);
    ask_problem(&client.reply, 500, NULL);
    CHECK_SAYING(strstr(client.reply.body, "ended in the middle") != NULL, "%s", client.reply.body);
    CHECK(ask_metric(server, "pendulumd_crashed_total") == 1);
    /* the log has a thread of its own */
    static const char said[] = "ended in the middle of a computation";
    for (double end = test_clock() + TEST_PATIENCE;
         !strstr(test_server_log(server), said) && test_clock() < end;)
        test_sleep(0.01);
    CHECK(strstr(test_server_log(server), said) != NULL);
    test_reply_clear(&client.reply);
    stop_after_deaths(&server);
}

/* ends processes of a job while they compute; returns how many */
static int crashes(const struct test_server *server, const char *id, int most) {
    int done = 0, before = 0;
    for (double end = test_clock() + TEST_PATIENCE; done < most && test_clock() < end;) {
        int pid = busiest(server);
        if (!pid) break;
        if (pid == before) {
            test_sleep(0.005);
            continue;
        }
        before = pid;
        done += !kill(pid, SIGSEGV);
    }
    CHECK_SAYING(done == most, "job %s", id);
    return done;
}

static void isolated_job(struct place *place) {
    struct test_server *server = place_serve(place, "all", "1000", "--isolate", "on");
    char id[ID + 1], word[WORDS];
    struct test_reply here, there;
    if (!server) return;
    /* three crashes are borne */
    CHECK_INT(submit(server, "/v1/trajectories", ASYNC, ask_long(BORNE), id), 202);
    crashes(server, id, 3);
    job_wait(server, id, word);
    CHECK_TEXT(word, "successful");
    CHECK_INT(job_get(server, &there, id, "/results", "Accept: text/csv\r\n"), 200);
    CHECK_INT(test_request(server, &here, "POST", "/v1/trajectories", "Accept: text/csv\r\n",
                           ask_long(BORNE)),
              200);
    CHECK(here.body_bytes == there.body_bytes && !memcmp(here.body, there.body, here.body_bytes));
    test_reply_clear(&here);
    test_reply_clear(&there);
    /* the fourth ends the job, which says so */
    CHECK_INT(submit(server, "/v1/trajectories", ASYNC, ask_long(3000), id), 202);
    crashes(server, id, 4);
    job_wait(server, id, word);
    CHECK_TEXT(word, "failed");
    CHECK_INT(job_get(server, &there, id, "", ""), 200);
    CHECK_SAYING(strstr(there.body, "4 times in a row: the process that computed this") != NULL,
                 "%s", there.body);
    test_reply_clear(&there);
    CHECK(ask_metric(server, "pendulumd_crashed_total") == 7);
    stop_after_deaths(&server);
}

TEST(a_part_whose_process_crashes_is_tried_again_and_then_the_job_says_so) {
    place_on_both(isolated_job);
}

TEST(an_answer_that_is_too_large_is_refused_as_threads_refuse_it_and_no_crash) {
    static const char *const accept[] = {"", "Accept: text/csv\r\n"};
    struct test_server *with = isolated("--max-answer-bytes", "65536"), *without = NULL;
    const char *const options[] = {"--max-answer-bytes", "65536", NULL};
    if (with) without = test_server_start(options);
    for (int i = 0; without && i < 4; i++) {
        const char *path = i < 2 ? "/v1/trajectories" : "/v1/modes",
                   *body = i < 2 ? ASK_EXAMPLE : "{\"pendulum\":" ASK_FOUR_ARMS "}";
        struct test_reply here, there;
        int status = test_request(without, &here, "POST", path, accept[i % 2], body);
        CHECK_INT(test_request(with, &there, "POST", path, accept[i % 2], body), status);
        CHECK_TEXT(there.body, here.body);
        /* tables of text flow, and have no such bound */
        CHECK(i || status >= 400);
        test_reply_clear(&here);
        test_reply_clear(&there);
    }
    if (with) CHECK(ask_metric(with, "pendulumd_crashed_total") == 0);
    test_server_stop(&with);
    test_server_stop(&without);
}

/* --- clients that go --- */

static void read_for_nobody(struct place *place) {
    static const char request[] =
        "POST /v1/trajectories HTTP/1.1\r\nHost: localhost\r\n" ASYNC
        "Content-Type: application/json\r\nContent-Length: %zu\r\n\r\n" ASK_EXAMPLE;
    const char *const options[] = {
        "--isolate", "on", "--store", place->url, "--max-compute-seconds", "3600", NULL};
    struct test_server *server = test_server_start(options);
    struct test_client client;
    char message[sizeof request + LITTLE];
    int pid[MOST];
    double end = test_clock() + TEST_PATIENCE;
    if (!server) return;
    int zygote = maker(server), made = 0;
    while (!(made = children(zygote, pid)) && test_clock() < end) test_sleep(0.01);
    int asked = made ? pid[0] : -1;
    snprintf(message, sizeof message, request, sizeof ASK_EXAMPLE - 1);
    /* the one that was made ahead is to read it, and does not answer */
    if (CHECK(made) && CHECK(!kill(asked, SIGSTOP)) &&
        test_client_open(&client, test_server_port(server))) {
        test_client_say(&client, message);
        while (children(zygote, pid) < 2 && test_clock() < end) test_sleep(0.01);
        CHECK(ticks(asked) >= 0);
        test_client_close(&client);
        while (ticks(asked) >= 0 && test_clock() < end) test_sleep(0.01);
        CHECK_INT((int)ticks(asked), -1);
        CHECK(ask_metric(server, "pendulumd_crashed_total") == 0);
    }
    test_server_stop(&server);
}

TEST(a_process_that_reads_a_job_ends_with_its_client) {
    struct place place;
    if (place_begin(&place, 0)) read_for_nobody(&place);
    place_end(&place);
}

TEST(a_server_drains_when_it_can_make_no_more_processes) {
    struct test_server *server = isolated(NULL, NULL);
    struct test_reply reply;
    if (!server) return;
    CHECK_INT(ask(server, &reply, "/v1/modes", ASK_LITTLE), 200);
    test_reply_clear(&reply);
    kill(maker(server), SIGKILL);
    CHECK_INT(test_server_wait(server), 1);
    CHECK_SAYING(strstr(test_server_log(server), "drains") != NULL, "%s", test_server_log(server));
    test_server_drop(&server);
}

TEST(no_process_outlives_the_daemon) {
    struct test_server *server = isolated(NULL, NULL);
    struct client client = {.port = server ? test_server_port(server) : 0};
    int pid[MOST], left = 1;
    if (!server || !CHECK(!pthread_create(&client.thread, NULL, client_long, &client))) return;
    int busy = busiest(server), zygote = maker(server), count = children(zygote, pid);
    test_server_signal(server, SIGKILL);
    pthread_join(client.thread, NULL);
    for (double end = test_clock() + TEST_PATIENCE; left && test_clock() < end;) {
        left = ticks(zygote) >= 0 || (busy && ticks(busy) >= 0);
        for (int i = 0; i < count; i++) left |= ticks(pid[i]) >= 0;
        test_sleep(0.01);
    }
    CHECK(!left);
    test_reply_clear(&client.reply);
    test_server_drop(&server);
}
