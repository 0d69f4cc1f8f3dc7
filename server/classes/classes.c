#include "server/classes/classes.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/json/json_out.h"
#include "server/classes/class_events.h"
#include "server/classes/class_request.h"
#include "server/classes/nickname.h"
#include "server/store/store_class_pupils.h"
#include "server/work/admission.h"

/* bursts: rooms and joins of an address, writes of a client; and tries for an unused code */
enum { CLASSES_ROOMS = 60, CLASSES_JOINS = 100, CLASSES_WRITES = 40, CLASSES_CODES = 16 };
/* An address may have CLASSES_ADDRESS rooms or a tenth of all rooms, whichever is more. A room
 * without pupils is deleted after CLASSES_EMPTY_US. */
enum { CLASSES_ADDRESS = 10, CLASSES_TENTH = 10 };
#define CLASSES_EMPTY_US INT64_C(3600000000)
#define CLASSES_ROOMS_A_SECOND (1.0 / 60)
#define CLASSES_JOINS_A_SECOND 10.0
#define CLASSES_WRITES_A_SECOND 5.0

static const char classes_json[] = "application/json";

static struct srv_class_request *classes_own(struct srv_store_call *call) {
    return srv_class_request_of(SRV_CONTAINER_OF(call, struct srv_store_request, ask.call));
}

static void classes_tell(struct srv_store_request *asked, int status) {
    struct srv_exchange *exchange = asked->exchange;
    struct srv_class_request *own = srv_class_request_of(asked);
    const struct srv_class *room = &own->room;
    struct api_class_room told = srv_class_request_view(room);
    told.token = *own->token ? own->token : NULL;
    assert(room->teacher || room->pupil);
    char *location = srv_exchange_text(exchange, 40);
    if (api_class_room_write(&told, &exchange->answer) != PEND_OK ||
        api_buffer_text(&exchange->answer, "}") != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return;
    }
    srv_exchange_answered(exchange, status, classes_json);
    srv_exchange_header(exchange, "Cache-Control", "no-store");
    if (!location) return;
    snprintf(location, 40, "/v1/classes/%s", room->code);
    srv_exchange_header(exchange, "Location", location);
}

/* --- a new room --- */

/* Reads an optional key of 1 to SRV_STORE_REQUEST_KEY visible characters. */
static int classes_read_key(const char *text, char key[SRV_STORE_REQUEST_KEY + 1]) {
    key[0] = 0;
    if (!text) return 1;
    size_t bytes = strlen(text);
    if (!bytes || bytes > SRV_STORE_REQUEST_KEY) return 0;
    for (size_t i = 0; i < bytes; i++)
        if (text[i] <= ' ' || text[i] > '~') return 0;
    memcpy(key, text, bytes + 1);
    return 1;
}

static enum srv_stored create_run(struct srv_store *store, struct srv_store_call *call) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(call, struct srv_store_request, ask.call);
    struct srv_class_request *own = srv_class_request_of(asked);
    enum srv_stored stored = SRV_STORED_CLASH;
    const struct srv_identity *identity = &asked->exchange->identity;
    int issued = identity->kind == SRV_IDENTITY_ISSUED;
    long classes = (long)asked->service->config.classes,
         own_most = (long)fmin(identity->limits.value[SRV_LIMIT_ROOMS], (double)classes),
         address_most = (long)fmax(CLASSES_ADDRESS, (double)(classes / CLASSES_TENTH));
    const struct srv_class_new made = {.code = own->code,
                                       .who = own->who,
                                       .key = *asked->key ? asked->key : NULL,
                                       .source = own->source,
                                       .span_us = (int64_t)(own->facts.hours * 3600e6),
                                       .empty_us = issued ? 0 : CLASSES_EMPTY_US,
                                       .most = own_most,
                                       .most_from = issued ? own_most : address_most};
    for (int i = 0; i < CLASSES_CODES && stored == SRV_STORED_CLASH; i++) {
        if (!srv_class_request_code(own->code)) return SRV_STORED_AGAIN;
        stored = srv_store_class_new(store, &made, &own->room, &own->full);
    }
    return stored == SRV_STORED_CLASH ? SRV_STORED_QUOTA : stored;
}

