/* A daemon with little memory and clients that do not read, do not send, or leave: its resident
 * memory, its accounts, and whether other clients are served meanwhile. */
#include <arpa/inet.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/harness/fence.h"
#include "tests/wire/place.h"

#define HELD "64M"

/* bytes of resident memory that the process may have under HELD, and its address space */
static const double resident_most = 1.2 * (64 << 20) + (64 << 20);
enum { SPACE = 1 << 30, CROWD = 20, BODY = 1 << 17 };

/* true if tools have memory of their own in the process */
#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
#define memory_tools 1
#else
#define memory_tools (getenv("TEST_UNDER") != NULL)
#endif

#define ONE_ARM "{\"length\":[1],\"mass\":[1],\"parent\":[0]}"
#define NPZ "Accept: application/x-npz\r\n"

/* a trajectory that takes 32 bytes per instant; each number of instants is a different answer */
static const char *memory_long(int instants) {
    static char body[256];
    snprintf(body, sizeof body,
             "{\"pendulum\":" ONE_ARM
             ",\"initial\":{\"theta\":[1]},\"times\":{\"stop\":10,\"count\":%d},"
             "\"output\":[\"phi\",\"phid\",\"lambda\"]}",
             instants);
    return body;
}

/* the system's limit on the memory of a test's daemon */
static struct test_fence memory_fence;

/* as test_server_start, with this much address space */
static struct test_server *memory_serve_limited(const char *const options[]) {
    struct rlimit before, space;
    getrlimit(RLIMIT_AS, &before);
    space = before;
    space.rlim_cur = SPACE;
    setrlimit(RLIMIT_AS, &space);
    struct test_server *server = test_server_start(options);
    setrlimit(RLIMIT_AS, &before);
    return server;
}

/* As test_server_start, in a group of cgroup v2 with as much memory as may be resident; if the
 * machine permits none, with little address space. Sanitizers and other tools could not run with
 * either. */
static struct test_server *memory_serve(const char *const options[]) {
    char reason[200];
    memory_fence.path[0] = 0;
    if (memory_tools) return test_server_start(options);
    if (!test_fence_open(&memory_fence, (long long)resident_most, reason)) {
        printf("  bounded by RLIMIT_AS, %d MB, as no cgroup v2 can be made: %s\n", SPACE >> 20,
               reason);
        return memory_serve_limited(options);
    }
    struct test_server *server = test_server_start(options);
    printf("  bounded by cgroup v2, %.0f MB: %s\n", resident_most / (1 << 20), memory_fence.path);
    if (server) test_fence_enter(&memory_fence, test_server_pid(server));
    return server;
}

/* as test_server_stop, for a daemon of memory_serve */
static void memory_stop(struct test_server **server) {
    if (memory_fence.path[0] && test_fence_peak(&memory_fence) > 0)
        printf("  its group has had %.0f MB at most\n", test_fence_peak(&memory_fence) / (1 << 20));
    test_server_stop(server);
    test_fence_close(&memory_fence);
}

/* the resident bytes of the process; 0 if tools have their own in it */
static double memory_resident(const struct test_server *server) {
    char path[64];
    unsigned long long pages = 0, resident = 0;
    if (memory_tools) return 0;
    snprintf(path, sizeof path, "/proc/%d/statm", test_server_pid(server));
    FILE *file = fopen(path, "re");
    if (file && fscanf(file, "%llu %llu", &pages, &resident) != 2) resident = 0;
    if (file) fclose(file);
    return (double)resident * (double)sysconf(_SC_PAGESIZE);
}

