/* Tests of server/protocol/identity: identifying the client. */
#include "server/protocol/identity.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/harness/test.h"

#define TOKEN "Bearer abcdefghijklmnopqrstuv"

static const char *key_of(struct srv_identity *identity, const char *address, const char *account,
                          const char *authorization) {
    CHECK(srv_identity_begin(identity, address, account));
    CHECK(srv_identity_token(identity, authorization));
    return identity->key;
}

TEST(an_ipv6_network_is_one_client_and_a_mapped_address_is_ipv4) {
    static const struct {
        const char *one, *two;
        int same;
    } pair[] = {
        {"2001:db8:1:2::1", "2001:db8:1:2:ffff::9", 1}, {"2001:db8:1:2::1", "2001:db8:1:3::1", 0},
        {"192.0.2.1", "::ffff:192.0.2.1", 1},           {"192.0.2.1", "192.0.2.2", 0},
        {"::ffff:192.0.2.1", "::ffff:192.0.2.2", 0},    {"fe80::1%eth0", "fe80::2%eth0", 0},
    };
    struct srv_identity one, two;
    for (size_t i = 0; i < sizeof pair / sizeof *pair; i++) {
        int same =
            !strcmp(key_of(&one, pair[i].one, NULL, NULL), key_of(&two, pair[i].two, NULL, NULL));
        CHECK_SAYING(same == pair[i].same, "%s and %s", pair[i].one, pair[i].two);
        CHECK_TEXT(one.source, one.key);
        CHECK_TEXT(one.shown, pair[i].one);
        CHECK_INT(one.kind, SRV_IDENTITY_ADDRESS);
        CHECK_TEXT(one.secret, "");
    }
}

TEST(a_token_an_account_and_an_address_of_one_text_are_three) {
    struct srv_identity address, account, token, again;
    key_of(&address, "192.0.2.1", "", NULL);
    key_of(&account, "192.0.2.1", "abcdefghijklmnopqrstuv", NULL);
    key_of(&token, "192.0.2.1", NULL, TOKEN);
    key_of(&again, "198.51.100.1", "abcdefghijklmnopqrstuv", TOKEN);
    CHECK(strcmp(address.key, account.key) && strcmp(account.key, token.key) &&
          strcmp(address.key, token.key));
    CHECK(strcmp(account.key + 2, token.key + 2) != 0);
    CHECK_TEXT(again.key, token.key);
    /* the origin is kept as well: the address, or the account */
    CHECK_TEXT(token.source, address.key);
    CHECK_TEXT(again.source, account.key);
    CHECK_TEXT(srv_identity_word(address.key), "address");
    CHECK_TEXT(srv_identity_word(account.key), "account");
    CHECK_TEXT(srv_identity_word(token.key), "token");
    CHECK_TEXT(srv_identity_word("192.0.2.1"), "address");
    CHECK_TEXT(srv_identity_word("2001:db8::"), "address");
    /* the texts for the log contain neither */
    CHECK(strlen(token.secret) == 18 && !strncmp(token.secret, "token:", 6) &&
          !strstr(token.secret, "abcdef"));
    CHECK(strlen(account.shown) == 20 && !strncmp(account.shown, "account:", 8));
    CHECK_TEXT(token.shown, "192.0.2.1");
}

TEST(what_is_no_account_or_no_token_is_refused) {
    static const char *const accounts[] = {"j\xc3\xb6rg", "a\tb", "a\x7f", "\x01"};
    struct srv_identity identity;
    for (size_t i = 0; i < sizeof accounts / sizeof *accounts; i++) {
        CHECK_SAYING(!srv_identity_begin(&identity, "192.0.2.1", accounts[i]), "%s", accounts[i]);
        CHECK_INT(identity.kind, SRV_IDENTITY_ADDRESS);
        CHECK_TEXT(identity.shown, "192.0.2.1");
    }
    char longest[SRV_TOKEN_MOST + 16] = "Bearer ";
    for (int i = 0; i <= SRV_TOKEN_MOST; i++) longest[7 + i] = (char)('a' + i % 26);
    CHECK(!srv_identity_token(&identity, longest));
    CHECK_INT(identity.kind, SRV_IDENTITY_ADDRESS);
    longest[7 + SRV_TOKEN_MOST] = 0;
    CHECK(srv_identity_token(&identity, longest));
    /* other schemes are ignored, and so is a name that begins like ours */
    CHECK(srv_identity_begin(&identity, "192.0.2.1", NULL));
    CHECK(srv_identity_token(&identity, "Basic x") && srv_identity_token(&identity, "Bearers x"));
    CHECK_INT(identity.kind, SRV_IDENTITY_ADDRESS);
}

TEST(things_are_ended_by_who_made_them) {
    struct srv_identity maker, other;
    key_of(&maker, "2001:db8:1:2::1", NULL, NULL);
    key_of(&other, "2001:db8:1:2::2", NULL, TOKEN);
    /* without a token: the network, with or without a token; and the text of the network, as in
     * older stores */
    CHECK(srv_identity_owns(&maker, maker.key) && srv_identity_owns(&other, maker.key));
    CHECK(srv_identity_owns(&maker, "2001:db8:1:2::") &&
          !srv_identity_owns(&maker, "2001:db8:1:3::"));
    /* with one: the token alone */
    CHECK(srv_identity_owns(&other, other.key) && !srv_identity_owns(&maker, other.key));
    key_of(&maker, "192.0.2.1", "anna", NULL);
    key_of(&other, "192.0.2.1", NULL, NULL);
    CHECK(!srv_identity_owns(&other, maker.key) && !srv_identity_owns(&maker, other.key));
    CHECK(!srv_identity_owns(&maker, "192.0.2.1") && !srv_identity_owns(&maker, ""));
}

