/* Webhooks: a real receiver behind TLS, with signatures that another library checks; receivers that
 * fail, redirect, are slow or never end; addresses that are refused; a server that dies between a
 * job's end and its telling. */
#include <arpa/inet.h>
#include <errno.h>
#include <gnutls/crypto.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/wire/place.h"
#include "tests/wire/safe.h"

enum { SEEN = 64, MESSAGE = 16384, SETTINGS = 1024 };

#define TOKEN "Authorization: Bearer webhook-test-0123456789-abcdefgh\r\n"

/* --- the receiver --- */

/* What came to a path. */
struct seen {
    char path[64], message[MESSAGE];
};

struct receiver {
    struct safe safe;
    gnutls_certificate_credentials_t credentials;
    int fd, port, over;
    pthread_t thread;
    pthread_mutex_t lock;
    int visits; /* that are not over */
    pthread_cond_t left;
    int count;
    struct seen seen[SEEN];
};

struct visit {
    struct receiver *receiver;
    int fd;
};

/* how often a path was asked for; copies the last message to it */
static int receiver_seen(struct receiver *receiver, const char *path, char message[MESSAGE]) {
    int count = 0;
    pthread_mutex_lock(&receiver->lock);
    for (int i = 0; i < receiver->count; i++) {
        if (strcmp(receiver->seen[i].path, path) != 0) continue;
        count++;
        if (message) memcpy(message, receiver->seen[i].message, MESSAGE);
    }
    pthread_mutex_unlock(&receiver->lock);
    return count;
}

static int receiver_note(struct receiver *receiver, const char *message) {
    pthread_mutex_lock(&receiver->lock);
    int at = receiver->count < SEEN ? receiver->count++ : SEEN - 1;
    struct seen *seen = &receiver->seen[at];
    snprintf(seen->message, sizeof seen->message, "%s", message);
    sscanf(message, "POST %63s", seen->path);
    char path[64];
    snprintf(path, sizeof path, "%s", seen->path);
    pthread_mutex_unlock(&receiver->lock);
    return receiver_seen(receiver, path, NULL);
}

/* reads a whole request; returns 0 where none came */
static int visit_read(gnutls_session_t session, char message[MESSAGE]) {
    size_t have = 0;
    for (;;) {
        ssize_t got = gnutls_record_recv(session, message + have, MESSAGE - 1 - have);
        if (got == GNUTLS_E_INTERRUPTED || got == GNUTLS_E_AGAIN) continue;
        if (got <= 0) return 0;
        have += (size_t)got;
        message[have] = 0;
        const char *body = strstr(message, "\r\n\r\n"), *length = strcasestr(message, "length: ");
        if (body && length && have >= (size_t)(body + 4 - message) + (size_t)atoi(length + 8))
            return 1;
    }
}

static void visit_say(gnutls_session_t session, const char *text) {
    gnutls_record_send(session, text, strlen(text));
}

/* answers by the path */
static void visit_answer(const struct receiver *receiver, gnutls_session_t session,
                         const char *message, int times) {
    char text[256];
    if (strstr(message, "POST /redirect ")) {
        snprintf(text, sizeof text,
                 "HTTP/1.1 302 Found\r\nLocation: https://localhost:%d/elsewhere\r\n"
                 "Content-Length: 0\r\n\r\n",
                 receiver->port);
        visit_say(session, text);
    } else if (strstr(message, "POST /gone "))
        visit_say(session, "HTTP/1.1 410 Gone\r\nContent-Length: 0\r\n\r\n");
    else if (strstr(message, "POST /once ") && times == 1)
        visit_say(session, "HTTP/1.1 500 No\r\nContent-Length: 0\r\n\r\n");
    else if (strstr(message, "POST /endless ")) {
        visit_say(session, "HTTP/1.1 200 OK\r\n\r\n");
        memset(text, 'x', sizeof text);
        while (gnutls_record_send(session, text, sizeof text) > 0) continue;
    } else if (strstr(message, "POST /heads ")) {
        visit_say(session, "HTTP/1.1 200 OK\r\n");
        while (gnutls_record_send(session, "X-More: more of it\r\n", 20) > 0) continue;
    } else if (strstr(message, "POST /slow ") || (strstr(message, "POST /dies ") && times == 1)) {
        while (gnutls_record_recv(session, text, sizeof text) > 0) continue;
    } else
        visit_say(session, "HTTP/1.1 204 No Content\r\n\r\n");
}

