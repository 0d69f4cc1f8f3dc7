#include "api/call/digest.h"

#include <assert.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <nettle/sha2.h>

/* collects short pieces of input for the hash */
struct digest {
    struct sha256_ctx sha;
    size_t used;
    uint8_t gathered[256];
};

static void digest_flush(struct digest *digest) {
    sha256_update(&digest->sha, digest->used, digest->gathered);
    digest->used = 0;
}

static void digest_bytes(struct digest *digest, size_t bytes, const void *data) {
    if (bytes > sizeof digest->gathered - digest->used) digest_flush(digest);
    if (bytes > sizeof digest->gathered) {
        sha256_update(&digest->sha, bytes, data);
        return;
    }
    memcpy(digest->gathered + digest->used, data, bytes);
    digest->used += bytes;
}

/* Every value begins with a letter for its kind and its length in one or nine bytes, so that
 * different values never give the same input. */
static void digest_kind(struct digest *digest, char kind, uint64_t count) {
    uint8_t head[10] = {(uint8_t)kind, (uint8_t)(count < 255 ? count : 255)};
    memcpy(head + 2, &count, sizeof count);
    digest_bytes(digest, count < 255 ? 2 : sizeof head, head);
}

static void digest_text(struct digest *digest, const char *text) {
    size_t bytes = strlen(text);
    digest_kind(digest, 's', bytes);
    digest_bytes(digest, bytes, text);
}

/* hashes small integers as one byte each: lists of parents can be long, and hashing dominates the
 * cost */
static int digest_small(struct digest *digest, int count, const double number[]) {
    uint8_t bytes[256];
    for (int i = 0; i < count; i++)
        if (!(number[i] >= 0 && number[i] <= 255 && (uint8_t)number[i] == number[i] &&
              !signbit(number[i])))
            return 0;
    digest_kind(digest, 'w', (uint64_t)count);
    for (int i = 0, some; i < count; i += some) {
        some = count - i < 256 ? count - i : 256;
        for (int k = 0; k < some; k++) bytes[k] = (uint8_t)number[i + k];
        digest_bytes(digest, (size_t)some, bytes);
    }
    return 1;
}

static void digest_numbers(struct digest *digest, char kind, int count, const double number[]) {
    digest_kind(digest, kind, (uint64_t)count);
    digest_bytes(digest, (size_t)count * sizeof *number, number);
}

static void digest_value(struct digest *digest, const struct api_value *value);

static void digest_array(struct digest *digest, const struct api_value *value) {
    int count = 0;
    const double *number = api_value_numbers(value, &count);
    if (number) {
        if (!digest_small(digest, count, number)) digest_numbers(digest, 'v', count, number);
        return;
    }
    digest_kind(digest, 'a', (uint64_t)api_value_count(value));
    API_VALUE_EACH (item, api_value_first(value)) digest_value(digest, &item);
}

static void digest_object(struct digest *digest, const struct api_value *value) {
    const char *last = NULL;
    uint64_t members = 0; // that do not repeat a default
    API_VALUE_EACH (one, api_value_first(value)) members += !api_value_is_usual(&one);
    digest_kind(digest, 'o', members);
    for (;;) {
        struct api_value member = api_value_behind(value, last, 1);
        if (!member.node) return;
        digest_text(digest, member.key);
        digest_value(digest, &member);
        last = member.key;
    }
}

static void digest_value(struct digest *digest, const struct api_value *value) {
    double number = api_value_number(value);
    switch (api_value_kind(value)) {
    case API_NUMBER:
        digest_numbers(digest, 'n', 1, &number);
        return;
    case API_BOOL:
        digest_kind(digest, 'b', (uint64_t)number);
        return;
    case API_STRING:
        digest_text(digest, api_value_text(value));
        return;
    case API_ARRAY:
        digest_array(digest, value);
        return;
    case API_OBJECT:
        digest_object(digest, value);
        return;
    case API_NULL:
    case API_MISSING:
        digest_kind(digest, 'z', 0);
        return;
    }
}

static void digest_write(struct sha256_ctx *sha, char digest[API_DIGEST_BYTES]) {
    static const char hex[] = "0123456789abcdef";
    uint8_t bytes[SHA256_DIGEST_SIZE];
    sha256_digest(sha, sizeof bytes, bytes);
    for (int i = 0; i < SHA256_DIGEST_SIZE; i++) {
        digest[2 * i] = hex[bytes[i] >> 4];
        digest[2 * i + 1] = hex[bytes[i] & 15];
    }
    digest[2 * SHA256_DIGEST_SIZE] = 0;
}

void api_digest_bytes(char digest[API_DIGEST_BYTES], const void *data, size_t bytes) {
    struct sha256_ctx sha;
    sha256_init(&sha);
    sha256_update(&sha, bytes, data);
    digest_write(&sha, digest);
}

void api_digest(char digest[API_DIGEST_BYTES], const char *const parts[],
                const struct api_value *root) {
    assert(parts[0]);
    struct digest fed = {.used = 0};
    sha256_init(&fed.sha);
    for (int i = 0; parts[i]; i++) digest_text(&fed, parts[i]);
    if (root) digest_value(&fed, root);
    digest_flush(&fed);
    digest_write(&fed.sha, digest);
}

void api_seal(unsigned char seal[API_SEAL_BYTES], const char *place, long number, const void *data,
              size_t bytes) {
    assert(place && number >= 0 && (data || !bytes));
    struct digest fed = {.used = 0};
    uint8_t all[SHA256_DIGEST_SIZE];
    sha256_init(&fed.sha);
    digest_text(&fed, place);
    digest_kind(&fed, 'p', (uint64_t)number);
    digest_kind(&fed, 'd', bytes);
    digest_bytes(&fed, bytes, data);
    digest_flush(&fed);
    sha256_digest(&fed.sha, sizeof all, all);
    memcpy(seal, all, API_SEAL_BYTES);
}