/* a connection from 127.0.0.`from` */
static int memory_open(struct test_client *client, const struct test_server *server, int from) {
    struct sockaddr_in own = {.sin_family = AF_INET,
                              .sin_addr.s_addr = htonl(0x7f000000u + (unsigned)from)};
    struct sockaddr_in there = {.sin_family = AF_INET,
                                .sin_port = htons((unsigned short)test_server_port(server)),
                                .sin_addr.s_addr = htonl(0x7f000001)};
    int little = 4096;
    *client = (struct test_client){.fd = socket(AF_INET, SOCK_STREAM, 0)};
    setsockopt(client->fd, SOL_SOCKET, SO_RCVBUF, &little, sizeof little);
    return CHECK(!bind(client->fd, (struct sockaddr *)&own, sizeof own) &&
                 !connect(client->fd, (struct sockaddr *)&there, sizeof there));
}

/* sends a complete request, and reads nothing */
static int memory_send(struct test_client *client, const struct test_server *server, int from,
                       const char *method, const char *path, const char *headers,
                       const char *body) {
    char head[512];
    snprintf(head, sizeof head,
             "%s %s HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n%sContent-Length: "
             "%zu\r\n\r\n",
             method, path, headers, strlen(body));
    return memory_open(client, server, from) && CHECK(test_client_say(client, head)) &&
           CHECK(test_client_say(client, body));
}

enum { HEAD = 1024 };

/* the status of an unread answer, 0 while there is none, -1 once the connection has ended; `text`
 * receives its visible part */
static int memory_peek(const struct test_client *client, char text[HEAD]) {
    struct pollfd look = {.fd = client->fd, .events = POLLIN};
    text[0] = 0;
    if (poll(&look, 1, 0) <= 0) return 0;
    ssize_t got = recv(client->fd, text, HEAD - 1, MSG_PEEK);
    if (got <= 0) return -1;
    text[got] = 0;
    return strncmp(text, "HTTP/1.1 ", 9) || !strstr(text, "\r\n\r\n") ? 0 : atoi(text + 9);
}

static int memory_status(const struct test_client *client) {
    char head[HEAD];
    return memory_peek(client, head);
}

/* Another client requests something small. The memory promised to a crowd's request before it is
 * refused may be missing for a moment, so a refusal is retried some times; so is an answer that was
 * started, on a slow machine, and broke off for lack of memory. */
static void memory_other_is_served(const struct test_server *server) {
    OWN(test_reply, clear) reply = {0};
    for (int tries = 0;; tries++) {
        struct test_client other;
        if (!memory_send(&other, server, 99, "POST", "/v1/trajectories",
                         "Accept: application/json\r\n", ASK_EXAMPLE))
            return;
        test_client_receive(&other, &reply, 0, TEST_PATIENCE);
        test_client_close(&other);
        if ((reply.status && reply.status != 503) || tries == 5) break;
        test_reply_clear(&reply);
        test_sleep(0.02);
    }
    CHECK_INT(reply.status, 200);
}

/* waits until all have a head, checking memory and another client; returns how many got 200 */
static int memory_crowd(const struct test_server *server, const struct test_client client[],
                        int count) {
    double most = 0, until = test_clock() + TEST_PATIENCE;
    int answered = 0, good = 0;
    while (answered < count && test_clock() < until) {
        memory_other_is_served(server);
        answered = good = 0;
        for (int i = 0; i < count; i++) {
            char head[HEAD];
            int status = memory_peek(&client[i], head);
            answered += status != 0;
            good += status == 200;
            if (status && status != 200)
                CHECK_SAYING((status == 503 || status == 429) && strstr(head, "\r\nRetry-After: "),
                             "answer %d is %d: %s", i, status, head);
        }
        double now = memory_resident(server);
        if (now > most) most = now;
    }
    CHECK_INT(answered, count);
    for (int i = 0; i < 20; i++) {
        test_sleep(0.01);
        double now = memory_resident(server);
        if (now > most) most = now;
    }
    CHECK_SAYING(most <= resident_most, "%.0f bytes are resident of at most %.0f", most,
                 resident_most);
    CHECK(ask_metric(server, "pendulumd_held_bytes") <= 64 << 20);
    return good;
}

static void memory_close(struct test_client client[], int count) {
    for (int i = 0; i < count; i++) test_client_close(&client[i]);
}

