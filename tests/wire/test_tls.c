/* HTTPS: certificates that fit and that do not, of the server and of clients; the strict reader
 * behind TLS; certificates read again. */
#include <gnutls/gnutls.h>
#include <gnutls/x509.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "tests/wire/ask.h"
#include "tests/wire/safe.h"

/* a list NAME.crl of certificates that are revoked, NULL at its end, signed by whose certificate
 * and key these are; its time for the next one from now in days */
static void safe_revoke(const struct safe *safe, const char *name, gnutls_x509_crt_t issuer,
                        gnutls_x509_privkey_t key, int next, const char *const revoked[]) {
    char path[PATH], file[64];
    gnutls_x509_crl_t list;
    gnutls_datum_t text = {NULL, 0};
    time_t now = time(NULL);
    good(gnutls_x509_crl_init(&list), "list");
    good(gnutls_x509_crl_set_version(list, 2), "version");
    good(gnutls_x509_crl_set_this_update(list, now - 2 * (time_t)DAY), "time");
    good(gnutls_x509_crl_set_next_update(list, now + next * (time_t)DAY), "next time");
    good(gnutls_x509_crl_set_number(list, "\1", 1), "number");
    for (; *revoked; revoked++) {
        gnutls_x509_crt_t crt;
        snprintf(file, sizeof file, "%s.pem", *revoked);
        safe_path(safe, file, path);
        good(gnutls_load_file(path, &text), path);
        good(gnutls_x509_crt_init(&crt), "certificate");
        good(gnutls_x509_crt_import(crt, &text, GNUTLS_X509_FMT_PEM), "certificate");
        good(gnutls_x509_crl_set_crt(list, crt, now - DAY), "revoked");
        gnutls_x509_crt_deinit(crt);
        gnutls_free(text.data);
    }
    good(gnutls_x509_crl_sign2(list, issuer, key, GNUTLS_DIG_SHA256, 0), "signature");
    good(gnutls_x509_crl_export2(list, GNUTLS_X509_FMT_PEM, &text), "PEM");
    snprintf(file, sizeof file, "%s.crl", name);
    safe_write(safe, file, &text);
    gnutls_free(text.data);
    gnutls_x509_crl_deinit(list);
}

/* Options of a daemon with the certificate NAME.pem, its key, and an authority of clients, NULL =
 * none. */
struct sealed_options {
    char pem[PATH], key[PATH], authority[PATH];
    const char *word[16];
};

static const char *const *options_of(const struct safe *safe, const char *pem, const char *key,
                                     const char *authority, struct sealed_options *options) {
    safe_path(safe, pem, options->pem);
    safe_path(safe, key, options->key);
    safe_path(safe, authority ? authority : "", options->authority);
    const char *const words[] = {"--listen",
                                 "127.0.0.1:0",
                                 "--store",
                                 "none",
                                 "--tls-certificate",
                                 options->pem,
                                 "--tls-key",
                                 options->key,
                                 "--header-seconds",
                                 "2",
                                 authority ? "--tls-client-authority" : NULL,
                                 options->authority,
                                 NULL};
    memcpy(options->word, words, sizeof words);
    return options->word;
}

/* A client's end of a sealed connection. */
struct sealed {
    struct test_client client;
    gnutls_certificate_credentials_t mine;
    gnutls_session_t session;
};

