/* Streams of server-sent events, answers that wait for a change, and the one thread that queries
 * the store for changes. Leaves to others: the contents (a topic: job_events,
 * classes/class_events), connections (http). Invariant: an open stream holds the memory of one
 * event, no worker and no thread; a slow reader may miss events, but not the last one; no stream
 * waits until another's backlog is read. */
#pragma once

#include "server/base/list.h"
#include "server/work/exchange.h"

enum {
    SRV_EVENTS_BEAT_S = 10, /* s without an event before a comment is sent */
    SRV_EVENTS_RETRY_MS = 2000,
    SRV_EVENTS_SHARE = 4,  /* 1/4 of all streams for a client, 3/4 for the clients of one address */
    SRV_EVENTS_TEXT = 8192 /* bytes of an event that the topic need not account for */
};

struct srv_events;
struct srv_topic;

/* The query that a topic needs next: none; one of a backlog, after a pause; one of new changes, at
 * once. */
enum srv_more { SRV_MORE_NONE, SRV_MORE_OLD, SRV_MORE_NEW };

/* An open stream; the first member of a topic's own struct. Guarded by the lock of the events. */
struct srv_listener {
    struct srv_exchange *exchange;
    struct srv_topic *topic;
    struct srv_list link;
    int64_t beat_at;        /* ns: when a comment is due */
    int beat, over;         /* a comment is due; the stream ends */
    int waits;              /* suspended until the next event */
    int wants;              /* the topic must query as soon as the text is sent */
    int64_t until;          /* ns: deadline of a waiting answer; 0 = a stream */
    const char *media_type; /* media type of a report, which ends; NULL = a stream of events */
    int whole;              /* the report is complete */
    struct api_buffer text; /* the text being sent */
    size_t taken;           /* bytes already sent */
    size_t kept;            /* memory that its topic holds for it, next event included */
    struct srv_hold hold;   /* the account of all this memory */
};

/* A source of events. All functions are called with the lock of the events, except `ask.call.run`
 * and `work`. */
struct srv_topic {
    struct srv_ask ask; /* the thread's query; the topic sets call.run */
    /** Prepares a listener before it is opened; PEND_NO_MEMORY refuses it. NULL = nothing to do. */
    enum pend_status (*enter)(struct srv_listener *listener);
    /** True if there is something to send. */
    int (*news)(const struct srv_listener *listener);
    /** Appends the next event to listener->text. */
    enum pend_status (*next)(struct srv_listener *listener);
    /** Answers the exchange of a waiting listener, on a change, timeout or end; NULL if the topic
     * has no such listeners. */
    void (*answer)(struct srv_listener *listener);
    /** Prepares one query of bounded size: for pages that listeners wait for and, if `due`, for
     * changes. Returns 0 if there is nothing to query. */
    int (*gather)(struct srv_topic *topic, struct srv_list *listeners, int due);
    /** Processes the result of the query, without the lock; NULL = nothing to do. */
    void (*work)(struct srv_topic *topic);
    /** Passes the result to the listeners. Returns the queries still needed, which follow those of
     * the other topics. */
    enum srv_more (*tell)(struct srv_topic *topic, struct srv_list *listeners);
    /** Frees a listener of the topic, except its text. */
    void (*drop)(struct srv_listener *listener);
    /** Frees the topic. */
    void (*free)(struct srv_topic *topic);
};

/**
 * Creates the events, without listeners, topics and thread.
 *
 * service  must outlive them.
 * most     limit of open streams.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_events_new(struct srv_events **events,
                                                struct srv_service *service, int most);
void srv_events_free(struct srv_events **events);

/** Adds a topic, which is freed with the events; NULL gives PEND_NO_MEMORY. Call before
 * srv_events_start. */
PEND_MUST_CHECK enum pend_status srv_events_add(struct srv_events *events, struct srv_topic *topic);

/** Returns the i-th topic that was added. */
struct srv_topic *srv_events_topic(const struct srv_events *events, int i);

/** Starts the thread; service->storage must exist. PEND_NO_MEMORY if the thread cannot be created.
 */
PEND_MUST_CHECK enum pend_status srv_events_start(struct srv_events *events);

/** Stops the thread; no stream may be open. */
void srv_events_end(struct srv_events *events);

/** Notifies that the store may have changed. Any thread; NULL is accepted. */
void srv_events_news(struct srv_events *events);

/** Reserves `kept` bytes that a topic will hold for a listener. Changes nothing if the memory
 * account or the client's share has no space. */
enum srv_room srv_events_keep(struct srv_listener *listener, size_t kept);

/**
 * Answers an exchange with a stream: 200, or 429, or 503. An incomplete report is cut off, so that
 * the client notices.
 *
 * listener  the topic's, malloc'ed, with exchange and topic set; ownership passes, also if no
 * stream is opened.
 */
void srv_events_open(struct srv_events *events, struct srv_listener *listener);

/**
 * Suspends an exchange until its topic has a change for it, at most until listener->until; then the
 * topic answers it. An answer may be half a second late. Waiting exchanges count as streams.
 *
 * listener  as for srv_events_open.
 *
 * Returns 1 if the exchange waits: its finish is called from here on. Returns 0 if it was answered
 * with 429 or 503, and the caller has to finish it.
 */
PEND_MUST_CHECK int srv_events_await(struct srv_events *events, struct srv_listener *listener);

/** As srv_inflight_read, of an exchange whose `listens` is set. */
long srv_events_read(struct srv_exchange *exchange, char *to, size_t cap,
                     void (*pause)(struct srv_exchange *));

/** Ends a stream, or a wait with its answer, because its client has left or the server is stopping.
 * Any thread. */
void srv_events_leave(struct srv_exchange *exchange, enum srv_stop why);

/** Ends every event stream after its pending event, and answers every waiting exchange. Clients
 * reconnect, to another process if this one no longer listens. Any thread; NULL is accepted. */
void srv_events_drain(struct srv_events *events);