static void create_answer(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    const struct srv_class_request *own = srv_class_request_of(asked);
    if (stored == SRV_STORED) {
        if (strcmp(own->room.code, own->code) != 0)
            srv_exchange_header(exchange, "Idempotency-Replayed", "true");
        classes_tell(asked, 201);
    } else if (stored == SRV_STORED_QUOTA) {
        srv_exchange_problem(exchange, 429,
                             API_TYPE_QUOTA "%s as many classrooms as allowed: delete one, or "
                                            "wait until one ends",
                             own->full ? own->full : "this server has");
        srv_exchange_retry(exchange, 600);
    } else {
        srv_class_request_refuse(asked, stored);
    }
    srv_store_request_end(asked);
}

void srv_classes_create(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_class_request_begin(exchange, 1);
    if (!asked) return;
    srv_class_request_of(asked)->kind = API_CLASS_ROOM;
    if (exchange->identity.limits.value[SRV_LIMIT_ROOMS] <= 0) {
        srv_admission_forbid(exchange, SRV_ROLE_TEACHER, "this role may not create classrooms");
    } else if (!classes_read_key(exchange->field[SRV_IDEMPOTENCY_KEY], asked->key)) {
        srv_exchange_problem(exchange, 400,
                             "Idempotency-Key must be 1 to %d visible ASCII characters",
                             SRV_STORE_REQUEST_KEY);
    } else if (*asked->key && !*srv_class_request_of(asked)->who) {
        srv_exchange_problem(exchange, 400,
                             "Idempotency-Key needs a token generated by the client: a token "
                             "generated by the server is sent only once");
    } else if (srv_class_request_token(asked)) {
        if (srv_class_request_pace(asked, SRV_PACE_ROOMS, CLASSES_ROOMS_A_SECOND, CLASSES_ROOMS, 0,
                                   "too many classrooms were created from your address"))
            srv_store_request_work(asked, srv_class_request_check, create_run, create_answer);
        return;
    }
    srv_store_request_end(asked);
}

/* --- writing --- */

static enum srv_stored join_run(struct srv_store *store, struct srv_store_call *call) {
    struct srv_class_request *own = classes_own(call);
    return srv_store_class_join(store, &own->put, &own->room);
}

static enum srv_stored put_run(struct srv_store *store, struct srv_store_call *call) {
    struct srv_class_request *own = classes_own(call);
    return srv_store_class_put(store, &own->put, &own->room);
}

static enum srv_stored erase_run(struct srv_store *store, struct srv_store_call *call) {
    struct srv_class_request *own = classes_own(call);
    return srv_store_class_end(store, &own->put, &own->room);
}

/* Continues after a write. Returns 0 if it is repeated or was refused. */
static int classes_written(struct srv_store_request *asked, enum srv_stored stored,
                           void (*answer)(struct srv_store_request *asked,
                                          enum srv_stored stored)) {
    if (stored == SRV_STORED_AGAIN && srv_class_request_of(asked)->tries++ < SRV_CLASS_TRIES) {
        srv_store_request_ask(asked, SRV_ASK_WRITE, asked->run, answer);
        return 0;
    }
    assert(!asked->exchange->status);
    if (stored == SRV_STORED) {
        srv_events_news(asked->service->events);
        return 1;
    }
    srv_class_request_refuse(asked, stored);
    srv_store_request_end(asked);
    return 0;
}

static void join_answer(struct srv_store_request *asked, enum srv_stored stored) {
    if (!classes_written(asked, stored, join_answer)) return;
    classes_tell(asked, 201);
    srv_store_request_end(asked);
}

