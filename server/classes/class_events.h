/* Streams of a room: its changes as events, or all items as a report.
 * Leaves to others: streams (jobs/events), the items (store_classes), their JSON (class_json), the
 * contents of a report (class_reports).
 * Invariant: a listener receives the latest state of every item that it may read, in the order of
 * changes; at most one page is pending per listener. New changes come before backlogs; rooms take
 * turns, and so do the clients within a room. */
#pragma once

#include "server/jobs/events.h"
#include "server/store/store_classes.h"

/* A report, computed from all items of a room page by page. */
struct srv_class_report {
    const char *media_type;
    size_t bytes; /* memory of the report; 0 = negligible */
    /** Adds an item, and may append to the text. PEND_INVALID: the stored item is damaged. */
    enum pend_status (*add)(struct srv_class_report *report, const struct srv_class_item *item,
                            struct api_buffer *text);
    /** Appends the text after the last item. */
    enum pend_status (*end)(struct srv_class_report *report, struct api_buffer *text);
    /** Frees it. */
    void (*free)(struct srv_class_report *report);
};

/** Creates the topic, the second of service->events. Returns NULL if memory is short. */
struct srv_topic *srv_class_events_new(void);

/**
 * Answers an exchange with a stream of a room's changes, or of a report, as srv_events_open does. A
 * client has one report at a time in a room; further ones wait.
 *
 * room    as the client may see it.
 * who     the key of the client's token.
 * since   the stream begins after this change.
 * report  ownership passes to the stream; NULL = changes.
 */
void srv_class_events_open(struct srv_exchange *exchange, const struct srv_class *room,
                           const char *who, int64_t since, struct srv_class_report *report);
