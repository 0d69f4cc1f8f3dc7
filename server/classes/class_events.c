#include "server/classes/class_events.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/class/class_json.h"

enum {
    EVENTS_NUMBER = 1,                        /* index of the topic in the service */
    EVENTS_PAGES = 16,                        /* pages read by one query to the store */
    EVENTS_BUDGET = 4 * SRV_CLASS_PAGE_BYTES, /* expected bytes of these pages */
    EVENTS_PAGE = 4 << 20,                    /* upper bound of the bytes of a page */
    EVENTS_REPORT = 1 << 19 /* bytes reserved for a page of a report until it is read */
};

/* The kind of a read: new changes for an up-to-date listener, or a page of a backlog. New changes
 * are read first, but each query also reads one page of a backlog. */
enum class_level { CLASS_NEW, CLASS_OLD, CLASS_LEVELS };

/* Expected bytes of a page of new changes and of a backlog. */
static const size_t class_expected[CLASS_LEVELS] = {SRV_EVENTS_TEXT, SRV_CLASS_PAGE_BYTES};

struct class_room {
    struct srv_list link, seats; /* link in the topic's list; the list of seats */
    char code[SRV_CLASS_CODE];
    struct srv_turns_road road[CLASS_LEVELS];
    struct class_room *next; /* next room whose change number the query reads */
    int64_t version, shared;
    enum srv_stored stored;
};

/* A client that listens to a room, with any number of streams. */
struct class_seat {
    struct srv_list link; /* in the room's list */
    struct class_room *room;
    char who[SRV_NAME_BYTES];
    int users;
    struct srv_turns_lane lane[CLASS_LEVELS];
    struct class_listener *reports; /* the listener whose report is in progress */
};

/* A stream of a room's events, or of a report. */
struct class_listener {
    struct srv_listener listener;
    struct class_seat *seat;
    struct srv_list turn;     /* link among the listeners that wait for a page */
    struct class_page *asked; /* the page being read for it, which other listeners may share */
    struct class_listener *beside;
    enum class_level level;
    int teacher;
    int64_t seen;                    /* the last change that was sent or is in `page` */
    int lags;                        /* non-zero: there are later changes */
    int ended;                       /* non-zero: the stream ends */
    struct api_buffer page;          /* the next page to send */
    struct srv_class_report *report; /* NULL = a stream of changes */
    const char *code, *who;          /* used to find the seat, invalid afterwards */
};

/* A page being read for listeners of one seat that have seen the same last change. During a query
 * only the events' thread uses it, except `reader`, which the lock guards. */
struct class_page {
    struct class_listener
        *reader; /* the first listener; NULL once all have left: then the page owns the report */
    struct srv_class_report *report;
    const struct class_seat *seat;
    char code[SRV_CLASS_CODE], who[SRV_NAME_BYTES];
    int64_t seen;
    int more;
    enum srv_stored stored;
    struct api_buffer items, text; /* the items as read; the text to send */
};

struct class_topic {
    struct srv_topic topic;
    struct srv_list rooms;
    struct srv_turns turns[CLASS_LEVELS];
    struct class_room *marks; /* the rooms whose change numbers are read */
    int pages;
    struct class_page page[EVENTS_PAGES];
};

static struct class_listener *class_listener(const struct srv_listener *listener) {
    return SRV_CONTAINER_OF(listener, struct class_listener, listener);
}

/* --- rooms and their listeners --- */

/* Attaches a listener to the seat of its client in its room. */
static enum pend_status seat_take(struct srv_listener *listener) {
    struct class_listener *own = class_listener(listener);
    struct class_topic *look = SRV_CONTAINER_OF(listener->topic, struct class_topic, topic);
    struct class_room *room = NULL;
    struct class_seat *seat = NULL;
    SRV_LIST_EACH (link, &look->rooms) {
        struct class_room *at = SRV_CONTAINER_OF(link, struct class_room, link);
        if (!memcmp(at->code, own->code, SRV_CLASS_CODE)) room = at;
    }
    if (!room && (room = calloc(1, sizeof *room))) {
        memcpy(room->code, own->code, SRV_CLASS_CODE);
        srv_list_append(&look->rooms, &room->link);
    }
    if (!room) return PEND_NO_MEMORY;
    SRV_LIST_EACH (link, &room->seats) {
        struct class_seat *at = SRV_CONTAINER_OF(link, struct class_seat, link);
        if (!strcmp(at->who, own->who)) seat = at;
    }
    if (!seat && (seat = calloc(1, sizeof *seat))) {
        seat->room = room;
        snprintf(seat->who, sizeof seat->who, "%s", own->who);
        srv_list_append(&room->seats, &seat->link);
    }
    own->seat = seat;
    if (seat) seat->users++;
    return seat ? PEND_OK : PEND_NO_MEMORY;
}

