/* Fuzzes header fields and the values that proxies and clients send in them.
 * Leaves to others: the layout of fields in a message (fuzz_front), all stages of a request
 * together (fuzz_router).
 * Invariant: every input ends with a valid value or a refusal; a value that is written again reads
 * the same. */
#include <arpa/inet.h>
#include <curl/curl.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "api/call/job_json.h"
#include "api/json/json_hint.h"
#include "api/number/number.h"
#include "server/config/hosts.h"
#include "server/keys/keys.h"
#include "server/protocol/coding.h"
#include "server/protocol/cors.h"
#include "server/protocol/identity.h"
#include "server/protocol/peer.h"
#include "server/protocol/range.h"
#include "tests/fuzz/fuzz.h"

static int read_range(char *text, size_t bytes) {
    struct api_range range = {-7, -7}, again;
    char written[80];
    (void)bytes;
    if (!srv_range_read(text, &range)) return 1;
    if (range.first < -1 || range.last < -1) return 0;
    /* the field's canonical text, without blanks */
    if (range.first < 0)
        snprintf(written, sizeof written, "bytes=-%lld", (long long)range.last);
    else if (range.last < 0)
        snprintf(written, sizeof written, "bytes=%lld-", (long long)range.first);
    else
        snprintf(written, sizeof written, "bytes=%lld-%lld", (long long)range.first,
                 (long long)range.last);
    return srv_range_read(written, &again) && again.first == range.first &&
           again.last == range.last;
}

static int read_coding(char *text, size_t bytes) {
    (void)bytes;
    enum srv_coding coding = srv_coding_choose(text);
    return !coding || srv_coding_accepts(text, coding);
}

/* ORIGIN LF HOST LF LIST */
static int read_places(char *text, size_t bytes) {
    char *host = memchr(text, '\n', bytes), *list = NULL;
    if (host) *host++ = 0;
    if (host && (list = strchr(host, '\n'))) *list++ = 0;
    if (!host) host = text;
    if (!list) list = text;
    const char *told = srv_cors_origin(list, text, (int)(bytes & 1));
    srv_cors_foreign(list, text, bytes & 2 ? "same-origin" : NULL, host);
    srv_hosts_numeric(host);
    if (srv_hosts_good(list)) srv_hosts_allow(list, host);
    /* the returned origin is the request's own, or any */
    return !told || !strcmp(told, "*") || !strcmp(told, text);
}

/* FIELD LF NETWORKS */
static int read_peer(char *text, size_t bytes) {
    static const char *const headers[] = {"X-Forwarded-For", "Forwarded"};
    struct srv_peers peers;
    struct pend_error error = {.text = ""};
    struct in6_addr number;
    char client[SRV_PEER_BYTES], shown[SRV_PEER_BYTES];
    char *list = memchr(text, '\n', bytes);
    if (list) *list++ = 0;
    if (srv_peers_read(&peers, list ? list : "127.0.0.0/8,unix", &error) != PEND_OK)
        return error.text[0] != 0;
    for (int i = 0; i < 2; i++) {
        srv_peer_client(&peers, "127.0.0.1", headers[i], text, client);
        if (!memchr(client, 0, sizeof client)) return 0;
        /* the result is an address that can be counted, whatever the field contained */
        if (inet_pton(AF_INET, client, &number) != 1 && inet_pton(AF_INET6, client, &number) != 1)
            return 0;
        srv_peer_network(client, shown);
        srv_peer_shorten(text, shown);
        if (!memchr(shown, 0, sizeof shown)) return 0;
    }
    return 1;
}

static int read_identity(char *text, size_t bytes) {
    struct srv_identity identity;
    char key[SRV_IDENTITY_KEY];
    (void)bytes;
    srv_identity_begin(&identity, "192.0.2.1", text);
    srv_identity_token(&identity, text);
    srv_keys_whole(text);
    srv_keys_meant(text);
    return !srv_identity_named(text, key) || memchr(key, 0, sizeof key);
}

static int read_instant(char *text, size_t bytes) {
    int64_t instant = 0, again = 0, now = 1800000000;
    char shown[SRV_KEY_TIME];
    struct srv_limits limits;
    struct pend_error error = {.text = ""};
    (void)bytes;
    if (srv_limits_read(&limits, text, &error) != PEND_OK && !error.text[0]) return 0;
    if (!srv_keys_instant(text, now, &instant)) return 1;
    srv_keys_time(instant, shown);
    return !instant || (srv_keys_instant(shown, now, &again) && again == instant);
}