/* only the querying connection holds memory */
static void memory_await_base(const struct test_server *server) {
    ask_await(server, "pendulumd_held_bytes", 0, 40000);
    CHECK_INT((int)ask_metric(server, "pendulumd_computations"), 0);
}

static const char *const memory_options[] = {
    "--max-held-bytes", HELD, "--cache-bytes", "0", "--workers", "2", NULL};

TEST(answers_that_nobody_reads_leave_the_process_its_memory) {
    struct test_server *server = memory_serve(memory_options);
    struct test_client client[CROWD];
    REQUIRE(server != NULL);
    for (int i = 0; i < CROWD; i++)
        REQUIRE(memory_send(&client[i], server, 2 + i, "POST", "/v1/trajectories", NPZ,
                            memory_long(500000 + i)));
    int good = memory_crowd(server, client, CROWD);
    CHECK_SAYING(good >= 2 && good <= 4, "%d answers of 16 MB have room in 64", good);
    /* the sockets' buffers may have 10 MB of each */
    ask_await(server, "pendulumd_held_kind_bytes{kind=\"computations\"}", good * 6e6, 1e9);
    memory_close(client, CROWD);
    memory_await_base(server);
    /* one client alone: its share is half, if that is little */
    for (int i = 0; i < CROWD; i++)
        REQUIRE(memory_send(&client[i], server, 2, "POST", "/v1/trajectories", NPZ,
                            memory_long(250000 + i)));
    good = memory_crowd(server, client, CROWD);
    CHECK_SAYING(good >= 1 && good <= 4, "%d answers of 8 MB have room in 32", good);
    CHECK(ask_metric(server, "pendulumd_refused_total{limit=\"max-client-held-bytes\"}") >=
          CROWD - 4);
    memory_close(client, CROWD);
    memory_await_base(server);
    CHECK_SAYING(memory_resident(server) < 64 << 20, "%.0f bytes stay resident",
                 memory_resident(server));
    memory_stop(&server);
}

TEST(an_answer_that_never_has_room_is_told_the_limit) {
    struct test_server *server = memory_serve(memory_options);
    struct test_client client;
    struct test_reply reply;
    REQUIRE(server != NULL);
    REQUIRE(memory_send(&client, server, 2, "POST", "/v1/trajectories", NPZ, memory_long(2000000)));
    test_client_receive(&client, &reply, 0, TEST_PATIENCE);
    ask_problem(&reply, 422, NULL);
    CHECK(strstr(reply.body, "max-client-held-bytes") != NULL);
    test_reply_clear(&reply);
    test_client_close(&client);
    /* a stream has room whatever its length */
    REQUIRE(memory_send(&client, server, 2, "POST", "/v1/trajectories",
                        "Accept: application/octet-stream\r\n", memory_long(2000000)));
    while (!memory_status(&client)) test_sleep(0.01);
    CHECK_INT(memory_status(&client), 200);
    test_client_close(&client);
    memory_await_base(server);
    memory_stop(&server);
}

/* a chain without two equal arms */
static const char *memory_chain(int n, double first) {
    static char body[BODY];
    char *at = body + sprintf(body, "{\"pendulum\":{\"length\":[%g", first);
    for (int i = 1; i < n; i++) at += sprintf(at, ",%g", 1 + 0.001 * i);
    at += sprintf(at, "],\"mass\":[1");
    for (int i = 1; i < n; i++) at += sprintf(at, ",1");
    at += sprintf(at, "],\"parent\":[0");
    for (int i = 1; i < n; i++) at += sprintf(at, ",%d", i);
    strcpy(at, "]}}");
    return body;
}

