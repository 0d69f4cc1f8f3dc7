#include <arpa/inet.h>
#include <math.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/wire/ask.h"

TEST(help_and_version_are_told_on_standard_output) {
    static const char *const help[] = {"--help", NULL}, *const version[] = {"--version", NULL};
    char text[16384];
    CHECK_INT(test_server_run(help, text, sizeof text), 0);
    CHECK(strstr(text, "--listen") && strstr(text, "--workers") && strstr(text, "--max-arms"));
    CHECK_INT(test_server_run(version, text, sizeof text), 0);
    CHECK(strstr(text, "pendulumd") && strstr(text, "(engine "));
    static const char *const h[] = {"-h", NULL}, *const v[] = {"-V", NULL};
    CHECK_INT(test_server_run(h, text, sizeof text), 0);
    CHECK(strstr(text, "--listen") != NULL);
    CHECK_INT(test_server_run(v, text, sizeof text), 0);
    CHECK(strstr(text, "(engine ") != NULL);
}

/* both texts as in an answer's stats */
static void stats_name(struct test_server *server, const char *path, const char *body,
                       const char *version, const char *engine) {
    OWN(test_reply, clear) reply;
    CHECK_INT(ask(server, &reply, path, body), 200);
    cJSON *answer = ask_json(&reply);
    const cJSON *stats = cJSON_GetObjectItemCaseSensitive(answer, "stats");
    CHECK_TEXT(cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(stats, "version")), version);
    CHECK_TEXT(cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(stats, "engine")), engine);
    cJSON_Delete(answer);
}

TEST(program_answers_and_metrics_name_one_version_and_engine) {
    static const char *const option[] = {"--version", NULL};
    static const char *const asked[][2] = {
        {"/v1/trajectories", "{\"pendulum\":" ASK_DOUBLE ",\"times\":{\"stop\":1,\"count\":3}}"},
        {"/v1/ensembles", "{\"pendulum\":" ASK_DOUBLE ",\"states\":[{},{}],\"duration\":1}"},
        {"/v1/lyapunov", "{\"pendulum\":" ASK_DOUBLE ",\"duration\":1}"},
        {"/v1/sections",
         "{\"pendulum\":" ASK_DOUBLE ",\"duration\":5,\"section\":{\"arm\":1,\"theta\":0}}"}};
    char text[512], want[256], version[64], engine[64];
    struct test_reply reply;
    CHECK_INT(test_server_run(option, text, sizeof text), 0);
    REQUIRE(sscanf(text, "pendulumd %63[0-9a-z.+~] (engine %63[0-9a-f])", version, engine) == 2);
    CHECK_INT((long long)strlen(engine), 16);
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server);
    CHECK_INT(test_request(server, &reply, "GET", "/version", "", NULL), 200);
    snprintf(want, sizeof want, "{\"version\":\"%s\",\"engine\":\"%s\"}", version, engine);
    CHECK_TEXT(reply.body, want);
    test_reply_clear(&reply);
    CHECK_INT(test_request(server, &reply, "GET", "/metrics", "", NULL), 200);
    snprintf(want, sizeof want, "\npendulumd_build_info{version=\"%s\",engine=\"%s\"} 1\n", version,
             engine);
    CHECK_SAYING(strstr(reply.body, want) != NULL, "the metrics have no line %s", want);
    test_reply_clear(&reply);
    /* answers keep their bytes from one build of a version to the next */
    version[strcspn(version, "+")] = 0;
    for (size_t i = 0; i < sizeof asked / sizeof *asked; i++)
        stats_name(server, asked[i][0], asked[i][1], version, engine);
}

/* of 1024 files, as many systems allow, an eighth is for sockets that linger and 128 for the
 * rest */
TEST(few_open_files_leave_most_of_them_to_connections) {
    if (getenv("TEST_UNDER")) return test_skip("the daemon runs under another program");
    setenv("TEST_UNDER", "prlimit --nofile=1024:1024", 1);
    OWN(test_server, drop) *server = test_server_start(NULL);
    unsetenv("TEST_UNDER");
    REQUIRE(server);
    const char *log = test_server_log(server);
    CHECK_SAYING(strstr(log, "max-connections is 768, not 4096") != NULL, "%s", log);
}

/* the process that a process has started */
static pid_t child_of(int pid) {
    char path[64];
    int child = 0;
    snprintf(path, sizeof path, "/proc/%d/task/%d/children", pid, pid);
    FILE *file = fopen(path, "r");
    if (file && fscanf(file, "%d", &child) != 1) child = 0;
    if (file) fclose(file);
    return child;
}