/* an instant of the API; its text in UTC, to the millisecond, reads the same */
static int read_moment(char *text, size_t bytes) {
    int64_t us = 0, again = 0;
    OWN(api_buffer, clear) out = {0};
    char *at, *end;
    (void)bytes;
    if (!api_job_instant(text, &us)) return 1;
    if (us < 0) return 0;
    api_buffer_init(&out, 256);
    int good = api_job_time(&out, "at", us) == PEND_OK && api_buffer_add(&out, "", 1) == PEND_OK;
    if (good && us >= 1000) {
        at = strstr(out.data, ":\"");
        end = at ? strchr(at + 2, '"') : NULL;
        if (end) *end = 0;
        good = end && api_job_instant(at + 2, &again) && again == us - us % 1000;
    }
    return good;
}

/* --- pieces of JSON --- */

/* the hint about invalid JSON is a clause of at most one line, wherever the text ends */
static int read_hint(char *text, size_t bytes) {
    for (size_t at = 0; at <= bytes; at++) {
        const char *hint = api_json_hint(text, bytes, at);
        if (!hint || strlen(hint) > 200) return 0;
    }
    return 1;
}

/* the length of the number at the start of a text, by the grammar of RFC 8259 */
static size_t number_bytes(const char *text) {
    const char *at = text + (*text == '-');
    size_t whole = strspn(at, "0123456789");
    if (!whole || (*at == '0' && whole > 1)) return 0;
    at += whole;
    if (*at == '.') {
        size_t digits = strspn(at + 1, "0123456789");
        if (!digits) return 0;
        at += 1 + digits;
    }
    if (*at == 'e' || *at == 'E') {
        size_t sign = at[1] == '+' || at[1] == '-', digits = strspn(at + 1 + sign, "0123456789");
        if (digits) at += 1 + sign + digits;
    }
    return (size_t)(at - text);
}

/* a number equals the C library's result, and the shortest text of the double reads back to it */
static int read_number(char *text, size_t bytes) {
    char shown[API_NUMBER_BYTES + 1];
    size_t used = number_bytes(text);
    (void)bytes;
    if (!used) return 1;
    text[used] = 0;
    double x = api_number_read(text, text + used), wanted = strtod(text, NULL);
    if (memcmp(&x, &wanted, sizeof x) != 0) return 0;
    if (!isfinite(x)) return 1;
    char *end = api_number_write(shown, x);
    double again = api_number_read(shown, end);
    return end - shown <= 24 && !memcmp(&x, &again, sizeof x);
}

static const struct fuzz_reader fields[] = {
    {"range",
     read_range,
     {"bytes=0-99", "bytes=-500", "bytes=9500-", "bytes=0-0,-1", "bytes= 1 - 2"},
     0},
    {"coding", read_coding, {"gzip, zstd;q=0.9", "gzip;q=0, *", "identity;q=1.000,*;q=0"}, 0},
    {"places",
     read_places,
     {"https://example.org\nexample.org:8080\nhttps://example.org, https://a.example",
      "null\n[::1]:8080\n*", "http://localhost:1\nlocalhost\n*.example.org, [::1]"},
     0},
    {"peer",
     read_peer,
     {"10.0.0.1, 192.0.2.7\n10.0.0.0/8", "for=\"[2001:db8::1]:80\";proto=https, for=unknown",
      "::ffff:192.0.2.1\n::1/128,unix", "192.0.2.9\n0.0.0.0/0"},
     0},
    {"identity",
     read_identity,
     {"Bearer pdk_0123456789abcdef", "alice@example.org", "Basic YTpi", "bearer  x"},
     0},
    {"instant",
     read_instant,
     {"2026-01-31T09:30:00Z", "365d", "12h", "never", "requests=20,jobs=500,seconds=9"},
     0},
    {"moment",
     read_moment,
     {"2026-01-31T09:30:00Z", "2026-01-31T09:30:00.125+01:30", "1970-01-01T00:00:00-00:00"},
     0},
    {"hint", read_hint, {"[1,]", "{'a':NaN}", "{a:1} // b", "\xef\xbb\xbf[True]", "[1 2]"}, 0},
    {"number",
     read_number,
     {"-1.5e-300", "0.1", "123456789012345678901234567890", "4.9e-324", "1E400"},
     0},
};
FUZZ_READERS(fields)