TEST(modes_that_nobody_reads_leave_the_process_its_memory) {
    struct test_server *server = memory_serve(memory_options);
    struct test_client client[CROWD];
    REQUIRE(server != NULL);
    for (int i = 0; i < CROWD; i++)
        REQUIRE(memory_send(&client[i], server, 2 + i, "POST", "/v1/modes", NPZ,
                            memory_chain(700, 1 + i)));
    int good = memory_crowd(server, client, CROWD);
    CHECK_SAYING(good >= 1, "%d modes of 700 arms have room", good);
    memory_close(client, CROWD);
    memory_await_base(server);
    memory_stop(&server);
}

TEST(results_that_nobody_reads_leave_the_process_its_memory) {
    static char url[300];
    const char *const options[] = {
        "--max-held-bytes", HELD, "--cache-bytes", "0", "--store", url, NULL};
    struct test_client client[CROWD];
    OWN(place, end) place;
    char path[64], id[ID + 1], word[WORDS];
    REQUIRE(place_begin(&place, 0));
    snprintf(url, sizeof url, "%s", place.url);
    struct test_server *server = memory_serve(options);
    REQUIRE(server != NULL);
    CHECK_INT(submit(server, "/v1/trajectories", ASYNC, memory_long(500000), id), 202);
    job_wait(server, id, word);
    CHECK_TEXT(word, "successful");
    snprintf(path, sizeof path, "/v1/jobs/%s/results", id);
    for (int i = 0; i < CROWD; i++)
        REQUIRE(memory_send(&client[i], server, 2 + i, "GET", path, NPZ, ""));
    int good = memory_crowd(server, client, CROWD);
    CHECK_SAYING(good >= 2 && good <= 4, "%d results of 16 MB have room in 64", good);
    memory_close(client, CROWD);
    memory_await_base(server);
    memory_stop(&server);
}

/* a request as a job is refused, with the name of the limit; then one that fits is computed */
static void memory_refuse_job(const char *const options[], const char *limit, const char *path,
                              const char *large, const char *small) {
    struct test_reply reply;
    char id[ID + 1], word[WORDS];
    struct test_server *server = memory_serve(options);
    REQUIRE(server != NULL);
    CHECK_INT(test_request(server, &reply, "POST", path, ASYNC, large), 422);
    ask_problem(&reply, 422, NULL);
    CHECK_SAYING(strstr(reply.body, limit) != NULL, "%s", reply.body);
    test_reply_clear(&reply);
    CHECK_INT((int)ask_metric(server, "pendulumd_jobs{state=\"accepted\"}"), 0);
    CHECK_INT(submit(server, path, ASYNC, small, id), 202);
    job_wait(server, id, word);
    CHECK_TEXT(word, "successful");
    memory_stop(&server);
}

TEST(a_job_that_could_never_have_room_is_refused_when_it_is_submitted) {
    static char url[300], large[BODY];
    const char *const held[] = {"--max-held-bytes", HELD, "--store", url, NULL};
    const char *const answer[] = {"--max-answer-bytes", "1M", "--store", url, NULL};
    OWN(place, end) place;
    REQUIRE(place_begin(&place, 0));
    snprintf(url, sizeof url, "%s", place.url);
    snprintf(large, sizeof large, "%s", memory_chain(4000, 1));
    memory_refuse_job(held, "max-held-bytes", "/v1/modes", large, memory_chain(100, 1));
    snprintf(large, sizeof large, "%s", memory_long(50000));
    memory_refuse_job(answer, "max-answer-bytes", "/v1/trajectories", large, memory_long(20000));
}

