/* Tests of server/keys/role: limits of roles, read and written. */
#include "server/keys/role.h"

#include <math.h>
#include <string.h>

#include "tests/harness/test.h"

TEST(every_role_has_a_word_by_which_it_is_found) {
    for (int role = SRV_ROLE_ANONYMOUS; role < SRV_ROLE_COUNT; role++) {
        const char *word = srv_role_word((enum srv_role)role);
        CHECK_INT(srv_role_of(word, strlen(word)), role);
        CHECK_INT(srv_role_of(word, strlen(word) - 1), SRV_ROLE_NONE);
        struct srv_limits limits = srv_role_limits((enum srv_role)role);
        for (int i = 0; i < SRV_LIMIT_COUNT; i++)
            CHECK_SAYING(limits.value[i] >= 0, "%s, limit %d", word, i);
    }
    CHECK_INT(srv_role_of("", 0), SRV_ROLE_NONE);
    CHECK_INT(srv_role_of("Pupil", 5), SRV_ROLE_NONE);
    CHECK_TEXT(srv_role_word(SRV_ROLE_NONE), "");
    /* anonymous clients and pupils post no jobs */
    CHECK(srv_role_limits(SRV_ROLE_PUPIL).value[SRV_LIMIT_JOBS] == 0);
    CHECK(srv_role_limits(SRV_ROLE_ANONYMOUS).value[SRV_LIMIT_JOBS] == 0);
    CHECK(isinf(srv_role_limits(SRV_ROLE_NONE).value[SRV_LIMIT_JOBS]));
}

TEST(limits_that_are_written_are_read_as_they_were) {
    static const char *const good[] = {"requests=0.5", "compute=none", "memory=64M", "bytes=2G",
                                       "jobs=0",       "priority=3",   "rooms=0"};
    static const double want[SRV_LIMIT_COUNT] = {0.5, INFINITY, 67108864, 2147483648.0, 0, 3, 0};
    struct srv_limits limits, again;
    char text[SRV_LIMITS_TEXT], *rest = text;
    srv_limits_unset(&limits);
    srv_limits_write(&limits, text);
    CHECK_TEXT(text, "");
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        CHECK_SAYING(srv_limits_read(&limits, good[i], NULL) == PEND_OK, "%s", good[i]);
    srv_limits_write(&limits, text);
    CHECK_TEXT(text, " requests=0.5 compute=none memory=67108864 bytes=2147483648 jobs=0 "
                     "priority=3 rooms=0");
    srv_limits_unset(&again);
    for (char *one; (one = strsep(&rest, " "));)
        if (*one) CHECK_SAYING(srv_limits_read(&again, one, NULL) == PEND_OK, "%s", one);
    for (int i = 0; i < SRV_LIMIT_COUNT; i++)
        CHECK(limits.value[i] == want[i] && again.value[i] == want[i]);
}

TEST(a_limit_that_is_none_is_refused_and_changes_nothing) {
    char texts[] =
        ";requests;requests=;requests=-1;requests=1e3;requests=5x;requests=inf;requests=nan;"
        "requests=99999;jobs=1.5;jobs=1K;memory=1K;memory=64MB;memory=64 M;priority=4;"
        "priority=none;priority=0.5;rooms=0.5;compute=99999999;job=1;jobs =1;requests=.5;"
        "requests=0x10;bytes=99999999999999999999";
    char *rest = texts;
    struct srv_limits limits;
    struct pend_error error;
    srv_limits_unset(&limits);
    for (char *bad; (bad = strsep(&rest, ";"));) {
        error.text[0] = 0;
        CHECK_SAYING(srv_limits_read(&limits, bad, &error) == PEND_INVALID, "%s", bad);
        CHECK_SAYING(strlen(error.text) > 20, "%s: %s", bad, error.text);
    }
    for (int i = 0; i < SRV_LIMIT_COUNT; i++) CHECK(limits.value[i] == SRV_LIMIT_UNSET);
}

TEST(what_is_unset_is_the_others) {
    struct srv_limits own, role = srv_role_limits(SRV_ROLE_TEACHER);
    srv_limits_unset(&own);
    own.value[SRV_LIMIT_JOBS] = 0;
    struct srv_limits both = srv_limits_over(&own, &role);
    CHECK(both.value[SRV_LIMIT_JOBS] == 0 && role.value[SRV_LIMIT_JOBS] == 100);
    CHECK(both.value[SRV_LIMIT_COMPUTE] == role.value[SRV_LIMIT_COMPUTE]);
}
