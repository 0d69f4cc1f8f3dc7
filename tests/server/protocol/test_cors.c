#include "server/protocol/cors.h"

#include <stddef.h>

#include "tests/harness/test.h"

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
    /* closed routes are for listed origins, whatever the list allows for open ones */
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
        {"https://a.org:8443", NULL, "a.org", 0}, /* a proxy removed the port */
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
