/* API keys: generation, the table of their digests, lookup.
 * Leaves to others: the file that holds the table (key_file), which table is active (key_ring).
 * Invariant: only digests of keys are stored; a lookup takes constant time, so that its duration
 * reveals nothing. */
#pragma once

#include <stdint.h>

#include "api/call/digest.h"
#include "server/keys/role.h"

enum {
    SRV_KEY_NAME = 33,  /* bytes of a name with its NUL: A-Z a-z 0-9 . _ - */
    SRV_KEY_TOKEN = 43, /* bytes of a key: pdk_, 32 letters with 160 bits, 6 check digits, NUL */
    SRV_KEY_ID = 8,     /* digits of the digest that identify a key for people */
    SRV_KEYS_MOST = 4096,
    SRV_KEYS_BYTES = 2 << 20, /* maximum bytes of a table as text */
    SRV_KEY_TIME = 24         /* bytes of an instant as text with its NUL */
};

/* A stored key. Instants are seconds since 1970, 0 = never. */
struct srv_key {
    char name[SRV_KEY_NAME]; /* the client; keys with the same name belong to one client */
    char digest[API_DIGEST_BYTES];
    enum srv_role role;
    int64_t made, expires, revoked;
    struct srv_limits limits; /* limits of the key; an unset one is that of the role */
};

/* All keys of a server, and the limits of the roles. */
struct srv_keys {
    struct srv_key *key;
    int count, room;
    struct srv_limits role[SRV_ROLE_COUNT]; /* an unset limit is the role's default */
};

/** Initializes a table without keys; ends with srv_keys_clear. */
void srv_keys_init(struct srv_keys *keys);

/** Frees the keys of a table, which has none afterwards. */
void srv_keys_clear(struct srv_keys *keys);

/**
 * Parses a table in the format of srv_keys_write; empty lines and lines that begin with # are
 * skipped.
 *
 * keys  from srv_keys_init; the caller clears it, after a failure too.
 *
 * PEND_INVALID    error names the line and the correct form.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_keys_read(struct srv_keys *keys, const char *text,
                                               size_t bytes, struct pend_error *error);

/** Writes a table as text; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status srv_keys_write(const struct srv_keys *keys,
                                                struct api_buffer *out);

/** Generates a new random key. Returns 0 if the system has no random numbers. */
int srv_keys_draw(char token[SRV_KEY_TOKEN]);

/** Returns true if a token looks like an API key: it begins with pdk_. */
int srv_keys_meant(const char *token);

/** Returns true if a token is a well-formed API key: length, letters and check digits are
 * correct. */
int srv_keys_whole(const char *token);

/** Computes the digest that is stored for a key. */
void srv_keys_digest(const char *token, char digest[API_DIGEST_BYTES]);

/** Returns true for a valid name of a key. */
int srv_keys_named(const char *name);

/**
 * Adds a key, whose digest must be set.
 *
 * PEND_LIMIT      the table has SRV_KEYS_MOST keys.
 * PEND_INVALID    the name is invalid, the key exists already, or keys of this name have another
 *                 role; error says which.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_keys_add(struct srv_keys *keys, const struct srv_key *key,
                                              struct pend_error *error);

/** Returns the key with a digest, or NULL; valid until the table changes. O(keys); the time does
 * not depend on the position. */
struct srv_key *srv_keys_find(const struct srv_keys *keys, const char digest[API_DIGEST_BYTES]);

/** Returns true if a key has this name, or its digest begins with these SRV_KEY_ID digits. */
int srv_keys_means(const struct srv_key *key, const char *name);

/** Returns the limits of a key: its own, else its role's in the table, else the role's defaults. */
struct srv_limits srv_keys_limits(const struct srv_keys *keys, const struct srv_key *key);

/** Returns the limits of a role: those in the table, else its defaults. */
struct srv_limits srv_keys_role(const struct srv_keys *keys, enum srv_role role);

/** Writes an instant as 2026-01-31T09:30:00Z, 0 as never. */
void srv_keys_time(int64_t instant, char text[SRV_KEY_TIME]);

/**
 * Reads an instant: 2026-01-31, 2026-01-31T09:30:00Z, never, now, or a span from now such as 90d
 * (s, m, h, d or w).
 *
 * Returns 0 if the text is none of these, or later than the year 9999.
 */
int srv_keys_instant(const char *text, int64_t now, int64_t *instant);