static void *visit_main(void *context) {
    struct visit *visit = context;
    struct receiver *receiver = visit->receiver;
    char *message = calloc(1, MESSAGE);
    gnutls_session_t session;
    int fd = visit->fd, code;
    free(visit);
    gnutls_init(&session, GNUTLS_SERVER);
    gnutls_set_default_priority(session);
    gnutls_credentials_set(session, GNUTLS_CRD_CERTIFICATE, receiver->credentials);
    gnutls_transport_set_int(session, fd);
    do code = gnutls_handshake(session);
    while (code < 0 && !gnutls_error_is_fatal(code));
    if (code >= 0 && message && visit_read(session, message))
        visit_answer(receiver, session, message, receiver_note(receiver, message));
    gnutls_deinit(session);
    close(fd);
    free(message);
    pthread_mutex_lock(&receiver->lock);
    if (!--receiver->visits) pthread_cond_signal(&receiver->left);
    pthread_mutex_unlock(&receiver->lock);
    return NULL;
}

static void *receiver_main(void *context) {
    struct receiver *receiver = context;
    for (;;) {
        int fd = accept(receiver->fd, NULL, NULL);
        if (fd < 0 && errno == EINTR) continue;
        if (fd < 0) return NULL;
        struct visit *visit = calloc(1, sizeof *visit);
        pthread_t thread;
        if (!visit) return NULL;
        *visit = (struct visit){receiver, fd};
        pthread_mutex_lock(&receiver->lock);
        receiver->visits++;
        pthread_mutex_unlock(&receiver->lock);
        CHECK(!pthread_create(&thread, NULL, visit_main, visit) && !pthread_detach(thread));
    }
}

static struct receiver *receiver_start(void) {
    struct receiver *receiver = calloc(1, sizeof *receiver);
    struct sockaddr_in here = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t bytes = sizeof here;
    char pem[PATH], key[PATH];
    if (!CHECK(receiver != NULL) || !safe_begin(&receiver->safe)) return NULL;
    signal(SIGPIPE, SIG_IGN);
    pthread_mutex_init(&receiver->lock, NULL);
    pthread_cond_init(&receiver->left, NULL);
    safe_path(&receiver->safe, "server.pem", pem);
    safe_path(&receiver->safe, "server.key", key);
    good(gnutls_certificate_allocate_credentials(&receiver->credentials), "credentials");
    good(gnutls_certificate_set_x509_key_file(receiver->credentials, pem, key, GNUTLS_X509_FMT_PEM),
         "certificate");
    receiver->fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    CHECK(!bind(receiver->fd, (struct sockaddr *)&here, sizeof here) && !listen(receiver->fd, 64));
    CHECK(!getsockname(receiver->fd, (struct sockaddr *)&here, &bytes));
    receiver->port = ntohs(here.sin_port);
    CHECK(!pthread_create(&receiver->thread, NULL, receiver_main, receiver));
    return receiver;
}

/* once those that visit have left, which they do with the server that sent them */
static void receiver_stop(struct receiver *receiver) {
    shutdown(receiver->fd, SHUT_RDWR);
    pthread_join(receiver->thread, NULL);
    pthread_mutex_lock(&receiver->lock);
    while (receiver->visits) pthread_cond_wait(&receiver->left, &receiver->lock);
    pthread_mutex_unlock(&receiver->lock);
    close(receiver->fd);
    gnutls_certificate_free_credentials(receiver->credentials);
    safe_end(&receiver->safe);
    pthread_cond_destroy(&receiver->left);
    pthread_mutex_destroy(&receiver->lock);
    free(receiver);
}

