#include "server/config/hosts.h"

#include <string.h>

#include "tests/harness/test.h"

TEST(lists_of_hosts_are_checked) {
    static const char *const good[] = {"*", "auto", "a.org", "a.org, *.b.org:8080,[::1]",
                                       "192.0.2.1"};
    static const char *const bad[] = {"a.org,,b.org", "a b", "http://a.org", "a.org:port",
                                      "*.*.org"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        CHECK_SAYING(srv_hosts_good(good[i]), "%s is refused", good[i]);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        CHECK_SAYING(!srv_hosts_good(bad[i]), "%s is accepted", bad[i]);
}

TEST(a_host_is_allowed_by_its_whole_name) {
    static const struct {
        const char *list, *host;
        int allowed;
    } row[] = {
        {"a.org", "a.org", 1},        {"a.org", "A.ORG.", 1},
        {"a.org", "a.org:8080", 1},   {"a.org:80", "a.org:8080", 0},
        {"a.org", "evil-a.org", 0},   {"a.org", "a.org.evil", 0},
        {"*.a.org", "b.a.org", 1},    {"*.a.org", "a.org", 0},
        {"*.a.org", "b.xa.org", 0},   {"[::1]", "[::1]:8080", 1},
        {"a.org, b.org", "b.org", 1}, {"*", "anything", 1},
        {"a.org", NULL, 1},           {"a.org", "", 1},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++)
        CHECK_SAYING(srv_hosts_allow(row[i].list, row[i].host) == row[i].allowed, "%s by %s",
                     row[i].host ? row[i].host : "no host", row[i].list);
}

TEST(auto_allows_loopbacks_names_where_only_this_machine_reaches_the_server) {
    const char *own = srv_hosts_mean("auto", "127.0.0.1:8080", 0);
    CHECK(srv_hosts_allow(own, "localhost:8080") && srv_hosts_allow(own, "127.0.0.1:8080"));
    CHECK(!srv_hosts_allow(own, "evil.org"));
    CHECK_TEXT(srv_hosts_mean("auto", "127.0.0.1:8080", 1), "*");
    CHECK_TEXT(srv_hosts_mean("auto", "*:8080", 0), "*");
    CHECK_TEXT(srv_hosts_mean("a.org", "127.0.0.1:8080", 0), "a.org");
}

TEST(an_address_is_no_name) {
    CHECK(srv_hosts_numeric("127.0.0.1:80") && srv_hosts_numeric("[::1]:80"));
    CHECK(srv_hosts_numeric("192.0.2.1") && !srv_hosts_numeric("a.org"));
    CHECK(!srv_hosts_numeric("1.2.3.4.org"));
}
