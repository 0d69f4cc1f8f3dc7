/* Keys that an operator hands out: making them, the table of their digests, looking one up.
 * Leaves to others: the file that holds the table (key_file), which table is in force (key_ring).
 * Invariant: no key is kept, only its digest; every look-up compares all digests whole, so that the
 * time it takes tells nothing of them. */
#ifndef SRV_KEYS_H
#define SRV_KEYS_H

#include <stdint.h>

#include "api/call/digest.h"
#include "server/keys/role.h"

enum {
    SRV_KEY_NAME = 33,  /* bytes of a name with its NUL: A-Z a-z 0-9 . _ - */
    SRV_KEY_TOKEN = 43, /* bytes of a key with its NUL: pdk_, 32 letters with 160 bits, 6 digits
                           that tell a slip of the pen */
    SRV_KEY_ID = 8,     /* digits of the digest by which people name a key */
    SRV_KEYS_MOST = 4096,
    SRV_KEYS_BYTES = 2 << 20, /* of a whole table as text */
    SRV_KEY_TIME = 24         /* bytes of an instant as text with its NUL */
};

/* A key, as it is kept. Instants are seconds since 1970, 0 = never. */
struct srv_key {
    char name[SRV_KEY_NAME]; /* who has it; several keys of one name are one client */
    char digest[API_DIGEST_BYTES];
    enum srv_role role;
    int64_t made, expires, revoked;
    struct srv_limits limits; /* of its own; what is unset is the role's */
};

/* All keys of a server, and what their roles may have. */
struct srv_keys {
    struct srv_key *key;
    int count, room;
    struct srv_limits role[SRV_ROLE_COUNT]; /* what is unset is the role's default */
};

/** A table without keys; ends with srv_keys_clear. */
void srv_keys_init(struct srv_keys *keys);

/** Frees the keys of a table, which has none afterwards. */
void srv_keys_clear(struct srv_keys *keys);

/**
 * Reads a table from text as srv_keys_write writes it; lines that are empty or begin with # are
 * passed over.
 *
 * keys  from srv_keys_init; to be cleared after a failure too.
 *
 * PEND_INVALID    error names the line and what would be right.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_keys_read(struct srv_keys *keys, const char *text,
                                               size_t bytes, struct pend_error *error);

/** Writes a table as text; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status srv_keys_write(const struct srv_keys *keys,
                                                struct api_buffer *out);

/** Draws a new key. Returns 0 where the system has no random numbers. */
int srv_keys_draw(char token[SRV_KEY_TOKEN]);

/** True where a token looks like a key of a server, whole or not: it begins with pdk_. */
int srv_keys_meant(const char *token);

/** True where a token is a whole key: its length, its letters and its last six digits are right. */
int srv_keys_whole(const char *token);

/** The digest by which a key is kept. */
void srv_keys_digest(const char *token, char digest[API_DIGEST_BYTES]);

/** True for what may be a key's name. */
int srv_keys_named(const char *name);

/**
 * Adds a key; its digest is set already.
 *
 * PEND_LIMIT      there are SRV_KEYS_MOST.
 * PEND_INVALID    the name is none, the same key is there, or keys of this name have another role;
 *                 error says which.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_keys_add(struct srv_keys *keys, const struct srv_key *key,
                                              struct pend_error *error);

/** The key of a digest, or NULL. O(keys), the same time whether and wherever it is there. Valid
 * until the table changes. */
struct srv_key *srv_keys_find(const struct srv_keys *keys, const char digest[API_DIGEST_BYTES]);

/** True where a key has this name, or its digest begins with these SRV_KEY_ID digits. */
int srv_keys_means(const struct srv_key *key, const char *name);

/** What a key may have: its own limits, else its role's, else the role's defaults. */
struct srv_limits srv_keys_limits(const struct srv_keys *keys, const struct srv_key *key);

/** What a role may have: what the table says of it, else its defaults. */
struct srv_limits srv_keys_role(const struct srv_keys *keys, enum srv_role role);

/** Writes an instant as 2026-01-31T09:30:00Z, 0 as never. */
void srv_keys_time(int64_t instant, char text[SRV_KEY_TIME]);

/**
 * Reads an instant: 2026-01-31, 2026-01-31T09:30:00Z, never, now, or a span from now such as 90d
 * (s, m, h, d or w).
 *
 * Returns 0 where the text is none of these, or beyond the year 9999.
 */
int srv_keys_instant(const char *text, int64_t now, int64_t *instant);

#endif
