/* Streams of events about what changes in a room.
 * Leaves to others: streams (jobs/events), the items (store_classes), their JSON (class_json).
 * Invariant: a listener is told every item that it may read, at least as it is in the end, in the
 * order of the changes; what it has not taken is one page at most, however much happens. */
#ifndef SRV_CLASS_EVENTS_H
#define SRV_CLASS_EVENTS_H

#include "server/jobs/events.h"
#include "server/store/store_classes.h"

/** Makes the topic, the second of service->events. NULL without memory. */
struct srv_topic *srv_class_events_new(void);

/**
 * Answers an exchange with a stream of a room's changes, as srv_events_open does.
 *
 * room   as it is for who asks.
 * who    the key of the token.
 * since  the change after which it begins.
 */
void srv_class_events_open(struct srv_exchange *exchange, const struct srv_class *room,
                           const char *who, int64_t since);

#endif
