#include "server/protocol/http_strict.h"

#include <string.h>

/* classes of bytes */
enum {
    FRONT_TOKEN = 1,     /* of a method or a field's name: RFC 9110 5.6.2 */
    FRONT_VISIBLE = 2,   /* visible ASCII */
    FRONT_VALUE = 4,     /* of a field's value: RFC 9110 5.5 */
    FRONT_AUTHORITY = 8, /* of a host and a port: RFC 3986 3.2.2 */
    FRONT_HEX = 16,
    /* and the sets of classes that bytes have */
    FRONT_BLANK = FRONT_VALUE,
    FRONT_DELIMITER = FRONT_VISIBLE | FRONT_VALUE,
    FRONT_HOST_MARK = FRONT_DELIMITER | FRONT_AUTHORITY,
    FRONT_TOKEN_MARK = FRONT_DELIMITER | FRONT_TOKEN,
    FRONT_MARK = FRONT_DELIMITER | FRONT_AUTHORITY | FRONT_TOKEN
};

/* clang-format off */
static const unsigned char front_class[256] = {
    ['\t'] = FRONT_BLANK, [' '] = FRONT_BLANK, [0x80 ... 0xff] = FRONT_BLANK,
    ['0' ... '9'] = FRONT_MARK | FRONT_HEX, ['A' ... 'F'] = FRONT_MARK | FRONT_HEX, ['a' ... 'f'] = FRONT_MARK | FRONT_HEX,
    ['G' ... 'Z'] = FRONT_MARK, ['g' ... 'z'] = FRONT_MARK,
    ['!'] = FRONT_MARK, ['$'] = FRONT_MARK, ['%'] = FRONT_MARK, ['&'] = FRONT_MARK, ['\''] = FRONT_MARK,
    ['*'] = FRONT_MARK, ['+'] = FRONT_MARK, ['-'] = FRONT_MARK, ['.'] = FRONT_MARK, ['_'] = FRONT_MARK,
    ['~'] = FRONT_MARK,
    ['#'] = FRONT_TOKEN_MARK, ['^'] = FRONT_TOKEN_MARK, ['`'] = FRONT_TOKEN_MARK, ['|'] = FRONT_TOKEN_MARK,
    ['('] = FRONT_HOST_MARK, [')'] = FRONT_HOST_MARK, [','] = FRONT_HOST_MARK, [';'] = FRONT_HOST_MARK,
    ['='] = FRONT_HOST_MARK, [':'] = FRONT_HOST_MARK, ['['] = FRONT_HOST_MARK, [']'] = FRONT_HOST_MARK,
    ['"'] = FRONT_DELIMITER, ['/'] = FRONT_DELIMITER, ['<'] = FRONT_DELIMITER, ['>'] = FRONT_DELIMITER,
    ['?'] = FRONT_DELIMITER, ['@'] = FRONT_DELIMITER, ['\\'] = FRONT_DELIMITER, ['{'] = FRONT_DELIMITER,
    ['}'] = FRONT_DELIMITER,
};
/* clang-format on */

/* The fields that say how a message is framed, and one of which libmicrohttpd makes much. */
enum { FRONT_OTHER, FRONT_HOST, FRONT_LENGTH, FRONT_CODING, FRONT_COOKIE };

static const struct {
    const char *name;
    int field;
} front_fields[] = {
    {"host", FRONT_HOST},
    {"content-length", FRONT_LENGTH},
    {"transfer-encoding", FRONT_CODING},
    {"cookie", FRONT_COOKIE},
};

static int front_is(unsigned char c, unsigned classes) { return (front_class[c] & classes) != 0; }

static void front_refuse(struct srv_front *front, int status, const char *detail) {
    front->place = SRV_FRONT_REFUSED;
    front->status = status;
    front->detail = detail;
}

static void front_go(struct srv_front *front, enum srv_front_place place) {
    front->place = place;
    front->part = 0;
}

/* goes on where the one byte came that had to come */
static void front_expect(struct srv_front *front, unsigned char c, unsigned char wanted, enum srv_front_place place,
                         const char *detail) {
    if (c == wanted)
        front_go(front, place);
    else
        front_refuse(front, 400, detail);
}

/* --- the request line --- */

