/* A request to a room: the code, the token and the pace of whoever asks, and the refusals.
 * Leaves to others: what is asked (classes, class_reports).
 * Invariant: whether there is a room of a code is told to those who are in it, and to those who try
 * to join; a wrong code is counted against its address, its network and everybody. */
#ifndef SRV_CLASS_REQUEST_H
#define SRV_CLASS_REQUEST_H

#include "api/class/class_json.h"
#include "server/jobs/store_request.h"
#include "server/store/store_classes.h"

enum {
    SRV_CLASS_TOKEN = 33, /* bytes of a token that the server makes, with its NUL */
    SRV_CLASS_TRIES = 100 /* that a room may be written into by another process just then */
};

/* What a store request to a room has beside it (store_request->more). */
struct srv_class_request {
    struct srv_exchange *exchange;
    char code[SRV_CLASS_CODE];
    char who[SRV_NAME_BYTES];    /* the key of the token */
    char token[SRV_CLASS_TOKEN]; /* that the server has made; "" = it has made none */
    char name[SRV_CLASS_NAME], base[SRV_CLASS_NAME];
    char source[SRV_CLASS_SOURCE]; /* the mark of the address */
    char fold[SRV_CLASS_FOLD];     /* of who joins: the folded nickname */
    struct srv_class room;
    struct srv_class_put put;
    enum api_class_kind kind; /* of the body */
    struct api_class_facts facts;
    int joins;        /* whoever asks need not be in the room */
    const char *full; /* of a new room: what has met its bound */
    int tries;
    /* of what reads a whole room, page by page */
    int64_t since;
    int more;
    struct api_buffer text;
};

/** What a store request to a room has beside it. */
struct srv_class_request *srv_class_request_of(struct srv_store_request *asked);

/**
 * Begins a request to a room, or one that makes a room (the path has no code).
 *
 * Whoever asks is known by the field Class-Token, else by the bearer token. A key that the operator
 * handed out is such a token too, but for who joins: a whole class may have one.
 *
 * joins  whoever asks need not have a token, nor be in the room.
 *
 * Returns NULL where it cannot be; the exchange is answered then, and its finish was called: 401
 * without a token, 404 or 429 for a code that no room can have.
 */
struct srv_store_request *srv_class_request_begin(struct srv_exchange *exchange, int joins);

/** Takes the next part of the path behind the room's code: "questions" and then "tide" of
 * ABCDE/questions/tide. `at` is 1 or 2; empty where there is none. */
void srv_class_request_part(const struct srv_exchange *exchange, int at, char part[], size_t cap);

/**
 * Whether what comes at a pace may come now; else the exchange is answered 429, its finish is
 * called and the store request is gone.
 *
 * own  the pace is that of the client, else of all of its address.
 */
int srv_class_request_pace(struct srv_store_request *asked, enum srv_pace pace, double a_second,
                           double burst, int own, const char *what);

/** Makes a token, if the client has sent none of its own. Returns 0, with the exchange answered,
 * without random numbers. */
int srv_class_request_token(struct srv_store_request *asked);

/**
 * Looks for the room that somebody wants to join, before anything is counted: a right code gets in
 * after wrong ones. Only while wrong codes come at a rate that nobody's mistakes have must the room
 * know the address: it was made there, its teacher wrote there last, or a pupil came from there. A
 * question to the store; SRV_STORED_NONE.
 */
enum srv_stored srv_class_request_look(struct srv_store *store, struct srv_store_call *call);

/**
 * Reads a room's code at the beginning of a path, up to the next slash, in capitals. Returns 0 if
 * what stands there cannot be a code.
 */
int srv_class_request_read_code(const char *path, char code[SRV_CLASS_CODE]);

/** Makes a code. Returns 0 without random numbers. */
int srv_class_request_code(char code[SRV_CLASS_CODE]);

/** Reads the body as `kind` into asked->body; a check of srv_store_request_work. */
int srv_class_request_check(struct srv_store_request *asked);

/** True where the store is to be asked once more, as another process was in the way. */
int srv_class_request_again(struct srv_store_request *asked, enum srv_stored stored);

/** A room as it is told to who asks: its teacher, a pupil, else an operator. */
struct api_class_room srv_class_request_view(const struct srv_class *room);

/** Answers with the problem that a result of the store stands for. */
void srv_class_request_refuse(struct srv_store_request *asked, enum srv_stored stored);

#endif