/* The room is freed later, because a running query may refer to it. */
static void seat_give(struct class_seat *seat) {
    if (--seat->users) return;
    srv_list_remove(&seat->link);
    free(seat);
}

/* --- one stream --- */

static int class_news(const struct srv_listener *listener) {
    const struct class_listener *own = class_listener(listener);
    return own->page.bytes > 0 || (own->ended && !listener->over);
}

static enum pend_status class_next(struct srv_listener *listener) {
    static const char end[] = "event: end\ndata: {}\n\n";
    struct class_listener *own = class_listener(listener);
    assert(class_news(listener) && !listener->text.bytes);
    if (own->page.bytes) {
        api_buffer_clear(&listener->text);
        listener->text = own->page;
        api_buffer_init(&own->page, EVENTS_PAGE);
        listener->kept = own->report ? own->report->bytes : 0;
        return PEND_OK;
    }
    listener->over = 1;
    return own->report ? PEND_OK : api_buffer_text(&listener->text, end);
}

static void class_unturn(struct class_listener *own) {
    if (!own->turn.next) return;
    srv_turns_remove(&own->seat->room->road[own->level], &own->seat->lane[own->level], &own->turn);
}

static void class_drop(struct srv_listener *listener) {
    struct class_listener *own = class_listener(listener);
    if (own->seat) {
        class_unturn(own);
        if (own->seat->reports == own) own->seat->reports = NULL;
        seat_give(own->seat);
    }
    if (own->asked) { // the page that is read for it
        struct class_listener **link = &own->asked->reader;
        while (*link != own) link = &(*link)->beside;
        *link = own->beside;
    } else if (own->report) {
        own->report->free(own->report);
    }
    api_buffer_clear(&own->page);
    free(own);
}

void srv_class_events_open(struct srv_exchange *exchange, const struct srv_class *room,
                           const char *who, int64_t since, struct srv_class_report *report) {
    struct srv_events *events = exchange->service->events;
    struct class_listener *made = calloc(1, sizeof *made);
    if (!made) {
        if (report) report->free(report);
        srv_exchange_busy(exchange, 1, "out of memory");
        return;
    }
    assert(since >= 0 && since <= room->version && (room->teacher || room->pupil));
    made->listener.exchange = exchange;
    made->listener.topic = srv_events_topic(events, EVENTS_NUMBER);
    made->listener.media_type = report ? report->media_type : NULL;
    made->report = report;
    made->teacher = room->teacher;
    made->seen = since;
    made->level = CLASS_OLD;
    made->lags = made->listener.wants = report || since < room->version;
    made->code = room->code;
    made->who = who;
    api_buffer_init(&made->page, EVENTS_PAGE);
    srv_events_open(events, &made->listener);
}

/* --- queries to the store --- */

/* Copies an item unchanged: its text is written after the query, so that the store is free sooner.
 */
static enum srv_stored page_take(void *context, const struct srv_class_item *item) {
    struct api_buffer *items = context;
    enum pend_status status = api_buffer_add(items, item, sizeof *item);
    if (status == PEND_OK && item->bytes) status = api_buffer_add(items, item->body, item->bytes);
    return status == PEND_OK ? SRV_STORED : SRV_STORED_BROKEN;
}

static enum srv_stored look_run(struct srv_store *store, struct srv_store_call *call) {
    struct class_topic *look = SRV_CONTAINER_OF(call, struct class_topic, topic.ask.call);
    enum srv_stored stored = SRV_STORED;
    /* If the store is unreachable, stop at the first room. */
    for (struct class_room *room = look->marks; room; room = room->next) {
        if (stored < SRV_STORED_AWAY)
            stored = srv_store_class_mark(store, room->code, &room->version, &room->shared);
        room->stored = stored;
    }
    for (int i = 0; i < look->pages; i++) {
        struct class_page *page = &look->page[i];
        struct srv_class room;
        if (stored < SRV_STORED_AWAY)
            stored = srv_store_class_items(store, page->code, page->who, &page->seen, &page->more,
                                           &room, page_take, &page->items);
        page->stored = stored;
    }
    return stored < SRV_STORED_AWAY ? SRV_STORED : stored;
}