static void front_begin(struct srv_front *front, unsigned char c) {
    if (c == '\r' && front->blanks++ < 2) {
        front_go(front, SRV_FRONT_START_LF);
    } else if (front_is(c, FRONT_TOKEN)) {
        long requests = front->requests + 1, complete = front->complete;
        *front = (struct srv_front){.requests = requests, .complete = complete, .part = 1, .bytes = 1};
        front->place = SRV_FRONT_IN_METHOD;
    } else {
        front_refuse(front, 400, "a request must begin with a method; this port speaks plain HTTP/1.1");
    }
}

static void front_method(struct srv_front *front, unsigned char c) {
    if (c == ' ')
        front_go(front, SRV_FRONT_IN_TARGET);
    else if (!front_is(c, FRONT_TOKEN))
        front_refuse(front, 400, "the request line must be a method, one blank, the target, one blank, and HTTP/1.1");
    else if (++front->part > SRV_FRONT_METHOD)
        front_refuse(front, 501, "the method is none that is known here");
}

static void front_target(struct srv_front *front, unsigned char c) {
    front->parameters += c == '&';
    if (c == ' ' && front->part)
        front_go(front, SRV_FRONT_IN_VERSION);
    else if (!front_is(c, FRONT_VISIBLE))
        front_refuse(front, 400, "the request target has a byte that is not allowed there");
    else if (++front->part > SRV_FRONT_TARGET || front->parameters >= SRV_FRONT_PARAMETERS)
        front_refuse(front, 414, "the request target has more than 1023 bytes or 64 parameters");
}

static void front_version(struct srv_front *front, unsigned char c) {
    static const char form[] = "HTTP/#.#\r";
    char wanted = form[front->part++];
    int digit = c >= '0' && c <= '9';
    if (wanted == '#' ? !digit : c != (unsigned char)wanted)
        front_refuse(front, 400, "the request line must end with HTTP/1.1 or HTTP/1.0 and CR LF");
    else if (front->part == 6 && c != '1')
        front_refuse(front, 505, "this server speaks HTTP/1.1 and HTTP/1.0");
    else if (front->part == 8)
        front->old = c == '0';
    else if (front->part == 9)
        front_go(front, SRV_FRONT_LINE_LF);
}

/* --- fields --- */

static void front_line(struct srv_front *front, unsigned char c) {
    if (c == '\r') {
        front_go(front, SRV_FRONT_END_LF);
    } else if (front_is(c, FRONT_TOKEN)) {
        front->place = SRV_FRONT_IN_NAME;
        front->part = 1;
        front->name[0] = (char)(c | 32);
        if (++front->fields > SRV_FRONT_FIELDS) front_refuse(front, 431, "the request has more than 100 header fields");
    } else if (c == ' ' || c == '\t') {
        front_refuse(front, 400, "a header field must not be folded, nor begin with a blank");
    } else {
        front_refuse(front, 400, "a line of the head is no header field");
    }
}

/* counts a field that may come once, and not among the trailers */
static int front_once(struct srv_front *front, int *count, const char *twice) {
    if (front->trailer)
        front_refuse(front, 400, "Host, Content-Length and Transfer-Encoding cannot be trailer fields");
    else if (++*count > 1)
        front_refuse(front, 400, twice);
    return front->place != SRV_FRONT_REFUSED;
}

static void front_name_end(struct srv_front *front) {
    size_t bytes = (size_t)front->part;
    front->field = FRONT_OTHER;
    for (size_t i = 0; i < sizeof front_fields / sizeof *front_fields && bytes <= SRV_FRONT_NAME; i++)
        if (strlen(front_fields[i].name) == bytes && !memcmp(front_fields[i].name, front->name, bytes))
            front->field = front_fields[i].field;
    front_go(front, SRV_FRONT_BEFORE_VALUE);
    if (front->field == FRONT_HOST) front_once(front, &front->hosts, "there are two header fields Host");
    if (front->field == FRONT_CODING)
        front_once(front, &front->codings, "there are two header fields Transfer-Encoding");
    if (front->field == FRONT_LENGTH) front_once(front, &front->lengths, "there are two header fields Content-Length");
}

static void front_name(struct srv_front *front, unsigned char c) {
    if (c == ':')
        front_name_end(front);
    else if (!front_is(c, FRONT_TOKEN))
        front_refuse(front, 400, "a header field must be a name, a colon at once behind it, and a value");
    else if (front->part++ < SRV_FRONT_NAME)
        front->name[front->part - 1] = (char)(c | 32);
}

static const char front_no_length[] = "Content-Length must be a decimal number and nothing else";
static const char front_no_coding[] = "the only Transfer-Encoding that is known here is chunked";

