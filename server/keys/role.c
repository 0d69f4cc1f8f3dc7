#include "server/keys/role.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const role_words[SRV_ROLE_COUNT] = {"",        "anonymous", "pupil",
                                                       "teacher", "batch",     "operator"};

#define MEGA 1048576.0

/* For each role: requests per second, seconds of computation per minute, bytes of memory, bytes
 * stored, open jobs, priority, classrooms. */
static const struct srv_limits role_limits[SRV_ROLE_COUNT] = {
    [SRV_ROLE_NONE] = {{INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, 0, 10}},
    [SRV_ROLE_ANONYMOUS] = {{INFINITY, INFINITY, INFINITY, 64 * MEGA, 0, 0, 10}},
    [SRV_ROLE_PUPIL] = {{20, 60, 128 * MEGA, 64 * MEGA, 0, 0, 2}},
    [SRV_ROLE_TEACHER] = {{50, 240, INFINITY, 1024 * MEGA, 100, 0, 20}},
    [SRV_ROLE_BATCH] = {{100, INFINITY, INFINITY, INFINITY, INFINITY, 1, 10}},
    [SRV_ROLE_OPERATOR] = {{INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, 0, INFINITY}},
};

static const struct {
    const char *word, *right;
    int whole, bytes;
    double least, most;
} limit_rows[SRV_LIMIT_COUNT] = {
    {"requests", "0 to 10000 a second", 0, 0, 0, 10000},
    {"compute", "0 to 60000 seconds a minute", 0, 0, 0, 60000},
    {"memory", "bytes from 1M to 1000000G", 1, 1, MEGA, 1e15},
    {"bytes", "bytes up to 1000000G", 1, 1, 0, 1e15},
    {"jobs", "a whole number up to 1000000000", 1, 0, 0, 1e9},
    {"priority", "0, 1, 2 or 3: a higher number has a lower priority", 1, 0, 0, 3},
    {"rooms", "a whole number up to 1000000 of classrooms", 1, 0, 0, 1e6},
};

const char *srv_role_word(enum srv_role role) {
    assert(role < SRV_ROLE_COUNT);
    return role_words[role];
}

enum srv_role srv_role_of(const char *word, size_t bytes) {
    for (int role = SRV_ROLE_ANONYMOUS; role < SRV_ROLE_COUNT; role++)
        if (strlen(role_words[role]) == bytes && !memcmp(role_words[role], word, bytes))
            return (enum srv_role)role;
    return SRV_ROLE_NONE;
}

struct srv_limits srv_role_limits(enum srv_role role) {
    assert(role < SRV_ROLE_COUNT);
    return role_limits[role];
}

void srv_limits_unset(struct srv_limits *limits) {
    for (int i = 0; i < SRV_LIMIT_COUNT; i++) limits->value[i] = SRV_LIMIT_UNSET;
}

/* Parses digits with at most one point, followed by K, M or G for bytes. Returns 0 if malformed. */
static int limit_number(const char *text, int whole, int bytes, double *value) {
    size_t digits = strspn(text, "0123456789");
    size_t all = digits;
    if (!whole && text[digits] == '.') all += 1 + strspn(text + digits + 1, "0123456789");
    if (!digits || all > 18) return 0;
    *value = strtod(text, NULL);
    static const char units[] = "KMG";
    const char *unit = bytes && text[all] ? strchr(units, text[all]) : NULL;
    if (unit) *value = ldexp(*value, 10 * (int)(unit - units + 1));
    return !text[all + (unit != NULL)];
}

enum pend_status srv_limits_read(struct srv_limits *limits, const char *text,
                                 struct pend_error *error) {
    assert(limits && text);
    const char *equals = strchr(text, '=');
    size_t bytes = equals ? (size_t)(equals - text) : strlen(text);
    for (int i = 0; i < SRV_LIMIT_COUNT; i++) {
        double value = INFINITY;
        if (strlen(limit_rows[i].word) != bytes || memcmp(limit_rows[i].word, text, bytes))
            continue;
        int none = equals && !strcmp(equals + 1, "none") && i != SRV_LIMIT_PRIORITY;
        int good =
            none ||
            (equals && limit_number(equals + 1, limit_rows[i].whole, limit_rows[i].bytes, &value) &&
             value >= limit_rows[i].least && value <= limit_rows[i].most);
        if (!good)
            return pend_fail(error, PEND_INVALID, -1, 0, "%s must be %s%s, got '%.40s'",
                             limit_rows[i].word, limit_rows[i].right,
                             i == SRV_LIMIT_PRIORITY ? "" : ", or none", equals ? equals + 1 : "");
        limits->value[i] = value;
        return PEND_OK;
    }
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "'%.40s' is not a limit: the limits are requests, compute, memory, bytes, "
                     "jobs, priority and rooms",
                     text);
}

void srv_limits_write(const struct srv_limits *limits, char text[SRV_LIMITS_TEXT]) {
    size_t at = 0;
    text[0] = 0;
    for (int i = 0; i < SRV_LIMIT_COUNT; i++) {
        double value = limits->value[i];
        assert(at < SRV_LIMITS_TEXT && !isnan(value));
        if (isinf(value))
            at += (size_t)snprintf(text + at, SRV_LIMITS_TEXT - at, " %s=none", limit_rows[i].word);
        else if (value >= 0)
            at += (size_t)snprintf(text + at, SRV_LIMITS_TEXT - at, " %s=%.15g", limit_rows[i].word,
                                   value);
    }
}

struct srv_limits srv_limits_over(const struct srv_limits *own, const struct srv_limits *other) {
    assert(own && other);
    struct srv_limits both = *own;
    for (int i = 0; i < SRV_LIMIT_COUNT; i++)
        if (both.value[i] < 0) both.value[i] = other->value[i];
    return both;
}
