/* Tests of server/front: what passes, what is refused with which status, and that cutting the stream changes nothing. */
#include "server/front.h"

#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"

#define HOST "Host: a\r\n"
#define GET "GET / HTTP/1.1\r\n" HOST
#define POST "POST / HTTP/1.1\r\n" HOST
#define CHUNKED POST "Transfer-Encoding: chunked\r\n\r\n"

/* A stream and what becomes of it; bytes is given where it holds a NUL. */
struct front_case {
    const char *what, *stream;
    int status, complete;
    size_t bytes;
};

static const struct front_case front_cases[] = {
    {"a plain request", GET "\r\n", 0, 1, 0},
    {"three at once", GET "\r\n" GET "\r\n" GET "\r\n", 0, 3, 0},
    {"an old one without Host", "GET / HTTP/1.0\r\n\r\n", 0, 1, 0},
    {"an absolute target", "GET http://a/b HTTP/1.1\r\n" HOST "\r\n", 0, 1, 0},
    {"a minor version to come", "GET / HTTP/1.7\r\n" HOST "\r\n", 0, 1, 0},
    {"an empty line before", "\r\n" GET "\r\n", 0, 1, 0},
    {"two empty lines before", "\r\n\r\n" GET "\r\n", 0, 1, 0},
    {"blanks around a value", "GET / HTTP/1.1\r\nHost: \t a\r\nX: b \t\r\n\r\n", 0, 1, 0},
    {"an empty value", GET "X:\r\nY: \r\n\r\n", 0, 1, 0},
    {"bytes beyond ASCII in a value", GET "X: caf\xc3\xa9\r\n\r\n", 0, 1, 0},
    {"names in capitals", "GET / HTTP/1.1\r\nHOST: a\r\nCONTENT-LENGTH: 0\r\n\r\n", 0, 1, 0},
    {"a body", POST "Content-Length: 5\r\n\r\nhello" GET "\r\n", 0, 2, 0},
    {"a body that looks like a request", POST "Content-Length: 29\r\n\r\nGET / HTTP/1.1\r\nHost: a\r\n\r\n..", 0, 1, 0},
    {"a body without end", POST "Content-Length: 5\r\n\r\nhell", 0, 0, 0},
    {"chunks", CHUNKED "5\r\nhello\r\n0\r\n\r\n" GET "\r\n", 0, 2, 0},
    {"chunks with capitals, zeros and extensions", CHUNKED "00A;x=\"y\"\r\n0123456789\r\n000\r\n\r\n", 0, 1, 0},
    {"chunks with trailer fields", CHUNKED "1\r\na\r\n0\r\nX: y\r\n\r\n" GET "\r\n", 0, 2, 0},
    {"Chunked with a capital", POST "Transfer-Encoding: Chunked\r\n\r\n0\r\n\r\n", 0, 1, 0},

    {"no Host", "GET / HTTP/1.1\r\n\r\n", 400, 0, 0},
    {"two Hosts", GET HOST "\r\n", 400, 0, 0},
    {"Host that is none", "GET / HTTP/1.1\r\nHost: a/b\r\n\r\n", 400, 0, 0},
    {"Host with two words", "GET / HTTP/1.1\r\nHost: a b\r\n\r\n", 400, 0, 0},
    {"Host with user", "GET / HTTP/1.1\r\nHost: u@a\r\n\r\n", 400, 0, 0},
    {"two lengths", POST "Content-Length: 1\r\nContent-Length: 1\r\n\r\na", 400, 0, 0},
    {"two different lengths", POST "Content-Length: 1\r\nContent-Length: 2\r\n\r\na", 400, 0, 0},
    {"a list of lengths", POST "Content-Length: 1, 1\r\n\r\na", 400, 0, 0},
    {"a length with a sign", POST "Content-Length: +1\r\n\r\na", 400, 0, 0},
    {"a negative length", POST "Content-Length: -1\r\n\r\na", 400, 0, 0},
    {"a hexadecimal length", POST "Content-Length: 0x1\r\n\r\na", 400, 0, 0},
    {"a length with a point", POST "Content-Length: 1.0\r\n\r\na", 400, 0, 0},
    {"a length with an exponent", POST "Content-Length: 1e0\r\n\r\na", 400, 0, 0},
    {"an empty length", POST "Content-Length:\r\n\r\na", 400, 0, 0},
    {"a length of letters", POST "Content-Length: one\r\n\r\na", 400, 0, 0},
    {"a length with a blank behind", POST "Content-Length: 1 \r\n\r\na", 400, 0, 0},
    {"a length with a blank within", POST "Content-Length: 1 0\r\n\r\na", 400, 0, 0},
    {"a length beyond 64 bits", POST "Content-Length: 18446744073709551617\r\n\r\na", 413, 0, 0},
    {"a length and chunks", POST "Content-Length: 1\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n", 400, 0, 0},
    {"chunks and a length", POST "Transfer-Encoding: chunked\r\nContent-Length: 1\r\n\r\n0\r\n\r\n", 400, 0, 0},
    {"chunks in HTTP/1.0", "POST / HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n", 400, 0, 0},
    {"two codings", POST "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n", 400, 0, 0},
    {"a list of codings", POST "Transfer-Encoding: gzip, chunked\r\n\r\n0\r\n\r\n", 501, 0, 0},
    {"chunked twice", POST "Transfer-Encoding: chunked, chunked\r\n\r\n0\r\n\r\n", 501, 0, 0},
    {"identity", POST "Transfer-Encoding: identity\r\n\r\n", 501, 0, 0},
    {"an unknown coding", POST "Transfer-Encoding: xchunked\r\n\r\n0\r\n\r\n", 501, 0, 0},
    {"a coding cut short", POST "Transfer-Encoding: chunke\r\n\r\n0\r\n\r\n", 501, 0, 0},
    {"an empty coding", POST "Transfer-Encoding:\r\n\r\n0\r\n\r\n", 501, 0, 0},
    {"a coding with a blank behind", POST "Transfer-Encoding: chunked \r\n\r\n0\r\n\r\n", 501, 0, 0},
    {"a coding in quotes", POST "Transfer-Encoding: \"chunked\"\r\n\r\n0\r\n\r\n", 501, 0, 0},
    {"a coding behind a vertical tab", POST "Transfer-Encoding: \vchunked\r\n\r\n0\r\n\r\n", 400, 0, 0},

    {"a blank before the colon", "GET / HTTP/1.1\r\nHost : a\r\n\r\n", 400, 0, 0},
    {"a tab before the colon", GET "X\t: a\r\n\r\n", 400, 0, 0},
    {"a length with a blank before its colon", POST "Content-Length : 1\r\n\r\na", 400, 0, 0},
    {"a coding with a blank before its colon", POST "Transfer-Encoding : chunked\r\n\r\n0\r\n\r\n", 400, 0, 0},
    {"a field without a name", GET ": a\r\n\r\n", 400, 0, 0},
    {"a field without a colon", GET "X\r\n\r\n", 400, 0, 0},
    {"a name with a comma", GET "X,Y: a\r\n\r\n", 400, 0, 0},
    {"a name in brackets", GET "[X]: a\r\n\r\n", 400, 0, 0},
    {"a name in quotes", GET "\"X\": a\r\n\r\n", 400, 0, 0},
    {"a name beyond ASCII", GET "caf\xc3\xa9: a\r\n\r\n", 400, 0, 0},
    {"a name with a control character", GET "X\x01: a\r\n\r\n", 400, 0, 0},
    {"a name with a NUL", GET "X\0Y: a\r\n\r\n", 400, 0, sizeof GET "X\0Y: a\r\n\r\n" - 1},
    {"a value with a NUL", GET "X: a\0b\r\n\r\n", 400, 0, sizeof GET "X: a\0b\r\n\r\n" - 1},
    {"a value with a bell", GET "X: a\ab\r\n\r\n", 400, 0, 0},
    {"a value with a DEL", GET "X: a\x7f\r\n\r\n", 400, 0, 0},
    {"a value with a bare CR", GET "X: a\rb\r\n\r\n", 400, 0, 0},
    {"a value with two CR", GET "X: a\r\r\n\r\n", 400, 0, 0},
    {"a folded field", GET "X: a\r\n b\r\n\r\n", 400, 0, 0},
    {"a field folded with a tab", GET "X: a\r\n\tb\r\n\r\n", 400, 0, 0},
    {"a blank before the first field", "GET / HTTP/1.1\r\n Host: a\r\n\r\n", 400, 0, 0},
    {"a bare LF behind the request line", "GET / HTTP/1.1\nHost: a\r\n\r\n", 400, 0, 0},
    {"a bare LF behind a field", "GET / HTTP/1.1\r\nHost: a\n\r\n", 400, 0, 0},
    {"a bare LF at the end of the head", GET "\n", 400, 0, 0},
    {"a bare CR at the end of the head", GET "\r\r", 400, 0, 0},
    {"bare LFs only", "GET / HTTP/1.1\nHost: a\n\n", 400, 0, 0},
    {"bare CRs only", "GET / HTTP/1.1\rHost: a\r\r", 400, 0, 0},

    {"two blanks before the target", "GET  / HTTP/1.1\r\n" HOST "\r\n", 400, 0, 0},
    {"two blanks before the version", "GET /  HTTP/1.1\r\n" HOST "\r\n", 400, 0, 0},
    {"a blank behind the version", "GET / HTTP/1.1 \r\n" HOST "\r\n", 400, 0, 0},
    {"a blank in the target", "GET /a b HTTP/1.1\r\n" HOST "\r\n", 400, 0, 0},
    {"a tab for a blank", "GET\t/ HTTP/1.1\r\n" HOST "\r\n", 400, 0, 0},
    {"a blank before the method", " GET / HTTP/1.1\r\n" HOST "\r\n", 400, 0, 0},
    {"no target", "GET HTTP/1.1\r\n" HOST "\r\n", 400, 0, 0},
    {"a target beyond ASCII", "GET /caf\xc3\xa9 HTTP/1.1\r\n" HOST "\r\n", 400, 0, 0},
    {"a target with a NUL", "GET /\0 HTTP/1.1\r\n\r\n", 400, 0, sizeof "GET /\0 HTTP/1.1\r\n\r\n" - 1},
    {"a target with a DEL", "GET /\x7f HTTP/1.1\r\n" HOST "\r\n", 400, 0, 0},
    {"no version", "GET /\r\n\r\n", 400, 0, 0},
    {"a version in small letters", "GET / http/1.1\r\n" HOST "\r\n", 400, 0, 0},
    {"a version with one digit", "GET / HTTP/1\r\n" HOST "\r\n", 400, 0, 0},
    {"a version with three digits", "GET / HTTP/1.10\r\n" HOST "\r\n", 400, 0, 0},
    {"a version with a letter", "GET / HTTP/1.x\r\n" HOST "\r\n", 400, 0, 0},
    {"another protocol", "GET / ICAP/1.1\r\n" HOST "\r\n", 400, 0, 0},
    {"HTTP/0.9", "GET / HTTP/0.9\r\n" HOST "\r\n", 505, 0, 0},
    {"HTTP/2", "GET / HTTP/2.0\r\n" HOST "\r\n", 505, 0, 0},
    {"the preface of HTTP/2", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 505, 0, 0},
    {"a method in brackets", "(GET) / HTTP/1.1\r\n" HOST "\r\n", 400, 0, 0},
    {"a method with a colon", "GET: / HTTP/1.1\r\n" HOST "\r\n", 400, 0, 0},
    {"a method that is too long", "ABCDEFGHIJKLMNOPQRSTUVWXYZABCDEFG / HTTP/1.1\r\n", 501, 0, 0},
    {"a field before any request line", "Host: a\r\n\r\n", 400, 0, 0},
    {"TLS", "\x16\x03\x01\x02", 400, 0, 0},
    {"a NUL", "\0", 400, 0, 1},
    {"a bare LF before the request", "\n" GET "\r\n", 400, 0, 0},
    {"three empty lines before", "\r\n\r\n\r\n" GET "\r\n", 400, 0, 0},

    {"a chunk without size", CHUNKED "\r\nhello\r\n0\r\n\r\n", 400, 0, 0},
    {"a chunk with a sign", CHUNKED "+5\r\nhello\r\n0\r\n\r\n", 400, 0, 0},
    {"a chunk with 0x", CHUNKED "0x5\r\nhello\r\n0\r\n\r\n", 400, 0, 0},
    {"a chunk with a blank before its size", CHUNKED " 5\r\nhello\r\n0\r\n\r\n", 400, 0, 0},
    {"a chunk with a blank behind its size", CHUNKED "5 \r\nhello\r\n0\r\n\r\n", 400, 0, 0},
    {"a chunk of size g", CHUNKED "g\r\nhello\r\n0\r\n\r\n", 400, 0, 0},
    {"a chunk beyond 64 bits", CHUNKED "10000000000000005\r\nhello\r\n0\r\n\r\n", 400, 0, 0},
    {"a chunk that is longer than it says", CHUNKED "4\r\nhello\r\n0\r\n\r\n", 400, 0, 0},
    {"a chunk that is shorter than it says", CHUNKED "6\r\nhello\r\n0\r\n\r\n", 400, 0, 0},
    {"a bare LF behind a size", CHUNKED "5\nhello\r\n0\r\n\r\n", 400, 0, 0},
    {"a bare CR behind a size", CHUNKED "5\rhello\r\n0\r\n\r\n", 400, 0, 0},
    {"a bare LF behind a chunk", CHUNKED "5\r\nhello\n0\r\n\r\n", 400, 0, 0},
    {"a bare LF in an extension", CHUNKED "5;a\nb\r\nhello\r\n0\r\n\r\n", 400, 0, 0},
    {"a bare LF behind the last chunk", CHUNKED "0\n\r\n", 400, 0, 0},
    {"a bare LF as the trailer", CHUNKED "0\r\n\n", 400, 0, 0},
    {"a length among the trailers", CHUNKED "0\r\nContent-Length: 1\r\n\r\n", 400, 0, 0},
    {"a coding among the trailers", CHUNKED "0\r\nTransfer-Encoding: chunked\r\n\r\n", 400, 0, 0},
    {"a Host among the trailers", CHUNKED "0\r\nHost: b\r\n\r\n", 400, 0, 0},
    {"a folded trailer", CHUNKED "0\r\nX: y\r\n z\r\n\r\n", 400, 0, 0},

    {"a good one before a bad one", GET "\r\n" GET "X : a\r\n\r\n", 400, 1, 0},
    {"a good one behind a bad one", GET "X : a\r\n\r\n" GET "\r\n", 400, 0, 0},
    {"more body than was said", POST "Content-Length: 1\r\n\r\na/b" GET "\r\n", 400, 1, 0},
};