TEST(bodies_that_drip_leave_other_clients_their_memory) {
    enum { SLOW = 24, SENT = 3 << 20 };
    struct test_server *server = memory_serve(memory_options);
    struct test_client client[SLOW];
    REQUIRE(server != NULL);
    OWN_MEMORY char *piece = malloc(SENT);
    REQUIRE(piece != NULL);
    memset(piece, ' ', SENT);
    int refused = 0;
    for (int i = 0; i < SLOW; i++) {
        REQUIRE(memory_open(&client[i], server, 2));
        test_client_say(&client[i],
                        "POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n"
                        "Content-Length: 8388608\r\n\r\n");
        test_client_send(&client[i], piece, SENT);
    }
    /* on a loaded machine the last refusals come late */
    for (double until = test_clock() + TEST_PATIENCE; refused <= SLOW / 2 && test_clock() < until;
         test_sleep(0.01)) {
        refused = 0;
        for (int i = 0; i < SLOW; i++) {
            char head[HEAD];
            memory_other_is_served(server);
            if (memory_peek(&client[i], head) != 429) continue;
            refused++;
            CHECK_SAYING(strstr(head, "\r\nRetry-After: ") && strstr(head, "\r\nCache-Control: "),
                         "%s", head);
        }
    }
    CHECK_SAYING(refused > SLOW / 2, "%d bodies were refused", refused);
    double held = ask_metric(server, "pendulumd_held_kind_bytes{kind=\"bodies\"}");
    CHECK_SAYING(held > SENT && held <= 16 << 20, "%.0f bytes of bodies are held", held);
    CHECK(memory_resident(server) <= resident_most);
    memory_close(client, SLOW);
    memory_await_base(server);
    memory_stop(&server);
}

TEST(idle_connections_of_one_client_leave_room_for_others) {
    enum { IDLE = 80 };
    static const char *const options[] = {"--max-connections", "64", NULL};
    static const char *const behind[] = {"--max-connections", "64", "--trusted-proxy", "127.0.0.2",
                                         NULL};
    struct test_client client[IDLE];
    OWN(test_server, stop) *server = test_server_start(options);
    REQUIRE(server != NULL);
    for (int i = 0; i < IDLE; i++) REQUIRE(memory_open(&client[i], server, 2));
    for (int i = 0; i < 20; i++) memory_other_is_served(server);
    /* a quarter is its share, and the next one is refused */
    struct test_reply reply;
    test_client_say(&client[15], "GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n");
    test_client_receive(&client[15], &reply, 0, TEST_PATIENCE);
    CHECK_INT(reply.status, 200);
    test_reply_clear(&reply);
    memory_close(client, IDLE);
    ask_await(server, "pendulumd_connections", 1, 1);
    for (int i = 0; i < 17; i++) REQUIRE(memory_open(&client[i], server, 2));
    test_client_say(&client[16], "GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n");
    test_client_receive(&client[16], &reply, 0, TEST_PATIENCE);
    ask_problem(&reply, 429, NULL);
    CHECK(strstr(reply.body, "max-client-connections") && test_reply_header(&reply, "Retry-After"));
    test_reply_clear(&reply);
    memory_close(client, 17);
    test_server_stop(&server);
    /* a proxy's connections are those of its clients */
    server = test_server_start(behind);
    REQUIRE(server != NULL);
    for (int i = 0; i < 40; i++) REQUIRE(memory_open(&client[i], server, 2));
    for (int i = 0; i < 40; i++) {
        test_client_say(&client[i], "GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n");
        test_client_receive(&client[i], &reply, 0, TEST_PATIENCE);
        CHECK_INT(reply.status, 200);
        test_reply_clear(&reply);
    }
    memory_close(client, 40);
}

/* four addresses have their share each, which fill the table, and a few more that are refused */
TEST(silent_connections_leave_room_for_who_asks_and_keep_that_of_who_has) {
    enum { ADDRESSES = 4, EACH = 20, ALL = ADDRESSES * EACH };
    static const char *const options[] = {"--max-connections", "64", NULL};
    OWN(test_server, stop) *server = test_server_start(options);
    struct test_client client[ALL];
    struct test_reply reply;
    REQUIRE(server != NULL);
    for (int i = 0; i < ALL; i++) {
        REQUIRE(memory_open(&client[i], server, 2 + i / EACH));
        if (i) continue;
        test_client_say(&client[i], "GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n");
        test_client_receive(&client[i], &reply, 0, TEST_PATIENCE);
        CHECK_INT(reply.status, 200);
        test_reply_clear(&reply);
    }
    for (int i = 0; i < 2 * ALL; i++) memory_other_is_served(server);
    test_client_say(&client[0], "GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n");
    test_client_receive(&client[0], &reply, 0, TEST_PATIENCE);
    CHECK_INT(reply.status, 200);
    test_reply_clear(&reply);
    memory_close(client, ALL);
}