/* connects, checks that the server is who it should be, and shows a certificate, NULL = none */
static int sealed_open(const struct safe *safe, struct sealed *sealed, int port,
                       const char *shows) {
    char ca[PATH], pem[PATH], key[PATH], file[64];
    memset(sealed, 0, sizeof *sealed);
    safe_path(safe, "ca.pem", ca);
    good(gnutls_certificate_allocate_credentials(&sealed->mine), "credentials");
    good(gnutls_certificate_set_x509_trust_file(sealed->mine, ca, GNUTLS_X509_FMT_PEM), "trust");
    if (shows) {
        snprintf(file, sizeof file, "%s.pem", shows);
        safe_path(safe, file, pem);
        snprintf(file, sizeof file, "%s.key", shows);
        safe_path(safe, file, key);
        good(gnutls_certificate_set_x509_key_file(sealed->mine, pem, key, GNUTLS_X509_FMT_PEM),
             "own certificate");
        gnutls_certificate_set_flags(sealed->mine, GNUTLS_CERTIFICATE_SKIP_KEY_CERT_MATCH);
    }
    good(gnutls_init(&sealed->session, GNUTLS_CLIENT | GNUTLS_FORCE_CLIENT_CERT), "session");
    good(gnutls_set_default_priority(sealed->session), "priority");
    good(gnutls_credentials_set(sealed->session, GNUTLS_CRD_CERTIFICATE, sealed->mine), "mine");
    gnutls_session_set_verify_cert(sealed->session, "localhost", 0);
    if (!test_client_open(&sealed->client, port)) return 0;
    gnutls_transport_set_int(sealed->session, sealed->client.fd);
    gnutls_handshake_set_timeout(sealed->session, 1000 * TEST_PATIENCE);
    int code;
    do code = gnutls_handshake(sealed->session);
    while (code < 0 && !gnutls_error_is_fatal(code));
    return good(code, "handshake");
}

static void sealed_close(struct sealed *sealed) {
    gnutls_deinit(sealed->session);
    gnutls_certificate_free_credentials(sealed->mine);
    test_client_close(&sealed->client);
}

/* sends bytes and reads until the other side ends; returns the status */
static int sealed_ask(struct sealed *sealed, const char *text, char reply[TEXT]) {
    size_t left = strlen(text), got = 0;
    while (left) {
        ssize_t sent = gnutls_record_send(sealed->session, text, left);
        if (sent < 0 && !gnutls_error_is_fatal((int)sent)) continue;
        if (sent <= 0) break;
        text += sent;
        left -= (size_t)sent;
    }
    for (;;) {
        ssize_t more = gnutls_record_recv(sealed->session, reply + got, TEXT - 1 - got);
        if (more < 0 && !gnutls_error_is_fatal((int)more)) continue;
        if (more <= 0) break;
        got += (size_t)more;
    }
    reply[got] = 0;
    return strncmp(reply, "HTTP/1.1 ", 9) ? 0 : atoi(reply + 9);
}

/* one request on a connection of its own */
static int ask_once(const struct safe *safe, const struct test_server *server, const char *shows,
                    const char *text, char reply[TEXT]) {
    struct sealed sealed;
    int status = 0;
    reply[0] = 0;
    if (sealed_open(safe, &sealed, test_server_port(server), shows))
        status = sealed_ask(&sealed, text, reply);
    sealed_close(&sealed);
    return status;
}

#define ONCE "Host: localhost\r\nConnection: close\r\n"
#define VERSION "GET /version HTTP/1.1\r\n" ONCE "\r\n"

