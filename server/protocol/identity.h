/* Who asks: a key that the operator handed out, a bearer token of the client's own, else the
 * account that a trusted proxy names, else the address; and the role that this gives.
 * Leaves to others: whom a proxy's header fields name (peer), what follows from it (admission,
 * jobs, scenes, events).
 * Invariant: what is kept or shown of a token or an account is a digest of all of it; two tokens
 * are two identities, and no token, account or address ever has the key of another kind. */
#ifndef SRV_IDENTITY_H
#define SRV_IDENTITY_H

#include "server/keys/key_ring.h"
#include "server/protocol/peer.h"

enum {
    SRV_IDENTITY_KEY =
        67, /* bytes of a key with its NUL: a letter for the kind, a colon, 64 digits */
    SRV_IDENTITY_SHOWN = 48,  /* bytes of what may be shown */
    SRV_TOKEN_LEAST = 22,     /* characters of a token: 22 of base 64 have 132 bits, */
    SRV_TOKEN_LEAST_HEX = 32, /* 32 hexadecimal digits have 128 */
    SRV_TOKEN_MOST = 4096,
    SRV_TOKEN_LETTERS =
        8 /* different characters that a token has at least: what was drawn at random has */
};

/* What names a client. */
enum srv_identity_kind {
    SRV_IDENTITY_ADDRESS,
    SRV_IDENTITY_ACCOUNT,
    SRV_IDENTITY_TOKEN,
    SRV_IDENTITY_ISSUED /* a key that the operator handed out */
};

/* Why a request does not say who asks, though it tries to. */
enum srv_identity_fault {
    SRV_IDENTITY_GOOD,
    SRV_IDENTITY_NO_ACCOUNT,
    SRV_IDENTITY_NO_TOKEN,
    SRV_IDENTITY_NO_KEY /* its verdict says why */
};

struct srv_identity {
    enum srv_identity_kind kind;
    enum srv_identity_fault fault;   /* of the request that it was made of */
    char key[SRV_IDENTITY_KEY];      /* who it is; stores, lanes, quotas and lists go by it */
    char source[SRV_IDENTITY_KEY];   /* the key of the address or account it came from; `key` itself
                                        without a token */
    char network[SRV_PEER_BYTES];    /* the address, of IPv6 its network: by this a store of before
                                        knows it */
    char shown[SRV_IDENTITY_SHOWN];  /* for the log: the address, or "account:" and 12 digits of the
                                        digest */
    char secret[SRV_IDENTITY_SHOWN]; /* for the log: "token:" and 12 digits of the digest, or "key:"
                                        and its name; "" without either */
    enum srv_role role;              /* SRV_ROLE_NONE where the server has no keys */
    struct srv_limits limits;        /* of the key, else of the role */
    enum srv_key_verdict verdict;    /* on the key that it shows, good without one */
    char issued[API_DIGEST_BYTES];   /* the digest of its key; "" without one that is good */
    int64_t since;                   /* s since 1970: since when that is expired or revoked */
};

/* The rule for tokens, as a sentence for problems. */
extern const char srv_identity_rule[];

/**
 * Whom a request comes from, without its token.
 *
 * address  as text; of IPv6 its network of 64 bits is the client, of ::ffff:192.0.2.1 the IPv4
 *          address.
 * account  what a trusted proxy says the client is, taken as a whole; NULL where it says nothing.
 *
 * Returns 0 where the account has control characters or bytes above 0x7e: then the address is who
 * asks, for the log.
 */
int srv_identity_begin(struct srv_identity *identity, const char *address, const char *account);

/**
 * Makes the identity a token's, where the field Authorization has the scheme Bearer; other schemes
 * are not looked at, as a proxy may have asked for them.
 *
 * authorization  the field's value, or NULL.
 *
 * Returns 0 where what follows Bearer is no token by srv_identity_rule; the identity is as before.
 */
int srv_identity_token(struct srv_identity *identity, const char *authorization);

/**
 * Gives the identity the role that it has without a key: anonymous, or what a trusted proxy says
 * of an account, a pupil's where it says nothing.
 *
 * ring   of the server's keys; NULL = it has none, and the role is nobody's.
 * roles  words, separated by commas, of which the first that is a role counts; NULL where the
 *        proxy says nothing.
 */
void srv_identity_role(struct srv_identity *identity, struct srv_key_ring *ring, const char *roles);

/**
 * Makes the identity a key's, where the field Authorization has the scheme Bearer and what looks
 * like a key. A client with a key has no other source: the operator vouches for it.
 *
 * ring  of the server's keys; NULL = nothing looks like a key.
 * now   s since 1970.
 *
 * Returns 1 where it is the identity of a good key now, 0 where no key is shown, and -1 where the
 * verdict is another: then the rest of the identity is as before.
 */
int srv_identity_issued(struct srv_identity *identity, struct srv_key_ring *ring,
                        const char *authorization, int64_t now);

/* What a request says of who asks. */
struct srv_identity_words {
    const char *address; /* as of srv_identity_begin */
    const char *account;
    const char *roles;         /* as of srv_identity_role */
    const char *authorization; /* the field, or NULL */
    int64_t now;               /* s since 1970 */
};

/**
 * Makes the identity of a request: srv_identity_begin, srv_identity_role, then srv_identity_issued
 * or srv_identity_token. Where one of them finds a fault, the identity is what was found before,
 * and its fault says which.
 */
void srv_identity_make(struct srv_identity *identity, struct srv_key_ring *ring,
                       const struct srv_identity_words *words);

/**
 * True where a thing that was made by `owner` may be ended by this identity: its token or account
 * made it; or its address or account did, without a token.
 *
 * owner  a key, or the text of a network in a store of before.
 */
int srv_identity_owns(const struct srv_identity *identity, const char *owner);

/**
 * The key of a client that an operator names: key:NAME, account:NAME or address:ADDRESS.
 *
 * Returns 0 where the name has none of these forms.
 */
int srv_identity_named(const char *name, char key[SRV_IDENTITY_KEY]);

/** The kind of an identity's key: "key", "token", "account" or "address". */
const char *srv_identity_word(const char *key);

#endif
