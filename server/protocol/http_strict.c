#include "server/protocol/http_strict.h"

#include <assert.h>
#include <string.h>

/* classes of bytes */
enum {
    STRICT_TOKEN = 1,     /* characters of a method or of a field's name: RFC 9110 5.6.2 */
    STRICT_VISIBLE = 2,   /* visible ASCII */
    STRICT_VALUE = 4,     /* characters of a field's value: RFC 9110 5.5 */
    STRICT_AUTHORITY = 8, /* characters of a host and a port: RFC 3986 3.2.2 */
    STRICT_HEX = 16,
    /* the classes of each byte */
    STRICT_BLANK = STRICT_VALUE,
    STRICT_DELIMITER = STRICT_VISIBLE | STRICT_VALUE,
    STRICT_HOST_MARK = STRICT_DELIMITER | STRICT_AUTHORITY,
    STRICT_TOKEN_MARK = STRICT_DELIMITER | STRICT_TOKEN,
    STRICT_MARK = STRICT_DELIMITER | STRICT_AUTHORITY | STRICT_TOKEN
};

/* clang-format off */
static const unsigned char strict_class[256] = {
    ['\t'] = STRICT_BLANK, [' '] = STRICT_BLANK, [0x80 ... 0xff] = STRICT_BLANK,
    ['0' ... '9'] = STRICT_MARK | STRICT_HEX, ['A' ... 'F'] = STRICT_MARK | STRICT_HEX,
    ['a' ... 'f'] = STRICT_MARK | STRICT_HEX,
    ['G' ... 'Z'] = STRICT_MARK, ['g' ... 'z'] = STRICT_MARK,
    ['!'] = STRICT_MARK, ['$'] = STRICT_MARK, ['%'] = STRICT_MARK, ['&'] = STRICT_MARK,
    ['\''] = STRICT_MARK,
    ['*'] = STRICT_MARK, ['+'] = STRICT_MARK, ['-'] = STRICT_MARK, ['.'] = STRICT_MARK,
    ['_'] = STRICT_MARK,
    ['~'] = STRICT_MARK,
    ['#'] = STRICT_TOKEN_MARK, ['^'] = STRICT_TOKEN_MARK, ['`'] = STRICT_TOKEN_MARK,
    ['|'] = STRICT_TOKEN_MARK,
    ['('] = STRICT_HOST_MARK, [')'] = STRICT_HOST_MARK, [','] = STRICT_HOST_MARK,
    [';'] = STRICT_HOST_MARK,
    ['='] = STRICT_HOST_MARK, [':'] = STRICT_HOST_MARK, ['['] = STRICT_HOST_MARK,
    [']'] = STRICT_HOST_MARK,
    ['"'] = STRICT_DELIMITER, ['/'] = STRICT_DELIMITER, ['<'] = STRICT_DELIMITER,
    ['>'] = STRICT_DELIMITER,
    ['?'] = STRICT_DELIMITER, ['@'] = STRICT_DELIMITER, ['\\'] = STRICT_DELIMITER,
    ['{'] = STRICT_DELIMITER,
    ['}'] = STRICT_DELIMITER,
};
/* clang-format on */

/* The fields that frame a message, and Cookie, for which libmicrohttpd allocates much memory. */
enum { STRICT_OTHER, STRICT_HOST, STRICT_LENGTH, STRICT_CODING, STRICT_COOKIE };

static const struct {
    const char *name;
    int field;
} strict_fields[] = {
    {"host", STRICT_HOST},
    {"content-length", STRICT_LENGTH},
    {"transfer-encoding", STRICT_CODING},
    {"cookie", STRICT_COOKIE},
};

static int strict_is(unsigned char c, unsigned classes) { return (strict_class[c] & classes) != 0; }

static void strict_refuse(struct srv_http_strict *strict, int status, const char *detail) {
    strict->place = SRV_STRICT_REFUSED;
    strict->status = status;
    strict->detail = detail;
}

static void strict_go(struct srv_http_strict *strict, enum srv_http_strict_place place) {
    strict->place = place;
    strict->part = 0;
}

