#include "server/keys/keys.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>

enum {
    KEYS_PREFIX = 4, /* the length of pdk_ */
    KEYS_SECRET = 32,
    KEYS_CHECK = 6,
    KEYS_LINE = 1024
};

static_assert(KEYS_PREFIX + KEYS_SECRET + KEYS_CHECK + 1 == SRV_KEY_TOKEN, "parts of a key");

static const char keys_prefix[] = "pdk_";
static const char keys_letters[] = "0123456789abcdefghjkmnpqrstvwxyz";
static const char keys_hex[] = "0123456789abcdef";

void srv_keys_init(struct srv_keys *keys) {
    *keys = (struct srv_keys){0};
    for (int role = 0; role < SRV_ROLE_COUNT; role++) srv_limits_unset(&keys->role[role]);
}

void srv_keys_clear(struct srv_keys *keys) {
    free(keys->key);
    srv_keys_init(keys);
}

/* --- a key --- */

static void keys_check(const char *token, char check[API_DIGEST_BYTES]) {
    char secret[KEYS_SECRET + 1];
    snprintf(secret, sizeof secret, "%.*s", KEYS_SECRET, token + KEYS_PREFIX);
    api_digest(check, (const char *const[]){"key-check", secret, NULL}, NULL);
}

int srv_keys_draw(char token[SRV_KEY_TOKEN]) {
    unsigned char bits[KEYS_SECRET];
    char check[API_DIGEST_BYTES];
    if (getrandom(bits, sizeof bits, 0) != (ssize_t)sizeof bits) return 0;
    memcpy(token, keys_prefix, KEYS_PREFIX);
    for (int i = 0; i < KEYS_SECRET; i++) token[KEYS_PREFIX + i] = keys_letters[bits[i] & 31];
    token[KEYS_PREFIX + KEYS_SECRET] = 0;
    keys_check(token, check);
    snprintf(token + KEYS_PREFIX + KEYS_SECRET, KEYS_CHECK + 1, "%.*s", KEYS_CHECK, check);
    explicit_bzero(bits, sizeof bits);
    return 1;
}

int srv_keys_meant(const char *token) { return !strncmp(token, keys_prefix, KEYS_PREFIX); }

int srv_keys_whole(const char *token) {
    char check[API_DIGEST_BYTES];
    if (!srv_keys_meant(token) || strlen(token) != SRV_KEY_TOKEN - 1) return 0;
    if (strspn(token + KEYS_PREFIX, keys_letters) < KEYS_SECRET) return 0;
    keys_check(token, check);
    return !memcmp(check, token + KEYS_PREFIX + KEYS_SECRET, KEYS_CHECK);
}

void srv_keys_digest(const char *token, char digest[API_DIGEST_BYTES]) {
    api_digest(digest, (const char *const[]){"key", token, NULL}, NULL);
}

int srv_keys_named(const char *name) {
    static const char letters[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";
    size_t bytes = strlen(name);
    return bytes && bytes < SRV_KEY_NAME && strspn(name, letters) == bytes && name[0] != '-';
}

int srv_keys_means(const struct srv_key *key, const char *name) {
    return !strcmp(key->name, name) ||
           (strlen(name) == SRV_KEY_ID && !strncmp(key->digest, name, SRV_KEY_ID));
}

/* --- the table --- */

static enum pend_status keys_room(struct srv_keys *keys, struct pend_error *error) {
    if (keys->count == SRV_KEYS_MOST)
        return pend_fail(error, PEND_LIMIT, -1, 0,
                         "there are %d keys, the maximum: remove old ones", SRV_KEYS_MOST);
    if (keys->count < keys->room) return PEND_OK;
    int room = keys->room ? 2 * keys->room : 16;
    struct srv_key *grown = realloc(keys->key, (size_t)room * sizeof *grown);
    if (!grown) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    keys->key = grown;
    keys->room = room;
    return PEND_OK;
}

enum pend_status srv_keys_add(struct srv_keys *keys, const struct srv_key *key,
                              struct pend_error *error) {
    assert(strlen(key->digest) == API_DIGEST_BYTES - 1);
    if (!srv_keys_named(key->name))
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "a name is 1 to %d of A-Z, a-z, 0-9, '.', '_' and '-', got '%.40s'",
                         SRV_KEY_NAME - 1, key->name);
    for (int i = 0; i < keys->count; i++) {
        const struct srv_key *other = &keys->key[i];
        if (!strcmp(other->digest, key->digest))
            return pend_fail(error, PEND_INVALID, -1, 0, "the key %.*s occurs twice", SRV_KEY_ID,
                             key->digest);
        if (!strcmp(other->name, key->name) && other->role != key->role)
            return pend_fail(error, PEND_INVALID, -1, 0,
                             "other keys with the name %s have the role %s: a client has one role",
                             key->name, srv_role_word(other->role));
    }
    PEND_TRY(keys_room(keys, error));
    assert(keys->count < keys->room);
    keys->key[keys->count++] = *key;
    return PEND_OK;
}

