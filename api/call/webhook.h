/* Webhooks by the specification Standard Webhooks 1.0: the url, the message, its signature.
 * Leaves to others: sending (server/hooks), keeping (server/store).
 * Invariant: a url that is accepted has one reading: no user, no fragment, no letter outside of
 * ASCII, and nothing that would have to be decoded to know its host. */
#ifndef API_WEBHOOK_H
#define API_WEBHOOK_H

#include "api/call/job_json.h"

enum {
    API_WEBHOOK_KEY = 32,       /* bytes of a client's key */
    API_WEBHOOK_SECRET = 52,    /* of its text with the NUL: "whsec_" and 44 letters */
    API_WEBHOOK_SIGNATURE = 48, /* "v1," and 44 letters, with the NUL */
    API_WEBHOOK_ID = 40,        /* "msg_" and 32 digits, with the NUL */
    API_WEBHOOK_HOST = 256
};

/* Where a url leads. */
struct api_webhook_place {
    char host[API_WEBHOOK_HOST]; /* a name, or an address, of IPv6 without brackets */
    int port;
};

/**
 * Reads a url: https://HOST[:PORT][/PATH][?QUERY].
 *
 * Returns NULL, or what is wrong with it, as a part of a sentence: "must begin with https://".
 */
const char *api_webhook_url(const char *url, struct api_webhook_place *place);

/**
 * The key of a client, made of the operator's: HMAC-SHA256 of the client's name, so that no client
 * can sign as another, and nothing secret is stored.
 *
 * name  of the client; `secret` is the key of the operator, of any length.
 */
void api_webhook_key(const char *secret, const char *name, unsigned char key[API_WEBHOOK_KEY]);

/** A key as its client is told it: "whsec_" and base 64. */
void api_webhook_secret(const unsigned char key[API_WEBHOOK_KEY], char text[API_WEBHOOK_SECRET]);

/** The id of the message of a job's end: the same at every attempt, and the job cannot be read by
 * who knows it. */
void api_webhook_id(const char *job, char id[API_WEBHOOK_ID]);

/** The signature of a message: "v1," and base 64 of HMAC-SHA256 of "ID.TIMESTAMP.BODY". O(bytes) */
void api_webhook_sign(const unsigned char key[API_WEBHOOK_KEY], const char *id,
                      const char *timestamp, const char *body, size_t bytes,
                      char signature[API_WEBHOOK_SIGNATURE]);

/** Appends the message of a job's end: {"type": "job.successful", "timestamp", "data": the job}.
 * Fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_webhook_write(const struct api_job *job,
                                                   struct api_buffer *out);

#endif
