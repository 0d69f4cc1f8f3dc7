/* The operator's secrets of webhooks: the one in force, and one before it while receivers change.
 * Leaves to others: the algorithms (api/call/webhook).
 * Invariant: a client is told, and signed for, by a key of its own, made of these. */
#ifndef SRV_HOOK_KEYS_H
#define SRV_HOOK_KEYS_H

#include "api/call/webhook.h"
#include "core/base/status.h"

enum { SRV_HOOK_SECRETS = 2, SRV_HOOK_SECRET_LEAST = 32, SRV_HOOK_SECRET_BYTES = 256 };

struct srv_hook_keys {
    int count;
    char secret[SRV_HOOK_SECRETS][SRV_HOOK_SECRET_BYTES]; /* the first is in force */
};

/* "v1,..." of each secret, with blanks between */
enum { SRV_HOOK_SIGNATURES = SRV_HOOK_SECRETS * API_WEBHOOK_SIGNATURE };

/**
 * Reads a file of mode 0600: a secret a line, of at least SRV_HOOK_SECRET_LEAST visible characters,
 * at most two; the second is that of before.
 *
 * PEND_INVALID    error says what is wrong.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_hook_keys_read(struct srv_hook_keys *keys, const char *path,
                                                    struct pend_error *error);

/** What a client is told to verify with: of the secret in force. */
void srv_hook_keys_secret(const struct srv_hook_keys *keys, const char *client,
                          char secret[API_WEBHOOK_SECRET]);

/** The signatures of a client's message, as the field webhook-signature has them. */
void srv_hook_keys_sign(const struct srv_hook_keys *keys, const char *client, const char *id,
                        const char *timestamp, const char *body, size_t bytes,
                        char signatures[SRV_HOOK_SIGNATURES]);

#endif
