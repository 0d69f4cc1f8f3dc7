/* Tests of server/work/clients, server/protocol/peer and server/protocol/cors: how often
 * somebody asks, and through whom. */
#include "server/work/clients.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "server/protocol/cors.h"
#include "server/protocol/peer.h"
#include "tests/harness/test.h"

TEST(a_client_is_one_record_however_often_it_comes) {
    struct srv_clients *clients;
    REQUIRE(srv_clients_new(&clients) == PEND_OK);
    struct srv_client *one = srv_clients_take(clients, "192.0.2.1", NULL),
                      *again = srv_clients_take(clients, "192.0.2.1", NULL),
                      *other = srv_clients_take(clients, "192.0.2.2", NULL);
    CHECK(one && one == again && one != other);
    srv_clients_share(clients, one);
    for (int i = 0; i < 3; i++) srv_clients_give(clients, one);
    srv_clients_give(clients, other);
    /* what nobody has is still known for a while */
    CHECK(srv_clients_take(clients, "192.0.2.1", NULL) == one);
    srv_clients_give(clients, one);
    srv_clients_free(&clients);
}

TEST(clients_that_nobody_has_are_forgotten_beyond_a_bound) {
    struct srv_clients *clients;
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
    /* the one that is in use is there still, the last is known, the first is not */
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
    srv_clients_free(&clients);
}

TEST(a_quota_is_so_many_a_minute_and_fills_evenly) {
    struct srv_clients *clients;
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
    /* asking too early costs nothing, and one comes every ten seconds */
    quota = srv_clients_quota(clients, client, 6, 64, now + 9 * second);
    CHECK(!quota.granted);
    CHECK(fabs(quota.retry - 1) < 1e-6);
    CHECK(srv_clients_quota(clients, client, 6, 64, now + 11 * second).granted);
    CHECK(!srv_clients_quota(clients, client, 6, 64, now + 11 * second).granted);
    /* never more than a minute's */
    now += 1000 * second;
    for (int i = 0; i < 6; i++) CHECK(srv_clients_quota(clients, client, 6, 64, now).granted);
    CHECK(!srv_clients_quota(clients, client, 6, 64, now).granted);
    srv_clients_give(clients, client);
    srv_clients_free(&clients);
}

TEST(clients_survive_want_of_memory) {
    struct srv_clients *clients = NULL;
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
    srv_clients_free(&clients);
}

/* who draws a token for each request has no more than its address: here twice what a client has */
TEST(clients_of_one_address_share_its_quota) {
    struct srv_clients *clients;
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
    /* one of them has its own bound as well, and the address itself one more client's */
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
    srv_clients_free(&clients);
}

TEST(only_a_trusted_proxy_is_believed) {
    static const struct {
        const char *trusted, *peer, *header, *value, *client;
    } told[] = {
        {"none", "10.0.0.1", "X-Forwarded-For", "1.2.3.4", "10.0.0.1"},
        {"10.0.0.0/8", "10.0.0.1", "X-Forwarded-For", NULL, "10.0.0.1"},
        {"10.0.0.0/8", "10.0.0.1", "X-Forwarded-For", "1.2.3.4", "1.2.3.4"},
        {"10.0.0.0/8", "11.0.0.1", "X-Forwarded-For", "1.2.3.4", "11.0.0.1"},
        {"10.0.0.0/8", "::ffff:10.0.0.1", "X-Forwarded-For", "1.2.3.4", "1.2.3.4"},
        /* a client may have written what it likes before the proxy added whom it saw */
        {"10.0.0.0/8", "10.0.0.1", "X-Forwarded-For", "6.6.6.6, 1.2.3.4", "1.2.3.4"},
        {"10.0.0.0/8", "10.0.0.1", "X-Forwarded-For", "6.6.6.6, 1.2.3.4 ,10.3.3.3", "1.2.3.4"},
        {"10.0.0.0/8", "10.0.0.1", "X-Forwarded-For", "10.9.9.9", "10.9.9.9"},
        {"10.0.0.0/8", "10.0.0.1", "X-Forwarded-For", "1.2.3.4:5555", "1.2.3.4"},
        {"10.0.0.0/8", "10.0.0.1", "X-Forwarded-For", "rubbish", "10.0.0.1"},
        {"10.0.0.0/8", "10.0.0.1", "X-Forwarded-For", "1.2.3.4, unknown", "10.0.0.1"},
        {"10.0.0.0/8", "10.0.0.1", "X-Forwarded-For", ",,", "10.0.0.1"},
        {"::1, 10.0.0.0/8", "::1", "X-Forwarded-For", "[2001:db8::1]:80", "2001:db8::1"},
        {"fd00::/8", "fd12::1", "x-forwarded-for", "2001:db8::1", "2001:db8::1"},
        {"10.0.0.0/9", "10.128.0.1", "X-Forwarded-For", "1.2.3.4", "10.128.0.1"},
        {"10.0.0.0/9", "10.127.0.1", "X-Forwarded-For", "1.2.3.4", "1.2.3.4"},
        {"0.0.0.0/0", "9.9.9.9", "X-Forwarded-For", "1.2.3.4", "1.2.3.4"},
        {"127.0.0.1", "127.0.0.1", "Forwarded", "for=1.2.3.4;proto=http, for=\"[2001:db8::7]:99\"",
         "2001:db8::7"},
        {"127.0.0.1", "127.0.0.1", "Forwarded", "proto=https;For=1.2.3.4", "1.2.3.4"},
        {"127.0.0.1", "127.0.0.1", "Forwarded", "by=1.2.3.4", "127.0.0.1"},
        {"127.0.0.1", "127.0.0.1", "X-Api-Key", "1.2.3.4", "127.0.0.1"},
    };
    static const char *const wrong[] = {"x",          "10.0.0.0/33",  "::/129", "10.0.0.0/-1",
                                        "1.2.3.4/8x", "1.2.3.4,,::1", "/8",     "none,::1"};
    struct srv_peers peers;
    struct pend_error error;
    char client[SRV_PEER_BYTES];
    for (size_t i = 0; i < sizeof told / sizeof *told; i++) {
        if (!CHECK_SAYING(srv_peers_read(&peers, told[i].trusted, &error) == PEND_OK, "%s",
                          error.text))
            continue;
        srv_peer_client(&peers, told[i].peer, told[i].header, told[i].value, client);
        CHECK_SAYING(!strcmp(client, told[i].client), "row %zu: %s", i, client);
    }
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        CHECK_SAYING(srv_peers_read(&peers, wrong[i], &error) == PEND_INVALID, "%s is accepted",
                     wrong[i]);
    /* a list of many trusted hops ends at the first that is not */
    char value[2000] = "7.7.7.7";
    for (int i = 0; i < 150; i++) strcat(value, ",10.0.0.1");
    REQUIRE(srv_peers_read(&peers, "10.0.0.0/8", &error) == PEND_OK);
    srv_peer_client(&peers, "10.0.0.1", "X-Forwarded-For", value, client);
    CHECK_TEXT(client, "10.0.0.1");
}