/* a byte of the value of a field that matters; part counts it already */
static void front_known(struct srv_front *front, unsigned char c) {
    static const char coding[] = "chunked";
    switch (front->field) {
    case FRONT_HOST:
        if (!front_is(c, FRONT_AUTHORITY)) front_refuse(front, 400, "the header field Host is no host");
        return;
    case FRONT_LENGTH:
        if (c < '0' || c > '9')
            front_refuse(front, 400, front_no_length);
        else if (front->part > 18)
            front_refuse(front, 413, "Content-Length is larger than any limit");
        else
            front->left = 10 * front->left + (c - '0');
        return;
    case FRONT_CODING:
        if (front->part >= (int)sizeof coding || (c | 32) != coding[front->part - 1])
            front_refuse(front, 501, front_no_coding);
        return;
    }
}

static void front_value_end(struct srv_front *front) {
    if (front->field == FRONT_LENGTH && !front->part)
        front_refuse(front, 400, front_no_length);
    else if (front->field == FRONT_CODING && front->part != 7)
        front_refuse(front, 501, front_no_coding);
    else
        front_go(front, SRV_FRONT_VALUE_LF);
}

static void front_value(struct srv_front *front, unsigned char c) {
    if (c == '\r') {
        front_value_end(front);
    } else if (!front_is(c, FRONT_VALUE)) {
        front_refuse(front, 400, "the value of a header field has a control character, or a line ends without CR LF");
    } else if (front->place == SRV_FRONT_IN_VALUE || !(c == ' ' || c == '\t')) {
        front->place = SRV_FRONT_IN_VALUE;
        front->part++;
        if (front->field) front_known(front, c);
    }
}

/* --- the end of the head, and bodies --- */

static void front_complete(struct srv_front *front) {
    front->complete++;
    front->blanks = 0;
    front_go(front, SRV_FRONT_START);
}

static void front_head_end(struct srv_front *front) {
    if (front->trailer)
        front_complete(front);
    else if (!front->hosts && !front->old)
        front_refuse(front, 400, "a request of HTTP/1.1 needs the header field Host");
    else if (front->codings && front->lengths)
        front_refuse(front, 400, "Content-Length and Transfer-Encoding exclude each other");
    else if (front->codings && front->old)
        front_refuse(front, 400, "HTTP/1.0 has no Transfer-Encoding");
    else if (front->codings)
        front_go(front, SRV_FRONT_CHUNK);
    else if (front->left)
        front_go(front, SRV_FRONT_IN_BODY);
    else
        front_complete(front);
}

static const char front_no_chunk[] = "a chunk must be its size in hexadecimal digits, CR LF, its bytes, CR LF";

static void front_size(struct srv_front *front, unsigned char c) {
    if (front->place == SRV_FRONT_CHUNK) front->left = 0;
    if (front_is(c, FRONT_HEX) && front->part < 15) {
        front->left = 16 * front->left + (unsigned)(c <= '9' ? c - '0' : (c | 32) - 'a' + 10);
        front->place = SRV_FRONT_IN_SIZE;
        front->part++;
    } else if (front->place == SRV_FRONT_IN_SIZE && (c == '\r' || c == ';')) {
        front_go(front, c == '\r' ? SRV_FRONT_SIZE_LF : SRV_FRONT_IN_EXTENSION);
    } else {
        front_refuse(front, 400, front_no_chunk);
    }
}

static void front_extension(struct srv_front *front, unsigned char c) {
    if (c == '\r')
        front_go(front, SRV_FRONT_SIZE_LF);
    else if (!front_is(c, FRONT_VALUE) || ++front->part > SRV_FRONT_EXTENSIONS)
        front_refuse(front, 400, "the extensions of a chunk are too long or have a control character");
}

static void front_size_end(struct srv_front *front, unsigned char c) {
    front_expect(front, c, '\n', front->left ? SRV_FRONT_IN_CHUNK : SRV_FRONT_LINE, front_no_chunk);
    if (front->place != SRV_FRONT_LINE) return;
    front->trailer = 1;
    front->fields = front->bytes = 0;
}

/* --- reading along --- */

static const char front_no_lf[] = "a line must end with CR LF";