enum { FRONT_CASES = sizeof front_cases / sizeof *front_cases };

static size_t front_length(const struct front_case *stream) {
    return stream->bytes ? stream->bytes : strlen(stream->stream);
}

TEST(the_front_knows_good_streams_from_bad_ones) {
    for (int i = 0; i < FRONT_CASES; i++) {
        const struct front_case *wanted = &front_cases[i];
        struct srv_front front;
        size_t bytes = front_length(wanted), passed;
        srv_front_init(&front);
        passed = srv_front_read(&front, wanted->stream, bytes);
        CHECK_SAYING(front.status == wanted->status, "%s: status %d, expected %d", wanted->what, front.status,
                     wanted->status);
        CHECK_SAYING(front.complete == wanted->complete, "%s: %ld requests complete, expected %d", wanted->what,
                     front.complete, wanted->complete);
        CHECK_SAYING(wanted->status ? passed < bytes && front.detail && front.detail[0] : passed == bytes,
                     "%s: %zu of %zu bytes passed", wanted->what, passed, bytes);
    }
}

/* reads the stream in pieces; returns the bytes passed */
static size_t front_in_pieces(struct srv_front *front, const struct front_case *stream, size_t first, size_t piece) {
    size_t bytes = front_length(stream), passed = 0;
    srv_front_init(front);
    for (size_t at = 0, next; at < bytes; at = next) {
        next = at ? at + piece : first;
        if (next > bytes) next = bytes;
        passed += srv_front_read(front, stream->stream + at, next - at);
    }
    return passed;
}

