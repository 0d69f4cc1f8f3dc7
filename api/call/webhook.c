#include "api/call/webhook.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <nettle/base64.h>
#include <nettle/hmac.h>

#include "api/json/json_out.h"

/* --- urls --- */

static int url_within(const char *text, size_t bytes, const char *others) {
    for (size_t i = 0; i < bytes; i++) {
        char letter = text[i];
        int plain = (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
                    (letter >= '0' && letter <= '9');
        if (!plain && (!letter || !strchr(others, letter))) return 0;
    }
    return 1;
}

/* the port behind a colon, up to a slash, a question mark or the end; -1 where it is none */
static int url_port(const char *text, const char **end) {
    size_t digits = strspn(text, "0123456789");
    int port = digits && digits < 6 ? atoi(text) : -1;
    *end = text + digits;
    return port >= 1 && port <= 65535 ? port : -1;
}

/* reads the host; *end is behind it. Returns 0 where it is none */
static int url_host(const char *text, struct api_webhook_place *place, const char **end) {
    int bracket = *text == '[';
    const char *host = text + bracket;
    size_t bytes = strcspn(host, bracket ? "]" : ":/?");
    *end = host + bytes + bracket;
    if (bracket && !host[bytes]) return 0;
    if (!bytes || bytes >= API_WEBHOOK_HOST || !url_within(host, bytes, bracket ? ":." : "-."))
        return 0;
    memcpy(place->host, host, bytes);
    return 1;
}

const char *api_webhook_url(const char *url, struct api_webhook_place *place) {
    static const char scheme[] = "https://";
    const char *end;
    *place = (struct api_webhook_place){.port = 443};
    if (strncmp(url, scheme, sizeof scheme - 1)) return "must begin with https://";
    if (!url_host(url + sizeof scheme - 1, place, &end))
        return "must have a host of letters, digits, hyphens and dots, or an address, and no user";
    if (*end == ':' && (place->port = url_port(end + 1, &end)) < 0)
        return "must have a port of 1 to 65535";
    if (*end && *end != '/' && *end != '?') return "must have a path or nothing behind its host";
    if (!url_within(end, strlen(end), "/?-._~!$&'()*+,;=:@%[]"))
        return "must be visible ASCII without a fragment, other letters percent-encoded";
    return NULL;
}

/* --- signatures --- */

static void webhook_hmac(const void *key, size_t bytes, const char *const text[],
                         const size_t length[], int count, unsigned char out[API_WEBHOOK_KEY]) {
    struct hmac_sha256_ctx mac;
    hmac_sha256_set_key(&mac, bytes, key);
    for (int i = 0; i < count; i++) hmac_sha256_update(&mac, length[i], (const uint8_t *)text[i]);
    hmac_sha256_digest(&mac, API_WEBHOOK_KEY, out);
}

void api_webhook_key(const char *secret, const char *name, unsigned char key[API_WEBHOOK_KEY]) {
    const char *const text[] = {"pendulumd webhooks of ", name};
    const size_t length[] = {strlen(text[0]), strlen(name)};
    assert(*secret && *name);
    webhook_hmac(secret, strlen(secret), text, length, 2, key);
}

/* a key in base 64 behind some letters */
static void webhook_letters(const char *before, const unsigned char key[API_WEBHOOK_KEY],
                            char out[]) {
    size_t bytes = strlen(before);
    memcpy(out, before, bytes);
    base64_encode_raw(out + bytes, API_WEBHOOK_KEY, key);
    out[bytes + BASE64_ENCODE_RAW_LENGTH(API_WEBHOOK_KEY)] = 0;
}

void api_webhook_secret(const unsigned char key[API_WEBHOOK_KEY], char text[API_WEBHOOK_SECRET]) {
    webhook_letters("whsec_", key, text);
}

void api_webhook_id(const char *job, char id[API_WEBHOOK_ID]) {
    const char *const text[] = {job};
    const size_t length[] = {strlen(job)};
    unsigned char mac[API_WEBHOOK_KEY];
    webhook_hmac("message", 7, text, length, 1, mac);
    memcpy(id, "msg_", 4);
    for (int i = 0; i < 16; i++) snprintf(id + 4 + (size_t)2 * (size_t)i, 3, "%02x", mac[i]);
}

void api_webhook_sign(const unsigned char key[API_WEBHOOK_KEY], const char *id,
                      const char *timestamp, const char *body, size_t bytes,
                      char signature[API_WEBHOOK_SIGNATURE]) {
    const char *const text[] = {id, ".", timestamp, ".", body};
    const size_t length[] = {strlen(id), 1, strlen(timestamp), 1, bytes};
    unsigned char mac[API_WEBHOOK_KEY];
    webhook_hmac(key, API_WEBHOOK_KEY, text, length, 5, mac);
    webhook_letters("v1,", mac, signature);
}

/* --- messages --- */

enum pend_status api_webhook_write(const struct api_job *job, struct api_buffer *out) {
    char type[64];
    assert(job->id && job->status && job->finished > 0);
    snprintf(type, sizeof type, "job.%.40s", job->status);
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_text(out, "type", type));
    PEND_TRY(api_job_time(out, "timestamp", job->finished));
    PEND_TRY(api_out_key(out, "data"));
    PEND_TRY(api_job_write(job, out));
    return api_buffer_text(out, "}");
}
