#include "server/classes/class_reports.h"

#include <assert.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/classes/class_request.h"

/* bytes of items after which the rest waits for a further request */
enum { REPORTS_PAGE = 1 << 20 };

typedef void reports_answer(struct srv_store_request *asked, enum srv_stored stored);

static struct api_class_item reports_item(const struct srv_class_item *item) {
    return (struct api_class_item){item->name, item->version, item->changed, item->body,
                                   item->bytes};
}

/* Converts the status of a piece of a report to that of a store. */
static enum srv_stored reports_stored(enum pend_status status) {
    if (status == PEND_OK) return SRV_STORED;
    return status == PEND_INVALID ? SRV_STORED_DAMAGED : SRV_STORED_BROKEN;
}

/* Reads a page; `take` receives its items. */
static enum srv_stored reports_page(struct srv_store *store, struct srv_store_call *call,
                                    srv_class_item_fn *take) {
    struct srv_class_request *own =
        srv_class_request_of(SRV_CONTAINER_OF(call, struct srv_store_request, ask.call));
    enum srv_stored stored = srv_store_class_items(store, own->code, own->who, &own->since,
                                                   &own->more, &own->room, take, own);
    if (stored == SRV_STORED_CLASH) own->put.why = SRV_CLASS_STRANGER;
    return stored;
}

/* Begins a report; the request has no body. */
static void reports_begin(struct srv_exchange *exchange,
                          enum srv_stored (*run)(struct srv_store *, struct srv_store_call *),
                          reports_answer *answer) {
    struct srv_store_request *asked = srv_class_request_begin(exchange, 0);
    if (asked) srv_store_request_ask(asked, SRV_ASK_READ, run, answer);
}

/* After a page: returns 1 if the report is complete; else the next page was asked for, or the
 * request has ended. */
static int reports_done(struct srv_store_request *asked, enum srv_stored stored, size_t most,
                        reports_answer *answer) {
    struct srv_class_request *own = srv_class_request_of(asked);
    if (stored != SRV_STORED) {
        srv_class_request_refuse(asked, stored);
        srv_store_request_end(asked);
        return 0;
    }
    assert(own->since >= 0);
    if (!own->more || own->text.bytes >= most) return 1;
    srv_store_request_ask(asked, SRV_ASK_READ, asked->run, answer);
    return 0;
}

/* Sends what is written in exchange->answer. */
static void reports_give(struct srv_store_request *asked, enum pend_status status,
                         const char *media_type) {
    struct srv_exchange *exchange = asked->exchange;
    if (status != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
    } else {
        srv_exchange_answered(exchange, 200, media_type);
        srv_exchange_header(exchange, "Cache-Control", "no-store");
    }
    srv_store_request_end(asked);
}

/* --- the room --- */

static enum srv_stored room_take(void *context, const struct srv_class_item *item) {
    struct srv_class_request *own = context;
    const struct api_class_item told = reports_item(item);
    return reports_stored(api_class_item_write(&told, &own->text));
}

static enum srv_stored room_run(struct srv_store *store, struct srv_store_call *call) {
    return reports_page(store, call, room_take);
}

static enum pend_status room_write(const struct srv_class_request *own, struct api_buffer *out) {
    const struct srv_class *room = &own->room;
    assert(own->since >= 0 && (room->teacher || room->pupil));
    const struct api_class_room told = {.code = room->code,
                                        .role = room->teacher ? "teacher" : "pupil",
                                        .pupil = (long)room->pupil,
                                        .created = room->created,
                                        .ends = room->ends,
                                        .version = own->since,
                                        .pupils = (long)room->pupils,
                                        .shut = room->shut};
    PEND_TRY(api_class_room_write(&told, out));
    if (own->more)
        PEND_TRY(api_buffer_format(out, ",\"next\":\"/v1/classes/%s?since=%lld\"", room->code,
                                   (long long)own->since));
    PEND_TRY(api_buffer_text(out, ",\"items\":["));
    if (own->text.bytes) PEND_TRY(api_buffer_add(out, own->text.data, own->text.bytes));
    return api_buffer_text(out, "]}");
}

