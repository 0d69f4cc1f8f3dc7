/* Streams of server-sent events, whatever they tell of, answers that wait for a change, and the one
 * thread that asks the store for changes.
 * Leaves to others: what is told (a topic: job_events, classes/class_events), connections (http).
 * Invariant: an open stream holds the memory of one event, no worker and no thread; a slow reader
 * may miss events, but not the last one; no stream's events wait until another's are all read. */
#ifndef SRV_EVENTS_H
#define SRV_EVENTS_H

#include "server/base/list.h"
#include "server/work/exchange.h"

enum {
    SRV_EVENTS_BEAT_S = 10, /* a comment after so long without an event */
    SRV_EVENTS_RETRY_MS = 2000,
    SRV_EVENTS_SHARE =
        4, /* one client may have an open stream in so many, all of an address three */
    SRV_EVENTS_TEXT = 8192 /* bytes of an event that need not be counted by its topic */
};

struct srv_events;
struct srv_topic;

/* What a topic has to ask without news: nothing; what was there before, for which time is left to
 * others; what has changed, at once. */
enum srv_more { SRV_MORE_NONE, SRV_MORE_OLD, SRV_MORE_NEW };

/* A stream that is open; a topic's own begins with it. Under the lock of the events. */
struct srv_listener {
    struct srv_exchange *exchange;
    struct srv_topic *topic;
    struct srv_list link;
    int64_t beat_at;        /* ns: when a comment is due */
    int beat, over;         /* a comment is due; nothing will come any more */
    int waits;              /* suspended, for the next event */
    int wants;              /* its topic is to look at once when the text was sent */
    int64_t until;          /* ns: when an answer that waits is given; 0 = a stream */
    const char *media_type; /* of a report, which has an end; NULL = a stream of events */
    int whole;              /* nothing is missing of the report where it ends now */
    struct api_buffer text; /* what is being sent */
    size_t taken;           /* bytes of it that were */
    size_t kept;            /* bytes of memory that its topic keeps for it, with its next event */
    struct srv_hold hold;   /* of all that */
};

/* What streams tell of. All but `run` of the ask and `work` are called with the lock of the
 * events. */
struct srv_topic {
    struct srv_ask ask; /* of the thread; its call.run is the topic's */
    /** Takes a listener in before it is opened; PEND_NO_MEMORY refuses it. NULL = nothing to do. */
    enum pend_status (*enter)(struct srv_listener *listener);
    /** True when there is something to tell. */
    int (*news)(const struct srv_listener *listener);
    /** Appends what there is to tell to listener->text. */
    enum pend_status (*next)(struct srv_listener *listener);
    /** Answers the exchange of a listener that waits, because there is news, its time is up or it
     * is over; NULL if the topic has no such listeners. */
    void (*answer)(struct srv_listener *listener);
    /** Lists what the store is to be asked in one question of bounded size: what may have changed
     * if that is due, and what listeners wait for in any case. Returns 0 when that is nothing. */
    int (*gather)(struct srv_topic *topic, struct srv_list *listeners, int due);
    /** Makes of what was found what is told, without the lock; NULL where nothing is to be made. */
    void (*work)(struct srv_topic *topic);
    /** Tells the listeners what was found. Returns what there is to ask after the other topics. */
    enum srv_more (*tell)(struct srv_topic *topic, struct srv_list *listeners);
    /** Frees what a listener of the topic has beside its text, and then the listener. */
    void (*drop)(struct srv_listener *listener);
    /** Frees the topic. */
    void (*free)(struct srv_topic *topic);
};

/**
 * Makes it, without listeners, topics and its thread.
 *
 * service  outlives it.
 * most     streams that may be open.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_events_new(struct srv_events **events,
                                                struct srv_service *service, int most);

/** Adds a topic, which is freed with the events; NULL is PEND_NO_MEMORY. Before the start. */
PEND_MUST_CHECK enum pend_status srv_events_add(struct srv_events *events, struct srv_topic *topic);

/** The topic that was added as number i. */
struct srv_topic *srv_events_topic(const struct srv_events *events, int i);

/** Starts its thread, once service->storage is there. PEND_NO_MEMORY when that cannot be had. */
PEND_MUST_CHECK enum pend_status srv_events_start(struct srv_events *events);

/** Ends its thread; no stream may be open. */
void srv_events_end(struct srv_events *events);

/** Frees, after the end. NULL is accepted. */
void srv_events_free(struct srv_events **events);

/** True when the counts agree with each other and with the list of streams; for assertions, under
 * its lock. O(1). */
int srv_events_valid(const struct srv_events *events);

/** Says that something in the store may have changed. Any thread; NULL is accepted. */
void srv_events_news(struct srv_events *events);

/** Counts that a topic will keep so many bytes for a listener. Changes nothing where the memory or
 * the client's share of it has no room for that. */
enum srv_room srv_events_keep(struct srv_listener *listener, size_t kept);

/**
 * Answers an exchange with a stream: 200, or 429, or 503. That of a report is cut off where it ends
 * before it is whole.
 *
 * listener  the topic's, malloc'ed, with exchange and topic set; it is taken, and freed where no
 *           stream is opened.
 */
void srv_events_open(struct srv_events *events, struct srv_listener *listener);

/**
 * Lets an exchange wait until its topic has news of it, at most until listener->until; then the
 * topic answers it. An answer may be half a second late. Waiting exchanges count as streams.
 *
 * listener  as srv_events_open.
 *
 * Returns 1 if the exchange waits: its finish is called from here on. Returns 0 if it was answered
 * with 429 or 503, and the caller has to finish it.
 */
PEND_MUST_CHECK int srv_events_await(struct srv_events *events, struct srv_listener *listener);

/** As srv_inflight_read, of an exchange whose `listens` is set. */
long srv_events_read(struct srv_exchange *exchange, char *to, size_t cap,
                     void (*pause)(struct srv_exchange *));

/** Ends a stream, or a wait with its answer, because its reader is gone or the server is stopping.
 * Any thread. */
void srv_events_leave(struct srv_exchange *exchange, enum srv_stop why);

/** Ends every stream of events after its last one, and answers who waits; the clients connect
 * again, to another process if this one does not listen. Any thread; NULL is accepted. */
void srv_events_drain(struct srv_events *events);

#endif
