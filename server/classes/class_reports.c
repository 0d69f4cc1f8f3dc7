#include "server/classes/class_reports.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/class/class_table.h"
#include "server/classes/class_events.h"
#include "server/classes/class_request.h"

enum {
    REPORTS_PAGE = 1 << 20, /* bytes of items per query to the store */
    REPORTS_STEP = 1 << 18  /* bytes reserved before a page is read */
};

static struct api_class_item reports_item(const struct srv_class_item *item) {
    return (struct api_class_item){item->name, item->version, item->changed, item->body,
                                   item->bytes};
}

/* --- the room --- */

static enum srv_stored room_take(void *context, const struct srv_class_item *item) {
    struct srv_class_request *own = context;
    const struct api_class_item told = reports_item(item);
    return api_class_item_write(&told, &own->text) == PEND_OK ? SRV_STORED : SRV_STORED_BROKEN;
}

static enum srv_stored room_run(struct srv_store *store, struct srv_store_call *call) {
    struct srv_class_request *own =
        srv_class_request_of(SRV_CONTAINER_OF(call, struct srv_store_request, ask.call));
    enum srv_stored stored = srv_store_class_items(store, own->code, own->who, &own->since,
                                                   &own->more, &own->room, room_take, own);
    if (stored == SRV_STORED_CLASH) own->put.why = SRV_CLASS_STRANGER;
    return stored;
}

static enum pend_status room_write(const struct srv_class_request *own, struct api_buffer *out) {
    const struct srv_class *room = &own->room;
    assert(own->since >= 0 && (room->teacher || room->pupil));
    struct api_class_room told = srv_class_request_view(room);
    told.version = own->since;
    PEND_TRY(api_class_room_write(&told, out));
    if (own->more)
        PEND_TRY(api_buffer_format(out, ",\"next\":\"/v1/classes/%s?since=%lld\"", room->code,
                                   (long long)own->since));
    PEND_TRY(api_buffer_text(out, ",\"items\":["));
    if (own->text.bytes) PEND_TRY(api_buffer_add(out, own->text.data, own->text.bytes));
    return api_buffer_text(out, "]}");
}

/* Reserves memory for the next page and for the answer, into which all pages are copied. */
static enum srv_room room_hold(struct srv_store_request *asked) {
    size_t text = srv_class_request_of(asked)->text.cap + REPORTS_STEP;
    return srv_exchange_hold(asked->exchange, asked->exchange->body.cap + 2 * text);
}

static void room_answer(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    struct srv_class_request *own = srv_class_request_of(asked);
    enum srv_room room = stored == SRV_STORED ? room_hold(asked) : SRV_ROOM;
    if (stored != SRV_STORED) {
        srv_class_request_refuse(asked, stored);
    } else if (room != SRV_ROOM) {
        srv_exchange_crowded(exchange, room, "contents of the classroom");
    } else if (own->more && own->text.bytes < REPORTS_PAGE) {
        srv_store_request_ask(asked, SRV_ASK_READ, room_run, room_answer);
        return;
    } else if (room_write(own, &exchange->answer) != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
    } else {
        srv_exchange_answered(exchange, 200, "application/json");
        srv_exchange_header(exchange, "Cache-Control", "no-store");
    }
    srv_store_request_end(asked);
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
    srv_exchange_problem(exchange, 422, "the query must be since=VERSION, got ?%.100s",
                         exchange->query);
    srv_store_request_end(asked);
}

/* --- for the teacher only --- */

/* The table, or the histogram of answers whose names begin with `name`. */
struct reports_report {
    struct srv_class_report report; /* must be the first member */
    struct api_class_names names;
    struct api_class_tally tally;
    char name[SRV_CLASS_NAME];
    int begun;
};

static struct reports_report *reports_own(struct srv_class_report *report) {
    return SRV_CONTAINER_OF(report, struct reports_report, report);
}

static void reports_free(struct srv_class_report *report) {
    struct reports_report *gone = reports_own(report);
    api_class_names_clear(&gone->names);
    api_class_tally_clear(&gone->tally);
    free(gone);
}

static enum pend_status table_end(struct srv_class_report *report, struct api_buffer *text) {
    struct reports_report *own = reports_own(report);
    /* Write the header even if the room has no items. */
    int begun = own->begun;
    own->begun = 1;
    return begun ? PEND_OK : api_class_table_begin(&own->names, text);
}

