/* The routes of rooms, of those who are in them, and of what stands there.
 * Leaves to others: what may stand there (api/class/class_json), keeping it (store_classes),
 * reading a whole room (class_reports).
 * Invariant: the finish of every exchange is called exactly once; what a client is told is in the
 * store. */
#ifndef SRV_CLASSES_H
#define SRV_CLASSES_H

#include "server/work/exchange.h"

/** POST /v1/classes: 201 with a new room; the client's token, or one that is made and told, is the
 * teacher's. */
void srv_classes_create(struct srv_exchange *exchange);

/** GET /v1/classes: the rooms of a teacher; to an operator's key all, with the marks of the
 * addresses that made them. ?after=CODE: the next page. */
void srv_classes_list(struct srv_exchange *exchange);

/** DELETE /v1/classes/{code}: the teacher, or an operator's key, erases the room with all that
 * stands there. */
void srv_classes_erase(struct srv_exchange *exchange);

/** POST /v1/classes/{code}/pupils: 201 with the pupil's number; the client's token, or one that is
 * made and told, is the pupil's. */
void srv_classes_join(struct srv_exchange *exchange);

/** PUT /v1/classes/{code}/{kind}/{id}: writes an item. */
void srv_classes_put(struct srv_exchange *exchange);

/** DELETE /v1/classes/{code}/{kind}/{id}: takes an item away, or a pupil. */
void srv_classes_remove(struct srv_exchange *exchange);

/** GET /v1/classes/{code}/events: a stream of what changes. */
void srv_classes_events(struct srv_exchange *exchange);

#endif
