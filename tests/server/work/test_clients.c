#include "server/work/clients.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"

TEST(a_client_is_one_record_however_often_it_comes) {
    OWN(srv_clients, free) *clients;
    REQUIRE(srv_clients_new(&clients) == PEND_OK);
    struct srv_client *one = srv_clients_take(clients, "192.0.2.1", NULL),
                      *again = srv_clients_take(clients, "192.0.2.1", NULL),
                      *other = srv_clients_take(clients, "192.0.2.2", NULL);
    CHECK(one && one == again && one != other);
    srv_clients_share(clients, one);
    for (int i = 0; i < 3; i++) srv_clients_give(clients, one);
    srv_clients_give(clients, other);
    /* a record without references is kept for a while */
    CHECK(srv_clients_take(clients, "192.0.2.1", NULL) == one);
    srv_clients_give(clients, one);
}

TEST(clients_that_nobody_has_are_forgotten_beyond_a_bound) {
    OWN(srv_clients, free) *clients;
    char key[SRV_CLIENT_KEY];
    int64_t second = 1000000000;
    REQUIRE(srv_clients_new(&clients) == PEND_OK);
    struct srv_client *held = srv_clients_take(clients, "held", NULL);
    CHECK(srv_clients_quota(clients, held, 60, 64, second).left == 59);
    for (int i = 0; i < 3 * SRV_CLIENTS_KEPT; i++) {
        snprintf(key, sizeof key, "client %d", i);
        struct srv_client *client = srv_clients_take(clients, key, NULL);
        if (!CHECK(client != NULL)) break;
        srv_clients_quota(clients, client, 60, 64, second);
        srv_clients_give(clients, client);
    }
    /* the one in use still exists, the last is known, the first is not */
    CHECK(srv_clients_take(clients, "held", NULL) == held);
    CHECK(srv_clients_quota(clients, held, 60, 64, second).left == 58);
    struct srv_client *last = srv_clients_take(clients, key, NULL),
                      *first = srv_clients_take(clients, "client 0", NULL);
    CHECK(srv_clients_quota(clients, last, 60, 64, second).left == 58);
    CHECK(srv_clients_quota(clients, first, 60, 64, second).left == 59);
    srv_clients_give(clients, last);
    srv_clients_give(clients, first);
    srv_clients_give(clients, held);
    srv_clients_give(clients, held);
}

TEST(a_quota_is_so_many_a_minute_and_fills_evenly) {
    OWN(srv_clients, free) *clients;
    int64_t second = 1000000000, now = 5 * second;
    REQUIRE(srv_clients_new(&clients) == PEND_OK);
    struct srv_client *client = srv_clients_take(clients, "a", NULL);
    struct srv_quota quota;
    for (int i = 0; i < 6; i++) {
        quota = srv_clients_quota(clients, client, 6, 64, now);
        CHECK(quota.granted && quota.left == 5 - i);
    }
    CHECK(fabs(quota.refresh - 60) < 1e-6);
    quota = srv_clients_quota(clients, client, 6, 64, now);
    CHECK(!quota.granted);
    CHECK(fabs(quota.retry - 10) < 1e-6);
    /* asking too early costs nothing, and one is added every ten seconds */
    quota = srv_clients_quota(clients, client, 6, 64, now + 9 * second);
    CHECK(!quota.granted);
    CHECK(fabs(quota.retry - 1) < 1e-6);
    CHECK(srv_clients_quota(clients, client, 6, 64, now + 11 * second).granted);
    CHECK(!srv_clients_quota(clients, client, 6, 64, now + 11 * second).granted);
    /* never more than those of a minute */
    now += 1000 * second;
    for (int i = 0; i < 6; i++) CHECK(srv_clients_quota(clients, client, 6, 64, now).granted);
    CHECK(!srv_clients_quota(clients, client, 6, 64, now).granted);
    srv_clients_give(clients, client);
}

TEST(clients_survive_want_of_memory) {
    OWN(srv_clients, free) *clients = NULL;
    test_alloc_fail(1, 0);
    CHECK(srv_clients_new(&clients) == PEND_NO_MEMORY && !clients);
    test_alloc_faults_off();
    REQUIRE(srv_clients_new(&clients) == PEND_OK);
    test_alloc_fail(1, 0);
    CHECK(!srv_clients_take(clients, "a", NULL));
    test_alloc_faults_off();
    struct srv_client *client = srv_clients_take(clients, "a", NULL);
    CHECK(client != NULL);
    srv_clients_give(clients, client);
}

/* a new token for each request does not exceed the quota of its address: here twice that of a
 * client */
