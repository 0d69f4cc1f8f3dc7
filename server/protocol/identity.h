/* Authentication: identifies the client by an API key that the operator issued, by its own bearer
 * token, by the account that a trusted proxy names, or by its address; and determines its role.
 * Leaves to others: reading a proxy's header fields (peer), authorization and quotas (admission,
 * jobs, scenes, events).
 * Invariant: of a token or account only a digest is stored or shown; different tokens, and
 * different kinds of clients, have different keys. */
#pragma once

#include "server/keys/key_ring.h"
#include "server/protocol/peer.h"

enum {
    SRV_IDENTITY_KEY = 67,    /* bytes of a key: a letter for the kind, a colon, 64 digits, NUL */
    SRV_IDENTITY_SHOWN = 48,  /* bytes of the texts for the log */
    SRV_TOKEN_LEAST = 22,     /* characters of a token: 22 of base 64 have 132 bits, */
    SRV_TOKEN_LEAST_HEX = 32, /* 32 hexadecimal digits have 128 */
    SRV_TOKEN_MOST = 4096,
    SRV_TOKEN_LETTERS = 8 /* least number of different characters; random tokens have more */
};

/* The kinds of identities of clients. */
enum srv_identity_kind {
    SRV_IDENTITY_ADDRESS,
    SRV_IDENTITY_ACCOUNT,
    SRV_IDENTITY_TOKEN,
    SRV_IDENTITY_ISSUED /* an API key that the operator issued */
};

/* Why authentication failed. */
enum srv_identity_fault {
    SRV_IDENTITY_GOOD,
    SRV_IDENTITY_NO_ACCOUNT,
    SRV_IDENTITY_NO_TOKEN,
    SRV_IDENTITY_NO_KEY /* the API key is not valid; `verdict` says why */
};

struct srv_identity {
    enum srv_identity_kind kind;
    enum srv_identity_fault fault; /* result of the authentication */
    char key[SRV_IDENTITY_KEY];    /* identifies the client in stores, queues, quotas and lists */
    char source[SRV_IDENTITY_KEY]; /* the key of its address or account; equals `key` without a
                                      token */
    char network[SRV_PEER_BYTES];  /* the address or IPv6 network, which older stores use as the key
                                    */
    char shown[SRV_IDENTITY_SHOWN];  /* for the log: the address, or "account:" and 12 digits of the
                                        digest */
    char secret[SRV_IDENTITY_SHOWN]; /* for the log: "token:" and 12 digits of the digest, or "key:"
                                        and its name; "" without either */
    enum srv_role role;              /* SRV_ROLE_NONE if the server has no API keys */
    struct srv_limits limits;        /* the limits of the API key, else of the role */
    enum srv_key_verdict verdict;    /* the check of the API key; good without one */
    char issued[API_DIGEST_BYTES];   /* digest of the API key; "" without a valid one */
    int64_t since;                   /* s since 1970: when the API key expired or was revoked */
};

/* The rule for tokens, as a sentence for problems. */
extern const char srv_identity_rule[];

/**
 * Identifies a client without a token.
 *
 * address  as text. The client is the /64 network of an IPv6 address; ::ffff:192.0.2.1 counts as
 *          IPv4.
 * account  the account that a trusted proxy names, or NULL.
 *
 * Returns 0 if the account has control characters or bytes above 0x7e; the identity is then the
 * address, for the log.
 */
int srv_identity_begin(struct srv_identity *identity, const char *address, const char *account);

/**
 * Identifies the client by its bearer token. Other schemes are ignored: a proxy may use them.
 *
 * authorization  value of Authorization, or NULL.
 *
 * Returns 0 if the token violates srv_identity_rule; the identity is then unchanged.
 */
int srv_identity_token(struct srv_identity *identity, const char *authorization);

/* The parts of a request that identify its client. */
struct srv_identity_words {
    const char *address; /* as for srv_identity_begin */
    const char *account;
    const char *roles;         /* words with commas; the first role counts; NULL = none named */
    const char *authorization; /* value of Authorization, or NULL */
    int64_t now;               /* s since 1970 */
};

/** Identifies the client of a request: srv_identity_begin, its role, then its key or
 * srv_identity_token. If one of them fails, `fault` says why and the identity is that of the steps
 * before. */
void srv_identity_make(struct srv_identity *identity, struct srv_key_ring *ring,
                       const struct srv_identity_words *words);

/**
 * Returns true if this client may end what `owner` created: its token or account created it, or its
 * address or account did without a token.
 *
 * owner  the key of an identity, or the text of a network (older stores).
 */
int srv_identity_owns(const struct srv_identity *identity, const char *owner);

/**
 * Computes the key of a client that the operator names: key:NAME, account:NAME or address:ADDRESS.
 *
 * Returns 0 if the name has none of these forms.
 */
int srv_identity_named(const char *name, char key[SRV_IDENTITY_KEY]);

/** Returns the kind of an identity's key: "key", "token", "account" or "address". */
const char *srv_identity_word(const char *key);