static void gone_answer(struct srv_store_request *asked, enum srv_stored stored) {
    if (!classes_written(asked, stored, gone_answer)) return;
    srv_exchange_static(asked->exchange, 204, NULL, NULL, 0);
    srv_store_request_end(asked);
}

static void put_answer(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    if (!classes_written(asked, stored, put_answer)) return;
    if (api_buffer_format(&exchange->answer, "{\"version\":%lld}",
                          (long long)srv_class_request_of(asked)->room.version) != PEND_OK)
        srv_exchange_busy(exchange, 1, "out of memory");
    else
        srv_exchange_answered(exchange, 200, classes_json);
    srv_store_request_end(asked);
}

static struct srv_class_put *classes_put(struct srv_class_request *own) {
    own->put.code = own->code;
    own->put.who = own->who;
    own->put.name = own->name;
    own->put.source = own->source;
    own->put.shut = -1;
    return &own->put;
}

static int join_check(struct srv_store_request *asked) {
    struct srv_class_request *own = srv_class_request_of(asked);
    if (!srv_class_request_check(asked)) return 0;
    /* leave space for a number after the fold */
    int bytes = srv_nickname_fold(own->facts.nickname, own->fold, sizeof own->fold - 16);
    if (!bytes) srv_exchange_problem(asked->exchange, 422, "nickname has no visible character");
    return bytes > 0;
}

/* Limits the rate of joins to this room from one address, once the code is known to be correct. */
static void join_looked(struct srv_store_request *asked, enum srv_stored stored) {
    if (stored != SRV_STORED) {
        srv_class_request_refuse(asked, stored);
        srv_store_request_end(asked);
    } else if (srv_class_request_pace(asked, SRV_PACE_JOINS, CLASSES_JOINS_A_SECOND, CLASSES_JOINS,
                                      0,
                                      "too many pupils joined this classroom from your address")) {
        srv_store_request_work(asked, join_check, join_run, join_answer);
    }
}

void srv_classes_join(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_class_request_begin(exchange, 1);
    if (!asked) return;
    (void)classes_put(srv_class_request_of(asked));
    srv_class_request_of(asked)->kind = API_CLASS_PUPIL;
    if (!srv_class_request_token(asked)) {
        srv_store_request_end(asked);
        return;
    }
    srv_store_request_ask(asked, SRV_ASK_READ, srv_class_request_look, join_looked);
}

void srv_classes_erase(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_class_request_begin(exchange, 0);
    if (!asked) return;
    classes_put(srv_class_request_of(asked))->operates =
        exchange->identity.role == SRV_ROLE_OPERATOR;
    srv_store_request_ask(asked, SRV_ASK_WRITE, erase_run, gone_answer);
}

/* --- items --- */

static const struct {
    const char *kind, *id; /* id: NULL = any */
    enum api_class_kind body;
    int own;          /* non-zero: the item belongs to a pupil */
    const char *base; /* the kind of item that it answers */
} classes_kind[] = {
    {"stages", "class", API_CLASS_STAGE, 0, NULL},
    {"stages", "own", API_CLASS_OWN_STAGE, 1, NULL},
    {"questions", NULL, API_CLASS_QUESTION, 0, NULL},
    {"solutions", NULL, API_CLASS_SOLUTION, 0, NULL},
    {"worksheets", NULL, API_CLASS_WORKSHEET, 0, NULL},
    {"answers", NULL, API_CLASS_ANSWER, 1, "questions"},
    {"handins", NULL, API_CLASS_HANDIN, 1, "worksheets"},
};

/* Parses the pupils to remove, numbers and ranges without leading zeros: "pupils/3,7-12". */
static int classes_pupils(struct srv_class_request *own, const char *kind) {
    const char *list = strchr(own->exchange->argument, '/'), *at;
    int64_t from, to;
    if (strcmp(kind, "pupils") || !list || !(list = strchr(list + 1, '/'))) return 0;
    at = ++list;
    if (!*list || strspn(list, "0123456789-,") != strlen(list)) return 0;
    for (const char *before = at; *at; before = at)
        if (*before == '0' || !srv_store_class_range(&at, &from, &to) || from > to) return 0;
    own->put.pupils = list;
    return 1;
}