/* --- the server --- */

/* the file of options of a server whose webhooks may go to loopback, or to nothing that is private;
 * returns its path */
static const char *settings(struct receiver *receiver, int loopback, char path[PATH]) {
    static char secret[] =
        "a-secret-of-the-operator-0123456789\nthe-one-before-it-0123456789-abcdef\n";
    char text[SETTINGS], file[PATH], ca[PATH];
    gnutls_datum_t data = {(unsigned char *)secret, sizeof secret - 1};
    safe_write(&receiver->safe, "secret", &data);
    safe_path(&receiver->safe, "secret", file);
    safe_path(&receiver->safe, "ca.pem", ca);
    snprintf(text, sizeof text,
             "webhook-secret = %s\nwebhook-authority = %s\nwebhook-networks = %s\n", file, ca,
             loopback ? "127.0.0.0/8, ::1" : "none");
    data = (gnutls_datum_t){(unsigned char *)text, (unsigned)strlen(text)};
    safe_write(&receiver->safe, "settings", &data);
    safe_path(&receiver->safe, "settings", path);
    return path;
}

/* posts a job that tells its end to a path of the receiver; its id, and what it is signed with */
static int post(const struct test_server *server, const char *url, char id[ID + 1],
                char secret[64]) {
    struct test_reply reply;
    char fields[700];
    snprintf(fields, sizeof fields, ASYNC TOKEN "Job-Notify: %s\r\n", url);
    int status = test_request(server, &reply, "POST", "/v1/modes", fields, ASK_LITTLE);
    cJSON *job = status == 202 ? ask_json(&reply) : NULL;
    const char *known = cJSON_GetStringValue(cJSON_GetObjectItem(job, "id"));
    const char *key =
        cJSON_GetStringValue(cJSON_GetObjectItem(cJSON_GetObjectItem(job, "notify"), "secret"));
    snprintf(id, ID + 1, "%s", known ? known : "");
    snprintf(secret, 64, "%s", key ? key : "");
    cJSON_Delete(job);
    test_reply_clear(&reply);
    return status;
}

static int post_to(const struct test_server *server, const struct receiver *receiver,
                   const char *path, char id[ID + 1], char secret[64]) {
    char url[128];
    snprintf(url, sizeof url, "https://localhost:%d%s", receiver->port, path);
    return post(server, url, id, secret);
}

/* waits until the telling of a job's end has come so far; checks attempts and status, < 0 = any */
static void await(const struct test_server *server, const char *id, const char *state, int attempts,
                  int status) {
    double until = test_clock() + TEST_PATIENCE;
    char path[64], now[32] = "";
    int tried = -1, last = -1;
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    do {
        struct test_reply reply;
        test_sleep(0.02);
        test_request(server, &reply, "GET", path, "", NULL);
        cJSON *job = ask_json(&reply), *notify = cJSON_GetObjectItem(job, "notify");
        const char *text = cJSON_GetStringValue(cJSON_GetObjectItem(notify, "state"));
        snprintf(now, sizeof now, "%s", text ? text : "");
        tried = (int)cJSON_GetNumberValue(cJSON_GetObjectItem(notify, "attempts"));
        const cJSON *answered = cJSON_GetObjectItem(notify, "last_status");
        last = cJSON_IsNumber(answered) ? answered->valueint : 0;
        CHECK(!cJSON_GetObjectItem(notify, "secret"));
        cJSON_Delete(job);
        test_reply_clear(&reply);
    } while ((strcmp(now, state) != 0 || (attempts >= 0 && tried < attempts)) &&
             test_clock() < until);
    CHECK_TEXT(now, state);
    if (attempts >= 0) CHECK_INT(tried, attempts);
    if (status >= 0) CHECK_INT(last, status);
}

/* a field of a message, copied; "" where there is none */
static void field(const char *message, const char *name, char value[256]) {
    const char *at = strcasestr(message, name);
    value[0] = 0;
    if (at) sscanf(at + strlen(name), ": %255[^\r]", value);
}

