#include "api/digest.h"

#include <stdint.h>
#include <string.h>

#include <nettle/sha2.h>

/* every value begins with a letter for its kind, every text with its length: what is fed in can be read in one way only
 */

static void digest_kind(struct sha256_ctx *sha, char kind, uint64_t count) {
    uint8_t head[9] = {(uint8_t)kind};
    memcpy(head + 1, &count, sizeof count);
    sha256_update(sha, sizeof head, head);
}

static void digest_text(struct sha256_ctx *sha, const char *text) {
    size_t bytes = strlen(text);
    digest_kind(sha, 's', bytes);
    sha256_update(sha, bytes, (const uint8_t *)text);
}

static void digest_numbers(struct sha256_ctx *sha, char kind, int count, const double number[]) {
    digest_kind(sha, kind, (uint64_t)count);
    sha256_update(sha, (size_t)count * sizeof *number, (const uint8_t *)number);
}

static void digest_value(struct sha256_ctx *sha, const struct api_value *value);

static void digest_array(struct sha256_ctx *sha, const struct api_value *value) {
    int count = 0;
    const double *number = api_value_numbers(value, &count);
    if (number) {
        digest_numbers(sha, 'v', count, number);
        return;
    }
    digest_kind(sha, 'a', (uint64_t)api_value_count(value));
    struct api_value item = api_value_first(value);
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) digest_value(sha, &item);
}

/* the member whose key comes next behind `last` in the order of bytes; missing behind the last */
static struct api_value member_behind(const struct api_value *object, const char *last) {
    struct api_value member = api_value_first(object), least = {0};
    for (; api_value_kind(&member) != API_MISSING; member = api_value_next(&member)) {
        if (last && strcmp(member.key, last) <= 0) continue;
        if (!least.node || strcmp(member.key, least.key) < 0) least = member;
    }
    return least;
}

static void digest_object(struct sha256_ctx *sha, const struct api_value *value) {
    const char *last = NULL;
    digest_kind(sha, 'o', (uint64_t)api_value_count(value));
    for (;;) {
        struct api_value member = member_behind(value, last);
        if (!member.node) return;
        digest_text(sha, member.key);
        digest_value(sha, &member);
        last = member.key;
    }
}

static void digest_value(struct sha256_ctx *sha, const struct api_value *value) {
    double number = api_value_number(value);
    switch (api_value_kind(value)) {
    case API_NUMBER:
        digest_numbers(sha, 'n', 1, &number);
        return;
    case API_BOOL:
        digest_kind(sha, 'b', (uint64_t)number);
        return;
    case API_STRING:
        digest_text(sha, api_value_text(value));
        return;
    case API_ARRAY:
        digest_array(sha, value);
        return;
    case API_OBJECT:
        digest_object(sha, value);
        return;
    case API_NULL:
    case API_MISSING:
        digest_kind(sha, 'z', 0);
        return;
    }
}

void api_digest(char digest[API_DIGEST_BYTES], const char *const parts[], const struct api_value *root) {
    static const char hex[] = "0123456789abcdef";
    struct sha256_ctx sha;
    uint8_t bytes[SHA256_DIGEST_SIZE];
    sha256_init(&sha);
    for (int i = 0; parts[i]; i++) digest_text(&sha, parts[i]);
    if (root) digest_value(&sha, root);
    sha256_digest(&sha, sizeof bytes, bytes);
    for (int i = 0; i < SHA256_DIGEST_SIZE; i++) {
        digest[2 * i] = hex[bytes[i] >> 4];
        digest[2 * i + 1] = hex[bytes[i] & 15];
    }
    digest[2 * SHA256_DIGEST_SIZE] = 0;
}
