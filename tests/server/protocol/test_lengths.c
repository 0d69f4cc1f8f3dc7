#include "server/protocol/lengths.h"

#include <stdio.h>

#include "tests/harness/test.h"

TEST(lengths_are_found_by_their_tags_and_no_others) {
    static struct srv_lengths lengths;
    char etag[32];
    int known = 0;
    srv_lengths_init(&lengths);
    CHECK_INT(srv_lengths_find(&lengths, "\"a\""), -1);
    CHECK_INT(srv_lengths_find(&lengths, ""), -1);
    srv_lengths_note(&lengths, "\"a\"", 7);
    srv_lengths_note(&lengths, "", 8);
    srv_lengths_note(&lengths, "\"a\"", -1);
    CHECK_INT(srv_lengths_find(&lengths, "\"a\""), 7);
    CHECK_INT(srv_lengths_find(&lengths, ""), -1);
    for (int i = 0; i < 10 * SRV_LENGTHS; i++) {
        snprintf(etag, sizeof etag, "\"%d\"", i);
        srv_lengths_note(&lengths, etag, i);
        CHECK_INT(srv_lengths_find(&lengths, etag), i);
    }
    for (int i = 0; i < 10 * SRV_LENGTHS; i++) {
        snprintf(etag, sizeof etag, "\"%d\"", i);
        long long found = srv_lengths_find(&lengths, etag);
        CHECK(found == i || found == -1);
        known += found == i;
    }
    CHECK(known > SRV_LENGTHS / 4 && known <= SRV_LENGTHS);
    srv_lengths_clear(&lengths);
}