TEST(what_is_sealed_is_read_as_strictly_and_answered_to_the_same_bytes) {
    struct safe safe;
    struct sealed_options options;
    struct test_reply reply;
    static char text[TEXT], request[1 << 18];
    REQUIRE(safe_begin(&safe));
    struct test_server *server =
        test_server_start(options_of(&safe, "server.pem", "server.key", NULL, &options));
    struct test_server *open = test_server_start(NULL);
    REQUIRE(server && open);
    CHECK(strstr(test_server_log(server), "listening on https://127.0.0.1:") != NULL);
    CHECK_INT(ask_once(&safe, server, NULL, VERSION, text), 200);
    /* a body of many records, an answer of many */
    size_t at =
        (size_t)snprintf(request, sizeof request, "{\"pendulum\":" ASK_DOUBLE ",\"times\":[0");
    for (int i = 1; i < 6000; i++)
        at += (size_t)snprintf(request + at, sizeof request - at, ",%.4f", i * 1e-3);
    snprintf(request + at, sizeof request - at, "]}");
    CHECK_INT(
        test_request(open, &reply, "POST", "/v1/trajectories", "Accept: text/csv\r\n", request),
        200);
    static char whole[(1 << 18) + 512];
    /* HTTP/1.0 has no chunks, which an answer that is not there at once comes in */
    snprintf(whole, sizeof whole,
             "POST /v1/trajectories HTTP/1.0\r\n" ONCE "Accept: text/csv\r\n"
             "Content-Type: application/json\r\nContent-Length: %zu\r\n\r\n%s",
             strlen(request), request);
    CHECK_INT(ask_once(&safe, server, NULL, whole, text), 200);
    const char *body = strstr(text, "\r\n\r\n");
    CHECK_SAYING(body && reply.body_bytes > 100000 && !strcmp(body + 4, reply.body),
                 "%zu bytes: %.60s", reply.body_bytes, body ? body + 4 : "none");
    test_reply_clear(&reply);
    /* what no request may have is refused by the strict reader, with its sentence */
    CHECK_INT(ask_once(&safe, server, NULL, "GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", text),
              400);
    CHECK_SAYING(strstr(text, "two header fields Host") != NULL, "%s", text);
    CHECK_INT(ask_once(&safe, server, NULL, "GET / HTTP/1.1\nHost: a\n\n", text), 400);
    /* what is not sealed is not answered, and its connection ends */
    struct test_client client;
    char byte;
    REQUIRE(test_client_open(&client, test_server_port(server)));
    CHECK(test_client_say(&client, VERSION));
    ssize_t plain = 0;
    for (int i = 0; i < 4096 && (plain = recv(client.fd, &byte, 1, 0)) == 1; i++)
        CHECK(i || byte != 'H');
    CHECK(plain <= 0);
    test_client_close(&client);
    /* a handshake that does not come is not waited for */
    REQUIRE(test_client_open(&client, test_server_port(server)));
    CHECK(test_client_ended(&client, TEST_PATIENCE));
    test_client_close(&client);
    test_server_stop(&server);
    test_server_stop(&open);
    safe_end(&safe);
}

TEST(a_clients_certificate_that_does_not_fit_is_told_why) {
    static const struct {
        const char *shows;
        int status;
        const char *says;
    } each[] = {{"client", 200, "version"},
                {NULL, 403, "has shown none"},
                {"old", 403, "it has expired"},
                {"early", 403, "its time has not begun"},
                {"server", 403, "not made for clients"},
                {"stranger", 403, "another authority has signed it"}};
    struct safe safe;
    struct sealed_options options;
    static char text[TEXT];
    REQUIRE(safe_begin(&safe));
    safe_make(&safe, "client", GNUTLS_KP_TLS_WWW_CLIENT, -1, 30);
    safe_make(&safe, "old", GNUTLS_KP_TLS_WWW_CLIENT, -30, -1);
    safe_make(&safe, "early", GNUTLS_KP_TLS_WWW_CLIENT, 1, 30);
    safe_make(&safe, "stranger", NULL, -1, 30);
    struct test_server *server =
        test_server_start(options_of(&safe, "server.pem", "server.key", "ca.pem", &options));
    REQUIRE(server != NULL);
    for (size_t i = 0; i < sizeof each / sizeof *each; i++) {
        int status = ask_once(&safe, server, each[i].shows, VERSION, text);
        CHECK_SAYING(status == each[i].status && strstr(text, each[i].says), "%s: %d %s",
                     each[i].shows ? each[i].shows : "none", status, text);
        if (status == 403)
            CHECK_SAYING(strstr(text, "application/problem+json") &&
                             strstr(text, "clients of this server need a certificate"),
                         "%s", text);
    }
    test_server_stop(&server);
    safe_end(&safe);
}

/* waits until the server has said a word so many times */
static int said(struct test_server *server, const char *word, int times) {
    for (double end = test_clock() + TEST_PATIENCE; test_clock() < end; test_sleep(0.02)) {
        int found = 0;
        for (const char *at = test_server_log(server); (at = strstr(at, word)); at++) found++;
        if (found >= times) return 1;
    }
    return CHECK_SAYING(0, "it does not say %s but: %s", word, test_server_log(server));
}

