/* Texts that are no JSON under bytes that nobody would send: header fields, what proxies say, the
 * files of keys and of options, recorded requests and tables of measurements. libFuzzer's entry,
 * and a test that makes mutations of its own from a seed. Leaves to others: JSON (fuzz_json),
 * requests (fuzz_call), messages (test_http_strict). Invariant: whatever is read ends with a good
 * value or a refusal; what was read and is written again reads the same. Texts end at a page that
 * cannot be read. */
#include <arpa/inet.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "api/call/call.h"
#include "api/encode/negotiate.h"
#include "server/base/config_load.h"
#include "server/base/hosts.h"
#include "server/keys/keys.h"
#include "server/protocol/coding.h"
#include "server/protocol/cors.h"
#include "server/protocol/identity.h"
#include "server/protocol/peer.h"
#include "server/protocol/range.h"
#include "server/work/recording.h"
#ifndef FUZZER
#include "tests/harness/test.h"
#endif

enum { ROOM = 1 << 14 };

/* returns 0 where an invariant does not hold */
typedef int read_fn(char *text, size_t bytes);

/* --- fields of requests --- */

static int read_range(char *text, size_t bytes) {
    struct api_range range = {-7, -7}, again;
    char written[80];
    (void)bytes;
    if (!srv_range_read(text, &range)) return 1;
    if (range.first < -1 || range.last < -1) return 0;
    /* as the field is written without blanks */
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

static int read_accept(char *text, size_t bytes) {
    (void)bytes;
    api_negotiate_json(text);
    for (int samples = 0; samples < 3; samples++) {
        const struct api_format *format = api_negotiate_format(text, samples);
        if (format && !format->content_type[0]) return 0;
    }
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
    /* an origin that is told back is the one that asked, or any */
    return !told || !strcmp(told, "*") || !strcmp(told, text);
}

/* --- who asks --- */

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
        /* an address that can be counted by, whatever was said */
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

/* --- files --- */

static int read_keys(char *text, size_t bytes) {
    struct srv_keys keys, again;
    struct pend_error error = {.text = ""};
    struct api_buffer written, twice;
    int good;
    srv_keys_init(&keys);
    srv_keys_init(&again);
    api_buffer_init(&written, 1 << 20);
    api_buffer_init(&twice, 1 << 20);
    if (srv_keys_read(&keys, text, bytes, &error) != PEND_OK)
        good = error.text[0] != 0;
    else
        good = srv_keys_write(&keys, &written) == PEND_OK &&
               srv_keys_read(&again, written.data ? written.data : "", written.bytes, &error) ==
                   PEND_OK &&
               srv_keys_write(&again, &twice) == PEND_OK && twice.bytes == written.bytes &&
               (!twice.bytes || !memcmp(twice.data, written.data, twice.bytes));
    api_buffer_clear(&written);
    api_buffer_clear(&twice);
    srv_keys_clear(&keys);
    srv_keys_clear(&again);
    return good;
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

static int read_recording(char *text, size_t bytes) {
    struct srv_recording recording;
    struct pend_error error = {.text = ""};
    return srv_recording_read(&recording, text, bytes, &error) == PEND_OK || error.text[0];
}

/* a file of options; their values must be good, or the message says which is not */
static int read_options(char *text, size_t bytes) {
    static int file = -1;
    static char path[32];
    static struct srv_config config;
    struct pend_error error = {.text = ""};
    char program[] = "pendulumd", option[] = "--config";
    char *words[] = {program, option, path, NULL}, *none[] = {NULL};
    if (file < 0) {
        file = memfd_create("options", 0);
        snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    }
    if (file < 0 || ftruncate(file, 0) || pwrite(file, text, bytes, 0) != (ssize_t)bytes) abort();
    if (srv_config_load(&config, 3, words, none, &error) != PEND_OK) return error.text[0] != 0;
    for (int i = 0;; i++) {
        struct srv_option row;
        size_t size;
        if (!srv_config_row(i, &row)) return 1;
        const void *value = srv_config_value(&config, i, &size);
        if (value && size == sizeof(double) && row.most > row.least) {
            double number;
            memcpy(&number, value, sizeof number);
            if (!(number >= row.least && number <= row.most)) return 0;
        } else if (value && size != sizeof(double) && !memchr(value, 0, size)) {
            return 0;
        }
    }
}

/* a table of measurements, in a request that is read and not run */
static int read_table(char *text, size_t bytes) {
    static const char before[] = "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},"
                                 "\"unknowns\":[{\"vary\":\"gravity\"}],\"data\":{\"csv\":\"";
    struct api_buffer body, out;
    struct api_limits limits;
    struct api_call *call = NULL;
    int good = 0;
    api_limits_init(&limits);
    api_buffer_init(&body, 1 << 20);
    api_buffer_init(&out, 1 << 20);
    enum pend_status status = api_buffer_text(&body, before);
    for (size_t i = 0; status == PEND_OK && i < bytes; i++)
        status = (unsigned char)text[i] < ' ' || (unsigned char)text[i] > '~' || text[i] == '"' ||
                         text[i] == '\\'
                     ? api_buffer_format(&body, "\\u%04x", (unsigned char)text[i])
                     : api_buffer_add(&body, &text[i], 1);
    if (status == PEND_OK) status = api_buffer_text(&body, "\"}}");
    if (status == PEND_OK) status = api_call_new(&call, &limits);
    if (status == PEND_OK) {
        const struct api_request request = {.op = API_OP_FITS,
                                            .content_type = "application/json",
                                            .body = body.data,
                                            .body_bytes = body.bytes};
        enum api_progress progress = api_call_open(call, &request, &out);
        int http = api_call_answer(call).status;
        /* no text may hold a NUL, however it is written */
        int nul = http == 400 && memchr(text, 0, bytes);
        good = progress == API_MORE || http == 422 || http == 503 || nul;
    }
    api_call_free(&call);
    api_buffer_clear(&body);
    api_buffer_clear(&out);
    return good;
}

/* --- all of them --- */

static const struct {
    read_fn *read;
    const char *seed[6];
} readers[] = {
    {read_range, {"bytes=0-99", "bytes=-500", "bytes=9500-", "bytes=0-0,-1", "bytes= 1 - 2"}},
    {read_accept,
     {"application/json", "text/csv;q=0.5, application/x-npz;q=1", "*/*;q=0.1, image/png",
      "gzip, zstd;q=0.9", "gzip;q=0, *", "application/json; charset=utf-8"}},
    {read_places,
     {"https://example.org\nexample.org:8080\nhttps://example.org, https://a.example",
      "null\n[::1]:8080\n*", "http://localhost:1\nlocalhost\n*.example.org, [::1]"}},
    {read_peer,
     {"10.0.0.1, 192.0.2.7\n10.0.0.0/8", "for=\"[2001:db8::1]:80\";proto=https, for=unknown",
      "::ffff:192.0.2.1\n::1/128,unix", "192.0.2.9\n0.0.0.0/0"}},
    {read_identity,
     {"Bearer pdk_0123456789abcdef", "alice@example.org", "Basic YTpi", "bearer  x"}},
    {read_keys,
     {"role pupil requests=2 compute=none\n\trole  anonymous jobs=3\r\n",
      "# a comment\n\nkey lab role=batch made=2023-11-14T22:13:20Z expires=2030-01-01T00:00:00Z "
      "revoked=2024-02-29 priority=2 jobs=5 digest="
      "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef\n"}},
    {read_instant,
     {"2026-01-31T09:30:00Z", "365d", "12h", "never", "requests=20,jobs=500,seconds=9"}},
    {read_recording,
     {"pendulumd request 1 64 2 "
      "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef\nengine: "
      "0123456789abcdef\noperation: modes\nmethod: POST\n{}"}},
    {read_options,
     {"listen = 127.0.0.1:8080\n# a comment\nworkers = 2\nmax-held-bytes = 1G\n",
      "role=worker\nstore = postgresql:///x\nheader-seconds = 0.5\nwalls = auto\n",
      "hosts = *.example.org, [::1]:8080\nframe-ancestors = https://a.example\nlog-client = "
      "none\n"}},
    {read_table,
     {"t,x,y\n0,1,2\n0.1,1.1,2.1\n", "mass A;;;mass B;\nt;x;y;x;y\n0;1,5;2;3;4\n",
      "t\ttheta_1\ttheta_2\r\n0\t1\t-2e-1\r\n1\t\t3\r\n", "# a\ntime, phi_1\n0, 1\n1, NaN\n"}},
};
enum { READERS = sizeof readers / sizeof *readers };

/* the first byte chooses the reader; the rest lies before a page that cannot be read, with a NUL */
static int sound(const uint8_t *data, size_t bytes) {
    static char *wall;
    if (!wall) {
        wall = mmap(NULL, 2 * ROOM, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (wall == MAP_FAILED || mprotect(wall + ROOM, ROOM, PROT_NONE)) abort();
    }
    if (!bytes || bytes >= ROOM) return 1;
    char *text = wall + ROOM - bytes;
    memcpy(text, data + 1, bytes - 1);
    text[bytes - 1] = 0;
    return readers[data[0] % READERS].read(text, bytes - 1);
}

#ifdef FUZZER

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes) {
    if (!sound(data, bytes)) abort();
    return 0;
}

#else

/* changes a text at one place */
static size_t mutate(char *text, size_t bytes, unsigned long long *state) {
    static const char *const words[] = {",",   ";",    "=",      "\n",  " ", "\"",
                                        "[",   "]:",   "q=",     "-",   "0", "99999999999999999999",
                                        "/33", "for=", "bytes=", "\xff"};
    size_t at = bytes ? (size_t)test_random_int(state, (int)bytes) : 0;
    const char *word = words[test_random_int(state, sizeof words / sizeof *words)];
    size_t more = strlen(word);
    switch (test_random_int(state, 4)) {
    case 0:
        if (bytes) text[at] = (char)test_random_int(state, 256);
        return bytes;
    case 1:
        return at;
    case 2:
        if (!bytes) return 0;
        memmove(text + at, text + at + 1, bytes - at - 1);
        return bytes - 1;
    default:
        memmove(text + at + more, text + at, bytes - at);
        memcpy(text + at, word, more);
        return bytes + more;
    }
}

TEST(fuzz_fields_are_read_or_refused_whatever_they_say) {
    const char *runs_text = getenv("FUZZ_RUNS"), *seed_text = getenv("FUZZ_SEED");
    long runs = runs_text ? atol(runs_text) : 40000;
    unsigned long long state = seed_text ? strtoull(seed_text, NULL, 10) : 1;
    char text[1024] = "";
    for (long i = 0; i < runs; i++) {
        int which = test_random_int(&state, READERS), seeds = 0;
        while (seeds < 6 && readers[which].seed[seeds]) seeds++;
        const char *seed = readers[which].seed[test_random_int(&state, seeds)];
        size_t bytes = strlen(seed);
        text[0] = (char)which;
        memcpy(text + 1, seed, bytes);
        for (int times = test_random_int(&state, 6); times > 0; times--)
            bytes = mutate(text + 1, bytes, &state);
        if (!CHECK_SAYING(sound((const uint8_t *)text, bytes + 1), "reader %d: %.*s", which,
                          (int)bytes, text + 1))
            return;
    }
}

/* FUZZ_FILES: names of files with inputs that once failed, separated by spaces */
TEST(fuzz_fields_files_are_replayed) {
    static uint8_t text[ROOM];
    char *files = strdup(getenv("FUZZ_FILES") ? getenv("FUZZ_FILES") : ""), *rest = files;
    if (!*files) test_skip("FUZZ_FILES names no files");
    for (char *name = strtok_r(files, " ", &rest); name; name = strtok_r(NULL, " ", &rest)) {
        FILE *file = fopen(name, "rb");
        if (!CHECK_SAYING(file != NULL, "cannot open %s", name)) continue;
        CHECK_SAYING(sound(text, fread(text, 1, sizeof text, file)), "%s", name);
        fclose(file);
    }
    free(files);
}

#endif