TEST(origins_are_compared_whole) {
    static const char list[] = "https://a.org,  http://localhost:8000";
    CHECK_TEXT(srv_cors_origin("*", NULL, 0), "*");
    CHECK_TEXT(srv_cors_origin("*", "https://evil.org", 0), "*");
    CHECK(!srv_cors_origin("none", "https://a.org", 0));
    CHECK_TEXT(srv_cors_origin(list, "https://a.org", 0), "https://a.org");
    CHECK_TEXT(srv_cors_origin(list, "http://localhost:8000", 0), "http://localhost:8000");
    CHECK(!srv_cors_origin(list, "http://localhost:80", 0) &&
          !srv_cors_origin(list, "https://a.org.evil.org", 0));
    CHECK(!srv_cors_origin(list, NULL, 0) && !srv_cors_origin(list, "", 0));
    /* what is closed is for those that are listed, whoever else may read what is open */
    CHECK(!srv_cors_origin("*", "https://a.org", 1) && !srv_cors_origin("*", "*", 1) &&
          !srv_cors_origin(list, "*", 1));
    CHECK_TEXT(srv_cors_origin("*, https://a.org", "https://a.org", 1), "https://a.org");
    CHECK_TEXT(srv_cors_origin("*, https://a.org", "https://a.org", 0), "*");
    CHECK(!srv_cors_origin("*, https://a.org", "https://b.org", 1));
    CHECK(srv_cors_varies(list) && !srv_cors_varies("*") && !srv_cors_varies("none"));
}

TEST(a_page_of_the_server_is_not_foreign) {
    static const struct {
        const char *origin, *site, *host;
        int foreign;
    } row[] = {
        {NULL, NULL, "a.org", 0},
        {"https://a.org", NULL, "a.org", 0},
        {"https://a.org:8443", NULL, "a.org", 0}, /* a proxy took the port off */
        {"https://a.org:8443", NULL, "a.org:8443", 0},
        {"https://A.org", NULL, "a.org", 0},
        {"http://[::1]:8080", NULL, "[::1]:8080", 0},
        {"http://[::1]:8080", NULL, "[::1]", 0},
        {"https://a.org:8443", NULL, "a.org:8444", 1},
        {"https://a.org", NULL, "a.org:8443", 1},
        {"https://a.org.evil", NULL, "a.org", 1},
        {"https://evil.org", NULL, "a.org", 1},
        {"https://evil.org", NULL, NULL, 1},
        {"null", NULL, "null", 1},
        {"https://evil.org", "cross-site", "evil.org", 1},
        {"https://evil.org", "same-site", "a.org", 1},
        {"https://a.org", "same-origin", "upstream", 0},
        {"https://good.org", "cross-site", "a.org", 0}, /* listed */
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++)
        CHECK_SAYING(srv_cors_foreign("*, https://good.org", row[i].origin, row[i].site,
                                      row[i].host) == row[i].foreign,
                     "row %zu", i);
}
