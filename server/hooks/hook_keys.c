#include "server/hooks/hook_keys.h"

#include <assert.h>
#include <string.h>

#include "server/sandbox/secret.h"

enum { KEYS_FILE = 1024 };

/* takes a line as a secret; returns 0 where it is none. An empty one is passed over */
static int keys_take(struct srv_hook_keys *keys, const char *line, size_t bytes) {
    while (bytes && strchr(" \t\r", line[bytes - 1])) bytes--;
    if (!bytes) return 1;
    if (keys->count == SRV_HOOK_SECRETS || bytes < SRV_HOOK_SECRET_LEAST ||
        bytes >= SRV_HOOK_SECRET_BYTES)
        return 0;
    for (size_t i = 0; i < bytes; i++)
        if (line[i] <= ' ' || line[i] > '~') return 0;
    memcpy(keys->secret[keys->count], line, bytes);
    keys->secret[keys->count++][bytes] = 0;
    return 1;
}

enum pend_status srv_hook_keys_read(struct srv_hook_keys *keys, const char *path,
                                    struct pend_error *error) {
    struct api_buffer text;
    int good = 1;
    *keys = (struct srv_hook_keys){0};
    api_buffer_init(&text, KEYS_FILE);
    enum pend_status status = srv_secret_read(path, &text, NULL, error);
    for (size_t at = 0, end; status == PEND_OK && at < text.bytes && good; at = end + 1) {
        for (end = at; end < text.bytes && text.data[end] != '\n';) end++;
        good = keys_take(keys, text.data + at, end - at);
    }
    api_buffer_clear(&text);
    if (status == PEND_OK && (!good || !keys->count))
        status = pend_fail(error, PEND_INVALID, -1, 0,
                           "webhook-secret: %.120s must have one line, or two, of %d to %d visible "
                           "ASCII characters each",
                           path, SRV_HOOK_SECRET_LEAST, SRV_HOOK_SECRET_BYTES - 1);
    return status;
}

void srv_hook_keys_secret(const struct srv_hook_keys *keys, const char *client,
                          char secret[API_WEBHOOK_SECRET]) {
    unsigned char key[API_WEBHOOK_KEY];
    assert(keys->count >= 1);
    api_webhook_key(keys->secret[0], client, key);
    api_webhook_secret(key, secret);
}

void srv_hook_keys_sign(const struct srv_hook_keys *keys, const char *client, const char *id,
                        const char *timestamp, const char *body, size_t bytes,
                        char signatures[SRV_HOOK_SIGNATURES]) {
    assert(keys->count >= 1);
    size_t used = 0;
    for (int i = 0; i < keys->count; i++) {
        unsigned char key[API_WEBHOOK_KEY];
        if (i) signatures[used++] = ' ';
        api_webhook_key(keys->secret[i], client, key);
        api_webhook_sign(key, id, timestamp, body, bytes, signatures + used);
        used += strlen(signatures + used);
    }
}
