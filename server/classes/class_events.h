/* Streams of what stands in a room: of its changes as events, and of all of it as a report.
 * Leaves to others: streams (jobs/events), the items (store_classes), their JSON (class_json), what
 * a report says (class_reports).
 * Invariant: a listener is told every item that it may read, at least as it is in the end, in the
 * order of the changes; what it has not taken is one page at most, however much happens. Changes
 * come before what was there; rooms take turns, and so do those who are in one. */
#ifndef SRV_CLASS_EVENTS_H
#define SRV_CLASS_EVENTS_H

#include "server/jobs/events.h"
#include "server/store/store_classes.h"

/* What is made of all items of a room, page by page. */
struct srv_class_report {
    const char *media_type;
    size_t bytes; /* of memory that it holds; 0 = too few to be counted */
    /** Takes an item, and may append to the text. PEND_INVALID: what is kept is damaged. */
    enum pend_status (*add)(struct srv_class_report *report, const struct srv_class_item *item,
                            struct api_buffer *text);
    /** Appends what comes after the last item. */
    enum pend_status (*end)(struct srv_class_report *report, struct api_buffer *text);
    /** Frees it. */
    void (*free)(struct srv_class_report *report);
};

/** Makes the topic, the second of service->events. NULL without memory. */
struct srv_topic *srv_class_events_new(void);

/**
 * Answers an exchange with a stream of a room's changes, or of a report, as srv_events_open does.
 * Of one client in one room one report is made at a time; the next ones wait.
 *
 * room    as it is for who asks.
 * who     the key of the token.
 * since   the change after which it begins.
 * report  taken over; NULL = changes.
 */
void srv_class_events_open(struct srv_exchange *exchange, const struct srv_class *room,
                           const char *who, int64_t since, struct srv_class_report *report);

#endif