static void room_answer(struct srv_store_request *asked, enum srv_stored stored) {
    if (!reports_done(asked, stored, REPORTS_PAGE, room_answer)) return;
    reports_give(asked, room_write(srv_class_request_of(asked), &asked->exchange->answer),
                 "application/json");
}

/* Reads ?since=VERSION. Returns 0 for any other query. */
static int room_since(const char *query, int64_t *since) {
    static const char name[] = "since=";
    char *end;
    if (!query || !*query) return 1;
    if (strncmp(query, name, sizeof name - 1) || strspn(query + 6, "0123456789") < 1) return 0;
    errno = 0;
    *since = strtoll(query + sizeof name - 1, &end, 10);
    return !errno && !*end && *since < (INT64_C(1) << 53);
}

void srv_class_reports_room(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_class_request_begin(exchange, 0);
    if (!asked) return;
    if (room_since(exchange->query, &srv_class_request_of(asked)->since)) {
        srv_store_request_ask(asked, SRV_ASK_READ, room_run, room_answer);
        return;
    }
    srv_exchange_problem(exchange, 422, "the query may say since=VERSION, got ?%.100s",
                         exchange->query);
    srv_store_request_end(asked);
}

/* --- what only the teacher may read --- */

static enum srv_stored teacher_run(struct srv_store *store, struct srv_store_call *call,
                                   srv_class_item_fn *take) {
    enum srv_stored stored = reports_page(store, call, take);
    struct srv_class_request *own =
        srv_class_request_of(SRV_CONTAINER_OF(call, struct srv_store_request, ask.call));
    if (stored != SRV_STORED || own->room.teacher) return stored;
    own->put.why = SRV_CLASS_NO_TEACHER;
    return SRV_STORED_CLASH;
}

static enum srv_stored table_take(void *context, const struct srv_class_item *item) {
    struct srv_class_request *own = context;
    const struct api_class_item told = reports_item(item);
    if (!own->text.bytes && api_class_table_begin(&own->text) != PEND_OK) return SRV_STORED_BROKEN;
    return reports_stored(api_class_table_add(&told, &own->names, &own->text));
}

static enum srv_stored table_run(struct srv_store *store, struct srv_store_call *call) {
    return teacher_run(store, call, table_take);
}

static void table_answer(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_class_request *own = srv_class_request_of(asked);
    struct api_buffer *out = &asked->exchange->answer;
    if (!reports_done(asked, stored, own->text.limit, table_answer)) return;
    /* A room without items has the header only. */
    enum pend_status status = own->text.bytes ? api_buffer_add(out, own->text.data, own->text.bytes)
                                              : api_class_table_begin(out);
    if (status == PEND_OK)
        srv_exchange_header(asked->exchange, "Content-Disposition",
                            "attachment; filename=\"class.csv\"");
    reports_give(asked, status, "text/csv; charset=utf-8");
}

void srv_class_reports_table(struct srv_exchange *exchange) {
    reports_begin(exchange, table_run, table_answer);
}

static enum srv_stored histogram_take(void *context, const struct srv_class_item *item) {
    struct srv_class_request *own = context;
    const struct api_class_item told = reports_item(item);
    size_t bytes = strlen(own->name);
    if (!item->bytes || strncmp(item->name, own->name, bytes)) return SRV_STORED;
    return reports_stored(api_class_tally_add(&told, &own->tally));
}

static enum srv_stored histogram_run(struct srv_store *store, struct srv_store_call *call) {
    return teacher_run(store, call, histogram_take);
}

static void histogram_answer(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_class_request *own = srv_class_request_of(asked);
    if (!reports_done(asked, stored, own->text.limit, histogram_answer)) return;
    reports_give(asked, api_class_tally_write(&own->tally, &asked->exchange->answer),
                 "application/json");
}

void srv_class_reports_histogram(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_class_request_begin(exchange, 0);
    char id[API_CLASS_ID + 2];
    if (!asked) return;
    struct srv_class_request *own = srv_class_request_of(asked);
    srv_class_request_part(exchange, 2, id, sizeof id);
    snprintf(own->name, sizeof own->name, "answers/%s/", id);
    srv_store_request_ask(asked, SRV_ASK_READ, histogram_run, histogram_answer);
}
