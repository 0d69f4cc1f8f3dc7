/* Tests of server/protocol/http_strict: what is accepted, what is refused with which status, and
 * that splitting the stream changes nothing. */
#include "server/protocol/http_strict.h"

#include <stdio.h>
#include <string.h>

#include "tests/harness/streams.h"
#include "tests/harness/test.h"

/* the strict reader changes what it reads, so it gets a copy */
static size_t strict_read(struct srv_http_strict *strict, const char *data, size_t bytes) {
    char copy[2048];
    if (bytes <= sizeof copy) return srv_http_strict_read(strict, memcpy(copy, data, bytes), bytes);
    CHECK(0);
    return 0;
}

static size_t strict_length(const struct stream *stream) {
    return stream->bytes ? stream->bytes : strlen(stream->stream);
}

/* bytes of the chunks' extensions; no chunk's data has a semicolon */
static size_t strict_extensions(const char *stream) {
    const char *at = strstr(stream, "chunked\r\n\r\n");
    size_t bytes = 0;
    while (at && (at = strchr(at, ';'))) bytes += strcspn(at, "\r"), at += strcspn(at, "\r");
    return bytes;
}

TEST(the_front_knows_good_streams_from_bad_ones) {
    for (int i = 0; i < STREAMS; i++) {
        const struct stream *wanted = &streams[i];
        struct srv_http_strict strict;
        size_t bytes = strict_length(wanted), passed;
        srv_http_strict_init(&strict);
        passed = strict_read(&strict, wanted->stream, bytes);
        CHECK_SAYING(strict.status == wanted->status, "%s: status %d, expected %d", wanted->what,
                     strict.status, wanted->status);
        CHECK_SAYING(strict.complete == wanted->complete, "%s: %ld requests complete, expected %d",
                     wanted->what, strict.complete, wanted->complete);
        size_t whole = bytes - strict_extensions(wanted->stream);
        CHECK_SAYING(wanted->status ? passed < bytes && strict.detail && strict.detail[0]
                                    : passed == whole,
                     "%s: %zu of %zu bytes passed", wanted->what, passed, bytes);
    }
}

/* reads the stream in pieces; returns the number of bytes passed on */
static size_t strict_in_pieces(struct srv_http_strict *strict, const struct stream *stream,
                               size_t first, size_t piece) {
    size_t bytes = strict_length(stream), passed = 0;
    srv_http_strict_init(strict);
    for (size_t at = 0, next; at < bytes; at = next) {
        next = at ? at + piece : first;
        if (next > bytes) next = bytes;
        passed += strict_read(strict, stream->stream + at, next - at);
    }
    return passed;
}

TEST(the_front_does_not_mind_how_a_stream_is_cut) {
    for (int i = 0; i < STREAMS; i++) {
        const struct stream *stream = &streams[i];
        struct srv_http_strict whole, cut;
        size_t bytes = strict_length(stream);
        strict_in_pieces(&whole, stream, bytes, bytes);
        for (size_t first = 1; first < bytes; first++) {
            for (size_t piece = 1; piece <= bytes; piece += bytes - 1) {
                strict_in_pieces(&cut, stream, first, piece);
                CHECK_SAYING(cut.status == whole.status && cut.complete == whole.complete &&
                                 cut.requests == whole.requests && cut.detail == whole.detail,
                             "%s: differs when cut at %zu", stream->what, first);
            }
        }
    }
}

