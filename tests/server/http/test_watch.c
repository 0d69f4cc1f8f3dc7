#include "server/http/watch.h"

#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/config/listen.h"
#include "tests/harness/server.h"
#include "tests/harness/test.h"

/* Both ends of a connection, one of them watched. */
struct watch_pair {
    struct srv_watched watched;
    struct test_client client;
    atomic_int left;
    double when;
};

static void watch_left(struct srv_watched *watched) {
    struct watch_pair *pair =
        (struct watch_pair *)((char *)watched - offsetof(struct watch_pair, watched));
    pair->when = test_clock();
    atomic_fetch_add(&pair->left, 1);
}

static int watch_open(struct watch_pair *pair) {
    char url[SRV_URL_BYTES];
    struct pend_error error;
    int fd;
    *pair = (struct watch_pair){.watched.left = watch_left};
    if (srv_listen_open("127.0.0.1:0", &fd, url, &error) != PEND_OK) return CHECK(0);
    int opened = test_client_open(&pair->client, atoi(strrchr(url, ':') + 1));
    for (double until = test_clock() + TEST_PATIENCE;
         (pair->watched.fd = accept(fd, NULL, NULL)) < 0 && test_clock() < until;)
        test_sleep(0.001);
    close(fd);
    return CHECK(opened && pair->watched.fd >= 0);
}

static void watch_close(struct watch_pair *pair) {
    close(pair->watched.fd);
    test_client_close(&pair->client);
}

static int watch_await(struct watch_pair *pair) {
    for (double until = test_clock() + TEST_PATIENCE; !pair->left && test_clock() < until;)
        test_sleep(0.001);
    return pair->left;
}

TEST(a_waiting_client_that_goes_away_is_noticed_once) {
    /* 0: it closes; 1: it resets; 2: it only shuts down its side */
    for (int way = 0; way < 3; way++) {
        struct srv_watch *watch;
        struct watch_pair pair;
        REQUIRE(srv_watch_new(&watch) == PEND_OK && watch_open(&pair));
        srv_watch_add(watch, &pair.watched, 0);
        srv_watch_phase(watch, &pair.watched, SRV_WATCH_WAITING, 0);
        test_sleep(0.15);
        CHECK_INT(pair.left, 0);
        double begin = test_clock();
        if (way == 1) {
            struct linger hard = {1, 0};
            setsockopt(pair.client.fd, SOL_SOCKET, SO_LINGER, &hard, sizeof hard);
        }
        if (way == 2)
            shutdown(pair.client.fd, SHUT_WR);
        else
            test_client_close(&pair.client);
        CHECK_INT(watch_await(&pair), 1);
        /* a client that has only shut down its side may want its answer, and is kept for a
         * moment */
        if (way == 2)
            CHECK_SAYING(pair.when - begin > 0.02, "noticed after %.3f s", pair.when - begin);
        test_sleep(0.1);
        CHECK_INT(pair.left, 1);
        srv_watch_remove(watch, &pair.watched);
        watch_close(&pair);
        srv_watch_free(&watch);
        CHECK(watch == NULL);
    }
}

TEST(a_client_is_only_looked_at_while_it_waits) {
    OWN(srv_watch, free) *watch;
    struct watch_pair pair;
    REQUIRE(srv_watch_new(&watch) == PEND_OK && watch_open(&pair));
    srv_watch_add(watch, &pair.watched, 0);
    test_client_close(&pair.client);
    srv_watch_phase(watch, &pair.watched, SRV_WATCH_SENDING, 0);
    test_sleep(0.1);
    CHECK_INT(pair.left, 0);
    srv_watch_remove(watch, &pair.watched);
    watch_close(&pair);
}

TEST(a_request_that_is_late_gets_408_and_an_answer_that_is_not_taken_an_end) {
    static const enum srv_watch_phase phase[] = {SRV_WATCH_READING, SRV_WATCH_IDLE,
                                                 SRV_WATCH_SENDING};
    for (int i = 0; i < 3; i++) {
        OWN(srv_watch, free) *watch;
        struct watch_pair pair;
        struct test_reply reply;
        REQUIRE(srv_watch_new(&watch) == PEND_OK && watch_open(&pair));
        srv_watch_add(watch, &pair.watched, 0);
        double begin = test_clock();
        srv_watch_phase(watch, &pair.watched, phase[i], srv_clock_now() + srv_clock_span(0.2));
        CHECK_INT(test_client_receive(&pair.client, &reply, 0, TEST_PATIENCE), i ? 0 : 408);
        double seconds = test_clock() - begin;
        CHECK_SAYING(seconds > 0.15, "after %.3f s", seconds);
        if (!i) {
            CHECK_TEXT(test_reply_header(&reply, "Content-Type"), "application/problem+json");
            CHECK(strstr(reply.body, "\"status\":408") != NULL);
        }
        test_reply_clear(&reply);
        CHECK(test_client_ended(&pair.client, TEST_PATIENCE));
        srv_watch_remove(watch, &pair.watched);
        watch_close(&pair);
    }
}

/* whether a connection is busy, as it is for a moment that began after `begin` */
static int watch_moment(struct srv_watch *watch, double begin) {
    int busy = srv_watch_busy(watch, 0, 0);
    return busy == 1 || (!busy && test_clock() > begin + 1e-3 * SRV_WATCH_MOMENT_MS);
}

/* lets the moment pass for which a connection counts as busy */
static void watch_pass(void) { srv_clock_advance((int64_t)SRV_WATCH_MOMENT_MS * 1000000 + 1); }