TEST(clients_that_an_operator_names_have_the_keys_that_they_had) {
    struct srv_identity identity;
    char key[SRV_IDENTITY_KEY];
    key_of(&identity, "192.0.2.1", "anna", NULL);
    CHECK(srv_identity_named("account:anna", key) && !strcmp(key, identity.key));
    key_of(&identity, "2001:db8:1:2::7", NULL, NULL);
    CHECK(srv_identity_named("address:2001:db8:1:2::9", key) && !strcmp(key, identity.key));
    CHECK(srv_identity_named("key:anna", key) && key[0] == 'k');
    CHECK(!srv_identity_named("anna", key) && !srv_identity_named("account:", key) &&
          !srv_identity_named("", key) && !srv_identity_named("accounts:anna", key) &&
          !srv_identity_named("token:0123", key));
}

TEST(without_keys_nobody_has_a_role_and_what_looks_like_a_key_is_a_token) {
    struct srv_identity identity;
    struct srv_identity_words words = {.address = "192.0.2.1",
                                       .roles = "operator",
                                       .authorization =
                                           "Bearer pdk_0123456789abcdefghjkmnpqrstvwxyz000000"};
    srv_identity_make(&identity, NULL, &words);
    CHECK_INT(identity.fault, SRV_IDENTITY_GOOD);
    CHECK_INT(identity.kind, SRV_IDENTITY_TOKEN);
    CHECK_INT(identity.role, SRV_ROLE_NONE);
    for (int i = 0; i < SRV_LIMIT_PRIORITY; i++) CHECK(isinf(identity.limits.value[i]));
    words.account = "anna";
    words.authorization = "Bearer short";
    srv_identity_make(&identity, NULL, &words);
    CHECK_INT(identity.fault, SRV_IDENTITY_NO_TOKEN);
    CHECK_INT(identity.kind, SRV_IDENTITY_ACCOUNT);
    CHECK_INT(identity.role, SRV_ROLE_NONE);
}

/* a ring with a teacher's key */
static struct srv_key_ring *ring_of(char path[], char token[SRV_KEY_TOKEN]) {
    struct srv_key_ring *ring = NULL;
    char digest[API_DIGEST_BYTES], text[256];
    int fd = mkstemp(path);
    if (!CHECK(fd >= 0 && srv_keys_draw(token))) return NULL;
    srv_keys_digest(token, digest);
    int bytes = snprintf(text, sizeof text,
                         "key anna role=teacher expires=2033-05-18T03:33:20Z digest=%s\n", digest);
    CHECK(write(fd, text, (size_t)bytes) == bytes && !close(fd));
    CHECK(srv_key_ring_new(&ring, path, NULL) == PEND_OK);
    unlink(path);
    return ring;
}

TEST(a_key_is_one_client_wherever_it_comes_from_and_gives_its_role) {
    char path[] = "/tmp/pendulumd-test-XXXXXX", token[SRV_KEY_TOKEN], field[64];
    OWN(srv_key_ring, free) *ring = ring_of(path, token);
    struct srv_identity here, there;
    REQUIRE(ring != NULL);
    snprintf(field, sizeof field, "bearer %s", token);
    struct srv_identity_words words = {
        .address = "192.0.2.1", .authorization = field, .now = 1999999999};
    srv_identity_make(&here, ring, &words);
    words.address = "2001:db8::1";
    words.account = "somebody";
    words.roles = "operator";
    srv_identity_make(&there, ring, &words);
    CHECK_INT(here.kind, SRV_IDENTITY_ISSUED);
    CHECK_INT(here.role, SRV_ROLE_TEACHER);
    CHECK_INT(there.role, SRV_ROLE_TEACHER);
    CHECK_TEXT(here.key, there.key);
    CHECK_TEXT(here.source, here.key);
    CHECK_TEXT(here.secret, "key:anna");
    CHECK_TEXT(srv_identity_word(here.key), "key");
    /* an account with the key's name is another client */
    words = (struct srv_identity_words){.address = "192.0.2.1", .account = "anna"};
    srv_identity_make(&there, ring, &words);
    CHECK(strcmp(there.key, here.key) && !srv_identity_owns(&there, here.key));
    CHECK_INT(there.role, SRV_ROLE_PUPIL);
    words.roles = "staff;teacher, batch,operator";
    srv_identity_make(&there, ring, &words);
    CHECK_INT(there.role, SRV_ROLE_BATCH);
    /* a second later it is identified by its address, with the role anonymous */
    words = (struct srv_identity_words){
        .address = "192.0.2.1", .authorization = field, .now = 2000000000};
    srv_identity_make(&there, ring, &words);
    CHECK_INT(there.fault, SRV_IDENTITY_NO_KEY);
    CHECK_INT(there.verdict, SRV_KEY_EXPIRED);
    CHECK_INT(there.since, 2000000000);
    CHECK_INT(there.kind, SRV_IDENTITY_ADDRESS);
    CHECK_INT(there.role, SRV_ROLE_ANONYMOUS);
    CHECK_TEXT(there.source, there.key);
}