TEST(the_front_takes_the_extensions_of_chunks_out) {
    static const char stream[] = CHUNKED "5;a=\"b\"\r\nhello\r\n00a ;\r\n",
                      good[] = CHUNKED
                      "5;a\r\nhello\r\nA;b=c\r\n;;;;;;;;;;\r\n0;\r\nX: ;\r\n\r\n" GET "\r\n",
                      wanted[] =
                          CHUNKED "5\r\nhello\r\nA\r\n;;;;;;;;;;\r\n0\r\nX: ;\r\n\r\n" GET "\r\n";
    struct srv_http_strict strict;
    char data[sizeof good], all[sizeof good];
    for (size_t piece = 1; piece < sizeof good; piece++) {
        size_t kept = 0;
        srv_http_strict_init(&strict);
        for (size_t at = 0; at < sizeof good - 1; at += piece) {
            size_t bytes = sizeof good - 1 - at < piece ? sizeof good - 1 - at : piece;
            memcpy(data, good + at, bytes);
            size_t passed = srv_http_strict_read(&strict, data, bytes);
            memcpy(all + kept, data, passed);
            kept += passed;
        }
        CHECK_SAYING(kept == sizeof wanted - 1 && !memcmp(all, wanted, kept), "cut at %zu: %.*s",
                     piece, (int)kept, all);
        CHECK_INT(strict.complete, 2);
    }
    srv_http_strict_init(&strict);
    CHECK_INT((long long)strict_read(&strict, stream, sizeof stream - 1), 0);
    CHECK_INT(strict.status, 400);
}

TEST(the_front_passes_nothing_of_a_request_that_is_refused_at_once) {
    static const char stream[] = GET "\r\n" GET "X : a\r\n\r\n";
    struct srv_http_strict strict;
    srv_http_strict_init(&strict);
    CHECK_INT((long long)strict_read(&strict, stream, sizeof stream - 1), sizeof(GET "\r\n") - 1);
    CHECK_INT((long long)strict_read(&strict, GET "\r\n", sizeof(GET "\r\n") - 1), 0);
    CHECK_INT(strict.complete, 1);
}

/* a head whose part `what` has this many pieces; returns the status */
static int strict_long(const char *before, const char *piece, int count, const char *after) {
    struct srv_http_strict strict;
    srv_http_strict_init(&strict);
    strict_read(&strict, before, strlen(before));
    for (int i = 0; i < count; i++) strict_read(&strict, piece, strlen(piece));
    strict_read(&strict, after, strlen(after));
    return strict.status ? strict.status : strict.complete == 1 ? 0 : -1;
}

TEST(the_front_keeps_heads_within_their_limits) {
    CHECK_INT(strict_long("GET /", "a", SRV_STRICT_TARGET - 1, " HTTP/1.1\r\n" HOST "\r\n"), 0);
    CHECK_INT(strict_long("GET /", "a", SRV_STRICT_TARGET, " HTTP/1.1\r\n" HOST "\r\n"), 414);
    CHECK_INT(strict_long("GET /?", "&", SRV_STRICT_PARAMETERS - 1, " HTTP/1.1\r\n" HOST "\r\n"),
              0);
    CHECK_INT(strict_long("GET /?", "&", SRV_STRICT_PARAMETERS, " HTTP/1.1\r\n" HOST "\r\n"), 414);
    CHECK_INT(strict_long(GET, "X: y\r\n", SRV_STRICT_FIELDS - 1, "\r\n"), 0);
    CHECK_INT(strict_long(GET, "X: y\r\n", SRV_STRICT_FIELDS, "\r\n"), 431);
    CHECK_INT(strict_long(GET "Cookie: a=b", "; a=b", 1000, "\r\n\r\n"), 0);
    CHECK_INT(
        strict_long(GET "X: ", "a", SRV_STRICT_HEAD - (int)sizeof(GET "X: \r\n\r\n"), "\r\n\r\n"),
        0);
    CHECK_INT(strict_long(GET "X: ", "a", SRV_STRICT_HEAD, "\r\n\r\n"), 431);
    CHECK_INT(strict_long(GET, "a", SRV_STRICT_HEAD, ": b\r\n\r\n"), 431);
    CHECK_INT(strict_long(CHUNKED "0\r\n", "X: y\r\n", SRV_STRICT_FIELDS, "\r\n"), 0);
    CHECK_INT(strict_long(CHUNKED "0\r\n", "X: y\r\n", SRV_STRICT_FIELDS + 1, "\r\n"), 431);
    CHECK_INT(strict_long(CHUNKED "0\r\nX: ", "a", SRV_STRICT_HEAD, "\r\n\r\n"), 431);
    CHECK_INT(strict_long(CHUNKED "1;", "a", SRV_STRICT_EXTENSIONS, "\r\na\r\n0\r\n\r\n"), 0);
    CHECK_INT(strict_long(CHUNKED "1;", "a", SRV_STRICT_EXTENSIONS + 1, "\r\na\r\n0\r\n\r\n"), 400);
    CHECK_INT(strict_long(CHUNKED, "1\r\na\r\n", 100000, "0\r\n\r\n"), 0);
}