static enum pend_status event_write(const struct srv_class_item *item, struct api_buffer *text) {
    const struct api_class_item told = {item->name, item->version, item->changed, item->body,
                                        item->bytes};
    PEND_TRY(api_buffer_format(text, "event: item\nid: %lld\ndata:", (long long)item->version));
    /* "data:" ends in a colon, so no comma is written before the item's text */
    PEND_TRY(api_class_item_write(&told, text));
    return api_buffer_text(text, "\n\n");
}

static enum pend_status page_write(struct class_page *page) {
    struct srv_class_report *report = page->report;
    for (size_t at = 0; at < page->items.bytes;) {
        struct srv_class_item item;
        memcpy(&item, page->items.data + at, sizeof item);
        at += sizeof item;
        item.body = page->items.data + at;
        at += item.bytes;
        PEND_TRY(report ? report->add(report, &item, &page->text)
                        : event_write(&item, &page->text));
    }
    return report && !page->more ? report->end(report, &page->text) : PEND_OK;
}

static void look_work(struct srv_topic *topic) {
    struct class_topic *look = SRV_CONTAINER_OF(topic, struct class_topic, topic);
    for (int i = 0; i < look->pages; i++) {
        struct class_page *page = &look->page[i];
        if (page->stored == SRV_STORED && page_write(page) != PEND_OK)
            page->stored = SRV_STORED_BROKEN;
        api_buffer_clear(&page->items);
    }
}

/* --- change numbers of rooms --- */

static void marks_gather(struct class_topic *look) {
    struct srv_list *next;
    for (struct srv_list *link = look->rooms.next; link && link != &look->rooms; link = next) {
        struct class_room *room = SRV_CONTAINER_OF(link, struct class_room, link);
        next = link->next;
        room->next = look->marks;
        look->marks = room;
        if (!srv_list_empty(&room->seats)) continue;
        look->marks = room->next;
        srv_list_remove(link);
        free(room);
    }
}

/* Marks a listener that has not seen the change number of its classroom that was just read. */
static void mark_tell(struct class_listener *at) {
    const struct class_room *room = at->seat->room;
    if (room->stored == SRV_STORED_NONE) at->ended = 1;
    int lags = room->stored == SRV_STORED && !at->ended && !at->report &&
               (at->teacher ? room->version : room->shared) > at->seen;
    if (lags && !at->lags) at->level = CLASS_NEW;
    if (lags) at->lags = at->listener.wants = 1;
}

/* --- pages --- */

/* Queues the listeners that are behind and have sent their last page. */
static void turns_gather(struct class_topic *look, struct srv_list *listeners) {
    SRV_LIST_EACH (link, listeners) {
        struct srv_listener *listener = SRV_CONTAINER_OF(link, struct srv_listener, link);
        struct class_listener *at = class_listener(listener);
        if (listener->topic != &look->topic || !at->lags || at->ended || !listener->waits ||
            at->page.bytes || at->turn.next)
            continue;
        struct class_seat *seat = at->seat;
        if (at->report && !seat->reports) seat->reports = at;
        if (at->report && seat->reports != at) continue;
        srv_turns_add(&look->turns[at->level], &seat->room->road[at->level], &seat->lane[at->level],
                      &at->turn);
    }
}

/* The page that a listener waits for, if another listener already requested it; reports are never
 * shared. */
static struct class_page *page_find(struct class_topic *look, const struct class_listener *at) {
    for (int i = 0; i < look->pages && !at->report; i++) {
        struct class_page *page = &look->page[i];
        if (page->seat == at->seat && page->seen == at->seen && !page->report) return page;
    }
    return NULL;
}

/* Requests the page of the next listener of a level. Returns the page's expected bytes (half if it
 * is only copied), 0 if no listener waits. A listener whose client has no memory left loses its
 * turn. */
static size_t page_gather(struct class_topic *look, enum class_level level) {
    for (struct srv_list *turn; (turn = srv_turns_next(&look->turns[level]));) {
        struct class_listener *at = SRV_CONTAINER_OF(turn, struct class_listener, turn);
        size_t bytes = at->report ? EVENTS_REPORT + at->report->bytes : 2 * class_expected[level];
        class_unturn(at);
        enum srv_room room = srv_events_keep(&at->listener, bytes);
        if (room == SRV_ROOM_NEVER) at->ended = 1;
        if (room != SRV_ROOM && level == CLASS_OLD) continue;
        struct class_page *page = at->asked = page_find(look, at);
        at->beside = page ? page->reader : NULL;
        if (page) {
            page->reader = at;
            return class_expected[level] / 2;
        }
        page = at->asked = &look->page[look->pages++];
        *page = (struct class_page){
            .reader = at, .report = at->report, .seat = at->seat, .seen = at->seen};
        memcpy(page->code, at->seat->room->code, sizeof page->code);
        memcpy(page->who, at->seat->who, sizeof page->who);
        api_buffer_init(&page->items, EVENTS_PAGE);
        api_buffer_init(&page->text, EVENTS_PAGE);
        return class_expected[level];
    }
    return 0;
}