static void strict_expect(struct srv_http_strict *strict, unsigned char c, unsigned char wanted,
                          enum srv_http_strict_place place, const char *detail) {
    if (c == wanted)
        strict_go(strict, place);
    else
        strict_refuse(strict, 400, detail);
}

/* --- the request line --- */

static void strict_begin(struct srv_http_strict *strict, unsigned char c) {
    if (c == '\r' && strict->blanks++ < 2) {
        strict_go(strict, SRV_STRICT_START_LF);
    } else if (strict_is(c, STRICT_TOKEN)) {
        long requests = strict->requests + 1, complete = strict->complete;
        *strict = (struct srv_http_strict){
            .requests = requests, .complete = complete, .part = 1, .bytes = 1};
        strict->place = SRV_STRICT_IN_METHOD;
    } else {
        strict_refuse(strict, 400,
                      "a request must begin with a method; this port speaks plain HTTP/1.1");
    }
}

static void strict_method(struct srv_http_strict *strict, unsigned char c) {
    if (c == ' ')
        strict_go(strict, SRV_STRICT_IN_TARGET);
    else if (!strict_is(c, STRICT_TOKEN))
        strict_refuse(
            strict, 400,
            "the request line must be a method, one space, the target, one space, and HTTP/1.1");
    else if (++strict->part > SRV_STRICT_METHOD)
        strict_refuse(strict, 501, "unknown method");
}

static void strict_target(struct srv_http_strict *strict, unsigned char c) {
    strict->parameters += c == '&';
    if (c == ' ' && strict->part)
        strict_go(strict, SRV_STRICT_IN_VERSION);
    else if (!strict_is(c, STRICT_VISIBLE))
        strict_refuse(strict, 400, "the request target has a forbidden byte");
    else if (++strict->part > SRV_STRICT_TARGET || strict->parameters >= SRV_STRICT_PARAMETERS)
        strict_refuse(strict, 414, "the request target has more than 1023 bytes or 64 parameters");
}

static void strict_version(struct srv_http_strict *strict, unsigned char c) {
    static const char form[] = "HTTP/#.#\r";
    char wanted = form[strict->part++];
    int digit = c >= '0' && c <= '9';
    if (wanted == '#' ? !digit : c != (unsigned char)wanted)
        strict_refuse(strict, 400, "the request line must end with HTTP/1.1 or HTTP/1.0 and CR LF");
    else if (strict->part == 6 && c != '1')
        strict_refuse(strict, 505, "this server speaks HTTP/1.1 and HTTP/1.0");
    else if (strict->part == 8)
        strict->old = c == '0';
    else if (strict->part == 9)
        strict_go(strict, SRV_STRICT_LINE_LF);
}

/* --- fields --- */

static void strict_line(struct srv_http_strict *strict, unsigned char c) {
    if (c == '\r') {
        strict_go(strict, SRV_STRICT_END_LF);
    } else if (strict_is(c, STRICT_TOKEN)) {
        strict->place = SRV_STRICT_IN_NAME;
        strict->part = 1;
        strict->name[0] = (char)(c | 32);
        if (++strict->fields > SRV_STRICT_FIELDS)
            strict_refuse(strict, 431, "the request has more than 100 header fields");
    } else if (c == ' ' || c == '\t') {
        strict_refuse(strict, 400, "a header field must not be folded or begin with a space");
    } else {
        strict_refuse(strict, 400, "a line of the head is not a header field");
    }
}

/* counts a field that may occur only once, and not in the trailer section; `twice`: the message for
 * a second one */
static int strict_once(struct srv_http_strict *strict, int *count, const char *twice) {
    if (strict->trailer)
        strict_refuse(strict, 400,
                      "Host, Content-Length and Transfer-Encoding cannot be trailer fields");
    else if (++*count > 1)
        strict_refuse(strict, 400, twice);
    return strict->place != SRV_STRICT_REFUSED;
}