TEST(busy_counts_what_is_not_over) {
    OWN(srv_watch, free) *watch;
    struct watch_pair pair;
    REQUIRE(srv_watch_new(&watch) == PEND_OK && watch_open(&pair));
    CHECK_INT(srv_watch_busy(watch, 0, 0), 0);
    double begin = test_clock();
    srv_watch_add(watch, &pair.watched, 0);
    CHECK(watch_moment(watch, begin));
    watch_pass();
    CHECK_INT(srv_watch_busy(watch, 0, 0), 0);
    srv_watch_phase(watch, &pair.watched, SRV_WATCH_SENDING, 0);
    watch_pass();
    CHECK_INT(srv_watch_busy(watch, 0, 0), 1);
    begin = test_clock();
    srv_watch_phase(watch, &pair.watched, SRV_WATCH_IDLE, 0);
    CHECK(watch_moment(watch, begin));
    watch_pass();
    CHECK_INT(srv_watch_busy(watch, 0, 0), 0);
    test_client_say(&pair.client, "G");
    for (double until = test_clock() + TEST_PATIENCE;
         !srv_watch_busy(watch, 0, 0) && test_clock() < until;)
        test_sleep(0.001);
    CHECK_INT(srv_watch_busy(watch, 0, 0), 1);
    srv_watch_remove(watch, &pair.watched);
    watch_close(&pair);
}

TEST(a_drain_waits_for_idle_connections_whose_client_may_be_asking) {
    const int64_t minute = 60000000000;
    OWN(srv_watch, free) *watch;
    struct watch_pair pair;
    REQUIRE(srv_watch_new(&watch) == PEND_OK && watch_open(&pair));
    int64_t now = srv_clock_now();
    /* a new connection may be about to send a request; so may one that has sent one before, however
     * long it is silent */
    srv_watch_add(watch, &pair.watched, 0);
    watch_pass();
    CHECK_INT(srv_watch_busy(watch, now - minute, minute), 1);
    CHECK_INT(srv_watch_busy(watch, now, 0), 0);
    pair.watched.since = now - 2 * minute;
    CHECK_INT(srv_watch_busy(watch, now, minute), 0);
    srv_watch_phase(watch, &pair.watched, SRV_WATCH_IDLE, 0);
    pair.watched.since = now - 2 * minute;
    /* a browser's connection is waited for a moment after the drain began, a proxy's for the whole
     * patience */
    CHECK_INT(srv_watch_busy(watch, srv_clock_now(), minute), 1);
    CHECK_INT(srv_watch_busy(watch, now - (int64_t)SRV_WATCH_MOMENT_MS * 1000000, minute), 0);
    atomic_store(&pair.watched.relayed, 1);
    CHECK_INT(srv_watch_busy(watch, now, minute), 1);
    CHECK_INT(srv_watch_busy(watch, now - 2 * minute, minute), 0);
    CHECK_INT(srv_watch_busy(watch, now - minute, 0), 0);
    srv_watch_remove(watch, &pair.watched);
    watch_close(&pair);
}

TEST(leave_all_tells_those_that_wait_once) {
    OWN(srv_watch, free) *watch;
    struct watch_pair one, two;
    REQUIRE(srv_watch_new(&watch) == PEND_OK && watch_open(&one) && watch_open(&two));
    srv_watch_add(watch, &one.watched, 0);
    srv_watch_add(watch, &two.watched, 0);
    srv_watch_phase(watch, &one.watched, SRV_WATCH_WAITING, 0);
    srv_watch_leave_all(watch);
    srv_watch_leave_all(watch);
    CHECK_INT(one.left, 1);
    CHECK_INT(two.left, 0);
    srv_watch_remove(watch, &one.watched);
    srv_watch_remove(watch, &two.watched);
    watch_close(&one);
    watch_close(&two);
}

TEST(a_lingering_socket_reads_on_so_that_nothing_is_reset) {
    OWN(srv_watch, free) *watch;
    struct watch_pair pair;
    struct test_reply reply;
    static char rubbish[65536];
    static const char answer[] = "HTTP/1.1 413 No\r\nContent-Length: 2\r\n\r\nno";
    REQUIRE(srv_watch_new(&watch) == PEND_OK && watch_open(&pair));
    /* the client sends much, the server answers early and closes */
    for (int i = 0; i < 4; i++) test_client_send(&pair.client, rubbish, sizeof rubbish);
    CHECK(send(pair.watched.fd, answer, sizeof answer - 1, MSG_NOSIGNAL) == sizeof answer - 1);
    double begin = test_clock();
    srv_watch_linger(watch, dup(pair.watched.fd));
    close(pair.watched.fd);
    CHECK(watch_moment(watch, begin));
    int sent = 0;
    for (; sent < 100 && test_client_send(&pair.client, rubbish, sizeof rubbish); sent++) continue;
    CHECK_SAYING(sent == 100 || test_clock() > begin + 1e-3 * SRV_WATCH_LINGER_MS,
                 "%d pieces were taken", sent);
    CHECK_INT(test_client_receive(&pair.client, &reply, 0, TEST_PATIENCE), 413);
    test_reply_clear(&reply);
    test_client_close(&pair.client);
    for (double until = test_clock() + TEST_PATIENCE;
         srv_watch_busy(watch, 0, 0) && test_clock() < until;)
        test_sleep(0.005);
    CHECK_INT(srv_watch_busy(watch, 0, 0), 0);
}

TEST(a_watch_survives_want_of_memory) {
    OWN(srv_watch, free) *watch = NULL;
    test_alloc_fail(1, 0);
    CHECK(srv_watch_new(&watch) == PEND_NO_MEMORY && !watch);
    test_alloc_faults_off();
}
