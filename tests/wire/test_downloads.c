/* Downloads of results while their store does not respond, is unreachable or changes: the effect on
 * the downloads, and on other computations. */
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/wire/place.h"

/* 32 bytes per instant: more than sockets and the server hold for two downloads */
enum { INSTANTS = 700000, BODY_BYTES = 32 * INSTANTS, DOWNLOADS = 2 };

#define OCTETS "Accept: application/octet-stream\r\n"

/* A download that is read by hand. */
struct download {
    struct test_client client;
    char *data;
    size_t bytes, cap;
};

/* requests the results and waits for the first byte, which is not taken yet */
static int download_begin(struct download *download, const struct test_server *server,
                          const char *id) {
    char text[256];
    int little = 1 << 16;
    memset(download, 0, sizeof *download);
    if (!test_client_open(&download->client, test_server_port(server))) return 0;
    setsockopt(download->client.fd, SOL_SOCKET, SO_RCVBUF, &little, sizeof little);
    download->cap = BODY_BYTES + 65536; /* with heads of chunks */
    download->data = calloc(1, download->cap + 1);
    snprintf(text, sizeof text,
             "GET /v1/jobs/%s/results HTTP/1.1\r\nHost: a\r\nConnection: close\r\n" OCTETS "\r\n",
             id);
    struct pollfd ready = {download->client.fd, POLLIN, 0};
    return CHECK(download->data && test_client_say(&download->client, text) &&
                 poll(&ready, 1, 1000 * TEST_PATIENCE) == 1);
}

/* reads until nothing arrives for this many seconds; returns 1 at its end, 0 if it pauses */
static int download_read(struct download *download, double seconds) {
    struct pollfd ready = {download->client.fd, POLLIN, 0};
    while (poll(&ready, 1, (int)(1000 * seconds)) == 1) {
        ssize_t got = recv(download->client.fd, download->data + download->bytes,
                           download->cap - download->bytes, 0);
        if (got <= 0) return 1;
        download->bytes += (size_t)got;
    }
    return 0;
}

/* The bytes of its body without the chunk framing, which is removed in place, once. 0 if there is
 * no head. */
static size_t download_body(struct download *download, const char **body) {
    char *end = memmem(download->data, download->bytes, "\r\n\r\n", 4);
    *body = end ? end + 4 : NULL;
    if (!end) return 0;
    size_t head = (size_t)(end + 4 - download->data), bytes = 0;
    if (!CHECK(memmem(download->data, head, "Transfer-Encoding: chunked", 26) != NULL)) return 0;
    for (size_t at = head; at < download->bytes;) {
        char *rest = NULL;
        size_t chunk = strtoul(download->data + at, &rest, 16);
        at = (size_t)(rest - download->data) + 2;
        if (!chunk || at >= download->bytes) break;
        if (chunk > download->bytes - at) chunk = download->bytes - at;
        memmove(download->data + head + bytes, download->data + at, chunk);
        bytes += chunk;
        at += chunk + 2;
    }
    return bytes;
}

static void download_end(struct download *download) {
    test_client_close(&download->client);
    free(download->data);
    download->data = NULL;
}

/* a daemon with one worker, and a finished job of many pieces */
static struct test_server *downloads_serve(const struct place *place, char id[ID + 1]) {
    char body[256], word[WORDS];
    struct test_server *server = place_serve(place, "all", "1", "--workers", "1");
    if (!server) return NULL;
    snprintf(
        body, sizeof body,
        "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},\"initial\":{\"theta\":[1]},"
        "\"times\":{\"stop\":10,\"count\":%d},\"output\":[\"phi\",\"phid\",\"lambda\"]}",
        INSTANTS);
    CHECK_INT(submit(server, "/v1/trajectories", ASYNC, body, id), 202);
    job_wait(server, id, word);
    CHECK_TEXT(word, "successful");
    return server;
}

/* others are computed for */
static void downloads_compute(struct test_server *server) {
    for (int i = 0; i < 5; i++) {
        OWN(test_reply, clear) reply;
        CHECK_INT(ask(server, &reply, "/v1/forces", ASK_LITTLE), 200);
    }
}

/* the download is complete, and equal to an undisturbed one */
static void check_whole(struct download *download, const struct test_reply *whole) {
    const char *body;
    size_t bytes = download_body(download, &body);
    CHECK_SAYING(bytes == whole->body_bytes && !memcmp(body, whole->body, bytes),
                 "%zu bytes of %zu", bytes, whole->body_bytes);
}

/* the database stops responding in the middle of a download: no computation waits for it, and once
 * it responds the downloads complete */