static enum pend_status table_add(struct srv_class_report *report,
                                  const struct srv_class_item *item, struct api_buffer *text) {
    const struct api_class_item told = reports_item(item);
    PEND_TRY(table_end(report, text));
    return api_class_table_add(&told, &reports_own(report)->names, text);
}

static enum pend_status histogram_add(struct srv_class_report *report,
                                      const struct srv_class_item *item, struct api_buffer *text) {
    struct reports_report *own = reports_own(report);
    const struct api_class_item told = reports_item(item);
    (void)text;
    if (!item->bytes || strncmp(item->name, own->name, strlen(own->name))) return PEND_OK;
    report->bytes += item->bytes + sizeof *own->tally.text;
    return api_class_tally_add(&told, &own->tally);
}

static enum pend_status histogram_end(struct srv_class_report *report, struct api_buffer *text) {
    return api_class_tally_write(&reports_own(report)->tally, text);
}

static enum srv_stored reports_find(struct srv_store *store, struct srv_store_call *call) {
    struct srv_class_request *own =
        srv_class_request_of(SRV_CONTAINER_OF(call, struct srv_store_request, ask.call));
    enum srv_stored stored = srv_store_class(store, own->code, own->who, &own->room);
    if (stored != SRV_STORED || own->room.teacher) return stored;
    if (!own->room.pupil) return SRV_STORED_NONE;
    own->put.why = SRV_CLASS_NO_TEACHER;
    return SRV_STORED_CLASH;
}

static int reports_open(struct srv_store_request *asked, enum srv_stored stored,
                        struct reports_report made) {
    struct srv_exchange *exchange = asked->exchange;
    struct srv_class_request *own = srv_class_request_of(asked);
    struct reports_report *report = stored == SRV_STORED ? malloc(sizeof *report) : NULL;
    if (report) {
        *report = made;
        report->report.free = reports_free;
        srv_class_events_open(exchange, &own->room, own->who, 0, &report->report);
    } else if (stored == SRV_STORED) {
        srv_exchange_busy(exchange, 1, "out of memory");
    } else {
        srv_class_request_refuse(asked, stored);
    }
    return exchange->status == 200;
}

/* Reads ?decimal=comma or point; -1 for any other query. */
static int table_sheet(const char *query) {
    if (!query || !*query) return API_CLASS_SHEET_PLAIN;
    if (!strcmp(query, "decimal=point")) return API_CLASS_SHEET_POINT;
    return strcmp(query, "decimal=comma") ? -1 : API_CLASS_SHEET_COMMA;
}

static void table_answer(struct srv_store_request *asked, enum srv_stored stored) {
    struct reports_report table = {
        .report = {.media_type = "text/csv; charset=utf-8", .add = table_add, .end = table_end},
        .names.sheet = (enum api_class_sheet)table_sheet(asked->exchange->query)};
    if (reports_open(asked, stored, table))
        srv_exchange_header(asked->exchange, "Content-Disposition",
                            "attachment; filename=\"class.csv\"");
    srv_store_request_end(asked);
}

void srv_class_reports_table(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_class_request_begin(exchange, 0);
    if (!asked) return;
    if (table_sheet(exchange->query) >= 0) {
        srv_store_request_ask(asked, SRV_ASK_READ, reports_find, table_answer);
        return;
    }
    srv_exchange_problem(exchange, 422,
                         "the query must be decimal=comma or decimal=point, got ?%.100s",
                         exchange->query);
    srv_store_request_end(asked);
}

static void histogram_answer(struct srv_store_request *asked, enum srv_stored stored) {
    struct reports_report histogram = {
        .report = {.media_type = "application/json", .add = histogram_add, .end = histogram_end}};
    char id[API_CLASS_ID + 2];
    srv_class_request_part(asked->exchange, 2, id, sizeof id);
    snprintf(histogram.name, sizeof histogram.name, "answers/%s/", id);
    (void)reports_open(asked, stored, histogram);
    srv_store_request_end(asked);
}

void srv_class_reports_histogram(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_class_request_begin(exchange, 0);
    if (asked) srv_store_request_ask(asked, SRV_ASK_READ, reports_find, histogram_answer);
}