/* on a terminal people read: requests are logged there only on request */
TEST(a_terminal_shows_messages_and_no_requests_unless_asked) {
    static const char *const asked[] = {"--access-log", "on", NULL};
    if (getenv("TEST_UNDER")) return test_skip("the daemon runs under another program");
    for (int wanted = 0; wanted < 2; wanted++) {
        /* a program that gives another one a terminal and passes on its output; words end with
         * blanks */
        setenv("TEST_UNDER", "/usr/bin/python3 -c import\tpty,sys;pty.spawn(sys.argv[1:])", 1);
        OWN(test_server, drop) *server = test_server_start(wanted ? asked : NULL);
        unsetenv("TEST_UNDER");
        REQUIRE(server);
        struct test_reply reply;
        struct test_client client;
        pid_t child = child_of(test_server_pid(server));
        REQUIRE(child > 0 && test_client_open(&client, test_server_port(server)));
        test_client_say(&client, "GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
        CHECK(test_client_receive(&client, &reply, 0, TEST_PATIENCE));
        CHECK_INT(reply.status, 200);
        test_reply_clear(&reply);
        test_client_close(&client);
        /* its end writes all waiting lines */
        kill(child, SIGTERM);
        test_server_wait(server);
        const char *log = test_server_log(server);
        CHECK_SAYING(strstr(log, "Ctrl-C stops it") != NULL, "%s", log);
        CHECK_SAYING(!strstr(log, "\"/healthz\"") == !wanted, "%s", log);
    }
}

TEST(a_bad_option_is_a_clear_message_and_status_2) {
    static const struct {
        const char *option[3], *word;
    } bad[] = {
        {{"--lisen", "127.0.0.1:0", NULL}, "lisen"},
        {{"--listen", "nowhere", NULL}, "listen"},
        {{"--listen", "127.0.0.1:99999", NULL}, "listen"},
        {{"--workers", "minus", NULL}, "workers"},
        {{"--workers", "-1", NULL}, "workers"},
        {{"--max-arms", "0", NULL}, "max-arms"},
        {{"--listen", NULL, NULL}, "listen"},
        {{"stray", NULL, NULL}, "stray"},
    };
    char text[4096];
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        int status = test_server_run(bad[i].option, text, sizeof text);
        CHECK_SAYING(status == 2, "%s %s ended with %d", bad[i].option[0], bad[i].option[1],
                     status);
        CHECK_SAYING(strstr(text, bad[i].word) != NULL, "the message is: %s", text);
    }
}

TEST(a_port_in_use_is_a_clear_message) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    char address[40], text[4096];
    REQUIRE(server != NULL);
    snprintf(address, sizeof address, "127.0.0.1:%d", test_server_port(server));
    const char *const options[] = {"--listen", address, NULL};
    CHECK(test_server_run(options, text, sizeof text) > 0);
    CHECK_SAYING(strstr(text, address) && strstr(text, "in use"), "the message is: %s", text);
}

TEST(it_listens_on_ipv6) {
    static const char *const options[] = {"--listen", "[::1]:0", NULL};
    int probe = socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0);
    struct sockaddr_in6 address = {.sin6_family = AF_INET6, .sin6_addr = in6addr_loopback};
    if (probe < 0 || bind(probe, (struct sockaddr *)&address, sizeof address) != 0) {
        test_skip("this machine has no IPv6 loopback");
        if (probe >= 0) close(probe);
        return;
    }
    close(probe);
    OWN(test_server, stop) *server = test_server_start(options);
    OWN(test_client, close) client = {.fd = socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    OWN(test_reply, clear) reply = {0};
    REQUIRE(server != NULL);
    CHECK(strstr(test_server_log(server), "listening on http://[::1]:") != NULL);
    address.sin6_port = htons((uint16_t)test_server_port(server));
    CHECK(connect(client.fd, (struct sockaddr *)&address, sizeof address) == 0);
    test_client_say(&client, "GET /healthz HTTP/1.1\r\nHost: [::1]\r\n\r\n");
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
}