/* a stream of a job's events, requested by a proxy for an address of its client's network */
static int memory_listen(struct test_client *client, const struct test_server *server,
                         const char *id, int last) {
    char path[80], headers[120];
    snprintf(path, sizeof path, "/v1/jobs/%s/events", id);
    snprintf(headers, sizeof headers, "X-Forwarded-For: 2001:db8:0:%x::%x\r\n", last / 16,
             last % 16);
    if (!memory_send(client, server, 2, "GET", path, headers, "")) return 0;
    double until = test_clock() + TEST_PATIENCE;
    while (!memory_status(client) && test_clock() < until) test_sleep(0.005);
    return memory_status(client);
}

TEST(streams_of_events_are_counted_by_network) {
    static char url[300];
    const char *const options[] = {"--trusted-proxy",
                                   "127.0.0.2",
                                   "--max-event-streams",
                                   "8",
                                   "--role",
                                   "api",
                                   "--store",
                                   url,
                                   NULL};
    struct test_client client[4];
    OWN(place, end) place;
    char id[ID + 1];
    REQUIRE(place_begin(&place, 0));
    snprintf(url, sizeof url, "%s", place.url);
    OWN(test_server, stop) *server = test_server_start(options);
    REQUIRE(server != NULL);
    CHECK_INT(submit(server, "/v1/trajectories", ASYNC, memory_long(500000), id), 202);
    CHECK_INT(memory_listen(&client[0], server, id, 1), 200);
    CHECK_INT(memory_listen(&client[1], server, id, 2), 200);
    CHECK_INT(memory_listen(&client[2], server, id, 3), 429);
    CHECK_INT(memory_listen(&client[3], server, id, 0x11), 200);
    memory_close(client, 4);
    ask_await(server, "pendulumd_event_streams", 0, 0);
    memory_await_base(server);
}

TEST(nothing_is_held_for_who_went_away_whenever_that_was) {
    struct test_server *server = memory_serve(memory_options);
    struct test_client client;
    REQUIRE(server != NULL);
    const char *body = memory_long(400000);
    char head[256], whole[600];
    snprintf(head, sizeof head,
             "POST /v1/trajectories HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n" NPZ
             "Content-Length: %zu\r\n\r\n",
             strlen(body));
    snprintf(whole, sizeof whole, "%s%s", head, body);
    size_t bytes = strlen(whole);
    /* in the head, in the body, at its end, during the computation, during the answer */
    for (size_t cut = 20; cut <= bytes;
         cut += cut + 40 < bytes || cut == bytes ? 40 : bytes - cut) {
        REQUIRE(memory_open(&client, server, 2));
        test_client_send(&client, whole, cut);
        test_client_close(&client);
    }
    for (int wait = 0; wait < 12; wait++) {
        REQUIRE(memory_open(&client, server, 2));
        test_client_send(&client, whole, bytes);
        test_sleep(0.01 * wait);
        test_client_close(&client);
    }
    for (int i = 0; i < 3; i++) {
        char some[100000];
        const char *accept[] = {"Accept: text/csv\r\nAccept-Encoding: gzip\r\n",
                                "Accept: text/csv\r\nAccept-Encoding: zstd\r\n",
                                "Accept: application/json\r\n"};
        REQUIRE(memory_send(&client, server, 2, "POST", "/v1/trajectories", accept[i], body));
        CHECK(recv(client.fd, some, sizeof some, 0) > 0);
        test_client_close(&client);
    }
    memory_await_base(server);
    memory_stop(&server);
}