/* Requests the pages of one query, new changes first. Backlogs get one page, and all pages that new
 * changes leave free. */
static void pages_gather(struct class_topic *look) {
    size_t bytes = page_gather(look, CLASS_OLD);
    for (int level = CLASS_NEW; level < CLASS_LEVELS;) {
        if (look->pages == EVENTS_PAGES || bytes >= EVENTS_BUDGET) return;
        size_t more = page_gather(look, (enum class_level)level);
        bytes += more;
        level += !more;
    }
}

/* Gives a listener the text of a page, or a copy if others need it too. Returns 0 if memory is
 * short. */
static int page_text(struct class_listener *at, struct class_page *page) {
    if (page->reader && page->text.bytes)
        return api_buffer_add(&at->page, page->text.data, page->text.bytes) == PEND_OK;
    at->page = page->text;
    api_buffer_init(&page->text, EVENTS_PAGE);
    return 1;
}

/* Delivers a page to its first listener. */
static void page_give(struct class_page *page) {
    struct class_listener *at = page->reader;
    page->reader = at->beside;
    at->asked = NULL;
    int stored = page->stored == SRV_STORED && page_text(at, page), report = at->report != NULL;
    int gone = page->stored == SRV_STORED_NONE || page->stored == SRV_STORED_CLASH;
    /* Retry a failed read, except that of a report, which may be half processed. */
    at->listener.kept = 0;
    if (stored) {
        assert(page->seen >= at->seen);
        at->seen = page->seen;
        at->lags = page->more;
        at->level = page->more ? CLASS_OLD : CLASS_NEW;
        at->listener.kept = at->page.cap + (report ? at->report->bytes : 0);
    }
    at->listener.wants = stored && at->lags;
    at->listener.whole = report && stored && !page->more;
    at->ended |= gone || at->listener.whole || (report && !stored);
}

static void pages_tell(struct class_topic *look) {
    for (int i = 0; i < look->pages; i++) {
        struct class_page *page = &look->page[i];
        if (!page->reader && page->report) page->report->free(page->report);
        while (page->reader) page_give(page);
        api_buffer_clear(&page->text);
    }
    look->pages = 0;
}

/* --- the topic --- */

static int look_gather(struct srv_topic *topic, struct srv_list *listeners, int due) {
    struct class_topic *look = SRV_CONTAINER_OF(topic, struct class_topic, topic);
    assert(!look->pages && !look->marks);
    if (due) marks_gather(look);
    turns_gather(look, listeners);
    pages_gather(look);
    return look->marks || look->pages;
}

static enum srv_more look_tell(struct srv_topic *topic, struct srv_list *listeners) {
    struct class_topic *look = SRV_CONTAINER_OF(topic, struct class_topic, topic);
    pages_tell(look);
    SRV_LIST_EACH (link, listeners) {
        struct srv_listener *listener = SRV_CONTAINER_OF(link, struct srv_listener, link);
        if (listener->topic == topic && look->marks) mark_tell(class_listener(listener));
    }
    look->marks = NULL;
    if (look->topic.ask.call.stored != SRV_STORED) return SRV_MORE_NONE;
    turns_gather(look, listeners);
    if (!srv_list_empty(&look->turns[CLASS_NEW].roads)) return SRV_MORE_NEW;
    return srv_list_empty(&look->turns[CLASS_OLD].roads) ? SRV_MORE_NONE : SRV_MORE_OLD;
}

static void look_free(struct srv_topic *topic) {
    struct class_topic *gone = SRV_CONTAINER_OF(topic, struct class_topic, topic);
    marks_gather(gone);
    assert(srv_list_empty(&gone->rooms));
    free(gone);
}

struct srv_topic *srv_class_events_new(void) {
    struct class_topic *made = calloc(1, sizeof *made);
    if (!made) return NULL;
    made->topic = (struct srv_topic){.ask = {.call = {.run = look_run}},
                                     .enter = seat_take,
                                     .news = class_news,
                                     .next = class_next,
                                     .gather = look_gather,
                                     .work = look_work,
                                     .tell = look_tell,
                                     .drop = class_drop,
                                     .free = look_free};
    return &made->topic;
}
