/* Malformed messages on the wire: every stream of harness/streams.h, and well-framed requests with
 * invalid contents. Each is answered as expected and the connection closed, the server works
 * afterwards, and a request hidden after the error is never run. */
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#include "tests/harness/streams.h"
#include "tests/wire/ask.h"

/* what a smuggler would have run: its target would be in the log */
#define HIDDEN "GET /hidden HTTP/1.1\r\nHost: x\r\n\r\n"

/* Well framed, so that the strict reader accepts it; refused when its head is read. */
static const struct {
    const char *what, *text;
    int status;
} unsaid[] = {
    {"a target without a slash", "GET healthz HTTP/1.1\r\n" HOST "\r\n", 400},
    {"an authority for a target", "CONNECT a:80 HTTP/1.1\r\n" HOST "\r\n", 400},
    {"an authority for a GET", "GET a:80 HTTP/1.1\r\n" HOST "\r\n", 400},
    {"an absolute target without host", "GET http:///healthz HTTP/1.1\r\n" HOST "\r\n", 400},
    {"an absolute target with a user", "GET http://u@a/healthz HTTP/1.1\r\n" HOST "\r\n", 400},
    {"an absolute target with a user and a password",
     "GET http://u:p@a/healthz HTTP/1.1\r\n" HOST "\r\n", 400},
    {"an absolute target of another scheme", "GET ftp://a/healthz HTTP/1.1\r\n" HOST "\r\n", 400},
    {"an absolute target of a file", "GET file:///etc/passwd HTTP/1.1\r\n" HOST "\r\n", 400},
    {"a scheme without slashes", "GET http:healthz HTTP/1.1\r\n" HOST "\r\n", 400},
    {"a target with a fragment", "GET /healthz#a HTTP/1.1\r\n" HOST "\r\n", 400},
    {"a target with a backslash", "GET \\healthz HTTP/1.1\r\n" HOST "\r\n", 400},
    {"a path with a backslash", "GET /a\\..\\healthz HTTP/1.1\r\n" HOST "\r\n", 400},
    {"a target in quotes", "GET \"/healthz\" HTTP/1.1\r\n" HOST "\r\n", 400},
    {"a target in angles", "GET </healthz> HTTP/1.1\r\n" HOST "\r\n", 400},
    {"a percent alone", "GET /healthz% HTTP/1.1\r\n" HOST "\r\n", 400},
    {"a percent and one digit", "GET /healthz%2 HTTP/1.1\r\n" HOST "\r\n", 400},
    {"a percent and letters", "GET /%zz HTTP/1.1\r\n" HOST "\r\n", 400},
    {"an encoded NUL", "GET /healthz%00 HTTP/1.1\r\n" HOST "\r\n", 400},
    {"an encoded line end", "GET /healthz%0d%0aX:%20y HTTP/1.1\r\n" HOST "\r\n", 400},
    {"an encoded DEL", "GET /healthz%7f HTTP/1.1\r\n" HOST "\r\n", 400},
    {"two types",
     "POST /v1/trees HTTP/1.1\r\n" HOST
     "Content-Type: application/json\r\nContent-Type: text/plain\r\n\r\n",
     400},
};

enum { UNSAID = sizeof unsaid / sizeof *unsaid };

/* sends a stream with its POSTs to a route that reads them to their end, whatever they contain */
static void say_stream(struct test_client *client, const char *text, size_t bytes) {
    static const char nowhere[] = "POST / ", somewhere[] = "POST /v1/trees ";
    const char *end = text + bytes;
    for (const char *at; (at = memmem(text, (size_t)(end - text), nowhere, sizeof nowhere - 1));) {
        test_client_send(client, text, (size_t)(at - text));
        test_client_say(client, somewhere);
        text = at + sizeof nowhere - 1;
    }
    test_client_send(client, text, (size_t)(end - text));
}

/* one stream followed by a hidden request, all at once or in pieces; returns the number of answers,
 * the last one's status in `status` */
