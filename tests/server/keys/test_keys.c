/* Tests of server/keys/keys: generating keys, their table, its text. */
#include "server/keys/keys.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "tests/harness/test.h"

TEST(a_key_is_whole_and_any_other_letter_makes_it_broken) {
    char token[SRV_KEY_TOKEN], other[SRV_KEY_TOKEN];
    REQUIRE(srv_keys_draw(token) && srv_keys_draw(other));
    CHECK(strcmp(token, other) != 0);
    CHECK(srv_keys_meant(token) && srv_keys_whole(token));
    CHECK_INT(strlen(token), SRV_KEY_TOKEN - 1);
    for (size_t i = 0; i < strlen(token); i++) {
        memcpy(other, token, sizeof other);
        other[i] = other[i] == 'a' ? 'b' : 'a';
        CHECK_SAYING(!srv_keys_whole(other), "%zu: %s", i, other);
        memcpy(other, token, sizeof other);
        other[i] = 0;
        CHECK_SAYING(!srv_keys_whole(other), "cut at %zu", i);
    }
    char longer[SRV_KEY_TOKEN + 1];
    snprintf(longer, sizeof longer, "%sa", token);
    CHECK(!srv_keys_whole(longer) && srv_keys_meant(longer));
    CHECK(!srv_keys_meant("PDK_") && !srv_keys_meant("") && srv_keys_meant("pdk_"));
}

static struct srv_key made(const char *name, enum srv_role role, const char *token) {
    struct srv_key key = {.role = role, .made = 1700000000};
    snprintf(key.name, sizeof key.name, "%s", name);
    srv_keys_digest(token, key.digest);
    srv_limits_unset(&key.limits);
    return key;
}

TEST(a_key_is_found_by_its_digest_wherever_it_stands) {
    enum { KEYS = 300 };
    struct srv_keys keys;
    static char token[KEYS][SRV_KEY_TOKEN];
    char digest[API_DIGEST_BYTES], name[SRV_KEY_NAME], none[SRV_KEY_TOKEN];
    srv_keys_init(&keys);
    for (int i = 0; i < KEYS; i++) {
        REQUIRE(srv_keys_draw(token[i]));
        snprintf(name, sizeof name, "key-%d", i);
        struct srv_key key = made(name, SRV_ROLE_PUPIL, token[i]);
        REQUIRE(srv_keys_add(&keys, &key, NULL) == PEND_OK);
    }
    for (int i = 0; i < KEYS; i++) {
        srv_keys_digest(token[i], digest);
        CHECK(srv_keys_find(&keys, digest) == &keys.key[i]);
        /* any changed digit gives another key */
        digest[i % 64] = digest[i % 64] == '0' ? '1' : '0';
        CHECK(srv_keys_find(&keys, digest) == NULL);
    }
    REQUIRE(srv_keys_draw(none));
    srv_keys_digest(none, digest);
    CHECK(srv_keys_find(&keys, digest) == NULL);
    srv_keys_clear(&keys);
    CHECK(srv_keys_find(&keys, digest) == NULL);
}

TEST(names_roles_and_digests_are_looked_at_when_a_key_is_added) {
    static const char *const bad[] = {
        "", "a b", "j\xc3\xb6rg", "a/b", "-a", "a\n", "0123456789012345678901234567890123"};
    OWN(srv_keys, clear) keys;
    struct pend_error error;
    srv_keys_init(&keys);
    struct srv_key key = made("lab", SRV_ROLE_BATCH, "pdk_1");
    CHECK_INT(srv_keys_add(&keys, &key, &error), PEND_OK);
    CHECK_INT(srv_keys_add(&keys, &key, &error), PEND_INVALID);
    CHECK_SAYING(strstr(error.text, "twice") != NULL, "%s", error.text);
    key = made("lab", SRV_ROLE_PUPIL, "pdk_2");
    CHECK_INT(srv_keys_add(&keys, &key, &error), PEND_INVALID);
    CHECK_SAYING(strstr(error.text, "one role") != NULL, "%s", error.text);
    key = made("lab", SRV_ROLE_BATCH, "pdk_2");
    CHECK_INT(srv_keys_add(&keys, &key, &error), PEND_OK);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        CHECK_SAYING(!srv_keys_named(bad[i]), "%s", bad[i]);
    char id[SRV_KEY_ID + 1];
    snprintf(id, sizeof id, "%.*s", SRV_KEY_ID, key.digest);
    CHECK(srv_keys_means(&keys.key[1], id) && srv_keys_means(&keys.key[1], "lab"));
    CHECK(!srv_keys_means(&keys.key[0], id) && !srv_keys_means(&keys.key[1], "la"));
}

#define DIGEST "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef"

