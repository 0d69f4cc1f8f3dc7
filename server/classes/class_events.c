#include "server/classes/class_events.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/class_json.h"

enum {
    EVENTS_NUMBER = 1,    /* the number of the topic among those of the service */
    EVENTS_PAGES = 16,    /* pages that are read in one question to the store */
    EVENTS_ROOMS = 64,    /* rooms whose version numbers are read in one question */
    EVENTS_PAGE = 1 << 20 /* more bytes than a page can have */
};

/* A stream of a room's events. */
struct class_listener {
    struct srv_listener listener;
    char code[SRV_CLASS_CODE], who[SRV_NAME_BYTES];
    int teacher;
    uint64_t serial;        /* a number that no other listener has */
    int64_t seen;           /* the change up to which the listener was told, or will be by `page` */
    int lags;               /* there are changes after that */
    int ended;              /* the listener has left the room, or the room was erased */
    struct api_buffer page; /* the page that is sent next */
};

/* A page that is read for a listener. */
struct class_page {
    uint64_t serial;
    char code[SRV_CLASS_CODE], who[SRV_NAME_BYTES];
    int64_t seen;
    int more;
    enum srv_stored stored;
    struct api_buffer text;
};

/* A room that somebody listens to. */
struct class_mark {
    char code[SRV_CLASS_CODE];
    int64_t version, shared;
    enum srv_stored stored;
};

struct class_topic {
    struct srv_topic topic;
    uint64_t serials;
    int paging; /* 1 = pages are read, 0 = version numbers of rooms */
    int marks, room;
    struct class_mark *mark; /* `marks` entries in use, `room` allocated */
    int pages;
    struct class_page page[EVENTS_PAGES];
};

static struct class_listener *class_listener(const struct srv_listener *listener) {
    return SRV_CONTAINER_OF(listener, struct class_listener, listener);
}

static struct class_listener *class_of_link(struct srv_list *link) {
    return class_listener(SRV_CONTAINER_OF(link, struct srv_listener, link));
}

/* --- one stream --- */

static int class_news(const struct srv_listener *listener) {
    const struct class_listener *own = class_listener(listener);
    return own->page.bytes > 0 || (own->ended && !listener->over);
}

static enum pend_status class_next(struct srv_listener *listener) {
    static const char end[] = "event: end\ndata: {}\n\n";
    struct class_listener *own = class_listener(listener);
    enum pend_status status = PEND_OK;
    assert(class_news(listener) && !listener->text.bytes);
    if (own->page.bytes) {
        api_buffer_clear(&listener->text);
        listener->text = own->page;
        api_buffer_init(&own->page, EVENTS_PAGE);
        listener->kept = 0;
        listener->wants = own->lags;
    } else {
        status = api_buffer_text(&listener->text, end);
        listener->over = 1;
    }
    return status;
}

static void class_drop(struct srv_listener *listener) {
    struct class_listener *own = class_listener(listener);
    api_buffer_clear(&own->page);
    free(own);
}

void srv_class_events_open(struct srv_exchange *exchange, const struct srv_class *room,
                           const char *who, int64_t since) {
    struct srv_events *events = exchange->service->events;
    struct class_listener *made = calloc(1, sizeof *made);
    if (!made) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return;
    }
    assert(since >= 0 && since <= room->version && (room->teacher || room->pupil));
    made->listener.exchange = exchange;
    made->listener.topic = srv_events_topic(events, EVENTS_NUMBER);
    made->teacher = room->teacher;
    made->seen = since;
    made->lags = made->listener.wants = since < room->version;
    memcpy(made->code, room->code, sizeof made->code);
    snprintf(made->who, sizeof made->who, "%s", who);
    api_buffer_init(&made->page, EVENTS_PAGE);
    srv_events_open(events, &made->listener);
}

/* --- what the store is asked --- */

static enum pend_status page_write(struct class_page *page, const struct srv_class_item *item) {
    const struct api_class_item told = {item->name, item->version, item->changed, item->body,
                                        item->bytes};
    struct api_buffer *text = &page->text;
    PEND_TRY(api_buffer_format(text, "event: item\nid: %lld\ndata:", (long long)item->version));
    /* a colon, behind which no comma is written */
    PEND_TRY(api_class_item_write(&told, text));
    return api_buffer_text(text, "\n\n");
}

static enum srv_stored page_take(void *context, const struct srv_class_item *item) {
    return page_write(context, item) == PEND_OK ? SRV_STORED : SRV_STORED_BROKEN;
}

static enum srv_stored look_run(struct srv_store *store, struct srv_store_call *call) {
    struct class_topic *look = SRV_CONTAINER_OF(call, struct class_topic, topic.ask.call);
    enum srv_stored stored = SRV_STORED;
    /* If the store is out of reach, it is not asked again for each room. */
    for (int i = 0; !look->paging && i < look->marks; i++) {
        struct class_mark *mark = &look->mark[i];
        if (stored < SRV_STORED_AWAY)
            stored = srv_store_class_mark(store, mark->code, &mark->version, &mark->shared);
        mark->stored = stored;
    }
    for (int i = 0; look->paging && i < look->pages; i++) {
        struct class_page *page = &look->page[i];
        struct srv_class room;
        if (stored < SRV_STORED_AWAY)
            stored = srv_store_class_items(store, page->code, page->who, &page->seen, &page->more,
                                           &room, page_take, page);
        page->stored = stored;
    }
    return stored < SRV_STORED_AWAY ? SRV_STORED : stored;
}

/* --- the numbers of rooms --- */