/* the daemon's options with a list of revoked certificates */
static const char *const *options_revoked(const struct safe *safe, const char *list,
                                          struct sealed_options *options, char path[PATH]) {
    int words = 0;
    (void)options_of(safe, "server.pem", "server.key", "ca.pem", options);
    while (options->word[words]) words++;
    safe_path(safe, list, path);
    options->word[words++] = "--tls-client-revoked";
    options->word[words++] = path;
    options->word[words] = NULL;
    return options->word;
}

TEST(a_clients_certificate_that_was_revoked_is_refused_and_lists_that_do_not_fit_are_not_taken) {
    static const char *const lost[] = {"lost", NULL}, *const both[] = {"lost", "client", NULL},
                             *const none[] = {NULL};
    static const char *const wrong[][2] = {{"late.crl", "is overdue"},
                                           {"foreign.crl", "is not signed by the authority"},
                                           {"ca.pem", "the list of revoked certificates"},
                                           {"nothing.crl", "nothing.crl"}};
    struct safe safe, other;
    struct sealed_options options;
    static char text[TEXT];
    char path[PATH], command[3 * PATH];
    REQUIRE(safe_begin(&safe));
    REQUIRE(safe_begin(&other));
    safe_make(&safe, "client", GNUTLS_KP_TLS_WWW_CLIENT, -1, 30);
    safe_make(&safe, "lost", GNUTLS_KP_TLS_WWW_CLIENT, -1, 30);
    safe_revoke(&safe, "late", safe.authority, safe.authority_key, -1, lost);
    safe_revoke(&safe, "foreign", other.authority, other.authority_key, 30, lost);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        int status =
            test_server_run(options_revoked(&safe, wrong[i][0], &options, path), text, sizeof text);
        CHECK_SAYING(status == 1 && strstr(text, wrong[i][1]), "%s: %d %s", wrong[i][0], status,
                     text);
    }
    safe_revoke(&safe, "now", safe.authority, safe.authority_key, 30, lost);
    struct test_server *server =
        test_server_start(options_revoked(&safe, "now.crl", &options, path));
    REQUIRE(server != NULL);
    CHECK_INT(ask_once(&safe, server, "client", VERSION, text), 200);
    CHECK_INT(ask_once(&safe, server, "lost", VERSION, text), 403);
    CHECK_SAYING(strstr(text, "it was revoked") != NULL, "%s", text);
    /* a list that does not fit changes nothing at a reload, one that fits is in force at once */
    safe_revoke(&safe, "now", other.authority, other.authority_key, 30, none);
    test_server_signal(server, SIGHUP);
    REQUIRE(said(server, "reload: nothing has changed: the list of revoked certificates", 1));
    CHECK_INT(ask_once(&safe, server, "lost", VERSION, text), 403);
    /* of two lists of one authority the newer one counts */
    safe_revoke(&safe, "before", safe.authority, safe.authority_key, 30, lost);
    safe_revoke(&safe, "after", safe.authority, safe.authority_key, 30, both);
    snprintf(command, sizeof command, "cd '%s' && cat after.crl before.crl > now.crl",
             safe.directory);
    CHECK(!system(command));
    test_server_signal(server, SIGHUP);
    REQUIRE(said(server, "reload: 0 options have changed", 1));
    CHECK_INT(ask_once(&safe, server, "client", VERSION, text), 403);
    CHECK_SAYING(strstr(text, "it was revoked") != NULL, "%s", text);
    test_server_signal(server, SIGTERM);
    CHECK_INT(test_server_wait(server), 0);
    test_server_drop(&server);
    safe_end(&other);
    safe_end(&safe);
}

