/* The strict parser of requests: it checks every byte of a connection before libmicrohttpd reads
 * it, and stops at the first invalid byte. This prevents request smuggling. Leaves to others:
 * receiving the bytes and answering the client (http), the meaning of a request (request_head,
 * router). Invariant: the bytes that pass can be divided into requests in one way only, that of RFC
 * 9112 without its leniencies. */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* The limits of a request's head; libmicrohttpd's memory per connection suffices for them. */
enum {
    SRV_STRICT_METHOD = 32,      /* bytes of the method */
    SRV_STRICT_TARGET = 1023,    /* bytes of the target */
    SRV_STRICT_PARAMETERS = 64,  /* query parameters */
    SRV_STRICT_FIELDS = 100,     /* header fields; trailer fields as well */
    SRV_STRICT_HEAD = 8192,      /* bytes of the head; of the trailer section as well */
    SRV_STRICT_EXTENSIONS = 256, /* bytes of a chunk's extensions */
    SRV_STRICT_NAME = 20         /* bytes of a field's name that are kept to identify it */
};

/* The part of a request to which the next byte belongs. */
enum srv_http_strict_place {
    SRV_STRICT_START, /* before the first byte of a request */
    SRV_STRICT_START_LF,
    SRV_STRICT_IN_METHOD,
    SRV_STRICT_IN_TARGET,
    SRV_STRICT_IN_VERSION,
    SRV_STRICT_LINE_LF,
    SRV_STRICT_LINE, /* at the start of a line of the head, or of the trailer section */
    SRV_STRICT_IN_NAME,
    SRV_STRICT_BEFORE_VALUE,
    SRV_STRICT_IN_VALUE,
    SRV_STRICT_VALUE_LF,
    SRV_STRICT_END_LF, /* before the LF of the empty line */
    SRV_STRICT_IN_BODY,
    SRV_STRICT_CHUNK, /* at the start of a chunk's size */
    SRV_STRICT_IN_SIZE,
    SRV_STRICT_IN_EXTENSION,
    SRV_STRICT_SIZE_LF,
    SRV_STRICT_IN_CHUNK,
    SRV_STRICT_CHUNK_CR,
    SRV_STRICT_CHUNK_LF,
    SRV_STRICT_REFUSED
};

struct srv_http_strict {
    enum srv_http_strict_place place;
    long requests, complete; /* requests begun and completed */
    int status;              /* HTTP status of the refusal; 0 = none */
    const char *detail;      /* the message of the refusal */
    /* the current request */
    int old;     /* HTTP/1.0 */
    int trailer; /* the head is complete, the fields are those of the trailer section */
    int bytes;   /* of the head or the trailer section */
    int part;    /* bytes of the part of a line that is being read */
    int blanks;  /* empty lines before the request */
    int fields, parameters, hosts, lengths, codings;
    int field;     /* the known field that the line belongs to */
    uint64_t left; /* bytes of the body or of the chunk */
    char name[SRV_STRICT_NAME];
};

/** Begins a new connection. */
void srv_http_strict_init(struct srv_http_strict *strict);

/**
 * Checks the next bytes of a connection.
 *
 * The values of cookies are removed, because nothing uses them and libmicrohttpd would need much
 * memory to parse them; the field remains, empty. Chunk extensions are removed too:
 * libmicrohttpd 1.0 takes the end of such a line for the chunk's first byte.
 *
 * Returns how many bytes of `data` may be passed on: all that were not removed or, after a refusal,
 * those of the complete requests before the invalid one. O(bytes): 1 to 2 ns per byte of a head,
 * nothing for a body.
 */
size_t srv_http_strict_read(struct srv_http_strict *strict, char *data, size_t bytes);

/** Returns true between the first byte of a request and its last. */
int srv_http_strict_within(const struct srv_http_strict *strict);
