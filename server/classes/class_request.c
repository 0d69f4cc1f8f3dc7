#include "server/classes/class_request.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "server/base/clock.h"
#include "server/work/admission.h"

/* Limits for wrong codes (burst, rate per second): from one address, from its /24 network (/48 of
 * IPv6), and globally. Beyond the first limits the client has to wait; beyond the second ones only
 * rooms that know the address accept codes. There are 2^30 codes. */
enum { REQUEST_ADDRESS, REQUEST_NETWORK, REQUEST_ALL, REQUEST_SOURCES };
static const struct {
    double burst, a_second, tries, tries_a_second;
} request_misses[REQUEST_SOURCES] = {{30, 0.5, 600, 20}, {120, 2, 2400, 60}, {1000, 10, 8000, 100}};

/* bytes of a request's body; bytes of a stored text */
enum { REQUEST_BODY = 1 << 18, REQUEST_TEXT = 4 << 20 };

static const char request_letters[] = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789";

static const struct srv_store_request_words request_words = {
    "classrooms", "a request that writes may be repeated unchanged"};

struct srv_class_request *srv_class_request_of(struct srv_store_request *asked) {
    assert(asked->more);
    return asked->more;
}

static void request_free(void *more) {
    struct srv_class_request *gone = more;
    api_buffer_clear(&gone->text);
    free(gone);
}

int srv_class_request_read_code(const char *path, char code[SRV_CLASS_CODE]) {
    size_t bytes = strcspn(path, "/");
    assert(sizeof request_letters - 1 == 32);
    if (bytes != SRV_CLASS_CODE - 1) return 0;
    for (size_t i = 0; i < bytes; i++) {
        code[i] = (char)toupper((unsigned char)path[i]);
        if (!strchr(request_letters, code[i])) return 0;
    }
    code[bytes] = 0;
    return 1;
}

/* Returns the seconds for which a source must wait because of too many wrong codes; 0 if it need
 * not wait, or if memory is short. `taken`: count this code as well. */
static double request_wait(struct srv_exchange *exchange, int source, enum srv_pace pace,
                           int taken) {
    struct srv_clients *clients = exchange->service->clients;
    char key[8 + SRV_PEER_BYTES] = "misses", network[SRV_PEER_BYTES];
    int tries = pace == SRV_PACE_TRIES;
    if (source == REQUEST_NETWORK) {
        /* For an account the connection's address is the proxy's. */
        if (*exchange->identity.source != 'n') return 0;
        srv_peer_shorten(exchange->identity.network, network);
        snprintf(key, sizeof key, "misses %s", network);
    }
    struct srv_client *client = srv_clients_take(
        clients, source == REQUEST_ADDRESS ? exchange->identity.source : key, NULL);
    if (!client) return 0;
    double wait = srv_clients_pace(
        clients, client, pace,
        tries ? request_misses[source].tries_a_second : request_misses[source].a_second,
        tries ? request_misses[source].tries : request_misses[source].burst, taken,
        srv_clock_now());
    srv_clients_give(clients, client);
    return wait;
}

/* As request_wait, for all sources of a request. A client that must wait is not counted for the
 * wider sources. */
static double request_waits(struct srv_exchange *exchange, enum srv_pace pace, int taken) {
    double wait = 0;
    for (int i = 0; i < REQUEST_SOURCES && wait <= 0; i++)
        wait = request_wait(exchange, i, pace, taken);
    return wait;
}

enum srv_stored srv_class_request_look(struct srv_store *store, struct srv_store_call *call) {
    struct srv_class_request *own =
        srv_class_request_of(SRV_CONTAINER_OF(call, struct srv_store_request, ask.call));
    int64_t from;
    SRV_STORED_TRY(srv_store_class(store, own->code, own->who, &own->room));
    if (request_waits(own->exchange, SRV_PACE_TRIES, 0) <= 0 ||
        !strcmp(own->room.source, own->source) || !strcmp(own->room.near, own->source))
        return SRV_STORED;
    SRV_STORED_TRY(srv_store_class_comes(store, own->code, own->source, &from));
    return from ? SRV_STORED : SRV_STORED_NONE;
}

/* Answers 404, both if the room does not exist and if the client is not in it; 429 after too many
 * wrong codes. */
static void request_nowhere(struct srv_class_request *own) {
    struct srv_exchange *exchange = own->exchange;
    if (!own->joins) {
        srv_exchange_problem(exchange, 404,
                             "there is no classroom with this code that your token has joined");
        return;
    }
    (void)request_waits(exchange, SRV_PACE_TRIES, 1);
    double wait = request_waits(exchange, SRV_PACE_MISSES, 1);
    if (wait > 0) {
        srv_exchange_problem(exchange, 429,
                             API_TYPE_RATE
                             "there is no classroom with this code, and too many wrong codes were "
                             "sent before, from your address or from many addresses");
        srv_exchange_retry(exchange, wait);
    } else {
        srv_exchange_problem(exchange, 404,
                             "there is no classroom with this code, or it has ended");
    }
}