TEST(a_servers_certificate_that_does_not_fit_is_refused_at_the_start) {
    static const struct {
        const char *pem, *key, *authority, *says;
    } each[] = {{"server.pem", "ca.key", NULL, "is not that of the certificate"},
                {"old.pem", "old.key", NULL, "has expired, at 20"},
                {"early.pem", "early.key", NULL, "is good only from 20"},
                {"server.key", "server.key", NULL, "the certificate"},
                {"server.pem", "server.pem", NULL, "the key"},
                {"nothing.pem", "server.key", NULL, "nothing.pem"},
                {"server.pem", "nothing.key", NULL, "No such file"},
                {"server.pem", "open.key", NULL, "has mode 0644"},
                {"server.pem", "server.key", "server.key", "the authority of clients"},
                {"server.pem", "server.key", "nothing.pem", "nothing.pem"}};
    struct safe safe;
    struct sealed_options options;
    char text[2048], path[PATH];
    REQUIRE(safe_begin(&safe));
    safe_make(&safe, "old", GNUTLS_KP_TLS_WWW_SERVER, -30, -1);
    safe_make(&safe, "early", GNUTLS_KP_TLS_WWW_SERVER, 1, 30);
    safe_make(&safe, "open", GNUTLS_KP_TLS_WWW_SERVER, -1, 30);
    safe_path(&safe, "open.key", path);
    CHECK(!chmod(path, 0644));
    for (size_t i = 0; i < sizeof each / sizeof *each; i++) {
        int status = test_server_run(
            options_of(&safe, each[i].pem, each[i].key, each[i].authority, &options), text,
            sizeof text);
        CHECK_SAYING(status == 1 && strstr(text, each[i].says), "%s %s: %d %s", each[i].pem,
                     each[i].key, status, text);
    }
    safe_path(&safe, "server.pem", path);
    const char *const half[] = {"--tls-certificate", path, "--store", "none", NULL};
    CHECK_INT(test_server_run(half, text, sizeof text), 1);
    CHECK_SAYING(strstr(text, "go together") != NULL, "%s", text);
    safe_end(&safe);
}

/* the serial number of the certificate that the server shows */
static int serial_of(const struct safe *safe, const struct test_server *server) {
    struct sealed sealed;
    unsigned count = 0;
    unsigned char serial[32] = {0};
    size_t bytes = sizeof serial;
    gnutls_x509_crt_t crt;
    if (sealed_open(safe, &sealed, test_server_port(server), NULL)) {
        const gnutls_datum_t *raw = gnutls_certificate_get_peers(sealed.session, &count);
        good(gnutls_x509_crt_init(&crt), "certificate");
        if (CHECK(raw && count))
            good(gnutls_x509_crt_import(crt, raw, GNUTLS_X509_FMT_DER), "certificate");
        good(gnutls_x509_crt_get_serial(crt, serial, &bytes), "serial");
        gnutls_x509_crt_deinit(crt);
    }
    sealed_close(&sealed);
    return serial[bytes - 1];
}

TEST(certificates_are_read_again_and_open_connections_go_on) {
    struct safe safe;
    struct sealed_options options;
    struct sealed held;
    static char text[TEXT];
    REQUIRE(safe_begin(&safe));
    struct test_server *server =
        test_server_start(options_of(&safe, "server.pem", "server.key", NULL, &options));
    REQUIRE(server != NULL);
    int first = serial_of(&safe, server);
    REQUIRE(sealed_open(&safe, &held, test_server_port(server), NULL));
    /* a certificate whose time is over does not take the place of one that fits */
    safe_make(&safe, "server", GNUTLS_KP_TLS_WWW_SERVER, -30, -1);
    test_server_signal(server, SIGHUP);
    REQUIRE(said(server, "reload: nothing has changed: the certificate", 1));
    CHECK_INT(serial_of(&safe, server), first);
    safe_make(&safe, "server", GNUTLS_KP_TLS_WWW_SERVER, -1, 30);
    test_server_signal(server, SIGHUP);
    REQUIRE(said(server, "reload: 0 options have changed", 1));
    CHECK_INT(serial_of(&safe, server), first + 2);
    CHECK_INT(sealed_ask(&held, VERSION, text), 200);
    sealed_close(&held);
    test_server_signal(server, SIGTERM);
    CHECK_INT(test_server_wait(server), 0);
    test_server_drop(&server);
    safe_end(&safe);
}