static int say_all(struct test_server *server, const char *what, const char *text, size_t bytes,
                   int at_once, int good, int *status) {
    OWN(test_client, close) client;
    struct test_reply reply;
    int answers = 0, on = 1, off = 0;
    *status = 0;
    if (!test_client_open(&client, test_server_port(server))) return -1;
    setsockopt(client.fd, IPPROTO_TCP, at_once ? TCP_CORK : TCP_NODELAY, &on, sizeof on);
    say_stream(&client, text, bytes);
    test_client_say(&client, HIDDEN);
    setsockopt(client.fd, IPPROTO_TCP, TCP_CORK, &off, sizeof off);
    while (answers <= good &&
           (*status = test_client_receive(&client, &reply, 0, TEST_PATIENCE)) != 0) {
        answers++;
        if (answers > good) {
            ask_problem(&reply, *status, NULL);
            CHECK_SAYING(!reply.keep_alive, "%s: the refusal does not say that the connection ends",
                         what);
        }
        test_reply_clear(&reply);
    }
    if (!*status) test_reply_clear(&reply);
    CHECK_SAYING(test_client_ended(&client, TEST_PATIENCE),
                 "%s: the connection goes on, or there is more than one answer", what);
    return answers;
}

static int healthy(struct test_server *server) {
    OWN(test_reply, clear) reply;
    int status = test_request(server, &reply, "GET", "/healthz", "", NULL);
    return status == 200;
}

static int count(const char *text, const char *part) {
    int found = 0;
    for (const char *at = text; (at = strstr(at, part)); at += strlen(part)) found++;
    return found;
}

TEST(malformed_messages_are_refused_and_the_connection_closed) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    int malformed = 0, lines = 0, refused = 0, status;
    REQUIRE(server != NULL);
    for (int turn = 0; turn < 2 * (STREAMS + UNSAID); turn++) {
        int i = turn / 2, at_once = turn % 2;
        int framing = i < STREAMS;
        const char *what = framing ? streams[i].what : unsaid[i - STREAMS].what;
        const char *text = framing ? streams[i].stream : unsaid[i - STREAMS].text;
        size_t bytes = framing && streams[i].bytes ? streams[i].bytes : strlen(text);
        int wanted = framing ? streams[i].status : unsaid[i - STREAMS].status,
            good = framing ? streams[i].complete : 0;
        if (!wanted) continue;
        int answers = say_all(server, what, text, bytes, at_once, good, &status);
        CHECK_SAYING(answers == good + 1, "%s: %d answers, expected %d", what, answers, good + 1);
        CHECK_SAYING(status == wanted, "%s: status %d, expected %d", what, status, wanted);
        CHECK_SAYING(healthy(server), "%s: not healthy afterwards", what);
        malformed++;
        refused += framing;
        lines += good + 2;
    }
    CHECK_SAYING(malformed >= 2 * 100, "only %d messages were tried", malformed / 2);
    test_server_signal(server, SIGTERM);
    CHECK_INT(test_server_wait(server), 0);
    /* every answer has its line in the log, and no line is of a request that must not run */
    const char *log = test_server_log(server);
    CHECK_INT(count(log, "hidden"), 0);
    CHECK_INT(count(log, "{\"time\":"), lines);
    CHECK_INT(count(log, "\"outcome\":\"refused\""), refused);
    CHECK_INT(count(log, "\"target\":\"/healthz\",\"status\":200"), malformed);
}

TEST(well_formed_streams_are_answered_request_by_request) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    int tried = 0;
    REQUIRE(server != NULL);
    for (int i = 0; i < STREAMS; i++) {
        struct test_client client;
        struct test_reply reply;
        int answers = 0;
        if (streams[i].status || !streams[i].complete) continue;
        REQUIRE(test_client_open(&client, test_server_port(server)));
        say_stream(&client, streams[i].stream, strlen(streams[i].stream));
        /* the last one ends the connection, so that no answer can be missed */
        test_client_say(&client, "GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
        while (test_client_receive(&client, &reply, 0, TEST_PATIENCE)) {
            answers++;
            test_reply_clear(&reply);
        }
        test_reply_clear(&reply);
        int wanted = streams[i].complete + !strstr(streams[i].stream, "HTTP/1.0");
        CHECK_SAYING(answers == wanted, "%s: %d answers, expected %d", streams[i].what, answers,
                     wanted);
        test_client_close(&client);
        tried++;
    }
    CHECK(tried >= 10);
}