/* Compares two digests. The time does not depend on where they differ. */
static int keys_same(const char *one, const char *other) {
    uint64_t different = 0;
    for (size_t i = 0; i < API_DIGEST_BYTES - 1; i += sizeof different) {
        uint64_t a, b;
        memcpy(&a, one + i, sizeof a);
        memcpy(&b, other + i, sizeof b);
        different |= a ^ b;
    }
    return (int)(1 & ((different | (0 - different)) >> 63 ^ 1));
}

struct srv_key *srv_keys_find(const struct srv_keys *keys, const char digest[API_DIGEST_BYTES]) {
    assert(strnlen(digest, API_DIGEST_BYTES) == API_DIGEST_BYTES - 1);
    int found = -1;
    for (int i = 0; i < keys->count; i++) {
        int same = -keys_same(keys->key[i].digest, digest);
        found = (found & ~same) | (i & same);
    }
    return found < 0 ? NULL : &keys->key[found];
}

struct srv_limits srv_keys_role(const struct srv_keys *keys, enum srv_role role) {
    struct srv_limits start = srv_role_limits(role);
    return srv_limits_over(&keys->role[role], &start);
}

struct srv_limits srv_keys_limits(const struct srv_keys *keys, const struct srv_key *key) {
    struct srv_limits role = srv_keys_role(keys, key->role);
    return srv_limits_over(&key->limits, &role);
}

/* --- instants --- */

void srv_keys_time(int64_t instant, char text[SRV_KEY_TIME]) {
    struct tm part;
    time_t seconds = (time_t)instant;
    if (!instant || !gmtime_r(&seconds, &part) ||
        !strftime(text, SRV_KEY_TIME, "%Y-%m-%dT%H:%M:%SZ", &part))
        snprintf(text, SRV_KEY_TIME, "never");
}

/* Parses a span such as 90d. Returns 0 if it is malformed. */
static int keys_span(const char *text, int64_t *seconds) {
    static const char units[] = "smhdw";
    static const int64_t each[] = {1, 60, 3600, 86400, 604800};
    size_t digits = strspn(text, "0123456789");
    const char *unit = text[digits] ? strchr(units, text[digits]) : NULL;
    if (!digits || digits > 8 || !unit || text[digits + 1]) return 0;
    *seconds = atoll(text) * each[unit - units];
    return 1;
}

/* The last instant of the year 9999. */
#define KEYS_LATEST INT64_C(253402300799)

int srv_keys_instant(const char *text, int64_t now, int64_t *instant) {
    static const char *const forms[] = {"%Y-%m-%dT%H:%M:%SZ", "%Y-%m-%d"};
    static const size_t lengths[] = {20, 10};
    int64_t span;
    if (!strcmp(text, "never")) {
        *instant = 0;
        return 1;
    }
    if (!strcmp(text, "now") || keys_span(text, &span)) {
        *instant = now + (strcmp(text, "now") ? span : 0);
        return *instant <= KEYS_LATEST;
    }
    for (int i = 0; i < 2; i++) {
        struct tm part = {0}, same;
        const char *end = strptime(text, forms[i], &part);
        if (!end || *end || strlen(text) != lengths[i]) continue;
        same = part;
        *instant = (int64_t)timegm(&part);
        /* refuses dates that do not exist, such as 31 April */
        return *instant > 0 && part.tm_mday == same.tm_mday && part.tm_sec == same.tm_sec;
    }
    return 0;
}

/* --- text --- */

static enum pend_status keys_field(struct srv_key *key, const char *field,
                                   struct pend_error *error) {
    static const char *const words[] = {"role=", "made=", "expires=", "revoked=", "digest="};
    const char *value = strchr(field, '=');
    size_t word = 0, count = sizeof words / sizeof *words;
    while (word < count && strncmp(field, words[word], strlen(words[word]))) word++;
    if (word == count) return srv_limits_read(&key->limits, field, error);
    value++;
    if (word == 0) {
        key->role = srv_role_of(value, strlen(value));
        if (key->role > SRV_ROLE_ANONYMOUS) return PEND_OK;
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "a key's role is pupil, teacher, batch or operator, got '%.40s'", value);
    }
    if (word == 4) {
        if (strlen(value) != API_DIGEST_BYTES - 1 || value[strspn(value, keys_hex)])
            return pend_fail(error, PEND_INVALID, -1, 0, "digest must be 64 hexadecimal digits");
        memcpy(key->digest, value, API_DIGEST_BYTES);
        return PEND_OK;
    }
    int64_t *const instant[] = {&key->made, &key->expires, &key->revoked};
    if (strchr("0123456789n", *value) && strcmp(value, "now") &&
        srv_keys_instant(value, 0, instant[word - 1]) && (strchr(value, '-') || *value == 'n'))
        return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "%s must be like 2026-01-31T09:30:00Z, got '%.40s'", words[word], value);
}