TEST(a_table_that_is_written_is_read_as_it_was) {
    static const char text[] =
        "# a comment\n\n"
        "role pupil requests=2 compute=none\n"
        "\trole  anonymous jobs=3\r\n"
        "key lab role=batch made=2023-11-14T22:13:20Z expires=2030-01-01T00:00:00Z "
        "revoked=2024-02-29 priority=2 jobs=5 digest=" DIGEST;
    struct srv_keys keys, again;
    OWN(api_buffer, clear) out, twice;
    struct pend_error error = {.text = ""};
    srv_keys_init(&keys);
    srv_keys_init(&again);
    api_buffer_init(&out, SRV_KEYS_BYTES);
    api_buffer_init(&twice, SRV_KEYS_BYTES);
    REQUIRE(srv_keys_read(&keys, text, strlen(text), &error) == PEND_OK);
    CHECK_INT(keys.count, 1);
    CHECK_INT(keys.key[0].made, 1700000000);
    CHECK_INT(keys.key[0].expires, 1893456000);
    CHECK_INT(keys.key[0].revoked, 1709164800);
    CHECK_INT(keys.key[0].role, SRV_ROLE_BATCH);
    struct srv_limits limits = srv_keys_limits(&keys, &keys.key[0]);
    CHECK(limits.value[SRV_LIMIT_JOBS] == 5 && limits.value[SRV_LIMIT_PRIORITY] == 2 &&
          limits.value[SRV_LIMIT_REQUESTS] == 100);
    CHECK(srv_keys_role(&keys, SRV_ROLE_PUPIL).value[SRV_LIMIT_REQUESTS] == 2);
    CHECK(srv_keys_role(&keys, SRV_ROLE_ANONYMOUS).value[SRV_LIMIT_JOBS] == 3);
    REQUIRE(srv_keys_write(&keys, &out) == PEND_OK);
    REQUIRE(srv_keys_read(&again, out.data, out.bytes, &error) == PEND_OK);
    REQUIRE(srv_keys_write(&again, &twice) == PEND_OK);
    CHECK(out.bytes == twice.bytes && !memcmp(out.data, twice.data, out.bytes));
    srv_keys_clear(&keys);
    srv_keys_clear(&again);
}

TEST(a_line_that_is_wrong_is_named) {
    static const struct {
        const char *text, *says;
    } bad[] = {
        {"\nkey\n", "line 2"},
        {"keys lab role=batch digest=" DIGEST, "line 1"},
        {"key lab role=batch", "digest="},
        {"key lab digest=" DIGEST, "role="},
        {"key lab role=anonymous digest=" DIGEST, "role"},
        {"key lab role=king digest=" DIGEST, "king"},
        {"key l\xc3\xa4"
         "b role=batch digest=" DIGEST,
         "name"},
        {"key lab role=batch digest=" DIGEST "0", "64"},
        {"key lab role=batch "
         "digest=XYZ3456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef",
         "64"},
        {"key lab role=batch made=now digest=" DIGEST, "made"},
        {"key lab role=batch expires=90d digest=" DIGEST, "expires"},
        {"key lab role=batch expires=2026-02-30 digest=" DIGEST, "expires"},
        {"key lab role=batch colour=red digest=" DIGEST, "colour"},
        {"key lab role=batch digest=" DIGEST "\nkey lib role=batch digest=" DIGEST, "twice"},
        {"role\n", "role"},
        {"role nobody jobs=1\n", "nobody"},
        {"role pupil jobs=x\n", "jobs"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        OWN(srv_keys, clear) keys;
        struct pend_error error = {.text = ""};
        srv_keys_init(&keys);
        CHECK_SAYING(srv_keys_read(&keys, bad[i].text, strlen(bad[i].text), &error) == PEND_INVALID,
                     "%s", bad[i].text);
        CHECK_SAYING(!strncmp(error.text, "line ", 5) && strstr(error.text, bad[i].says), "%s: %s",
                     bad[i].text, error.text);
    }
}

TEST(bytes_that_are_no_table_are_refused_and_nothing_else) {
    static const char start[] = "role pupil jobs=3\nkey lab role=batch made=2026-01-31T09:30:00Z "
                                "expires=never memory=64M digest=" DIGEST "\n";
    char text[sizeof start];
    unsigned seed = 1;
    int refused = 0;
    for (int turn = 0; turn < 20000; turn++) {
        OWN(srv_keys, clear) keys;
        struct pend_error error = {.text = ""};
        memcpy(text, start, sizeof start);
        for (int change = 0; change < 1 + turn % 4; change++) {
            seed = seed * 1103515245u + 12345u;
            text[(seed >> 8) % (sizeof start - 1)] = (char)(seed >> 20);
        }
        srv_keys_init(&keys);
        enum pend_status status = srv_keys_read(&keys, text, sizeof start - 1, &error);
        CHECK(status == PEND_OK || (status == PEND_INVALID && error.text[0]));
        refused += status != PEND_OK;
    }
    CHECK_SAYING(refused > 10000 && refused < 20000, "%d", refused);
}

TEST(instants_are_read_as_people_write_them) {
    static const struct {
        const char *text;
        int64_t want;
    } good[] = {{"never", 0},
                {"now", 1000},
                {"90d", 1000 + 90 * 86400},
                {"2w", 1000 + 14 * 86400},
                {"5m", 1300},
                {"0s", 1000},
                {"2026-01-31", 1769817600},
                {"2026-01-31T09:30:00Z", 1769851800}};
    static const char *const bad[] = {"",
                                      "d",
                                      "90",
                                      "-1d",
                                      "1y",
                                      "2026-1-31",
                                      "2026-02-30",
                                      "2026-01-31T09:30:00",
                                      "2026-01-31T24:00:00Z",
                                      "tomorrow",
                                      "1969-12-31",
                                      "999999999d",
                                      "99999999w"};
    char text[SRV_KEY_TIME];
    int64_t instant;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        instant = -1;
        CHECK_SAYING(srv_keys_instant(good[i].text, 1000, &instant) && instant == good[i].want,
                     "%s: %lld", good[i].text, (long long)instant);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        CHECK_SAYING(!srv_keys_instant(bad[i], 1000, &instant), "%s", bad[i]);
    srv_keys_time(1769851800, text);
    CHECK_TEXT(text, "2026-01-31T09:30:00Z");
    srv_keys_time(0, text);
    CHECK_TEXT(text, "never");
}
