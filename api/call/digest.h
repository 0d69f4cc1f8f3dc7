/* The digest of a request in canonical form, which identifies answers in ETags and caches.
 * Leaves to others: comparing digests (server).
 * Invariant: SHA-256, so that no client can make two requests collide; requests that differ only in
 * the order of keys, in blanks or in the spelling of numbers have the same digest. */
#pragma once

#include "api/json/json_in.h"

enum { API_DIGEST_BYTES = 65 }; /* 64 hexadecimal digits and a NUL */

/**
 * Computes the digest of an operation's request.
 *
 * parts  texts that identify the answer besides the body: operation, argument, media type, engine;
 *        ended by NULL.
 * root   the body, or NULL.
 *
 * O(bytes of the body), and O(m^2) in an object of m members. No allocation.
 */
void api_digest(char digest[API_DIGEST_BYTES], const char *const parts[],
                const struct api_value *root);

/** Writes the SHA-256 of bytes as hexadecimal digits. O(bytes). */
void api_digest_bytes(char digest[API_DIGEST_BYTES], const void *data, size_t bytes);

enum { API_SEAL_BYTES = 16 };

/**
 * Computes the seal of stored bytes, which later proves that they are unchanged and where they
 * belong.
 *
 * seal   out: the first bytes of a SHA-256.
 * place  identifies, together with `number`, where the bytes belong; elsewhere their seal would
 *        differ.
 *
 * The seal has no secret: an attacker who can change the bytes can change it too, so readers must
 * still validate them. O(bytes).
 */
void api_seal(unsigned char seal[API_SEAL_BYTES], const char *place, long number, const void *data,
              size_t bytes);