static void front_byte(struct srv_front *front, unsigned char c) {
    switch (front->place) {
    case SRV_FRONT_START:
        front_begin(front, c);
        return;
    case SRV_FRONT_START_LF:
        front_expect(front, c, '\n', SRV_FRONT_START, front_no_lf);
        return;
    case SRV_FRONT_IN_METHOD:
        front_method(front, c);
        return;
    case SRV_FRONT_IN_TARGET:
        front_target(front, c);
        return;
    case SRV_FRONT_IN_VERSION:
        front_version(front, c);
        return;
    case SRV_FRONT_LINE_LF:
    case SRV_FRONT_VALUE_LF:
        front_expect(front, c, '\n', SRV_FRONT_LINE, front_no_lf);
        return;
    case SRV_FRONT_LINE:
        front_line(front, c);
        return;
    case SRV_FRONT_IN_NAME:
        front_name(front, c);
        return;
    case SRV_FRONT_BEFORE_VALUE:
    case SRV_FRONT_IN_VALUE:
        front_value(front, c);
        return;
    case SRV_FRONT_END_LF:
        if (c == '\n')
            front_head_end(front);
        else
            front_refuse(front, 400, front_no_lf);
        return;
    case SRV_FRONT_CHUNK:
    case SRV_FRONT_IN_SIZE:
        front_size(front, c);
        return;
    case SRV_FRONT_IN_EXTENSION:
        front_extension(front, c);
        return;
    case SRV_FRONT_SIZE_LF:
        front_size_end(front, c);
        return;
    case SRV_FRONT_CHUNK_CR:
        front_expect(front, c, '\r', SRV_FRONT_CHUNK_LF, front_no_chunk);
        return;
    case SRV_FRONT_CHUNK_LF:
        front_expect(front, c, '\n', SRV_FRONT_CHUNK, front_no_chunk);
        return;
    case SRV_FRONT_IN_BODY:
    case SRV_FRONT_IN_CHUNK:
    case SRV_FRONT_REFUSED:
        return;
    }
}

/* passes over the bytes of a body, or of a value that nobody looks at; returns how many */
static size_t front_skip(struct srv_front *front, const char *data, size_t bytes) {
    if (front->place == SRV_FRONT_IN_VALUE && !front->field) {
        size_t run = 0;
        while (run < bytes && front_is((unsigned char)data[run], FRONT_VALUE)) run++;
        front->bytes += run < SRV_FRONT_HEAD ? (int)run : SRV_FRONT_HEAD;
        return run;
    }
    if (front->place != SRV_FRONT_IN_BODY && front->place != SRV_FRONT_IN_CHUNK) return 0;
    size_t run = front->left < bytes ? (size_t)front->left : bytes;
    front->left -= run;
    if (!front->left && front->place == SRV_FRONT_IN_CHUNK)
        front_go(front, SRV_FRONT_CHUNK_CR);
    else if (!front->left)
        front_complete(front);
    return run;
}

static int front_in_head(const struct srv_front *front) {
    return front->place >= SRV_FRONT_IN_METHOD && front->place <= SRV_FRONT_END_LF;
}

void srv_front_init(struct srv_front *front) { *front = (struct srv_front){.place = SRV_FRONT_START}; }

/* is the front within what is taken out: a chunk's extensions, or the value of a cookie's field? */
static int front_takes_out(const struct srv_front *front) {
    int value = front->place == SRV_FRONT_BEFORE_VALUE || front->place == SRV_FRONT_IN_VALUE;
    return front->place == SRV_FRONT_IN_EXTENSION || (value && front->field == FRONT_COOKIE);
}

size_t srv_front_read(struct srv_front *front, char *data, size_t bytes) {
    size_t passed = 0, kept = 0;
    for (size_t i = 0; i < bytes && front->place != SRV_FRONT_REFUSED;) {
        long complete = front->complete;
        int within = front_takes_out(front);
        size_t run = front_skip(front, data + i, bytes - i), count = run ? run : 1;
        if (!run) front_byte(front, (unsigned char)data[i]);
        /* the colon that begins a value stays */
        if (run || !front_takes_out(front) || (data[i] == ':' && !within)) {
            if (kept != i) memmove(data + kept, data + i, count);
            kept += count;
        }
        i += count;
        front->bytes += !run && front_in_head(front);
        if (front->bytes > SRV_FRONT_HEAD && front_in_head(front))
            front_refuse(front, 431, "the request's head has more than 8192 bytes");
        if (front->complete != complete) passed = kept;
    }
    return front->place == SRV_FRONT_REFUSED ? passed : kept;
}

int srv_front_within(const struct srv_front *front) {
    return front->place != SRV_FRONT_START && front->place != SRV_FRONT_START_LF && front->place != SRV_FRONT_REFUSED;
}
