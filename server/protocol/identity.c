#include "server/protocol/identity.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

static_assert((int)SRV_IDENTITY_KEY == (int)API_DIGEST_BYTES + 2,
              "a key is a digest with its kind before it");

enum { IDENTITY_DIGITS = 12 /* digits of a digest in logs */ };

const char srv_identity_rule[] =
    "a bearer token is a random secret of at least 128 bits that the client generates: 22 to 4096 "
    "characters of A-Z, a-z, 0-9 and -._~+/, at least 32 if all are hexadecimal digits, at least 8 "
    "of them different, with = at the end only; for example the output of: openssl rand -hex 16";

static const char identity_letter[] = {'n', 'a', 't', 'k'};
static const char *const identity_word[] = {"address", "account", "token", "key"};

static void identity_key(char key[SRV_IDENTITY_KEY], enum srv_identity_kind kind,
                         const char *text) {
    const char *const parts[] = {"identity", identity_word[kind], text, NULL};
    key[0] = identity_letter[kind];
    key[1] = ':';
    api_digest(key + 2, parts, NULL);
}

int srv_identity_begin(struct srv_identity *identity, const char *address, const char *account) {
    int good = 1;
    for (const char *at = account; at && *at && good; at++) good = *at >= ' ' && *at <= '~';
    srv_peer_network(address, identity->network);
    identity->kind = account && *account && good ? SRV_IDENTITY_ACCOUNT : SRV_IDENTITY_ADDRESS;
    identity_key(identity->key, identity->kind,
                 identity->kind == SRV_IDENTITY_ACCOUNT ? account : identity->network);
    memcpy(identity->source, identity->key, sizeof identity->source);
    identity->secret[0] = 0;
    identity->role = SRV_ROLE_NONE;
    identity->limits = srv_role_limits(SRV_ROLE_NONE);
    identity->verdict = SRV_KEY_GOOD;
    identity->since = 0;
    identity->issued[0] = 0;
    if (identity->kind == SRV_IDENTITY_ACCOUNT)
        snprintf(identity->shown, sizeof identity->shown, "account:%.*s", IDENTITY_DIGITS,
                 identity->key + 2);
    else
        snprintf(identity->shown, sizeof identity->shown, "%s", address);
    return good;
}

/* the number of different characters; hex: whether all are hexadecimal digits */
static int identity_letters(const char *text, size_t bytes, int *hex) {
    unsigned char seen[256] = {0};
    int different = 0;
    *hex = 1;
    for (size_t i = 0; i < bytes; i++) {
        unsigned char c = (unsigned char)text[i];
        different += !seen[c];
        seen[c] = 1;
        *hex &= strchr("0123456789abcdefABCDEF", c) != NULL;
    }
    return different;
}