/* Finds the item that the path names. Returns 0 if there can be no such item. */
static int classes_find(struct srv_class_request *own, int removes) {
    char kind[SRV_CLASS_NAME / 3], id[SRV_CLASS_NAME / 2];
    srv_class_request_part(own->exchange, 1, kind, sizeof kind);
    srv_class_request_part(own->exchange, 2, id, sizeof id);
    if (removes && classes_pupils(own, kind)) return 1;
    for (size_t i = 0; i < sizeof classes_kind / sizeof *classes_kind; i++) {
        const char *only = classes_kind[i].id;
        if (strcmp(kind, classes_kind[i].kind) || (only && strcmp(id, only))) continue;
        if (!api_class_id_good(id)) return 0;
        own->kind = classes_kind[i].body;
        own->put.own = classes_kind[i].own;
        /* the stage of a pupil is stages/NUMBER */
        snprintf(own->name, sizeof own->name, "%s%s%s", kind, only && own->put.own ? "" : "/",
                 only && own->put.own ? "" : id);
        if (!classes_kind[i].base) return 1;
        snprintf(own->base, sizeof own->base, "%s/%s", classes_kind[i].base, id);
        own->put.base = own->base;
        return 1;
    }
    return 0;
}

static struct srv_store_request *classes_begin_item(struct srv_exchange *exchange, int removes) {
    struct srv_store_request *asked = srv_class_request_begin(exchange, 0);
    if (!asked) return NULL;
    struct srv_class_request *own = srv_class_request_of(asked);
    (void)classes_put(own);
    if (!classes_find(own, removes)) {
        srv_exchange_problem(exchange, 404,
                             "a room has stages/class, stages/own, and questions, solutions, "
                             "worksheets, answers and handins whose ids are 1 to %d of a-z, 0-9 "
                             "and -; pupils can be removed by their numbers, as pupils/3,7-12",
                             API_CLASS_ID);
        srv_store_request_end(asked);
        return NULL;
    }
    return srv_class_request_pace(asked, SRV_PACE_WRITES, CLASSES_WRITES_A_SECOND, CLASSES_WRITES,
                                  1, "too many writes: wait before the next one")
               ? asked
               : NULL;
}

static int put_check(struct srv_store_request *asked) {
    struct srv_class_request *own = srv_class_request_of(asked);
    if (!srv_class_request_check(asked)) return 0;
    assert(own->put.body && *own->name);
    own->put.flag = own->facts.flag;
    if (own->kind == API_CLASS_STAGE) own->put.shut = own->facts.shut;
    if (own->kind == API_CLASS_STAGE) own->put.share = (int)own->facts.share;
    if (own->kind == API_CLASS_ANSWER) own->put.fits = api_class_fits;
    int hidden = own->kind == API_CLASS_SOLUTION && !own->facts.shown;
    own->put.reader = hidden ? SRV_CLASS_TEACHER : SRV_CLASS_ALL;
    return 1;
}

void srv_classes_put(struct srv_exchange *exchange) {
    struct srv_store_request *asked = classes_begin_item(exchange, 0);
    if (asked) srv_store_request_work(asked, put_check, put_run, put_answer);
}

void srv_classes_remove(struct srv_exchange *exchange) {
    struct srv_store_request *asked = classes_begin_item(exchange, 1);
    if (!asked) return;
    struct srv_class_request *own = srv_class_request_of(asked);
    /* removing the stage of the class opens the class again */
    if (own->kind == API_CLASS_STAGE && !strncmp(own->name, "stages/", 7)) own->put.shut = 0;
    srv_store_request_ask(asked, SRV_ASK_WRITE, put_run, gone_answer);
}

/* --- lists --- */