/* the signature of a message by a key as its client was told it, made by another library */
static void check_signature(const char *message, const char *secret) {
    char id[256], stamp[256], signatures[256], text[MESSAGE], expected[64];
    unsigned char mac[32];
    gnutls_datum_t key = {NULL, 0}, out = {NULL, 0}, raw = {mac, sizeof mac};
    gnutls_datum_t letters = {(unsigned char *)secret + 6, (unsigned)strlen(secret) - 6};
    if (!CHECK(!strncmp(secret, "whsec_", 6))) return;
    field(message, "webhook-id", id);
    field(message, "webhook-timestamp", stamp);
    field(message, "webhook-signature", signatures);
    const char *body = strstr(message, "\r\n\r\n");
    if (!CHECK(body && *id && *stamp)) return;
    snprintf(text, sizeof text, "%s.%s.%s", id, stamp, body + 4);
    good(gnutls_base64_decode2(&letters, &key), "key");
    CHECK(!gnutls_hmac_fast(GNUTLS_MAC_SHA256, key.data, key.size, text, strlen(text), mac));
    good(gnutls_base64_encode2(&raw, &out), "signature");
    snprintf(expected, sizeof expected, "v1,%.*s", (int)out.size, (const char *)out.data);
    /* the first is of the secret in force, behind it one of the secret before */
    CHECK_SAYING(!strncmp(signatures, expected, strlen(expected)) &&
                     signatures[strlen(expected)] == ' ' &&
                     !strncmp(signatures + strlen(expected) + 1, "v1,", 3),
                 "%s is not %s", signatures, expected);
    gnutls_free(key.data);
    gnutls_free(out.data);
}

/* --- what is told --- */

static void told(struct place *place) {
    struct receiver *receiver = receiver_start();
    char path[PATH], id[ID + 1], again[ID + 1], secret[64], message[MESSAGE], part[96];
    REQUIRE(receiver);
    struct test_server *server =
        place_serve(place, "all", "1", "--config", settings(receiver, 1, path));
    REQUIRE(server);
    CHECK_INT(post_to(server, receiver, "/ok?for=me", id, secret), 202);
    await(server, id, "delivered", 1, 204);
    CHECK_INT(receiver_seen(receiver, "/ok?for=me", message), 1);
    check_signature(message, secret);
    snprintf(part, sizeof part, "\"type\":\"job.successful\"");
    CHECK(strstr(message, part) && strstr(message, id));
    CHECK(!strstr(message, "whsec_") && !strstr(message, "notify"));
    /* an attempt that failed is followed by another, of the same id */
    CHECK_INT(post_to(server, receiver, "/once", again, secret), 202);
    await(server, again, "delivered", 2, 204);
    CHECK_INT(receiver_seen(receiver, "/once", message), 2);
    check_signature(message, secret);
    CHECK(ask_metric(server, "pendulumd_webhooks_total{end=\"delivered\"}") == 2);
    CHECK(ask_metric(server, "pendulumd_webhooks_total{end=\"failed\"}") == 1);
    test_server_stop(&server);
    receiver_stop(receiver);
}

TEST(the_end_of_a_job_is_told_and_signed) { place_on_both(told); }

TEST(no_receiver_leads_elsewhere_or_holds_up_the_others) {
    struct receiver *receiver = receiver_start();
    struct place place;
    char path[PATH], slow[ID + 1], heads[ID + 1], id[ID + 1], secret[64];
    REQUIRE(receiver && place_begin(&place, 0));
    struct test_server *server =
        place_serve(&place, "all", "1", "--config", settings(receiver, 1, path));
    REQUIRE(server);
    CHECK_INT(post_to(server, receiver, "/slow", slow, secret), 202);
    CHECK_INT(post_to(server, receiver, "/heads", heads, secret), 202);
    CHECK_INT(post_to(server, receiver, "/redirect", id, secret), 202);
    await(server, id, "sending", 1, 302);
    CHECK_INT(receiver_seen(receiver, "/elsewhere", NULL), 0);
    CHECK_INT(post_to(server, receiver, "/endless", id, secret), 202);
    await(server, id, "delivered", 1, 200);
    CHECK_INT(post_to(server, receiver, "/gone", id, secret), 202);
    await(server, id, "failed", 1, 410);
    await(server, slow, "sending", 1, 0);
    /* whose certificate is another's, or who is not there, is told nothing */
    char url[128];
    snprintf(url, sizeof url, "https://127.0.0.1:%d/ok", receiver->port);
    CHECK_INT(post(server, url, id, secret), 202);
    await(server, id, "sending", 1, 0);
    CHECK_INT(receiver_seen(receiver, "/ok", NULL), 0);
    test_server_stop(&server);
    place_end(&place);
    receiver_stop(receiver);
}