static void strict_name_end(struct srv_http_strict *strict) {
    size_t bytes = (size_t)strict->part;
    strict->field = STRICT_OTHER;
    for (size_t i = 0; i < sizeof strict_fields / sizeof *strict_fields && bytes <= SRV_STRICT_NAME;
         i++)
        if (strlen(strict_fields[i].name) == bytes &&
            !memcmp(strict_fields[i].name, strict->name, bytes))
            strict->field = strict_fields[i].field;
    strict_go(strict, SRV_STRICT_BEFORE_VALUE);
    if (strict->field == STRICT_HOST)
        strict_once(strict, &strict->hosts, "there are two Host header fields");
    if (strict->field == STRICT_CODING)
        strict_once(strict, &strict->codings, "there are two header fields Transfer-Encoding");
    if (strict->field == STRICT_LENGTH)
        strict_once(strict, &strict->lengths, "there are two header fields Content-Length");
}

static void strict_name(struct srv_http_strict *strict, unsigned char c) {
    if (c == ':')
        strict_name_end(strict);
    else if (!strict_is(c, STRICT_TOKEN))
        strict_refuse(strict, 400,
                      "a header field must be a name, directly followed by a colon, and a value");
    else if (strict->part++ < SRV_STRICT_NAME)
        strict->name[strict->part - 1] = (char)(c | 32);
}

static const char strict_no_length[] = "Content-Length must be a decimal number and nothing else";
static const char strict_no_coding[] = "the only supported Transfer-Encoding is chunked";

/* handles a byte of a known field's value, which `part` already counts */
static void strict_known(struct srv_http_strict *strict, unsigned char c) {
    static const char coding[] = "chunked";
    switch (strict->field) {
    case STRICT_HOST:
        if (!strict_is(c, STRICT_AUTHORITY))
            strict_refuse(strict, 400, "the header field Host is not a host");
        return;
    case STRICT_LENGTH:
        if (c < '0' || c > '9')
            strict_refuse(strict, 400, strict_no_length);
        else if (strict->part > 18)
            strict_refuse(strict, 413, "Content-Length is larger than any limit");
        else
            strict->left = 10 * strict->left + (c - '0');
        return;
    case STRICT_CODING:
        if (strict->part >= (int)sizeof coding || (c | 32) != coding[strict->part - 1])
            strict_refuse(strict, 501, strict_no_coding);
        return;
    }
}

static void strict_value_end(struct srv_http_strict *strict) {
    if (strict->field == STRICT_LENGTH && !strict->part)
        strict_refuse(strict, 400, strict_no_length);
    else if (strict->field == STRICT_CODING && strict->part != 7)
        strict_refuse(strict, 501, strict_no_coding);
    else
        strict_go(strict, SRV_STRICT_VALUE_LF);
}

static void strict_value(struct srv_http_strict *strict, unsigned char c) {
    if (c == '\r') {
        strict_value_end(strict);
    } else if (!strict_is(c, STRICT_VALUE)) {
        strict_refuse(
            strict, 400,
            "the value of a header field has a control character, or a line ends without CR LF");
    } else if (strict->place == SRV_STRICT_IN_VALUE || !(c == ' ' || c == '\t')) {
        strict->place = SRV_STRICT_IN_VALUE;
        strict->part++;
        if (strict->field) strict_known(strict, c);
    }
}

/* --- the end of the head, and bodies --- */

static void strict_complete(struct srv_http_strict *strict) {
    strict->complete++;
    strict->blanks = 0;
    strict_go(strict, SRV_STRICT_START);
}

static void strict_head_end(struct srv_http_strict *strict) {
    if (strict->trailer)
        strict_complete(strict);
    else if (!strict->hosts && !strict->old)
        strict_refuse(strict, 400, "a request of HTTP/1.1 needs the header field Host");
    else if (strict->codings && strict->lengths)
        strict_refuse(strict, 400, "Content-Length and Transfer-Encoding exclude each other");
    else if (strict->codings && strict->old)
        strict_refuse(strict, 400, "HTTP/1.0 has no Transfer-Encoding");
    else if (strict->codings)
        strict_go(strict, SRV_STRICT_CHUNK);
    else if (strict->left)
        strict_go(strict, SRV_STRICT_IN_BODY);
    else
        strict_complete(strict);
}

