/* Tests of server/store/store_postgres in addition to those that run on each store: its
 * messages. */
#include <string.h>

#include "server/store/store.h"
#include "tests/harness/test.h"

TEST(a_malformed_url_is_refused_without_a_piece_of_its_password) {
    static const char *const urls[] = {
        "postgresql://user:S3cret%zzWord@host/db",
        "postgresql://user:S3cretWord@[host/db",
        "postgresql://user:S3cretWord@host/db?S3cretWord",
        "postgresql://user:S3cretWord@host/db?password=S3cret=Word",
        "postgresql://user@host/db?password=S3cret%0gWord",
        "postgresql://user:S3cretWord@host:x y/db?connect_timeout",
    };
    for (size_t i = 0; i < sizeof urls / sizeof *urls; i++) {
        const struct srv_store_rules rules = {.client_jobs = 1};
        struct srv_store *store;
        struct pend_error error = {.text = ""};
        CHECK_INT(srv_store_open(&store, urls[i], &rules, &error), PEND_INVALID);
        CHECK_SAYING(!strstr(error.text, "S3cret") && !strstr(error.text, "Word"), "%s: %s",
                     urls[i], error.text);
        CHECK_SAYING(strstr(error.text, "url of the database") != NULL, "%s", error.text);
    }
}
