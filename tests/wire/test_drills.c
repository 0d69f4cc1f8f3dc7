/* Drills with a whole process: ended under load, killed, asked twenty thousand times, and left with
 * streams that nobody reads. */
#include <netinet/in.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/wire/ask.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { SANITIZED = 1 }; /* memory and time are those of the tool */
#else
enum { SANITIZED = 0 };
#endif

/* bytes of resident memory of the process */
static double resident(const struct test_server *server) {
    char path[64], line[256];
    double kilobytes = 0;
    snprintf(path, sizeof path, "/proc/%d/status", test_server_pid(server));
    FILE *file = fopen(path, "r");
    while (file && fgets(line, sizeof line, file)) sscanf(line, "VmRSS: %lf", &kilobytes);
    if (file) fclose(file);
    return 1024 * kilobytes;
}

static size_t message(char *text, size_t cap, const char *path, const char *accept,
                      const char *body) {
    return (size_t)snprintf(
        text, cap,
        "POST %s HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nAccept: %s\r\n"
        "Content-Length: %zu\r\n\r\n%s",
        path, accept, strlen(body), body);
}

/* --- told to end under load --- */

enum { CLIENTS = 24, KINDS = 4, UNTOLD = 64 };

struct drill {
    int port;
    const char *path[KINDS], *accept[KINDS], *body[KINDS];
    /* counted by all clients */
    int number, answered, refused, cut, untold;
    int number_untold[UNTOLD]; /* requests for which the connection ended before the first byte of
                                * an answer */
};