TEST(private_addresses_are_told_nothing) {
    static const char *const literal[] = {
        "127.0.0.1", "10.1.2.3",  "192.168.0.1",        "169.254.169.254",   "[::1]",
        "[fd00::1]", "[fe80::1]", "[::ffff:127.0.0.1]", "[64:ff9b::7f00:1]", "0.0.0.0",
        "224.0.0.1", "100.64.0.1"};
    static const char *const name[] = {"localhost", "2130706433", "0x7f.1", "127.1"};
    struct receiver *receiver = receiver_start();
    struct place place;
    char path[PATH], url[128], id[ID + 1], secret[64];
    REQUIRE(receiver && place_begin(&place, 0));
    struct test_server *server =
        place_serve(&place, "all", "1", "--config", settings(receiver, 0, path));
    REQUIRE(server);
    for (size_t i = 0; i < sizeof literal / sizeof *literal; i++) {
        snprintf(url, sizeof url, "https://%s:%d/ok", literal[i], receiver->port);
        CHECK_SAYING(post(server, url, id, secret) == 422, "%s", url);
    }
    /* what is only known once it is looked up */
    for (size_t i = 0; i < sizeof name / sizeof *name; i++) {
        snprintf(url, sizeof url, "https://%s:%d/ok", name[i], receiver->port);
        CHECK_INT(post(server, url, id, secret), 202);
        await(server, id, "failed", 1, 0);
    }
    CHECK_INT(receiver_seen(receiver, "/ok", NULL), 0);
    CHECK(ask_metric(server, "pendulumd_webhooks_total{end=\"refused\"}") ==
          sizeof name / sizeof *name);
    test_server_stop(&server);
    place_end(&place);
    receiver_stop(receiver);
}

/* such a url is its own address, of which libcurl wants to be told nothing more */
TEST(an_address_of_ipv6_is_reached) {
    struct sockaddr_in6 here = {.sin6_family = AF_INET6, .sin6_addr = in6addr_loopback};
    socklen_t bytes = sizeof here;
    struct pollfd ear = {.fd = socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0), .events = POLLIN};
    if (ear.fd < 0 || bind(ear.fd, (struct sockaddr *)&here, sizeof here) != 0) {
        test_skip("this machine has no IPv6 loopback");
        if (ear.fd >= 0) close(ear.fd);
        return;
    }
    CHECK(!listen(ear.fd, 4) && !getsockname(ear.fd, (struct sockaddr *)&here, &bytes));
    struct receiver *receiver = receiver_start();
    struct place place;
    char path[PATH], url[128], id[ID + 1], secret[64];
    REQUIRE(receiver && place_begin(&place, 0));
    struct test_server *server =
        place_serve(&place, "all", "1", "--config", settings(receiver, 1, path));
    REQUIRE(server);
    snprintf(url, sizeof url, "https://[::1]:%d/ok", ntohs(here.sin6_port));
    CHECK_INT(post(server, url, id, secret), 202);
    /* somebody knocks; that is all there is to see here */
    CHECK_INT(poll(&ear, 1, 1000 * TEST_PATIENCE), 1);
    close(ear.fd);
    test_server_stop(&server);
    place_end(&place);
    receiver_stop(receiver);
}