/* true for a token68 (RFC 9110, 11.2) with enough entropy */
static int identity_good(const char *token) {
    static const char letters[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~+/";
    size_t bytes = strspn(token, letters), all = bytes + strspn(token + bytes, "=");
    int hex, different = identity_letters(token, bytes, &hex);
    return !token[all] && all <= SRV_TOKEN_MOST && different >= SRV_TOKEN_LETTERS &&
           bytes >= (size_t)(hex ? SRV_TOKEN_LEAST_HEX : SRV_TOKEN_LEAST);
}

/* the credentials after Bearer; NULL for another scheme */
static const char *identity_bearer(const char *authorization) {
    static const char scheme[] = "Bearer";
    size_t bytes = sizeof scheme - 1;
    if (!authorization || strncasecmp(authorization, scheme, bytes)) return NULL;
    /* a longer name, such as "BearerX", is another scheme */
    if (authorization[bytes] && !strchr(" \t,;=\"", authorization[bytes])) return NULL;
    return authorization + bytes + strspn(authorization + bytes, " ");
}

int srv_identity_token(struct srv_identity *identity, const char *authorization) {
    assert(identity->key[0] && identity->source[0]);
    const char *token = identity_bearer(authorization);
    if (!token) return 1;
    if (!identity_good(token)) return 0;
    identity->kind = SRV_IDENTITY_TOKEN;
    identity_key(identity->key, identity->kind, token);
    snprintf(identity->secret, sizeof identity->secret, "token:%.*s", IDENTITY_DIGITS,
             identity->key + 2);
    return 1;
}

/* the first role in a list of words */
static enum srv_role identity_role(const char *roles) {
    for (const char *at = roles; at && *at;) {
        at += strspn(at, ", \t");
        size_t bytes = strcspn(at, ", \t");
        enum srv_role role = srv_role_of(at, bytes);
        if (role != SRV_ROLE_NONE) return role;
        at += bytes;
    }
    return SRV_ROLE_NONE;
}

/**
 * Sets the role of a client without an API key: anonymous, or for an account the role that a
 * trusted proxy names (pupil if it names none).
 *
 * ring   the server's API keys; NULL = roles are not used.
 * roles  a comma-separated list of words, whose first role counts; NULL = none named.
 */
static void identity_role_of(struct srv_identity *identity, struct srv_key_ring *ring,
                             const char *roles) {
    assert(identity->key[0]);
    if (!ring) return;
    identity->role = SRV_ROLE_ANONYMOUS;
    if (identity->kind == SRV_IDENTITY_ACCOUNT) {
        enum srv_role told = identity_role(roles);
        identity->role = told != SRV_ROLE_NONE ? told : SRV_ROLE_PUPIL;
    }
    identity->limits = srv_key_ring_role(ring, identity->role);
}

/**
 * Identifies the client by an API key, sent as a bearer token. Such a client has no other source:
 * the operator vouches for it.
 *
 * ring  the server's API keys; NULL = API keys are not used.
 * now   s since 1970.
 *
 * Returns 1 if the key is valid, 0 if no API key was sent, -1 if it is not valid: `verdict` says
 * why, and the rest of the identity is unchanged.
 */
static int identity_issued(struct srv_identity *identity, struct srv_key_ring *ring,
                           const char *authorization, int64_t now) {
    const char *token = identity_bearer(authorization);
    if (!ring || !token || !srv_keys_meant(token)) return 0;
    struct srv_key_found found = srv_key_ring_find(ring, token, now);
    identity->verdict = found.verdict;
    identity->since = found.when;
    if (found.name[0]) snprintf(identity->secret, sizeof identity->secret, "key:%s", found.name);
    if (found.verdict != SRV_KEY_GOOD) return -1;
    identity->kind = SRV_IDENTITY_ISSUED;
    identity->role = found.role;
    identity->limits = found.limits;
    memcpy(identity->issued, found.digest, sizeof identity->issued);
    identity_key(identity->key, identity->kind, found.name);
    memcpy(identity->source, identity->key, sizeof identity->source);
    return 1;
}

void srv_identity_make(struct srv_identity *identity, struct srv_key_ring *ring,
                       const struct srv_identity_words *words) {
    int named = srv_identity_begin(identity, words->address, words->account);
    identity->fault = named ? SRV_IDENTITY_GOOD : SRV_IDENTITY_NO_ACCOUNT;
    identity_role_of(identity, ring, named ? words->roles : NULL);
    if (!named) return;
    int issued = identity_issued(identity, ring, words->authorization, words->now);
    if (issued < 0) identity->fault = SRV_IDENTITY_NO_KEY;
    if (!issued && !srv_identity_token(identity, words->authorization))
        identity->fault = SRV_IDENTITY_NO_TOKEN;
}

int srv_identity_owns(const struct srv_identity *identity, const char *owner) {
    return !strcmp(owner, identity->key) || !strcmp(owner, identity->source) ||
           (identity->source[0] == identity_letter[SRV_IDENTITY_ADDRESS] &&
            !strcmp(owner, identity->network));
}

const char *srv_identity_word(const char *key) {
    for (int kind = SRV_IDENTITY_ACCOUNT; kind <= SRV_IDENTITY_ISSUED; kind++)
        if (key[0] == identity_letter[kind] && key[1] == ':') return identity_word[kind];
    return identity_word[SRV_IDENTITY_ADDRESS];
}

int srv_identity_named(const char *name, char key[SRV_IDENTITY_KEY]) {
    static const enum srv_identity_kind kinds[] = {SRV_IDENTITY_ADDRESS, SRV_IDENTITY_ACCOUNT,
                                                   SRV_IDENTITY_ISSUED};
    char network[SRV_PEER_BYTES];
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        size_t bytes = strlen(identity_word[kinds[i]]);
        if (strncmp(name, identity_word[kinds[i]], bytes) || name[bytes] != ':') continue;
        const char *text = name + bytes + 1;
        srv_peer_network(text, network);
        identity_key(key, kinds[i], kinds[i] == SRV_IDENTITY_ADDRESS ? network : text);
        return *text != 0;
    }
    return 0;
}