/* Sets the identity of a token. Returns 0 if the token is malformed. */
static int request_identity(const char *token, struct srv_identity *identity) {
    char field[sizeof "Bearer " + SRV_TOKEN_MOST];
    snprintf(field, sizeof field, "Bearer %s", token);
    identity->kind = SRV_IDENTITY_ADDRESS;
    return strlen(token) <= SRV_TOKEN_MOST && srv_identity_token(identity, field) &&
           identity->kind == SRV_IDENTITY_TOKEN;
}

/* Identifies the client. Returns 0 if the exchange was answered because the token is malformed. */
static int request_who(struct srv_class_request *own) {
    struct srv_exchange *exchange = own->exchange;
    struct srv_identity who = exchange->identity;
    const char *token = exchange->field[SRV_ROOM_TOKEN];
    if (token && !request_identity(token, &who)) {
        srv_exchange_problem(exchange, 401,
                             API_TYPE_CREDENTIALS "Class-Token is not a valid token: %s",
                             srv_identity_rule);
        srv_exchange_header(exchange, "WWW-Authenticate", "Bearer realm=\"pendulumd\"");
        return 0;
    }
    int pupil = own->joins && exchange->argument;
    if (who.kind == SRV_IDENTITY_TOKEN || (who.kind == SRV_IDENTITY_ISSUED && !pupil))
        snprintf(own->who, sizeof own->who, "%s", who.key);
    return 1;
}

/* Returns 1 if the client may send codes; else answers the request. */
static int request_names(struct srv_class_request *own) {
    struct srv_exchange *exchange = own->exchange;
    if (!request_who(own)) return 0;
    if (!own->joins && !*own->who) {
        srv_admission_challenge(
            exchange, "only members can use a classroom: send the token with which you joined it");
        return 0;
    }
    if (!exchange->argument) return 1;
    if (srv_class_request_read_code(exchange->argument, own->code)) return 1;
    request_nowhere(own);
    return 0;
}

struct srv_store_request *srv_class_request_begin(struct srv_exchange *exchange, int joins) {
    struct srv_store_request *asked = srv_store_request_begin(exchange, &request_words);
    if (!asked) return NULL;
    assert(exchange->account);
    struct srv_class_request *own = calloc(1, sizeof *own);
    asked->more = own;
    asked->more_free = request_free;
    if (!own) {
        srv_exchange_busy(exchange, 1, "out of memory");
    } else {
        own->exchange = exchange;
        own->joins = joins;
        /* the first 20 bits of the source's digest, which many sources share */
        snprintf(own->source, sizeof own->source, "%s", exchange->identity.source + 2);
        api_buffer_init(&own->text, REQUEST_TEXT);
        if (request_names(own)) return asked;
    }
    srv_store_request_end(asked);
    return NULL;
}

void srv_class_request_part(const struct srv_exchange *exchange, int at, char part[], size_t cap) {
    const char *from = exchange->argument;
    assert(at >= 1 && cap > 1);
    for (int i = 0; i < at && from; i++)
        if ((from = strchr(from, '/'))) from++;
    size_t bytes = from ? strcspn(from, "/") : 0;
    /* No item has an id that is too long, so treat it as empty. */
    if (bytes >= cap) bytes = 0;
    memcpy(part, bytes ? from : "", bytes);
    part[bytes] = 0;
}

int srv_class_request_pace(struct srv_store_request *asked, enum srv_pace pace, double a_second,
                           double burst, int own, const char *what) {
    struct srv_exchange *exchange = asked->exchange;
    struct srv_clients *clients = exchange->service->clients;
    assert(exchange->account && (!own || *srv_class_request_of(asked)->who));
    /* Each client of a shared API key has a rate of its own. */
    struct srv_client *client =
        own ? srv_clients_take(clients, srv_class_request_of(asked)->who, exchange->identity.source)
            : exchange->account->source;
    double wait =
        client ? srv_clients_pace(clients, client, pace, a_second, burst, 1, srv_clock_now()) : 1;
    if (own && client) srv_clients_give(clients, client);
    if (wait <= 0) return 1;
    srv_exchange_problem(exchange, 429, API_TYPE_RATE "%s: %.0f at once, and then %.3g a second",
                         what, burst, a_second);
    srv_exchange_retry(exchange, wait);
    srv_store_request_end(asked);
    return 0;
}

int srv_class_request_code(char code[SRV_CLASS_CODE]) {
    unsigned char bits[SRV_CLASS_CODE - 1];
    if (getrandom(bits, sizeof bits, 0) != (ssize_t)sizeof bits) return 0;
    for (size_t i = 0; i < sizeof bits; i++) code[i] = request_letters[bits[i] & 31];
    code[sizeof bits] = 0;
    return 1;
}