TEST(clients_of_one_address_share_its_quota) {
    OWN(srv_clients, free) *clients;
    struct srv_quota quota;
    int64_t now = 5000000000;
    char key[16];
    int granted = 0;
    REQUIRE(srv_clients_new(&clients) == PEND_OK);
    for (int i = 0; i < 40; i++) {
        snprintf(key, sizeof key, "t:%d", i);
        struct srv_client *client = srv_clients_take(clients, key, "n:home");
        REQUIRE(client && client->source != client);
        quota = srv_clients_quota(clients, client, 6, 2, now);
        granted += quota.granted;
        srv_clients_give(clients, client);
    }
    CHECK_INT(granted, 12);
    CHECK_SAYING(fabs(quota.retry - 5) < 1e-6, "%g", quota.retry);
    struct srv_client *other = srv_clients_take(clients, "t:0", "n:school");
    CHECK(srv_clients_quota(clients, other, 6, 2, now).granted);
    srv_clients_give(clients, other);
    /* one of them has its own limit as well, and the address that of one more client */
    now += 60000000000;
    struct srv_client *one = srv_clients_take(clients, "t:1", "n:home"),
                      *same = srv_clients_take(clients, "t:1", "n:school"),
                      *home = srv_clients_take(clients, "n:home", "n:home");
    CHECK(one == same && one->source == home && home->source == home);
    for (int i = 0; i < 7; i++)
        CHECK_INT(srv_clients_quota(clients, one, 6, 2, now).granted, i < 6);
    for (int i = 0; i < 7; i++)
        CHECK_INT(srv_clients_quota(clients, home, 6, 2, now).granted, i < 6);
    srv_clients_give(clients, one);
    srv_clients_give(clients, same);
    srv_clients_give(clients, home);
}

TEST(who_has_computed_too_much_waits_until_it_is_made_up_for) {
    OWN(srv_clients, free) *clients;
    int64_t second = 1000000000, now = 5 * second;
    REQUIRE(srv_clients_new(&clients) == PEND_OK);
    struct srv_client *client = srv_clients_take(clients, "a", NULL);
    srv_clients_charge(clients, client, 1e9);
    /* 30 s per minute: a computation that starts while some are left may take more */
    CHECK(srv_clients_debt(clients, client, 30, now) == 0);
    srv_clients_charge(clients, client, 29);
    CHECK(srv_clients_debt(clients, client, 30, now) == 0);
    srv_clients_charge(clients, client, 11);
    double wait = srv_clients_debt(clients, client, 30, now);
    CHECK_SAYING(wait > 20 && wait < 20.01, "%.15g s", wait);
    CHECK(srv_clients_debt(clients, client, 30, now + 19 * second) > 0);
    CHECK(srv_clients_debt(clients, client, 30, now + 21 * second) == 0);
    /* a client that may compute nothing always waits */
    CHECK(srv_clients_debt(clients, client, 0, now + 22 * second) == 60);
    srv_clients_give(clients, client);
}

TEST(what_comes_at_a_pace_comes_in_bursts_and_then_one_by_one) {
    OWN(srv_clients, free) *clients;
    const int64_t second = 1000000000;
    REQUIRE(srv_clients_new(&clients) == PEND_OK);
    struct srv_client *one = srv_clients_take(clients, "t:1", "a:1"),
                      *other = srv_clients_take(clients, "t:2", "a:1");
    REQUIRE(one && other && one->source == other->source);
    int64_t now = 1000 * second;
    for (int i = 0; i < 3; i++)
        CHECK(srv_clients_pace(clients, one, SRV_PACE_WRITES, 2, 3, 1, now) <= 0);
    double wait = srv_clients_pace(clients, one, SRV_PACE_WRITES, 2, 3, 1, now);
    CHECK_SAYING(wait > 0.49 && wait < 0.51, "%g s", wait);
    /* another client, another action and a mere check take nothing of it */
    CHECK(srv_clients_pace(clients, other, SRV_PACE_WRITES, 2, 3, 1, now) <= 0);
    CHECK(srv_clients_pace(clients, one, SRV_PACE_JOINS, 2, 3, 1, now) <= 0);
    now += second / 2;
    for (int i = 0; i < 2; i++)
        CHECK(srv_clients_pace(clients, one, SRV_PACE_WRITES, 2, 3, 0, now) <= 0);
    CHECK(srv_clients_pace(clients, one, SRV_PACE_WRITES, 2, 3, 1, now) <= 0);
    CHECK(srv_clients_pace(clients, one, SRV_PACE_WRITES, 2, 3, 1, now) > 0);
    /* after a long pause the full burst is available */
    now += 3600 * second;
    for (int i = 0; i < 3; i++)
        CHECK(srv_clients_pace(clients, one, SRV_PACE_WRITES, 2, 3, 1, now) <= 0);
    CHECK(srv_clients_pace(clients, one, SRV_PACE_WRITES, 2, 3, 1, now) > 0);
    /* a limit of the address applies to all of its clients */
    CHECK(srv_clients_pace(clients, one->source, SRV_PACE_MISSES, 1, 1, 1, now) <= 0);
    CHECK(srv_clients_pace(clients, other->source, SRV_PACE_MISSES, 1, 1, 1, now) > 0);
    srv_clients_give(clients, one);
    srv_clients_give(clients, other);
}
