#include "server/protocol/peer.h"

#include <string.h>

#include "tests/harness/test.h"

TEST(only_a_trusted_proxy_is_believed) {
    static const struct {
        const char *trusted, *peer, *header, *value, *client;
    } told[] = {
        {"none", "10.0.0.1", "X-Forwarded-For", "1.2.3.4", "10.0.0.1"},
        {"10.0.0.0/8", "10.0.0.1", "X-Forwarded-For", NULL, "10.0.0.1"},
        {"10.0.0.0/8", "10.0.0.1", "X-Forwarded-For", "1.2.3.4", "1.2.3.4"},
        {"10.0.0.0/8", "11.0.0.1", "X-Forwarded-For", "1.2.3.4", "11.0.0.1"},
        {"10.0.0.0/8", "::ffff:10.0.0.1", "X-Forwarded-For", "1.2.3.4", "1.2.3.4"},
        /* a client may have written anything before the proxy appended the address that it saw */
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
    /* a list of many trusted hops ends at the first untrusted one */
    char value[2000] = "7.7.7.7";
    for (int i = 0; i < 150; i++) strcat(value, ",10.0.0.1");
    REQUIRE(srv_peers_read(&peers, "10.0.0.0/8", &error) == PEND_OK);
    srv_peer_client(&peers, "10.0.0.1", "X-Forwarded-For", value, client);
    CHECK_TEXT(client, "10.0.0.1");
}

TEST(an_address_that_is_to_name_nobody_is_cut) {
    static const char *const pair[][2] = {{"192.0.2.77", "192.0.2.0"},
                                          {"::ffff:192.0.2.77", "192.0.2.0"},
                                          {"2001:db8:1:2:3:4:5:6", "2001:db8:1::"},
                                          {"::1", "::"},
                                          {"fe80::1%eth0", ""},
                                          {"account:0123", ""},
                                          {"", ""}};
    char shown[SRV_PEER_BYTES];
    for (size_t i = 0; i < sizeof pair / sizeof *pair; i++) {
        srv_peer_shorten(pair[i][0], shown);
        CHECK_TEXT(shown, pair[i][1]);
    }
}