/* Writes a page of rooms; the next page begins after the code of the last one. */
static enum srv_stored list_run(struct srv_store *store, struct srv_store_call *call) {
    struct srv_class_request *own = classes_own(call);
    int operates = own->exchange->identity.role == SRV_ROLE_OPERATOR;
    struct srv_class_codes codes;
    SRV_STORED_TRY(srv_store_class_codes(store, operates ? "" : own->who, own->code, &codes));
    own->more = codes.count == SQL_CLASSES_MOST;
    for (int i = 0; i < codes.count; i++) {
        memcpy(own->code, codes.code[i], sizeof own->code);
        enum srv_stored stored = srv_store_class(store, own->code, own->who, &own->room);
        if (stored == SRV_STORED_NONE) continue;
        if (stored != SRV_STORED) return stored;
        struct api_class_room told = srv_class_request_view(&own->room);
        told.source = operates ? own->room.source : NULL;
        if (api_out_comma(&own->text) != PEND_OK ||
            api_class_room_write(&told, &own->text) != PEND_OK ||
            api_buffer_text(&own->text, "}") != PEND_OK)
            return SRV_STORED_BROKEN;
    }
    return SRV_STORED;
}

static void list_answer(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    const struct srv_class_request *own = srv_class_request_of(asked);
    struct api_buffer *out = &exchange->answer;
    if (stored != SRV_STORED) {
        srv_class_request_refuse(asked, stored);
    } else if (api_buffer_text(out, "{\"classes\":[") != PEND_OK ||
               (own->text.bytes &&
                api_buffer_add(out, own->text.data, own->text.bytes) != PEND_OK) ||
               api_buffer_text(out, "]") != PEND_OK ||
               (own->more && api_buffer_format(out, ",\"next\":\"/v1/classes?after=%s\"",
                                               own->code) != PEND_OK) ||
               api_buffer_text(out, "}") != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
    } else {
        srv_exchange_answered(exchange, 200, classes_json);
        srv_exchange_header(exchange, "Cache-Control", "no-store");
    }
    srv_store_request_end(asked);
}

void srv_classes_list(struct srv_exchange *exchange) {
    static const char after[] = "after=";
    struct srv_store_request *asked = srv_class_request_begin(exchange, 0);
    if (!asked) return;
    const char *query = exchange->query && *exchange->query ? exchange->query : NULL;
    if (!query || (!strncmp(query, after, sizeof after - 1) &&
                   srv_class_request_read_code(query + sizeof after - 1,
                                               srv_class_request_of(asked)->code))) {
        srv_store_request_ask(asked, SRV_ASK_READ, list_run, list_answer);
        return;
    }
    srv_exchange_problem(exchange, 422, "the query must be after=CODE, got ?%.100s", query);
    srv_store_request_end(asked);
}

/* --- events --- */

static enum srv_stored events_run(struct srv_store *store, struct srv_store_call *call) {
    struct srv_class_request *own = classes_own(call);
    enum srv_stored stored = srv_store_class(store, own->code, own->who, &own->room);
    if (stored != SRV_STORED) return stored;
    return own->room.teacher || own->room.pupil ? stored : SRV_STORED_NONE;
}

/* Reads the number of the last change that the client has seen; 0 for an impossible number. */
static int64_t events_since(const char *last, const struct srv_class *room) {
    char *end;
    if (!last || *last < '0' || *last > '9') return 0;
    errno = 0;
    long long since = strtoll(last, &end, 10);
    return errno || *end || since > room->version ? 0 : since;
}

static void events_answer(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    struct srv_class_request *own = srv_class_request_of(asked);
    if (stored == SRV_STORED)
        srv_class_events_open(exchange, &own->room, own->who,
                              events_since(exchange->field[SRV_LAST_EVENT_ID], &own->room), NULL);
    else
        srv_class_request_refuse(asked, stored);
    srv_store_request_end(asked);
}

void srv_classes_events(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_class_request_begin(exchange, 0);
    if (asked) srv_store_request_ask(asked, SRV_ASK_READ, events_run, events_answer);
}