static const char strict_no_chunk[] =
    "a chunk must be its size in hexadecimal digits, CR LF, its bytes, CR LF";

static void strict_size(struct srv_http_strict *strict, unsigned char c) {
    if (strict->place == SRV_STRICT_CHUNK) strict->left = 0;
    if (strict_is(c, STRICT_HEX) && strict->part < 15) {
        strict->left = 16 * strict->left + (unsigned)(c <= '9' ? c - '0' : (c | 32) - 'a' + 10);
        strict->place = SRV_STRICT_IN_SIZE;
        strict->part++;
    } else if (strict->place == SRV_STRICT_IN_SIZE && (c == '\r' || c == ';')) {
        strict_go(strict, c == '\r' ? SRV_STRICT_SIZE_LF : SRV_STRICT_IN_EXTENSION);
    } else {
        strict_refuse(strict, 400, strict_no_chunk);
    }
}

static void strict_extension(struct srv_http_strict *strict, unsigned char c) {
    if (c == '\r')
        strict_go(strict, SRV_STRICT_SIZE_LF);
    else if (!strict_is(c, STRICT_VALUE) || ++strict->part > SRV_STRICT_EXTENSIONS)
        strict_refuse(strict, 400,
                      "the extensions of a chunk are too long or have a control character");
}

static void strict_size_end(struct srv_http_strict *strict, unsigned char c) {
    strict_expect(strict, c, '\n', strict->left ? SRV_STRICT_IN_CHUNK : SRV_STRICT_LINE,
                  strict_no_chunk);
    if (strict->place != SRV_STRICT_LINE) return;
    strict->trailer = 1;
    strict->fields = strict->bytes = 0;
}

/* --- reading --- */

static const char strict_no_lf[] = "a line must end with CR LF";

/* handles a byte of a head, of a trailer section, or of the empty lines before a request */
static void strict_head_byte(struct srv_http_strict *strict, unsigned char c) {
    switch (strict->place) {
    case SRV_STRICT_START:
        strict_begin(strict, c);
        return;
    case SRV_STRICT_START_LF:
        strict_expect(strict, c, '\n', SRV_STRICT_START, strict_no_lf);
        return;
    case SRV_STRICT_IN_METHOD:
        strict_method(strict, c);
        return;
    case SRV_STRICT_IN_TARGET:
        strict_target(strict, c);
        return;
    case SRV_STRICT_IN_VERSION:
        strict_version(strict, c);
        return;
    case SRV_STRICT_LINE_LF:
    case SRV_STRICT_VALUE_LF:
        strict_expect(strict, c, '\n', SRV_STRICT_LINE, strict_no_lf);
        return;
    case SRV_STRICT_LINE:
        strict_line(strict, c);
        return;
    case SRV_STRICT_IN_NAME:
        strict_name(strict, c);
        return;
    case SRV_STRICT_BEFORE_VALUE:
    case SRV_STRICT_IN_VALUE:
        strict_value(strict, c);
        return;
    case SRV_STRICT_END_LF:
        if (c == '\n')
            strict_head_end(strict);
        else
            strict_refuse(strict, 400, strict_no_lf);
        return;
    default:
        return;
    }
}

/* handles a byte between the chunks of a body */
static void strict_chunk_byte(struct srv_http_strict *strict, unsigned char c) {
    switch (strict->place) {
    case SRV_STRICT_CHUNK:
    case SRV_STRICT_IN_SIZE:
        strict_size(strict, c);
        return;
    case SRV_STRICT_IN_EXTENSION:
        strict_extension(strict, c);
        return;
    case SRV_STRICT_SIZE_LF:
        strict_size_end(strict, c);
        return;
    case SRV_STRICT_CHUNK_CR:
        strict_expect(strict, c, '\r', SRV_STRICT_CHUNK_LF, strict_no_chunk);
        return;
    case SRV_STRICT_CHUNK_LF:
        strict_expect(strict, c, '\n', SRV_STRICT_CHUNK, strict_no_chunk);
        return;
    default:
        return;
    }
}