TEST(the_front_does_not_mind_how_a_stream_is_cut) {
    for (int i = 0; i < FRONT_CASES; i++) {
        const struct front_case *stream = &front_cases[i];
        struct srv_front whole, cut;
        size_t bytes = front_length(stream);
        front_in_pieces(&whole, stream, bytes, bytes);
        for (size_t first = 1; first < bytes; first++) {
            for (size_t piece = 1; piece <= bytes; piece += bytes - 1) {
                front_in_pieces(&cut, stream, first, piece);
                CHECK_SAYING(cut.status == whole.status && cut.complete == whole.complete &&
                                 cut.requests == whole.requests && cut.detail == whole.detail,
                             "%s: differs when cut at %zu", stream->what, first);
            }
        }
    }
}

TEST(the_front_passes_nothing_of_a_request_that_is_refused_at_once) {
    static const char stream[] = GET "\r\n" GET "X : a\r\n\r\n";
    struct srv_front front;
    srv_front_init(&front);
    CHECK_INT((long long)srv_front_read(&front, stream, sizeof stream - 1), sizeof(GET "\r\n") - 1);
    CHECK_INT((long long)srv_front_read(&front, GET "\r\n", sizeof(GET "\r\n") - 1), 0);
    CHECK_INT(front.complete, 1);
}

