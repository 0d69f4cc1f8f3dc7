/* The routes of classrooms, of their pupils and of their items.
 * Leaves to others: the format of items (api/class/class_json), storing them (store_classes),
 * reading a whole room (class_reports). Invariant: the finish of every exchange is called exactly
 * once; a success is answered only after the store has committed. */
#pragma once

#include "server/work/exchange.h"

/** POST /v1/classes: 201 with a new room. The teacher's token is the client's, or one that is
 * generated and returned. */
void srv_classes_create(struct srv_exchange *exchange);

/** GET /v1/classes: the rooms of a teacher; all rooms for an operator's key, with digest bits of
 * the addresses that created them. ?after=CODE: the next page. */
void srv_classes_list(struct srv_exchange *exchange);

/** DELETE /v1/classes/{code}: the teacher, or an operator's key, deletes the room with all items.
 */
void srv_classes_erase(struct srv_exchange *exchange);

/** POST /v1/classes/{code}/pupils: 201 with the pupil's number. The pupil's token is the client's,
 * or one that is generated and returned. */
void srv_classes_join(struct srv_exchange *exchange);

/** PUT /v1/classes/{code}/{kind}/{id}: writes an item. */
void srv_classes_put(struct srv_exchange *exchange);

/** DELETE /v1/classes/{code}/{kind}/{id}: removes an item or pupils. */
void srv_classes_remove(struct srv_exchange *exchange);

/** GET /v1/classes/{code}/events: a stream of changes. */
void srv_classes_events(struct srv_exchange *exchange);