TEST(every_request_leaves_one_json_line_in_the_log) {
    struct test_reply reply;
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    ask(server, &reply, "/v1/trees", ASK_LITTLE);
    test_reply_clear(&reply);
    test_request(server, &reply, "GET", "/no%22where?q=%5c", "", NULL);
    test_reply_clear(&reply);
    test_server_signal(server, SIGTERM);
    CHECK_INT(test_server_wait(server), 0);
    int lines = 0;
    const char *log = test_server_log(server);
    for (const char *line = log; *line; line += strcspn(line, "\n"), line += *line == '\n') {
        if (*line != '{' || !strncmp(line, "{}", 2)) continue;
        cJSON *entry = cJSON_ParseWithLength(line, strcspn(line, "\n"));
        CHECK_SAYING(entry != NULL, "not JSON: %.200s", line);
        const cJSON *status = cJSON_GetObjectItemCaseSensitive(entry, "status");
        if (status) {
            CHECK_INT(status->valueint, lines ? 404 : 200);
            CHECK_TEXT(cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(entry, "method")),
                       lines ? "GET" : "POST");
            lines++;
        }
        cJSON_Delete(entry);
    }
    CHECK_INT(lines, 2);
}

/* how much of the long computation takes about a second here */
static double span_of_a_second(struct test_server *server) {
    OWN(test_reply, clear) reply;
    double begin = test_clock();
    ask(server, &reply, "/v1/trajectories", ask_long(1));
    return fmin(100, 1 / (test_clock() - begin));
}

TEST(a_drain_lets_the_running_request_finish) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    struct test_client client;
    struct test_reply reply;
    char head[256];
    REQUIRE(server != NULL);
    REQUIRE(test_client_open(&client, test_server_port(server)));
    const char *body = ask_long(span_of_a_second(server));
    snprintf(head, sizeof head,
             "POST /v1/trajectories HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n"
             "Content-Length: %zu\r\n\r\n",
             strlen(body));
    test_client_say(&client, head);
    test_client_say(&client, body);
    for (double end = test_clock() + TEST_PATIENCE;
         ask_metric(server, "pendulumd_computations") < 1 && test_clock() < end;)
        test_sleep(0.02);
    test_server_signal(server, SIGTERM);
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
    cJSON *answer = ask_json(&reply);
    CHECK_INT(cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(answer, "phi")), 5);
    cJSON_Delete(answer);
    test_reply_clear(&reply);
    CHECK(test_client_ended(&client, TEST_PATIENCE));
    test_client_close(&client);
    CHECK_INT(test_server_wait(server), 0);
}

TEST(an_idle_server_goes_at_once_on_sigterm_and_on_sigint) {
    for (int i = 0; i < 2; i++) {
        OWN(test_server, stop) *server = test_server_start(NULL);
        OWN(test_client, close) idle = {.fd = -1};
        REQUIRE(server != NULL);
        REQUIRE(test_client_open(&idle, test_server_port(server)));
        test_server_signal(server, i ? SIGINT : SIGTERM);
        CHECK_INT(test_server_wait(server), 0);
    }
}

TEST(a_worker_may_end_when_nothing_is_left_to_compute) {
    char directory[] = "/tmp/pendulumd-test-XXXXXX", store[64], command[64], path[64], text[1024];
    struct test_reply reply;
    REQUIRE(mkdtemp(directory));
    snprintf(store, sizeof store, "sqlite:%s/store.db", directory);
    snprintf(command, sizeof command, "rm -rf '%s'", directory);
    const char *const api[] = {"--store", store, "--role", "api", NULL};
    const char *const worker[] = {"--store", store, "--role", "worker", "--until-idle-seconds",
                                  "0.3",     NULL};
    struct test_server *asked = test_server_start(api);
    REQUIRE(asked);
    CHECK_INT(test_request(asked, &reply, "POST", "/v1/trajectories", "Prefer: respond-async\r\n",
                           ASK_EXAMPLE),
              202);
    snprintf(path, sizeof path, "%s", test_reply_header(&reply, "Location"));
    test_reply_clear(&reply);
    struct test_server *works = test_server_start(worker);
    CHECK_INT(test_server_wait(works), 0);
    CHECK_SAYING(strstr(test_server_log(works), "nothing to compute"), "it says %s",
                 test_server_log(works));
    test_server_drop(&works);
    CHECK_INT(test_request(asked, &reply, "GET", path, "", NULL), 200);
    CHECK_SAYING(strstr(reply.body, "\"status\":\"successful\""), "the job: %s", reply.body);
    test_reply_clear(&reply);
    test_server_stop(&asked);
    CHECK(!system(command));
    /* only for processes that compute jobs */
    static const char *const idle[] = {"--store", "none", "--until-idle-seconds", "1", NULL};
    CHECK_INT(test_server_run(idle, text, sizeof text), 1);
    CHECK_SAYING(strstr(text, "until-idle-seconds"), "the message is: %s", text);
}
