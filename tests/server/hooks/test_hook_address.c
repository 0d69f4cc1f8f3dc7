/* Tests of server/hooks/hook_address: blocks of addresses, each at its ends. */
#include "server/hooks/hook_address.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <sys/socket.h>
#include <sys/un.h>

#include "tests/harness/test.h"

TEST(webhooks_go_to_the_public_internet_and_nowhere_else) {
    static const char *const may[] = {
        "1.1.1.1",          "9.255.255.255",        "11.0.0.0",     "100.63.255.255",
        "100.128.0.0",      "126.255.255.255",      "128.0.0.0",    "169.253.255.255",
        "169.255.0.0",      "172.15.255.255",       "172.32.0.0",   "192.167.255.255",
        "192.169.0.0",      "198.17.255.255",       "198.20.0.0",   "223.255.255.255",
        "2606:4700::1111",  "2001:4860:4860::8888", "2a00:1450::1", "::ffff:1.1.1.1",
        "64:ff9b::101:101", "2002:101:101::1"};
    static const char *const may_not[] = {"0.0.0.0",
                                          "0.255.255.255",
                                          "10.0.0.0",
                                          "10.255.255.255",
                                          "100.64.0.0",
                                          "100.127.255.255",
                                          "127.0.0.1",
                                          "127.255.255.255",
                                          "169.254.0.0",
                                          "169.254.169.254",
                                          "172.16.0.0",
                                          "172.31.255.255",
                                          "192.0.0.1",
                                          "192.0.2.1",
                                          "192.88.99.1",
                                          "192.168.0.0",
                                          "192.168.255.255",
                                          "198.18.0.0",
                                          "198.19.255.255",
                                          "198.51.100.1",
                                          "203.0.113.1",
                                          "224.0.0.1",
                                          "240.0.0.1",
                                          "255.255.255.255",
                                          "::",
                                          "::1",
                                          "fc00::1",
                                          "fdff::1",
                                          "fe80::1",
                                          "fec0::1",
                                          "ff02::1",
                                          "::ffff:127.0.0.1",
                                          "::ffff:10.0.0.1",
                                          "64:ff9b::a00:1",
                                          "64:ff9b:1::1",
                                          "2002:a00:1::1",
                                          "2002:7f00:1::1",
                                          "2001::1",
                                          "2001:db8::1",
                                          "3fff::1",
                                          "::127.0.0.1",
                                          "5f00::1",
                                          "100::1"};
    struct srv_peers none;
    struct pend_error error;
    REQUIRE(srv_hook_networks(&none, "none", &error) == PEND_OK);
    for (size_t i = 0; i < sizeof may / sizeof *may; i++)
        CHECK_SAYING(srv_hook_host_may(may[i], &none), "%s", may[i]);
    for (size_t i = 0; i < sizeof may_not / sizeof *may_not; i++)
        CHECK_SAYING(!srv_hook_host_may(may_not[i], &none), "%s", may_not[i]);
    /* a name is judged by its addresses, once it is looked up */
    CHECK(srv_hook_host_may("localhost", &none));
}

TEST(networks_that_are_named_are_allowed_besides) {
    const struct sockaddr_un path = {.sun_family = AF_UNIX};
    struct srv_peers some, bad;
    struct pend_error error;
    REQUIRE(srv_hook_networks(&some, "10.1.0.0/16, fd00:1::/32", &error) == PEND_OK);
    CHECK(srv_hook_host_may("10.1.2.3", &some) && srv_hook_host_may("::ffff:10.1.2.3", &some));
    CHECK(srv_hook_host_may("fd00:1::5", &some) && srv_hook_host_may("1.1.1.1", &some));
    CHECK(!srv_hook_host_may("10.2.0.0", &some) && !srv_hook_host_may("127.0.0.1", &some));
    CHECK(!srv_hook_address_may((const struct sockaddr *)&path, &some));
    CHECK(srv_hook_networks(&bad, "unix", &error) == PEND_INVALID);
    CHECK(srv_hook_networks(&bad, "10.0.0.0/33", &error) == PEND_INVALID);
}