static void refused(const struct test_server *server, const char *fields, int status) {
    struct test_reply reply;
    test_request(server, &reply, "POST", "/v1/modes", fields, ASK_LITTLE);
    ask_problem(&reply, status, NULL);
    test_reply_clear(&reply);
}

TEST(what_cannot_be_told_is_refused_when_the_job_is_posted) {
    struct receiver *receiver = receiver_start();
    struct place place;
    char path[PATH];
    REQUIRE(receiver && place_begin(&place, 0));
    struct test_server *server = place_serve(&place, "all", "1", NULL, NULL);
    REQUIRE(server);
    /* webhooks are off by default */
    refused(server, ASYNC TOKEN "Job-Notify: https://example.org/\r\n", 422);
    test_server_stop(&server);
    server = place_serve(&place, "all", "1", "--config", settings(receiver, 1, path));
    REQUIRE(server);
    refused(server, ASYNC TOKEN "Job-Notify: http://example.org/\r\n", 400);
    refused(server, ASYNC TOKEN "Job-Notify: https://me@example.org/\r\n", 400);
    refused(server, ASYNC "Job-Notify: https://example.org/\r\n", 401);
    /* there will be no job */
    refused(server, TOKEN "Job-Notify: https://example.org/\r\n", 400);
    test_server_stop(&server);
    place_end(&place);
    receiver_stop(receiver);
}

/* a server is killed while its message is under way; another, on the same store, tells it again */
static void killed(struct place *place) {
    struct receiver *receiver = receiver_start();
    char path[PATH], id[ID + 1], secret[64], message[MESSAGE];
    REQUIRE(receiver);
    settings(receiver, 1, path);
    struct test_server *server = place_serve(place, "api", "1", "--config", path);
    REQUIRE(server);
    CHECK_INT(post_to(server, receiver, "/ok", id, secret), 202);
    test_server_stop(&server);
    /* it computes the job and tells nobody: webhooks are off there */
    server = place_serve(place, "all", "1", NULL, NULL);
    REQUIRE(server);
    await(server, id, "sending", 0, 0);
    test_server_signal(server, SIGKILL);
    test_server_wait(server);
    test_server_drop(&server);
    struct test_server *one = place_serve(place, "all", "1", "--config", path);
    struct test_server *two = place_serve(place, "all", "1", "--config", path);
    REQUIRE(one && two);
    await(one, id, "delivered", 1, 204);
    CHECK_INT(receiver_seen(receiver, "/ok", message), 1);
    check_signature(message, secret);
    stop_after_deaths(&one);
    stop_after_deaths(&two);
    receiver_stop(receiver);
}

TEST(a_server_that_dies_between_end_and_telling_is_followed_by_one_other) { place_on_both(killed); }

/* the message was under way: whoever has taken it says nothing more, and after a minute it is due
 * again */
TEST(a_server_that_dies_in_mid_message_is_followed_by_one_with_the_same_id) {
    struct receiver *receiver = receiver_start();
    struct place place;
    char path[PATH], id[ID + 1], secret[64], message[MESSAGE], first[256], second[256];
    REQUIRE(receiver && place_begin(&place, 0));
    settings(receiver, 1, path);
    struct test_server *server = place_serve(&place, "all", "1", "--config", path);
    REQUIRE(server);
    CHECK_INT(post_to(server, receiver, "/dies", id, secret), 202);
    double until = test_clock() + TEST_PATIENCE;
    while (receiver_seen(receiver, "/dies", message) < 1 && test_clock() < until) test_sleep(0.02);
    field(message, "webhook-id", first);
    test_server_signal(server, SIGKILL);
    test_server_wait(server);
    test_server_drop(&server);
    server = place_serve(&place, "all", "1", "--config", path);
    REQUIRE(server);
    await(server, id, "delivered", 2, 204);
    CHECK_INT(receiver_seen(receiver, "/dies", message), 2);
    check_signature(message, secret);
    field(message, "webhook-id", second);
    CHECK(*first);
    CHECK_TEXT(second, first);
    stop_after_deaths(&server);
    place_end(&place);
    receiver_stop(receiver);
}