static enum pend_status keys_line_key(struct srv_keys *keys, char **rest,
                                      struct pend_error *error) {
    struct srv_key key = {.role = SRV_ROLE_NONE};
    srv_limits_unset(&key.limits);
    const char *name = strtok_r(NULL, " \t\r", rest);
    snprintf(key.name, sizeof key.name, "%s", name ? name : "");
    if (!name || strlen(name) >= sizeof key.name || !srv_keys_named(name))
        return pend_fail(error, PEND_INVALID, -1, 0, "'%.40s' is not the name of a key",
                         name ? name : "");
    for (const char *field; (field = strtok_r(NULL, " \t\r", rest));)
        PEND_TRY(keys_field(&key, field, error));
    if (!key.role || !key.digest[0])
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "the key %s needs role= and digest=", key.name);
    return srv_keys_add(keys, &key, error);
}

static enum pend_status keys_line_role(struct srv_keys *keys, char **rest,
                                       struct pend_error *error) {
    const char *name = strtok_r(NULL, " \t\r", rest);
    enum srv_role role = name ? srv_role_of(name, strlen(name)) : SRV_ROLE_NONE;
    if (!role)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "a role is anonymous, pupil, teacher, batch or operator, got '%.40s'",
                         name ? name : "");
    for (const char *field; (field = strtok_r(NULL, " \t\r", rest));)
        PEND_TRY(srv_limits_read(&keys->role[role], field, error));
    return PEND_OK;
}

static enum pend_status keys_line(struct srv_keys *keys, char *line, struct pend_error *error) {
    char *rest = NULL;
    const char *word = strtok_r(line, " \t\r", &rest);
    if (!word || *word == '#') return PEND_OK;
    if (!strcmp(word, "key")) return keys_line_key(keys, &rest, error);
    if (!strcmp(word, "role")) return keys_line_role(keys, &rest, error);
    return pend_fail(error, PEND_INVALID, -1, 0, "a line begins with key, role or #, got '%.40s'",
                     word);
}

enum pend_status srv_keys_read(struct srv_keys *keys, const char *text, size_t bytes,
                               struct pend_error *error) {
    char line[KEYS_LINE];
    struct pend_error why = {.text = ""};
    const char *end = text + bytes;
    for (int number = 1; text < end; number++) {
        const char *stop = memchr(text, '\n', (size_t)(end - text));
        size_t length = (size_t)((stop ? stop : end) - text);
        int odd = length >= sizeof line || memchr(text, 0, length);
        if (!odd) memcpy(line, text, length);
        line[odd ? 0 : length] = 0;
        enum pend_status status =
            odd ? pend_fail(&why, PEND_INVALID, -1, 0, "it is too long, or not text")
                : keys_line(keys, line, &why);
        if (status != PEND_OK)
            return pend_fail(error, status, -1, 0, "line %d: %.200s", number, why.text);
        text += length + (stop != NULL);
    }
    return PEND_OK;
}

static enum pend_status keys_write_key(const struct srv_key *key, struct api_buffer *out) {
    char limits[SRV_LIMITS_TEXT], time[SRV_KEY_TIME];
    srv_keys_time(key->made, time);
    PEND_TRY(api_buffer_format(out, "key %s role=%s made=%s", key->name, srv_role_word(key->role),
                               time));
    srv_keys_time(key->expires, time);
    if (key->expires) PEND_TRY(api_buffer_format(out, " expires=%s", time));
    srv_keys_time(key->revoked, time);
    if (key->revoked) PEND_TRY(api_buffer_format(out, " revoked=%s", time));
    srv_limits_write(&key->limits, limits);
    return api_buffer_format(out, "%s digest=%s\n", limits, key->digest);
}

enum pend_status srv_keys_write(const struct srv_keys *keys, struct api_buffer *out) {
    char limits[SRV_LIMITS_TEXT];
    PEND_TRY(api_buffer_text(out, "# Keys of pendulumd, as digests: `pendulumd keys` writes this "
                                  "file, and running servers read it again.\n"));
    for (int role = SRV_ROLE_ANONYMOUS; role < SRV_ROLE_COUNT; role++) {
        srv_limits_write(&keys->role[role], limits);
        if (limits[0])
            PEND_TRY(
                api_buffer_format(out, "role %s%s\n", srv_role_word((enum srv_role)role), limits));
    }
    for (int i = 0; i < keys->count; i++) PEND_TRY(keys_write_key(&keys->key[i], out));
    return PEND_OK;
}