static void silence(struct place *place, struct test_server *server, const char *id,
                    const struct test_reply *whole) {
    struct download download[DOWNLOADS];
    for (int i = 0; i < DOWNLOADS; i++) REQUIRE(download_begin(&download[i], server, id));
    test_postgres_freeze(place->postgres, 1);
    for (int i = 0; i < DOWNLOADS; i++) CHECK(!download_read(&download[i], 0.3));
    downloads_compute(server);
    /* all this happened while no download continued or ended: nobody waited for the database's
     * limit */
    for (int i = 0; i < DOWNLOADS; i++)
        CHECK(!download_read(&download[i], 0.3) && download[i].bytes < BODY_BYTES);
    test_postgres_freeze(place->postgres, 0);
    for (int i = 0; i < DOWNLOADS; i++) {
        CHECK(download_read(&download[i], TEST_PATIENCE));
        check_whole(&download[i], whole);
        download_end(&download[i]);
    }
}

/* clients that waited for a silent database leave: nothing is kept for them once it responds, and
 * the job is unchanged */
static void leaving(struct place *place, struct test_server *server, const char *id) {
    struct download download[DOWNLOADS];
    for (int i = 0; i < DOWNLOADS; i++) REQUIRE(download_begin(&download[i], server, id));
    test_postgres_freeze(place->postgres, 1);
    for (int i = 0; i < DOWNLOADS; i++) {
        CHECK(!download_read(&download[i], 0.3));
        download_end(&download[i]);
    }
    /* they end at once, whatever the database does */
    CHECK(ask_await(server, "pendulumd_computations", 0, 0));
    downloads_compute(server);
    test_postgres_freeze(place->postgres, 0);
    CHECK(ask_await(server, "pendulumd_held_kind_bytes{kind=\"computations\"}", 0, 0));
}

/* the process that must end soon ends with a download in progress from a silent database */
static void hurry(struct place *place, struct test_server *server, const char *id) {
    OWN(download, end) last;
    REQUIRE(download_begin(&last, server, id));
    test_postgres_freeze(place->postgres, 1);
    CHECK(!download_read(&last, 0.3));
    test_server_signal(server, SIGTERM);
    /* two signals that come together are one, and then the database's limit is waited for */
    test_sleep(0.3);
    test_server_signal(server, SIGTERM);
    CHECK(download_read(&last, TEST_PATIENCE));
    test_postgres_freeze(place->postgres, 0);
}

/* the database ends, and restarts: the download is truncated, and can be repeated afterwards */
static void absence(struct place *place, struct test_server *server, const char *id,
                    const struct test_reply *whole) {
    const char *body;
    struct download download;
    OWN(test_reply, clear) again = {0};
    REQUIRE(download_begin(&download, server, id));
    test_postgres_halt(place->postgres, SIGQUIT);
    CHECK(download_read(&download, TEST_PATIENCE));
    CHECK(download_body(&download, &body) < BODY_BYTES);
    downloads_compute(server);
    download_end(&download);
    CHECK(test_postgres_resume(place->postgres));
    CHECK(ask_await(server, "pendulumd_store_up", 1, 1));
    CHECK_INT(job_get(server, &again, id, "/results", OCTETS), 200);
    CHECK(again.body_bytes == whole->body_bytes &&
          !memcmp(again.body, whole->body, whole->body_bytes));
}

/* on PostgreSQL, which alone can stop responding: one job of many pieces is used for all of it */
TEST(downloads_bear_a_database_that_falls_silent_or_goes_and_nobody_else_waits) {
    OWN(place, end) place = {0};
    struct test_server *server = NULL;
    OWN(test_reply, clear) whole = {0};
    char id[ID + 1];
    if (access("/usr/lib/postgresql", F_OK)) {
        test_skip("PostgreSQL is not installed");
        return;
    }
    if (place_begin(&place, 1)) server = downloads_serve(&place, id);
    if (server) {
        CHECK_INT(job_get(server, &whole, id, "/results", OCTETS), 200);
        CHECK_INT((long)whole.body_bytes, BODY_BYTES);
        silence(&place, server, id, &whole);
        leaving(&place, server, id);
        absence(&place, server, id, &whole);
        hurry(&place, server, id);
        stop_after_deaths(&server);
    }
}

/* the job is deleted in the middle of the download: it is truncated, and missing for the next */
static void deletion(struct place *place) {
    char id[ID + 1], path[64];
    const char *body;
    struct download download;
    struct test_reply reply;
    OWN(test_server, stop) *server = downloads_serve(place, id);
    if (!server) return;
    REQUIRE(download_begin(&download, server, id));
    /* the figures are a second old */
    CHECK(ask_await(server, "pendulumd_store_bytes", 1e6, 1e12));
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    CHECK_INT(test_request(server, &reply, "DELETE", path, "", NULL), 200);
    test_reply_clear(&reply);
    /* what was stored for it is removed gradually */
    CHECK(ask_await(server, "pendulumd_store_bytes", 0, 1e6));
    CHECK(download_read(&download, TEST_PATIENCE));
    CHECK(download_body(&download, &body) < BODY_BYTES);
    download_end(&download);
    CHECK_INT(job_get(server, &reply, id, "/results", OCTETS), 409);
    test_reply_clear(&reply);
    downloads_compute(server);
}

TEST(a_job_that_is_deleted_in_mid_download_cuts_it) { place_on_both(deletion); }