/* a separate connection of the client, or 0 if nobody listens any more */
static int drill_open(struct test_client *client, int port) {
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    struct timeval patience = {.tv_sec = 5};
    *client = (struct test_client){.fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    /* a server that is about to end drops new connections: they do not wait for the system's
     * minutes */
    setsockopt(client->fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    if (!connect(client->fd, (struct sockaddr *)&address, sizeof address)) return 1;
    test_client_close(client);
    return 0;
}

static int count_up(int *counter) { return __atomic_fetch_add(counter, 1, __ATOMIC_RELAXED); }

/* sends a request whose id is its number */
static int drill_say(struct drill *drill, struct test_client *client, int kind, int number) {
    char text[2048];
    snprintf(
        text, sizeof text,
        "POST %s HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nAccept: %s\r\n"
        "X-Request-Id: drill-%06d\r\nContent-Length: %zu\r\n\r\n%s",
        drill->path[kind], drill->accept[kind], number, strlen(drill->body[kind]),
        drill->body[kind]);
    return test_client_say(client, text);
}

/* one after the other, until nobody listens; a connection that announced its end is not used
 * again */
static void *drill_client(void *context) {
    struct drill *drill = context;
    struct test_client client;
    int kind = 0;
    while (drill_open(&client, drill->port)) {
        for (int more = 1; more;) {
            OWN(test_reply, clear) reply = {0};
            int number = count_up(&drill->number);
            if (!drill_say(drill, &client, kind++ % KINDS, number)) break;
            int status = test_client_receive(&client, &reply, 0, TEST_PATIENCE);
            if (status == 200) count_up(&drill->answered);
            if (status == 503) count_up(&drill->refused);
            if (!status && reply.head) count_up(&drill->cut);
            if (!status && !reply.head)
                drill->number_untold[count_up(&drill->untold) % UNTOLD] = number;
            more = status && reply.keep_alive;
        }
        test_client_close(&client);
    }
    return NULL;
}

TEST(told_to_end_under_load_it_answers_everything_that_it_took) {
    static struct drill drill;
    pthread_t thread[CLIENTS];
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    drill = (struct drill){
        .port = test_server_port(server),
        .path = {"/v1/trajectories", "/v1/trees", "/v1/trajectories", "/v1/modes"},
        .accept = {"application/json", "*/*", "text/csv", "application/json"},
        .body = {ASK_EXAMPLE, ASK_LITTLE,
                 "{\"pendulum\":" ASK_DOUBLE ",\"times\":{\"start\":0,\"stop\":10,\"count\":4001}}",
                 "{\"pendulum\":" ASK_FOUR_ARMS "}"},
    };
    for (int i = 0; i < CLIENTS; i++) pthread_create(&thread[i], NULL, drill_client, &drill);
    int before = 0;
    for (double end = test_clock() + TEST_PATIENCE; before < 10 * CLIENTS && test_clock() < end;
         test_sleep(0.01))
        before = __atomic_load_n(&drill.answered, __ATOMIC_RELAXED);
    test_server_signal(server, SIGTERM);
    CHECK_INT(test_server_wait(server), 0);
    for (int i = 0; i < CLIENTS; i++) pthread_join(thread[i], NULL);
    CHECK_SAYING(before >= CLIENTS, "only %d requests were answered before the end", before);
    CHECK_SAYING(!drill.cut, "%d answers were cut (%d answered, %d refused)", drill.cut,
                 drill.answered, drill.refused);
    /* an idle connection may end while a request is being sent; requests that were read are in the
     * log */
    const char *log = test_server_log(server);
    CHECK(drill.untold < UNTOLD);
    for (int i = 0; i < drill.untold && i < UNTOLD; i++) {
        char id[24];
        snprintf(id, sizeof id, "\"drill-%06d\"", drill.number_untold[i]);
        CHECK_SAYING(!strstr(log, id), "request %s was taken and not answered", id);
    }
}

/* --- killed --- */

TEST(killed_under_load_it_starts_again_on_its_port) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    struct test_client client[8];
    struct test_reply reply;
    char address[40], text[2048];
    REQUIRE(server != NULL);
    snprintf(address, sizeof address, "127.0.0.1:%d", test_server_port(server));
    message(text, sizeof text, "/v1/trajectories", "*/*", ASK_EXAMPLE);
    for (int i = 0; i < 8; i++) {
        REQUIRE(test_client_open(&client[i], test_server_port(server)));
        for (int k = 0; k < 20; k++) test_client_say(&client[i], text);
    }
    test_server_signal(server, SIGKILL);
    CHECK_INT(test_server_wait(server), 128 + SIGKILL);
    test_server_drop(&server);
    const char *const options[] = {"--listen", address, NULL};
    REQUIRE((server = test_server_start(options)) != NULL);
    CHECK_INT(ask(server, &reply, "/v1/trajectories", ASK_EXAMPLE), 200);
    test_reply_clear(&reply);
    for (int i = 0; i < 8; i++) test_client_close(&client[i]);
}

/* --- asked often --- */

/* requests of every kind, valid and invalid, on connections that change now and then, or are left
 * in the middle of an answer */
static int ask_often(struct test_server *server, char text[][2048], const int status[], int kinds,
                     int count) {
    OWN(test_client, close) client = {.fd = -1};
    struct test_reply reply;
    int good = 0;
    for (int i = 0; i < count; i++) {
        if (client.fd < 0 && !test_client_open(&client, test_server_port(server))) return 0;
        test_client_say(&client, text[i % kinds]);
        if (i % 97 == 96) {
            test_client_close(&client);
            good++;
            continue;
        }
        good += test_client_receive(&client, &reply, 0, TEST_PATIENCE) == status[i % kinds];
        if (!reply.keep_alive || i % 41 == 40) test_client_close(&client);
        test_reply_clear(&reply);
    }
    return good;
}

TEST(twenty_thousand_mixed_requests_leave_no_memory_behind) {
    enum { COUNT = SANITIZED ? 1000 : 10000, KINDS_ASKED = 10 };
    static char text[KINDS_ASKED][2048];
    static const struct {
        const char *path, *accept, *body;
        int status;
    } kind[KINDS_ASKED] = {
        {"/v1/trees", "*/*", ASK_LITTLE, 200},
        {"/v1/trajectories", "*/*",
         "{\"pendulum\":" ASK_DOUBLE ",\"times\":{\"start\":0,\"stop\":1,\"step\":0.1}}", 200},
        {"/v1/trajectories", "text/csv",
         "{\"pendulum\":" ASK_DOUBLE ",\"times\":{\"start\":0,\"stop\":1,\"step\":0.1}}", 200},
        {"/v1/forces", "*/*", "{\"pendulum\":" ASK_DOUBLE ",\"state\":{\"phi\":[1,2]}}", 200},
        {"/v1/modes", "*/*", ASK_LITTLE, 200},
        {"/nowhere", "*/*", ASK_LITTLE, 404},
        {"/v1/trees", "*/*", "{\"pendulum\":", 400},
        {"/v1/trees", "*/*", "{\"pendulum\":" ASK_DOUBLE ",\"unknown\":1}", 422},
        {"/v1/trajectories", "image/png",
         "{\"pendulum\":" ASK_DOUBLE ",\"times\":{\"start\":0,\"stop\":1,\"step\":0.1}}", 406},
        {"/healthz", "*/*", "", 405},
    };
    static const char *const options[] = {"--access-log", "off", NULL};
    int status[KINDS_ASKED];
    OWN(test_server, stop) *server = test_server_start(options);
    REQUIRE(server != NULL);
    for (int i = 0; i < KINDS_ASKED; i++) {
        message(text[i], sizeof text[i], kind[i].path, kind[i].accept, kind[i].body);
        status[i] = kind[i].status;
    }
    CHECK_INT(ask_often(server, text, status, KINDS_ASKED, COUNT), COUNT);
    double before = resident(server);
    CHECK_INT(ask_often(server, text, status, KINDS_ASKED, COUNT), COUNT);
    double grown = resident(server) - before;
    CHECK(before > 0);
    if (!SANITIZED) CHECK_SAYING(grown < 1e6, "%.0f bytes more after the second half", grown);
}

/* --- streams that nobody reads --- */

TEST(streams_that_nobody_reads_hold_little_and_end_with_their_clients) {
    static const char *const options[] = {"--workers", "2", "--max-samples", "10000000", NULL};
    enum { COUNT = 6 };
    OWN(test_server, stop) *server = test_server_start(options);
    struct test_client lazy[COUNT];
    struct test_reply reply;
    char text[2048];
    REQUIRE(server != NULL);
    CHECK_INT(ask(server, &reply, "/v1/trees", ASK_LITTLE), 200);
    test_reply_clear(&reply);
    double idle = resident(server);
    /* a gigabyte each, on two workers */
    message(text, sizeof text, "/v1/trajectories", "text/csv",
            "{\"pendulum\":" ASK_DOUBLE
            ",\"times\":{\"start\":0,\"stop\":1000,\"count\":10000000}}");
    for (int i = 0; i < COUNT; i++) {
        REQUIRE(test_client_open(&lazy[i], test_server_port(server)));
        test_client_say(&lazy[i], text);
    }
    /* a loaded machine starts them late */
    for (int i = 0; i < COUNT; i++) {
        struct pollfd begun = {.fd = lazy[i].fd, .events = POLLIN};
        CHECK_INT(poll(&begun, 1, (int)(1000 * TEST_PATIENCE)), 1);
    }
    test_sleep(SANITIZED ? 2 : 0.6);
    double held = resident(server) - idle;
    if (!SANITIZED) CHECK_SAYING(held < 64e6, "%.0f MB for %d streams", held / 1e6, COUNT);
    /* they hold no worker either */
    CHECK_INT(ask(server, &reply, "/v1/trajectories", ASK_EXAMPLE), 200);
    test_reply_clear(&reply);
    double left = test_clock();
    for (int i = 0; i < COUNT; i++) test_client_close(&lazy[i]);
    /* each of them has its line once its computation is over */
    const char *log = NULL;
    int over = 0;
    for (double until = left + TEST_PATIENCE; over < COUNT && test_clock() < until;
         test_sleep(0.01)) {
        over = 0;
        log = test_server_log(server);
        for (const char *at = log; (at = strstr(at, "\"bytes_out\":")); at++) {
            const char *line = at;
            while (line > log && line[-1] != '\n') line--;
            over += memmem(line, (size_t)(at - line), "\"outcome\":\"left\"", 16) ||
                    memmem(line, (size_t)(at - line), "\"outcome\":\"cut\"", 15);
        }
    }
    double gone = test_clock() - left;
    CHECK_INT(over, COUNT);
    printf("  %d streams that nobody read held %.1f MB, and were over %.0f ms after their clients "
           "left\n",
           COUNT, held / 1e6, gone * 1e3);
}