/* a head whose part `what` has so many pieces; returns the status */
static int front_long(const char *before, const char *piece, int count, const char *after) {
    struct srv_front front;
    srv_front_init(&front);
    srv_front_read(&front, before, strlen(before));
    for (int i = 0; i < count; i++) srv_front_read(&front, piece, strlen(piece));
    srv_front_read(&front, after, strlen(after));
    return front.status ? front.status : front.complete == 1 ? 0 : -1;
}

TEST(the_front_keeps_heads_within_their_limits) {
    CHECK_INT(front_long("GET /", "a", SRV_FRONT_TARGET - 1, " HTTP/1.1\r\n" HOST "\r\n"), 0);
    CHECK_INT(front_long("GET /", "a", SRV_FRONT_TARGET, " HTTP/1.1\r\n" HOST "\r\n"), 414);
    CHECK_INT(front_long("GET /?", "&", SRV_FRONT_PARAMETERS - 1, " HTTP/1.1\r\n" HOST "\r\n"), 0);
    CHECK_INT(front_long("GET /?", "&", SRV_FRONT_PARAMETERS, " HTTP/1.1\r\n" HOST "\r\n"), 414);
    CHECK_INT(front_long(GET, "X: y\r\n", SRV_FRONT_FIELDS - 1, "\r\n"), 0);
    CHECK_INT(front_long(GET, "X: y\r\n", SRV_FRONT_FIELDS, "\r\n"), 431);
    CHECK_INT(front_long(GET "Cookie: a=b", "; a=b", SRV_FRONT_COOKIES - 1, "\r\n\r\n"), 0);
    CHECK_INT(front_long(GET "Cookie: a=b", "; a=b", SRV_FRONT_COOKIES, "\r\n\r\n"), 431);
    CHECK_INT(front_long(GET "X: ", "a", SRV_FRONT_HEAD - (int)sizeof(GET "X: \r\n\r\n"), "\r\n\r\n"), 0);
    CHECK_INT(front_long(GET "X: ", "a", SRV_FRONT_HEAD, "\r\n\r\n"), 431);
    CHECK_INT(front_long(GET, "a", SRV_FRONT_HEAD, ": b\r\n\r\n"), 431);
    CHECK_INT(front_long(CHUNKED "0\r\n", "X: y\r\n", SRV_FRONT_FIELDS, "\r\n"), 0);
    CHECK_INT(front_long(CHUNKED "0\r\n", "X: y\r\n", SRV_FRONT_FIELDS + 1, "\r\n"), 431);
    CHECK_INT(front_long(CHUNKED "0\r\nX: ", "a", SRV_FRONT_HEAD, "\r\n\r\n"), 431);
    CHECK_INT(front_long(CHUNKED "1;", "a", SRV_FRONT_EXTENSIONS, "\r\na\r\n0\r\n\r\n"), 0);
    CHECK_INT(front_long(CHUNKED "1;", "a", SRV_FRONT_EXTENSIONS + 1, "\r\na\r\n0\r\n\r\n"), 400);
    CHECK_INT(front_long(CHUNKED, "1\r\na\r\n", 100000, "0\r\n\r\n"), 0);
}