TEST(the_front_takes_cookies_out_wherever_the_stream_is_cut) {
    static const char stream[] =
        GET "cOOkie: a=b;c:d\r\nCookies: a\r\nX-Cookie: c\r\nCookie:e=f;g=h\r\nCookie: \r\n\r\n";
    static const char rest[] =
        GET "cOOkie:\r\nCookies: a\r\nX-Cookie: c\r\nCookie:\r\nCookie:\r\n\r\n";
    enum { BYTES = sizeof stream - 1 };
    for (size_t cut = 0; cut < BYTES; cut++) {
        char text[sizeof stream] = "", joined[sizeof stream] = "";
        struct srv_http_strict strict;
        srv_http_strict_init(&strict);
        memcpy(text, stream, BYTES);
        size_t first = srv_http_strict_read(&strict, text, cut),
               second = srv_http_strict_read(&strict, text + cut, BYTES - cut);
        memcpy(joined, text, first);
        memcpy(joined + first, text + cut, second);
        CHECK_SAYING(!strcmp(joined, rest), "cut at %zu: %s", cut, joined);
        CHECK(!strict.status && strict.complete == 1);
    }
    /* the most and the longest parts that a head may have, in any pieces */
    struct srv_http_strict strict;
    srv_http_strict_init(&strict);
    strict_read(&strict, GET "Coo", sizeof(GET "Coo") - 1);
    strict_read(&strict, "kie: a=b", 8);
    for (int i = 0; i < 1000; i++) strict_read(&strict, ";c=d", 4);
    strict_read(&strict, "\r\n\r\n", 4);
    CHECK(!strict.status && strict.complete == 1);
    srv_http_strict_init(&strict);
    strict_read(&strict, GET "Cookie: a=", sizeof(GET "Cookie: a=") - 1);
    for (int i = 0; i < SRV_STRICT_HEAD; i++) strict_read(&strict, "b", 1);
    CHECK_INT(strict.status, 431);
    srv_http_strict_init(&strict);
    strict_read(&strict, GET "Cookie: a\n", sizeof(GET "Cookie: a\n") - 1);
    CHECK_INT(strict.status, 400);
}

TEST(the_front_tells_when_it_is_within_a_request) {
    static const char stream[] = POST "Content-Length: 2\r\n\r\nab";
    struct srv_http_strict strict;
    srv_http_strict_init(&strict);
    CHECK(!srv_http_strict_within(&strict));
    for (size_t i = 0; i + 1 < sizeof stream; i++) {
        strict_read(&strict, stream + i, 1);
        CHECK_INT(srv_http_strict_within(&strict), i + 2 < sizeof stream);
    }
    CHECK_INT(strict.requests, 1);
}

TEST(the_front_never_lets_random_bytes_out_of_step) {
    /* mutations of valid streams: whatever the result, counts stay consistent and nothing is passed
     * on after a refusal */
    unsigned long long random = 7;
    for (int round = 0; round < 20000; round++) {
        char stream[512];
        const struct stream *from = &streams[test_random_int(&random, 18)];
        size_t bytes = strict_length(from);
        memcpy(stream, from->stream, bytes);
        for (int change = test_random_int(&random, 3); change >= 0; change--)
            stream[test_random_int(&random, (int)bytes)] = (char)test_random_int(&random, 256);
        struct srv_http_strict strict;
        srv_http_strict_init(&strict);
        size_t passed = srv_http_strict_read(&strict, stream, bytes),
               later = strict_read(&strict, GET "\r\n", 26);
        int good = strict.complete <= strict.requests && strict.requests <= strict.complete + 1 &&
                   passed <= bytes;
        if (strict.status && passed < bytes) good = good && !later && strict.status >= 400;
        if (!CHECK_SAYING(good, "round %d: %ld of %ld requests, status %d", round, strict.complete,
                          strict.requests, strict.status))
            return;
    }
}