/* skips bytes of a body or of an unknown field's value; returns their number */
static size_t strict_skip(struct srv_http_strict *strict, const char *data, size_t bytes) {
    if (strict->place == SRV_STRICT_IN_VALUE && !strict->field) {
        size_t run = 0;
        while (run < bytes && strict_is((unsigned char)data[run], STRICT_VALUE)) run++;
        strict->bytes += run < SRV_STRICT_HEAD ? (int)run : SRV_STRICT_HEAD;
        return run;
    }
    if (strict->place != SRV_STRICT_IN_BODY && strict->place != SRV_STRICT_IN_CHUNK) return 0;
    size_t run = strict->left < bytes ? (size_t)strict->left : bytes;
    strict->left -= run;
    if (!strict->left && strict->place == SRV_STRICT_IN_CHUNK)
        strict_go(strict, SRV_STRICT_CHUNK_CR);
    else if (!strict->left)
        strict_complete(strict);
    return run;
}

static int strict_in_head(const struct srv_http_strict *strict) {
    return strict->place >= SRV_STRICT_IN_METHOD && strict->place <= SRV_STRICT_END_LF;
}

void srv_http_strict_init(struct srv_http_strict *strict) {
    *strict = (struct srv_http_strict){.place = SRV_STRICT_START};
}

/* true within bytes that are removed: a chunk's extensions, or the value of Cookie */
static int strict_takes_out(const struct srv_http_strict *strict) {
    int value = strict->place == SRV_STRICT_BEFORE_VALUE || strict->place == SRV_STRICT_IN_VALUE;
    return strict->place == SRV_STRICT_IN_EXTENSION || (value && strict->field == STRICT_COOKIE);
}

#ifndef NDEBUG
/* true if all counts are within their bounds, and a refusal has its sentence */
static int strict_valid(const struct srv_http_strict *strict) {
    int refused = strict->place == SRV_STRICT_REFUSED;
    return refused == (strict->status != 0) && refused == (strict->detail != NULL) &&
           strict->complete <= strict->requests && strict->requests <= strict->complete + 1 &&
           (refused || (strict->fields <= SRV_STRICT_FIELDS && strict->bytes <= SRV_STRICT_HEAD &&
                        strict->parameters <= SRV_STRICT_PARAMETERS && strict->hosts <= 1));
}
#endif

static void strict_byte(struct srv_http_strict *strict, unsigned char c) {
    if (strict->place <= SRV_STRICT_END_LF)
        strict_head_byte(strict, c);
    else
        strict_chunk_byte(strict, c);
}

size_t srv_http_strict_read(struct srv_http_strict *strict, char *data, size_t bytes) {
    size_t passed = 0, kept = 0;
    assert(strict_valid(strict));
    for (size_t i = 0; i < bytes && strict->place != SRV_STRICT_REFUSED;) {
        long complete = strict->complete;
        int within = strict_takes_out(strict);
        size_t run = strict_skip(strict, data + i, bytes - i), count = run ? run : 1;
        if (!run) strict_byte(strict, (unsigned char)data[i]);
        /* the colon before a removed value stays */
        if (run || !strict_takes_out(strict) || (data[i] == ':' && !within)) {
            if (kept != i) memmove(data + kept, data + i, count);
            kept += count;
        }
        i += count;
        strict->bytes += !run && strict_in_head(strict);
        if (strict->bytes > SRV_STRICT_HEAD && strict_in_head(strict))
            strict_refuse(strict, 431, "the request's head has more than 8192 bytes");
        if (strict->complete != complete) passed = kept;
    }
    assert(strict_valid(strict));
    assert(passed <= kept);
    assert(kept <= bytes);
    return strict->place == SRV_STRICT_REFUSED ? passed : kept;
}

int srv_http_strict_within(const struct srv_http_strict *strict) {
    return strict->place != SRV_STRICT_START && strict->place != SRV_STRICT_START_LF &&
           strict->place != SRV_STRICT_REFUSED;
}