static struct class_mark *mark_find(const struct class_topic *look, const char *code) {
    for (int i = 0; i < look->marks; i++)
        if (!memcmp(look->mark[i].code, code, SRV_CLASS_CODE)) return &look->mark[i];
    return NULL;
}

/* Notes a room whose version number is to be read. Without memory the room waits for the next
 * time. */
static void mark_add(struct class_topic *look, const char *code) {
    if (look->marks == look->room) {
        int room = look->room + EVENTS_ROOMS;
        struct class_mark *more = realloc(look->mark, (size_t)room * sizeof *more);
        if (!more) return;
        look->mark = more;
        look->room = room;
    }
    assert(look->marks < look->room);
    struct class_mark *mark = &look->mark[look->marks++];
    *mark = (struct class_mark){.stored = SRV_STORED_AWAY};
    memcpy(mark->code, code, SRV_CLASS_CODE);
}

static void mark_gather(struct class_topic *look, struct srv_list *listeners) {
    look->marks = 0;
    assert(!look->paging);
    SRV_LIST_EACH (link, listeners) {
        const struct class_listener *at = class_of_link(link);
        if (at->listener.topic == &look->topic && !at->ended && !mark_find(look, at->code))
            mark_add(look, at->code);
    }
}

static void mark_tell(struct class_topic *look, struct srv_list *listeners) {
    SRV_LIST_EACH (link, listeners) {
        struct class_listener *at = class_of_link(link);
        if (at->listener.topic != &look->topic) continue;
        const struct class_mark *mark = mark_find(look, at->code);
        if (!mark) continue;
        if (mark->stored == SRV_STORED_NONE) at->ended = 1;
        if (mark->stored == SRV_STORED)
            at->lags |= (at->teacher ? mark->version : mark->shared) > at->seen;
    }
}

/* --- pages --- */

static void page_gather(struct class_topic *look, struct srv_list *listeners) {
    look->pages = 0;
    assert(look->paging);
    SRV_LIST_EACH (link, listeners) {
        struct class_listener *at = class_of_link(link);
        if (look->pages == EVENTS_PAGES) break;
        if (at->listener.topic != &look->topic || !at->lags || at->ended || at->page.bytes)
            continue;
        if (!at->serial) at->serial = ++look->serials;
        struct class_page *page = &look->page[look->pages++];
        page->serial = at->serial;
        page->seen = at->seen;
        page->more = 0;
        memcpy(page->code, at->code, sizeof page->code);
        memcpy(page->who, at->who, sizeof page->who);
        api_buffer_init(&page->text, EVENTS_PAGE);
    }
}

/* Gives a listener the page that was read for it. */
static void page_give(struct class_listener *at, struct class_page *page) {
    at->listener.wants = 0;
    if (page->stored == SRV_STORED_NONE || page->stored == SRV_STORED_CLASH) at->ended = 1;
    /* What could not be read is asked for again after a while. */
    if (page->stored != SRV_STORED) return;
    assert(page->seen >= at->seen && !at->page.bytes && page->serial == at->serial);
    at->seen = page->seen;
    at->lags = page->more;
    at->page = page->text;
    api_buffer_init(&page->text, EVENTS_PAGE);
    at->listener.kept = at->page.cap;
}

/* Listeners that received a page go to the end of the list, so that all have their turn. */
static void page_tell(struct class_topic *look, struct srv_list *listeners) {
    struct srv_list *link = listeners->next;
    for (int left = look->pages; left > 0 && link && link != listeners;) {
        struct class_listener *at = class_of_link(link);
        int i = 0;
        link = link->next;
        if (at->listener.topic != &look->topic || !at->serial) continue;
        while (i < look->pages && look->page[i].serial != at->serial) i++;
        if (i == look->pages) continue;
        page_give(at, &look->page[i]);
        left--;
        /* The number belongs to one page only; the search does not find it again at the list's
         * end. */
        look->page[i].serial = 0;
        srv_list_remove(&at->listener.link);
        srv_list_append(listeners, &at->listener.link);
    }
    for (int i = 0; i < look->pages; i++) api_buffer_clear(&look->page[i].text);
}

/* --- the topic --- */

static int look_gather(struct srv_topic *topic, struct srv_list *listeners) {
    struct class_topic *look = SRV_CONTAINER_OF(topic, struct class_topic, topic);
    if (look->paging) {
        page_gather(look, listeners);
        if (look->pages) return look->pages;
        look->paging = 0;
        return 0;
    }
    mark_gather(look, listeners);
    return look->marks;
}

static int look_tell(struct srv_topic *topic, struct srv_list *listeners) {
    struct class_topic *look = SRV_CONTAINER_OF(topic, struct class_topic, topic);
    int reached = look->topic.ask.call.stored == SRV_STORED;
    if (look->paging)
        page_tell(look, listeners);
    else
        mark_tell(look, listeners);
    look->paging = reached;
    return reached;
}

static void look_free(struct srv_topic *topic) {
    struct class_topic *gone = SRV_CONTAINER_OF(topic, struct class_topic, topic);
    free(gone->mark);
    free(gone);
}

struct srv_topic *srv_class_events_new(void) {
    struct class_topic *made = calloc(1, sizeof *made);
    if (!made) return NULL;
    made->topic = (struct srv_topic){.ask = {.call = {.run = look_run}},
                                     .news = class_news,
                                     .next = class_next,
                                     .gather = look_gather,
                                     .tell = look_tell,
                                     .drop = class_drop,
                                     .free = look_free};
    return &made->topic;
}