TEST(the_front_tells_when_it_is_within_a_request) {
    static const char stream[] = POST "Content-Length: 2\r\n\r\nab";
    struct srv_front front;
    srv_front_init(&front);
    CHECK(!srv_front_within(&front));
    for (size_t i = 0; i + 1 < sizeof stream; i++) {
        srv_front_read(&front, stream + i, 1);
        CHECK_INT(srv_front_within(&front), i + 2 < sizeof stream);
    }
    CHECK_INT(front.requests, 1);
}

TEST(the_front_never_lets_random_bytes_out_of_step) {
    /* mutations of good streams: whatever the verdict, counts stay in order and nothing is passed after a refusal */
    unsigned long long random = 7;
    for (int round = 0; round < 20000; round++) {
        char stream[512];
        const struct front_case *from = &front_cases[test_random_int(&random, 18)];
        size_t bytes = front_length(from);
        memcpy(stream, from->stream, bytes);
        for (int change = test_random_int(&random, 3); change >= 0; change--)
            stream[test_random_int(&random, (int)bytes)] = (char)test_random_int(&random, 256);
        struct srv_front front;
        srv_front_init(&front);
        size_t passed = srv_front_read(&front, stream, bytes), later = srv_front_read(&front, GET "\r\n", 26);
        int good = front.complete <= front.requests && front.requests <= front.complete + 1 && passed <= bytes;
        if (front.status && passed < bytes) good = good && !later && front.status >= 400;
        if (!CHECK_SAYING(good, "round %d: %ld of %ld requests, status %d", round, front.complete, front.requests,
                          front.status))
            return;
    }
}