int srv_class_request_token(struct srv_store_request *asked) {
    struct srv_class_request *own = asked->more;
    struct srv_identity made = asked->exchange->identity;
    unsigned char bits[(SRV_CLASS_TOKEN - 1) / 2];
    /* One token in many millions has too few different letters; draw again. */
    for (int i = 0; i < 4 && !*own->who; i++) {
        if (getrandom(bits, sizeof bits, 0) != (ssize_t)sizeof bits) break;
        for (size_t k = 0; k < sizeof bits; k++) snprintf(own->token + 2 * k, 3, "%02x", bits[k]);
        if (request_identity(own->token, &made))
            snprintf(own->who, sizeof own->who, "%s", made.key);
    }
    if (*own->who) return 1;
    srv_exchange_busy(asked->exchange, 1, "the system has no random numbers");
    return 0;
}

int srv_class_request_check(struct srv_store_request *asked) {
    struct srv_exchange *exchange = asked->exchange;
    struct srv_class_request *own = asked->more;
    struct api_request request = {.query = exchange->query,
                                  .content_type = exchange->field[SRV_CONTENT_TYPE],
                                  .accept = exchange->field[SRV_ACCEPT],
                                  .body = exchange->body.bytes ? exchange->body.data : NULL,
                                  .body_bytes = exchange->body.bytes};
    assert(own->kind < API_CLASS_KINDS && !exchange->status);
    api_buffer_init(&asked->body, REQUEST_BODY);
    own->put.fold = own->fold;
    int http = api_class_read(&request, &srv_service_config(exchange->service)->limits, own->kind,
                              &own->facts, &asked->body, &exchange->answer);
    if (http) {
        srv_exchange_answered(exchange, http, "application/problem+json");
        return 0;
    }
    own->put.body = asked->body.data;
    own->put.bytes = asked->body.bytes;
    return 1;
}

static void request_why(struct srv_class_request *own) {
    struct srv_exchange *exchange = own->exchange;
    const struct srv_config *config = &exchange->service->config;
    assert(own->put.why != SRV_CLASS_FINE);
    switch (own->put.why) {
    case SRV_CLASS_NO_TEACHER:
        srv_exchange_problem(exchange, 403,
                             API_TYPE_ROLE "only the teacher of the classroom may do this");
        break;
    case SRV_CLASS_NO_PUPIL:
        srv_exchange_problem(exchange, 403,
                             API_TYPE_ROLE "only pupils of the classroom may do this");
        break;
    case SRV_CLASS_SHUT:
        srv_exchange_problem(exchange, 403, "the teacher has closed the classroom to new pupils");
        break;
    case SRV_CLASS_CROWDED:
        srv_exchange_problem(exchange, 429,
                             API_TYPE_QUOTA "the classroom is full: max-class-pupils is %.0f",
                             config->class_pupils);
        srv_exchange_retry(exchange, 60);
        break;
    case SRV_CLASS_SHARED:
        srv_exchange_problem(
            exchange, 429,
            API_TYPE_QUOTA
            "the classroom has as many pupils from your address as allowed; its teacher can allow "
            "more (address_share of stages/class), or remove some");
        srv_exchange_retry(exchange, 60);
        break;
    case SRV_CLASS_ROOM_FULL:
        srv_exchange_problem(exchange, 429,
                             API_TYPE_QUOTA
                             "the classroom's storage is full: max-class-bytes is %.0f",
                             config->class_bytes);
        srv_exchange_retry(exchange, 60);
        break;
    case SRV_CLASS_PUPIL_FULL:
        srv_exchange_problem(exchange, 429,
                             API_TYPE_QUOTA "the items of one pupil may have at most %d bytes",
                             SRV_CLASS_PUPIL_BYTES);
        srv_exchange_retry(exchange, 60);
        break;
    case SRV_CLASS_NO_BASE:
        srv_exchange_problem(exchange, 409, "there is no question %.90s", own->base);
        break;
    case SRV_CLASS_CLOSED:
        srv_exchange_problem(exchange, 409, "%.90s is closed for answers", own->base);
        break;
    case SRV_CLASS_MISFIT:
        srv_exchange_problem(exchange, 422,
                             "the value does not answer %.90s: see the kind of the question",
                             own->base);
        break;
    default:
        request_nowhere(own);
        break;
    }
}

void srv_class_request_refuse(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_class_request *own = asked->more;
    if (stored == SRV_STORED_NONE)
        request_nowhere(own);
    else if (stored == SRV_STORED_CLASH)
        request_why(own);
    else
        srv_store_request_refuse(asked, stored);
}

struct api_class_room srv_class_request_view(const struct srv_class *room) {
    return (struct api_class_room){.code = room->code,
                                   .role = room->teacher ? "teacher"
                                           : room->pupil ? "pupil"
                                                         : "operator",
                                   .pupil = (long)room->pupil,
                                   .created = room->created,
                                   .ends = room->ends,
                                   .version = room->version,
                                   .pupils = (long)room->pupils,
                                   .empty_ends = room->empty_ends,
                                   .shut = room->shut};
}
